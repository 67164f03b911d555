import numpy as np
import pytest
from mesh_files import octahedron

from SDFStentLib.files.formats.obj import decode_obj, encode_obj
from SDFStentLib.validation import InputError


@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_no_digit_is_lost(kind):
    points, triangles = octahedron()
    points = points.astype(kind)
    mesh = decode_obj(encode_obj(points, triangles, "SPACE=LPS"), "a.obj")
    assert np.array_equal(mesh.points.astype(kind), points)
    assert np.array_equal(mesh.corners.reshape(-1, 3), triangles)
    assert "SPACE=LPS" in mesh.text
    assert mesh.warnings == ()


def test_corners_are_joined_by_point_whatever_their_normals_and_textures():
    text = b"""# by hand
mtllib a.mtl
v 0 0 0 1 0 0
v 1 0 0
v 1 1 0 1.0
v 0 1 0
vt 0 0
vn 0 0 1
vn 0 1 0
g one
usemtl red
f 1/1/1 2/1/1 3/1/1
f 1//2 3//2 \\
 4//2
f -4 -3 -2 -1
"""
    mesh = decode_obj(text, "a.obj")
    assert mesh.corners.tolist() == [0, 1, 2, 0, 2, 3, 0, 1, 2, 3]
    assert mesh.offsets.tolist() == [0, 3, 6, 10]
    assert mesh.points.shape == (4, 3)
    assert tuple(map(str, mesh.warnings)) == (
        "a.obj: texture coordinates, normals, materials, groups of the OBJ file are not kept.",
    )


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (b"\x00\x01\x02 v 1 2 3", "found none"),
        (b"hello\n", "found none"),
        (b"v 0 0 0\nv 1 x 0\n", "expected numbers"),
        (b"v 0 0 0\nv 1 0\n", "expected numbers"),
        (b"v 0 0 0\nf 1 0 1\n", "point numbers from 1"),
        (b"v 0 0 0\nv 1 0 0\nf 1 2", "cut short"),
        (b"v 0 0 0\nv 1 0", "expected numbers"),
    ],
)
def test_what_is_no_obj_is_said(text, words):
    with pytest.raises(InputError, match=words):
        decode_obj(text, "a.obj")


@pytest.mark.parametrize(
    "data",
    [
        b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9223372036854775808\n",
        b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -9223372036854775809\n",
        b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3.5\n",
        b"v 0 0\nv 1 0 0\nv 0 1 0 0\nf 1 2 3\n",
        b"v 0 0 1" + b"0" * 10**6 + b"x\n" + b"v 1 0 0\n" * 4000 + b"f 1 2 3\n",
    ],
)
def test_numbers_beyond_all_bounds_are_said(data):
    with pytest.raises(InputError, match="expected numbers after v and f"):
        decode_obj(data, "a.obj")
