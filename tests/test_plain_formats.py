"""Surfaces as PLY, OBJ and STL: what is read, what comes back, and what is none."""

from __future__ import annotations

import numpy as np
import pytest
from mesh_files import octahedron

from SDFStentLib.files.plain.obj import decode_obj
from SDFStentLib.files.plain.ply import decode_ply, encode_ply
from SDFStentLib.files.plain.stl import decode_stl, encode_stl
from SDFStentLib.geometry import surface_topology
from SDFStentLib.validation import InputError

HEADER = """ply
format {} 1.0
comment by hand SPACE=RAS
obj_info nothing
element vertex 4
property double x
property double y
property double z
property uchar red
element face 2
property list uchar int vertex_indices
property list uchar float texcoord
property short part
element edge 1
property int vertex1
end_header
"""


def by_hand(order):
    vertices = [(0, 0, 0, 1), (1.5, 0, 0, 2), (1, 1, 0, 3), (0, 1, 0, 255)]
    faces = [([0, 1, 2], [], 5), ([0, 1, 2, 3], [0.5], -6)]
    if order == "":
        body = "".join(" ".join(map(str, row)) + "\n" for row in vertices)
        for corners, texture, part in faces:
            row = [len(corners), *corners, len(texture), *texture, part]
            body += " ".join(map(str, row)) + "\n"
        return (HEADER.format("ascii") + body + "7\n").encode()
    body = b""
    for x, y, z, red in vertices:
        body += np.array([x, y, z], f"{order}f8").tobytes() + bytes([red])
    for corners, texture, part in faces:
        body += bytes([len(corners)]) + np.array(corners, f"{order}i4").tobytes()
        body += bytes([len(texture)]) + np.array(texture, f"{order}f4").tobytes()
        body += np.array(part, f"{order}i2").tobytes()
    body += np.array(7, f"{order}i4").tobytes()
    name = "binary_little_endian" if order == "<" else "binary_big_endian"
    return HEADER.format(name).encode() + body


@pytest.mark.parametrize("order", ["", "<", ">"])
def test_polygons_of_different_sizes_and_all_properties_are_read(order):
    mesh = decode_ply(by_hand(order), "a.ply")
    assert mesh.points.dtype == np.float64
    assert mesh.points[1, 0] == 1.5
    assert mesh.corners.tolist() == [0, 1, 2, 0, 1, 2, 3]
    assert mesh.offsets.tolist() == [0, 3, 7]
    assert mesh.point_arrays["red"].tolist() == [1, 2, 3, 255]
    assert mesh.point_arrays["red"].dtype == np.uint8
    assert mesh.cell_arrays["part"].tolist() == [5, -6]
    assert "SPACE=RAS" in mesh.text
    assert tuple(map(str, mesh.warnings)) == (
        "a.ply: texcoord, edge of the PLY file are not kept.",
    )


@pytest.mark.parametrize("order", ["", "<", ">"])
def test_every_cut_of_a_ply_file_is_noticed(order):
    data = by_hand(order)
    # Of text the last digit may be missing without a trace, and the line break.
    for length in range(1, len(data) - (2 if order == "" else 0), 3):
        with pytest.raises(InputError, match=r"a\.ply: "):
            decode_ply(data[:length], "a.ply")


@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_what_is_written_comes_back(kind):
    points, triangles = octahedron()
    points = points.astype(kind)
    normals = (points / 30).astype(np.float32)
    labels = np.arange(len(points), dtype=np.int16)
    faces = np.arange(len(triangles), dtype=np.int32)
    data = encode_ply(
        points, triangles, {"label": labels, "Normals": normals}, {"face": faces}, "SPACE=LPS"
    )
    mesh = decode_ply(data, "a.ply")
    assert mesh.points.dtype == kind
    assert np.array_equal(mesh.points, points)
    assert np.array_equal(mesh.corners.reshape(-1, 3), triangles)
    assert np.array_equal(mesh.point_arrays["label"], labels)
    assert mesh.point_arrays["label"].dtype == np.int16
    assert np.array_equal(mesh.point_arrays["Normals"], normals)
    assert np.array_equal(mesh.cell_arrays["face"], faces)
    assert "SPACE=LPS" in mesh.text


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("ply\n", "plx\n", "expected a PLY file, got a file that begins with b'plx"),
        ("ply\n", "solid x\n", "got an STL file"),
        ("end_header", "end", "expected a header that ends"),
        ("format ascii 1.0\n", "", "expected a line 'format'"),
        ("property double x", "property quad x", "damaged"),
        ("vertex 4", "vertex -4", "damaged"),
        ("vertex 4", "vertex 4000000000", "its data end"),
        ("property double z", "property double w", "expected PLY vertices with x, y and z"),
        ("3 0 1 2", "-3 0 1 2", "its data end"),
        ("1.5", "one", "its data end"),
    ],
)
def test_what_is_no_ply_is_said(old, new, words):
    data = by_hand("").decode().replace(old, new, 1).encode()
    with pytest.raises(InputError, match=words):
        decode_ply(data, "a.ply")


