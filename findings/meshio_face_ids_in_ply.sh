#!/usr/bin/env bash
# meshio 5.3.5: a binary PLY with a number for every face cannot be read, its text twin can.
#
# PLY allows any properties behind the list of a face's corners. The same tetrahedron with an id for
# each face is written as text and as binary by the rules of the format. Text is read with the ids.
# Binary ends in a TypeError, for meshio takes every property of a face for a list. trimesh 5.2.0
# reads both.
#
# Seen:  text:   4 triangles, face_id [7, 8, 9, 10]
#        binary: TypeError: object of type 'numpy.int32' has no len()
#        trimesh, both: 4 triangles
#
# Why it matters: ids of faces (wall, inlet, outlets) are what a solver sets its conditions by. Who
# keeps them in a PLY has to write it as text for meshio, or to give meshio an STL without them.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check meshio==5.3.5 trimesh==5.2.0
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import struct
import sys

import meshio
import trimesh

POINTS = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
TRIANGLES = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]
IDS = [7, 8, 9, 10]
HEADER = """ply
format {} 1.0
element vertex 4
property float x
property float y
property float z
element face 4
property list uchar int vertex_indices
property int face_id
end_header
"""
rows = ["{} {} {}".format(*point) for point in POINTS]
rows += ["3 {} {} {} {}".format(*triangle, face) for triangle, face in zip(TRIANGLES, IDS)]
with open("text.ply", "w", encoding="ascii") as file:
    file.write(HEADER.format("ascii") + "\n".join(rows) + "\n")
with open("binary.ply", "wb") as file:
    file.write(HEADER.format("binary_little_endian").encode())
    file.write(b"".join(struct.pack("<3f", *point) for point in POINTS))
    file.write(b"".join(struct.pack("<B4i", 3, *t, face) for t, face in zip(TRIANGLES, IDS)))

text = meshio.read("text.ply")
ids = text.cell_data["face_id"][0].tolist()
print("text:", len(text.cells[0].data), "triangles, face_id", ids)
try:
    meshio.read("binary.ply")
    said = "read"
except TypeError as error:
    said = f"TypeError: {error}"
print("binary:", said)
others = [len(trimesh.load_mesh(f"{name}.ply").faces) for name in ("text", "binary")]
print("trimesh, both:", others[0], "triangles" if others == [4, 4] else others)
sys.exit(0 if ids == IDS and "has no len()" in said and others == [4, 4] else 1)
PYTHON
