#!/usr/bin/env bash
# pymeshlab 2025.7.post1 (MeshLab 2025.07): an STL of several solids loses a triangle where a solid
# has a name of two words.
#
# A closed tetrahedron is written as ASCII STL in two solids, the boundary of a mesh as OpenFOAM has
# it. With names of one word, or of three, all four triangles are read. With a name of two words, or
# of four, one triangle is missing, the first of the second solid, whichever of the two has that
# name; of two such names still one. A single solid of that name is read whole.
#
# Seen:  wall + cap: 4 of 4
#        left lower artery + cap: 4 of 4
#        left artery + cap: 3 of 4, without [2, 1, 3]
#        wall + left artery: 3 of 4, without [2, 1, 3]
#        left artery alone: 4 of 4
#
# Why it matters: "left artery", "rca distal" are usual names of patches. The closed wall has a hole
# of one triangle after loading, without a message: no inside, no volume, and a mesher that leaks.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check pymeshlab==2025.7.post1
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import sys

import pymeshlab

POINTS = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
TRIANGLES = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]


def stl(*solids):
    lines = []
    for name, triangles in solids:
        lines.append(f"solid {name}")
        for triangle in triangles:
            lines += ["facet normal 0 0 0", "outer loop"]
            lines += ["vertex {} {} {}".format(*POINTS[corner]) for corner in triangle]
            lines += ["endloop", "endfacet"]
        lines.append(f"endsolid {name}")
    return "\n".join(lines) + "\n"


def read(text):
    with open("a.stl", "w", encoding="ascii") as file:
        file.write(text)
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh("a.stl")
    mesh = meshes.current_mesh()
    return [tuple(row) for row in mesh.face_matrix().tolist()]


whole = read(stl(("wall", TRIANGLES[:2]), ("cap", TRIANGLES[2:])))
seen = []
for first, second in (
    ("wall", "cap"),
    ("left lower artery", "cap"),
    ("left artery", "cap"),
    ("wall", "left artery"),
):
    found = read(stl((first, TRIANGLES[:2]), (second, TRIANGLES[2:])))
    missing = [list(row) for row in whole if row not in found]
    print(f"{first} + {second}: {len(found)} of 4" + (f", without {missing[0]}" if missing else ""))
    seen.append(len(found))
found = read(stl(("left artery", TRIANGLES)))
print(f"left artery alone: {len(found)} of 4")
seen.append(len(found))
sys.exit(0 if seen == [4, 4, 3, 3, 4] else 1)
PYTHON