@pytest.mark.parametrize("corner", ["1.7", "9223372036854775808", "x", "1" + "0" * 10**6])
@pytest.mark.parametrize("more", ["", "4 0 1 2 0\n"])
def test_a_corner_that_is_no_integer_is_said(corner, more):
    head = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
    head += f"property float z\nelement face {2 if more else 1}\n"
    head += "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n"
    with pytest.raises(InputError, match="do not fit its PLY header"):
        decode_ply(f"{head}3 0 {corner} 2\n{more}".encode(), "a.ply")
    assert decode_ply(f"{head}3 0 1.0 2\n{more}".encode(), "a.ply").corners[1] == 1


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
        "a.obj: colors, texture coordinates, normals, materials, groups of the OBJ file are not "
        "kept.",
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


def ascii_stl(points, triangles):
    lines = ["solid vein SPACE=RAS"]
    for corners in points[triangles]:
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += [f"vertex {x:.9g} {y:.9g} {z:.9g}" for x, y, z in corners]
        lines += ["endloop", "endfacet"]
    return ("\n".join([*lines, "endsolid vein"]) + "\n").encode()


@pytest.mark.parametrize("is_text", [False, True])
def test_corners_become_points_again_and_the_surface_is_closed(is_text):
    points, triangles = octahedron()
    points[np.abs(points) < 1e-12] = -0.0  # equal to 0, with other bits
    data = ascii_stl(points, triangles) if is_text else encode_stl(points, triangles, None, "t")
    mesh = decode_stl(data, "a.stl")
    read = mesh.corners.reshape(-1, 3)
    assert len(mesh.points) == len(points)
    assert surface_topology(read).is_closed
    assert np.array_equal(mesh.points[read], points[triangles].astype(np.float32))
    assert read[0].tolist() == [0, 1, 2]  # in the order of the file


def test_header_and_attributes_are_kept():
    points, triangles = octahedron(rounds=0)
    attribute = np.arange(8, dtype=np.uint16)
    mesh = decode_stl(encode_stl(points, triangles, attribute, "SPACE=LPS"), "a.stl")
    assert mesh.text.startswith("SPACE=LPS")
    assert np.array_equal(mesh.cell_arrays["Attribute"], attribute)


def test_every_cut_of_an_stl_file_is_noticed():
    points, triangles = octahedron(rounds=0)
    for data in (ascii_stl(points, triangles), encode_stl(points, triangles, None, "t")):
        for length in range(1, len(data.rstrip()) - 5, 7):
            with pytest.raises(InputError, match=r"a.stl: expected"):
                decode_stl(data[:length], "a.stl")


def test_words_instead_of_numbers_are_refused():
    points, triangles = octahedron(rounds=0)
    data = ascii_stl(points, triangles).replace(b"vertex 30 ", b"vertex ten ")
    with pytest.raises(InputError, match="expected numbers as STL corners"):
        decode_stl(data, "a.stl")


def test_bytes_behind_the_announced_triangles_are_said():
    points, triangles = octahedron(rounds=0)
    data = encode_stl(points, triangles, None, "x")
    fewer = data[:80] + (7).to_bytes(4, "little") + data[84:]
    with pytest.raises(InputError, match="its number of triangles is damaged"):
        decode_stl(fewer, "a.stl")
    assert len(decode_stl(data + b"\0\0\n", "a.stl").corners) == 3 * len(triangles)
