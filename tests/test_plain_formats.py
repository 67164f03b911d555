"""Surfaces as PLY, OBJ and STL: what is read, what comes back, and what is none."""

import numpy as np
import pytest
from mesh_files import octahedron
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkFiltersCore import vtkTriangleFilter

from SDFStentLib.files import polydata_from_arrays
from SDFStentLib.files.plain.obj import decode_obj
from SDFStentLib.files.plain.ply import decode_ply, encode_ply
from SDFStentLib.files.plain.stl import decode_stl, encode_solids, encode_stl
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
    assert tuple(map(str, mesh.warnings)) == ("a.ply: not kept of the PLY file: texcoord, edge.",)


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
        "a.obj: not kept of the OBJ file: colors, texture coordinates, normals, materials, groups.",
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


@pytest.mark.parametrize("seed", range(5))
def test_comments_blanks_and_continued_lines_change_nothing_of_an_obj(seed):
    generator = np.random.default_rng(seed)
    points, triangles = octahedron(rounds=1)
    rows = [f"v {x!r} {y!r} {z!r}" for x, y, z in points.tolist()]
    rows += [f"f {a} {b} {c}" for a, b, c in (triangles + 1).tolist()]
    plain = decode_obj("\n".join(rows).encode(), "a.obj")
    noise = ["  {}", "\t{} ", "{} # wall 1/2", "{}#", "# C:\\\n{}", "\n{}", "{}\r"]
    noisy = [noise[generator.integers(len(noise))].format(row) for row in rows]
    broken = [row.replace(" ", " \\\n ", 1) if n % 5 == 0 else row for n, row in enumerate(noisy)]
    broken = [row if "#" not in row else noisy[n] for n, row in enumerate(broken)]
    mesh = decode_obj("\n".join(broken).encode(), "a.obj")
    assert np.array_equal(mesh.points, plain.points)
    assert np.array_equal(mesh.corners, plain.corners)
    assert mesh.warnings == ()


def test_what_an_obj_has_beside_its_surface_is_named():
    text = b"# SPACE=LPS\no vein\ng wall\nv 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 0 1 0 1 0 0\n"
    text += b"  vp 1\nf 1 2 3\n  l 1 2 3\np 1 2\n"
    mesh = decode_obj(text, "a.obj")
    assert mesh.corners.tolist() == [0, 1, 2]
    assert mesh.text == "# SPACE=LPS"
    said = "groups, objects, lines, points that are drawn"
    assert str(mesh.warnings[0]) == f"a.obj: not kept of the OBJ file: colors, {said}."


LISTED = """ply
format {} 1.0
element vertex 3
property list uchar float first
property float x
property float y
property list uchar int middle
property float z
property list uchar double last
element face 1
property list uchar int vertex_index
end_header
"""


@pytest.mark.parametrize("order", ["", "<", ">"])
@pytest.mark.parametrize("sizes", [(0, 0, 0), (2, 2, 2), (0, 3, 1)])
def test_lists_of_vertices_are_left_out_and_said(order, sizes):
    points = [(0, 0, 0), (30, 0, 0), (0, 30, 5)]
    body = b""
    for size, (x, y, z) in zip(sizes, points, strict=True):
        row = [(size, "u1"), *[(float("nan"), "f4")] * size, (x, "f4"), (y, "f4")]
        row += [(size, "u1"), *[(7, "i4")] * size, (z, "f4"), (size, "u1"), *[(1e300, "f8")] * size]
        body += coded(row, order)
    body += coded([(3, "u1"), (0, "i4"), (1, "i4"), (2, "i4")], order)
    name = {"": "ascii", "<": "binary_little_endian", ">": "binary_big_endian"}[order]
    data = LISTED.format(name).encode() + body
    mesh = decode_ply(data, "a.ply")
    assert mesh.points.tolist() == [list(point) for point in points]
    assert mesh.corners.tolist() == [0, 1, 2]
    assert mesh.point_arrays == {}
    assert str(mesh.warnings[0]) == "a.ply: not kept of the PLY file: first, middle, last."
    for length in range(1, len(data) - (2 if order == "" else 0)):
        with pytest.raises(InputError, match=r"a\.ply: "):
            decode_ply(data[:length], "a.ply")


def coded(row, order):
    if order == "":
        return (" ".join(str(value) for value, _ in row) + "\n").encode()
    return b"".join(np.array(value, order + kind).tobytes() for value, kind in row)


@pytest.mark.parametrize("name", ["x", "vertex_index"])
def test_a_list_where_a_number_is_wanted_and_a_number_where_a_list_is_are_said(name):
    text = LISTED.format("ascii") + "0 0 0 0 0 0\n" * 3 + "3 0 1 2\n"
    if name == "x":
        text = text.replace("property float x", "property list uchar float x")
        with pytest.raises(InputError, match="expected PLY vertices with x, y and z"):
            decode_ply(text.encode(), "a.ply")
    else:
        text = text.replace("property list uchar int vertex_index", "property int vertex_index")
        mesh = decode_ply(text.replace("3 0 1 2", "0").encode(), "a.ply")
        assert len(mesh.corners) == 0


