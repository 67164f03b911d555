import numpy as np
import pytest
from mesh_files import octahedron

from SDFStentLib.files.formats.stl import decode_stl, encode_stl
from SDFStentLib.geometry import surface_topology
from SDFStentLib.validation import InputError


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


def test_a_binary_file_may_begin_with_solid():
    points, triangles = octahedron(rounds=0)
    mesh = decode_stl(encode_stl(points, triangles, None, "solid as a rock"), "a.stl")
    assert len(mesh.corners) == 24


def test_every_cut_is_noticed():
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
