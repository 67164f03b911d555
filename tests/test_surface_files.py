import hashlib

import numpy as np
import pytest
from mesh_files import assert_refused_by_name, octahedron
from vtkmodules.vtkCommonDataModel import vtkPolyData

from SDFStentLib.files import (
    encode_vtp,
    polydata_from_arrays,
    polydata_from_lines,
    read_surface,
)
from SDFStentLib.validation import InputError


def saved(folder, polydata, name="a.vtp"):
    path = folder / name
    path.write_bytes(encode_vtp(polydata))
    return path


@pytest.mark.parametrize(("units", "scale"), [("mm", 1), ("cm", 10), ("m", 1000)])
def test_points_are_millimetres_whatever_the_file_uses(tmp_path, units, scale):
    points, triangles = octahedron()
    surface = read_surface(saved(tmp_path, polydata_from_arrays(points / scale, triangles)), units)
    assert np.allclose(surface.points, points, rtol=1e-15)
    assert np.array_equal(surface.triangles, triangles)
    assert surface.units == units
    assert surface.coordinate_type == np.float64
    assert surface.sha256 == hashlib.sha256(surface.path.read_bytes()).hexdigest()
    assert surface.warnings == ()


def test_degenerate_triangles_and_unused_points_stay_and_are_said(tmp_path):
    points, triangles = octahedron()
    points = np.concatenate([points, [[1, 1, 1], points[:2].mean(axis=0)]])
    triangles = np.concatenate([triangles, [[0, 0, 1], [0, 1, len(points) - 1]]])
    surface = read_surface(saved(tmp_path, polydata_from_arrays(points, triangles)))
    assert np.array_equal(surface.triangles, triangles)
    assert len(surface.points) == len(points)
    assert tuple(map(str, surface.warnings)) == (
        f"{surface.path}: 2 triangles are degenerate (no height).",
    )


def test_integer_coordinates_become_doubles(tmp_path):
    path = tmp_path / "a.vtk"
    path.write_text(
        "# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\n"
        "POINTS 3 int\n0 0 0 50 0 0 0 50 0\nPOLYGONS 1 4\n3 0 1 2\n",
        encoding="utf-8",
    )
    surface = read_surface(path)
    assert surface.coordinate_type == np.float64
    assert "coordinates are integers" in str(surface.warnings[0])


def test_bad_files_give_one_sentence_with_their_name(tmp_path):
    points, triangles = octahedron(rounds=0)
    bad = polydata_from_arrays(points, triangles)
    bad.GetPoints().SetPoint(3, 0, float("nan"), 0)
    saved(tmp_path, bad, "nan.vtp")
    saved(tmp_path, vtkPolyData(), "nothing.vtp")
    saved(tmp_path, polydata_from_lines(points, [[0, 1, 2]]), "lines.vtp")
    (tmp_path / "noise.stl").write_bytes(np.random.default_rng(1).bytes(5000))
    (tmp_path / "wild.obj").write_bytes(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n")
    (tmp_path / "pointless.stl").write_bytes(b"\0" * 84)
    (tmp_path / "words.txt").write_text("words", encoding="utf-8")
    (tmp_path / "empty.vtp").write_bytes(b"")
    for name, words in (
        ("nan.vtp", "got NaN or infinity at 1 of 6 points"),
        ("nothing.vtp", "expected a surface of triangles, got none"),
        ("lines.vtp", "expected a surface of triangles, got none"),
        ("noise.stl", "cut short or no STL file"),
        ("wild.obj", "expected point indices from 0 to 2 in its faces, got 0 to 8"),
        ("pointless.stl", "expected a surface of triangles, got none"),
        ("words.txt", "expected a surface as .vtp, .vtk, .stl, .ply, .obj, got '.txt'"),
        ("empty.vtp", "got an empty file"),
        ("missing.vtp", "no such file"),
        (".", "got a folder"),
    ):
        assert_refused_by_name(read_surface, tmp_path / name, words)
    with pytest.raises(InputError, match="units: expected one of"):
        read_surface(tmp_path / "nan.vtp", "inch")
