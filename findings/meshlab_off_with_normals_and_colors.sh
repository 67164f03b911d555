#!/usr/bin/env bash
# pymeshlab 2025.7.post1 (MeshLab 2025.07): an OFF with normals and colors is written in an order in
# which MeshLab does not read it.
#
# Geomview's format has position, normal, color for each point of an NCOFF, whatever the order of
# the letters. MeshLab reads such a file so. What it writes under the same word has the color before
# the normal: read back, every normal is a color of up to 255, and every color is made of a channel
# and the normal. Files with only one of both (NOFF, COFF) come back as they were.
#
# Seen:  by the format:     normal [0.0, 0.0, 1.0], as written
#        COFF, by MeshLab:  color [1.0, 0.0, 0.0, 1.0], as set
#        NCOFF, by MeshLab: row of the first point: 0 0 0 255 0 0 255 ...
#        read back:         normal [255.0, 0.0, 0.0], another color
#
# Why it matters: MeshLab saves both wherever a surface has both, as colored surfaces of a scanner
# or of a map of wall shear do. Shading, offsets along normals and whatever is kept as a color are
# wrong afterwards; points and triangles are right, so nothing tells.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check numpy==2.2.6 pymeshlab==2025.7.post1
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
from pathlib import Path

import numpy as np
import pymeshlab

points = np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3]], dtype=float)
triangles = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
colors = np.array([[1, 0, 0, 1], [0, 1, 0, 1], [0, 0, 1, 1], [1, 1, 0, 1]], dtype=float)


def read(name):
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(name)
    mesh = meshes.current_mesh()
    return [
        np.array(values)
        for values in (mesh.vertex_matrix(), mesh.vertex_normal_matrix(), mesh.vertex_color_matrix())
    ]


rows = ["NCOFF", "4 4 0"]
for point in points.astype(int):
    rows.append(" ".join(map(str, [*point, 0, 0, 1, 1, 0, 0, 1])))
rows += [" ".join(map(str, [3, *triangle])) for triangle in triangles]
Path("by_the_format.off").write_text("\n".join(rows) + "\n")
normal = read("by_the_format.off")[1][0].tolist()
print("by the format:     normal", normal)
assert normal == [0.0, 0.0, 1.0]

meshes = pymeshlab.MeshSet()
meshes.add_mesh(pymeshlab.Mesh(points, np.array(triangles), v_color_matrix=colors))
meshes.save_current_mesh("colors.off", save_vertex_color=True, save_vertex_normal=False)
color = read("colors.off")[2][0].tolist()
print("COFF, by MeshLab:  color", color)
assert np.allclose(color, colors[0], atol=1 / 255)

meshes.save_current_mesh("both.off", save_vertex_color=True, save_vertex_normal=True)
lines = Path("both.off").read_text().splitlines()
print("NCOFF, by MeshLab:", lines[0], "| first point:", lines[2])
assert lines[0] == "NCOFF" and lines[2].split()[3:7] == ["255", "0", "0", "255"]
kept, normals, found = read("both.off")
normal, color = normals[0].tolist(), found[0].tolist()
print("read back:         normal", normal, "color", np.round(color, 3).tolist())
assert normal == [255.0, 0.0, 0.0] and not np.allclose(color, colors[0], atol=0.01)
assert np.allclose(kept, points)
PYTHON
