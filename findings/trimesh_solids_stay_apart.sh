#!/usr/bin/env bash
# trimesh 5.2.0: a closed surface in an STL of several solids is read as an open one.
#
# STL has no shared points; trimesh joins equal corners, but solid by solid. The same closed
# tetrahedron is written once as one solid and once as the solids wall and cap: the second has eight
# points and no inside. `load_mesh` gives one mesh, so that nothing tells of the solids;
# `merge_vertices()` mends it.
#
# Seen:  one solid:  4 points, watertight True, volume 0.1667
#        two solids: 8 points, watertight False
#        after merge_vertices(): 4 points, watertight True
#
# Why it matters: models for OpenFOAM and snappyHexMesh have wall, inlet and outlets as solids. Who
# tests such a vessel with `is_watertight`, or repairs it for not being so, closes ends that are
# closed; `fill_holes` and `volume` are wrong before the points are joined.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check trimesh==5.2.0
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import sys

import trimesh

POINTS = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
TRIANGLES = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]


def read(*solids):
    lines = []
    for name, triangles in solids:
        lines.append(f"solid {name}")
        for triangle in triangles:
            lines += ["facet normal 0 0 0", "outer loop"]
            lines += ["vertex {} {} {}".format(*POINTS[corner]) for corner in triangle]
            lines += ["endloop", "endfacet"]
        lines.append(f"endsolid {name}")
    with open("a.stl", "w", encoding="ascii") as file:
        file.write("\n".join(lines) + "\n")
    return trimesh.load_mesh("a.stl")


one = read(("vessel", TRIANGLES))
print(f"one solid: {len(one.vertices)} points, watertight {one.is_watertight}, volume {one.volume:.4f}")
two = read(("wall", TRIANGLES[:2]), ("cap", TRIANGLES[2:]))
seen = [len(one.vertices), one.is_watertight, len(two.vertices), two.is_watertight]
print(f"two solids: {len(two.vertices)} points, watertight {two.is_watertight}")
two.merge_vertices()
seen += [len(two.vertices), two.is_watertight]
print(f"after merge_vertices(): {len(two.vertices)} points, watertight {two.is_watertight}")
sys.exit(0 if seen == [4, True, 8, False, 4, True] else 1)
PYTHON