def test_strips_of_a_ply_are_cut_as_the_strips_of_vtk_are():
    points, _ = octahedron(rounds=1)
    strips = [[0, 6, 7, 8, 2], [3, 4, 5], [9, 10, 11, 12, 13, 14], [1, 1, 15, 16]]
    values = [value for strip in strips[:3] for value in (*strip, -1)] + strips[3]
    text = "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\n"
    text += "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
    text += "property uchar part\nelement tristrips 1\nproperty list int int vertex_indices\n"
    text = text.format(len(points)) + "end_header\n"
    text += "\n".join(f"{x} {y} {z}" for x, y, z in points) + "\n3 0 1 2 9\n"
    mesh = decode_ply(f"{text}{len(values)} {' '.join(map(str, values))}\n".encode(), "a.ply")

    cells = vtkCellArray()
    for strip in strips:
        cells.InsertNextCell(len(strip), strip)
    polydata = vtkPolyData()
    polydata.SetPoints(polydata_from_arrays(points, [[0, 1, 2]]).GetPoints())
    polydata.SetStrips(cells)
    cut = vtkTriangleFilter()
    cut.SetInputData(polydata)
    cut.Update()
    expected = vtk_to_numpy(cut.GetOutput().GetPolys().GetConnectivityArray()).reshape(-1, 3)
    expected = [row for row in expected.tolist() if len(set(row)) == 3]
    # The same winding; which corner comes first says nothing.
    assert [turned(row) for row in mesh.corners.reshape(-1, 3)[1:].tolist()] == [
        turned(row) for row in expected
    ]
    assert mesh.corners[:3].tolist() == [0, 1, 2]
    assert [str(one) for one in mesh.warnings] == [
        f"a.ply: 4 polygons or strips were cut into triangles, {len(expected)} triangles now.",
        "a.ply: not kept of the PLY file: part.",
    ]


def turned(row):
    start = row.index(min(row))
    return row[start:] + row[:start]


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


@pytest.mark.parametrize("header", [b"", b"solid", b"solid of a scanner", b"SOLID facet endfacet"])
@pytest.mark.parametrize("tail", [b"", b"\0", b"\n", b"\r\n\0\x1a", bytes(100)])
def test_a_binary_stl_is_one_whatever_its_header_and_its_tail(header, tail):
    points, triangles = octahedron(rounds=0)
    data = header.ljust(80, b" ") + encode_stl(points, triangles, None, "x")[80:]
    mesh = decode_stl(data + tail, "a.stl")
    assert np.array_equal(mesh.points[mesh.corners], points[triangles.ravel()].astype(np.float32))
    for length in range(1, len(data)):
        with pytest.raises(InputError, match=r"a\.stl: expected .*cut short"):
            decode_stl(data[:length], "a.stl")


def solids(points, parts, end="\n"):
    """ASCII STL as an independent writer has it: rows of (name, triangles)."""
    lines = []
    for name, triangles in parts:
        lines.append(f"solid {name}".rstrip())
        for corners in points[triangles]:
            lines += ["  facet normal 0 0 0", "    outer loop"]
            lines += [f"      vertex {x:.9g} {y:.9g} {z:.9g}" for x, y, z in corners]
            lines += ["    endloop", "  endfacet"]
        lines.append(f"endsolid {name}".rstrip())
    return (end.join(lines) + end).encode()


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_solids_are_faces_by_name(end):
    points, triangles = octahedron(rounds=0)
    parts = [("wall SPACE=RAS", triangles[:3]), ("left  vein", triangles[3:4])]
    parts += [("", triangles[4:5]), ("wall", triangles[5:6]), ("", triangles[6:])]
    mesh = decode_stl(solids(points, parts, end), "a.stl")
    assert mesh.face_names == {1: "wall", 2: "left vein"}
    assert mesh.face_ids.tolist() == [1, 1, 1, 2, 3, 1, 4, 4]
    assert np.array_equal(mesh.points[mesh.corners], points[triangles.ravel()].astype(np.float32))
    assert "SPACE=RAS" in mesh.text


def test_one_solid_is_the_whole_and_empty_ones_are_none():
    points, triangles = octahedron(rounds=0)
    for parts in ([("vein", triangles)], [("a", triangles[:0]), ("vein", triangles)]):
        mesh = decode_stl(solids(points, parts), "a.stl")
        assert mesh.face_ids is None
        assert mesh.face_names == {}


def test_every_cut_within_a_solid_is_noticed():
    points, triangles = octahedron(rounds=0)
    data = solids(points, [("wall", triangles[:4]), ("cap", triangles[4:])])
    second = data.index(b"solid cap")
    between = range(data.index(b"endsolid") + 8, second + 1)  # a whole file of one solid
    for length in set(range(1, data.rindex(b"endsolid"))) - set(between):
        with pytest.raises(InputError, match=r"a\.stl: expected"):
            decode_stl(data[:length], "a.stl")


@pytest.mark.parametrize("seed", range(3))
def test_what_is_written_as_solids_comes_back(seed):
    generator = np.random.default_rng(seed)
    points, triangles = octahedron()
    points = points.astype(np.float32)
    ids = np.sort(generator.integers(5, 9, len(triangles)))[::-1]
    names = {5: "wall", 7: "rechter Ast, käudal", 8: "cap 1"}
    mesh = decode_stl(encode_solids(points, triangles, ids, names, "SPACE=LPS"), "a.stl")
    assert np.array_equal(mesh.points[mesh.corners], points[triangles.ravel()])
    back = [mesh.face_names.get(number) for number in mesh.face_ids.tolist()]
    assert back == [names.get(number) for number in ids.tolist()]
    assert "SPACE=LPS" in mesh.text
