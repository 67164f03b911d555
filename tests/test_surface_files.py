"""Surfaces from files, and whether a centerline lies in the same space."""

import numpy as np
import pytest
from mesh_files import assert_refused_by_name, octahedron, open_tube
from tube_files import write_line, write_wall
from vtkmodules.vtkCommonDataModel import vtkPolyData

from benchmarks.phantoms import branching_pulmonary_artery
from SDFStentLib.files import (
    check_same_space,
    encode_vtp,
    polydata_from_arrays,
    polydata_from_lines,
    read_surface,
    size_warnings,
)
from SDFStentLib.geometry import Surface
from SDFStentLib.plan import read_input_files
from SDFStentLib.validation import InputError


def saved(folder, polydata, name="a.vtp"):
    path = folder / name
    path.write_bytes(encode_vtp(polydata))
    return path


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
        ("words.txt", "expected a surface as .vtp, .vtk, .stl, .ply, .obj, .off, .*, got '.txt'"),
        ("empty.vtp", "got an empty file"),
        ("missing.vtp", "no such file"),
        (".", "got a folder"),
    ):
        assert_refused_by_name(read_surface, tmp_path / name, words)
    with pytest.raises(InputError, match="units: expected one of"):
        read_surface(tmp_path / "nan.vtp", "inch")


HERE = np.array([100.0, 60.0, 20.0])


def moved_tube():
    points, triangles = open_tube()
    return points + HERE, triangles


def axis(start=1.0, end=59.0, count=80):
    return HERE + np.stack([np.zeros(count)] * 2 + [np.linspace(start, end, count)], axis=1)


@pytest.mark.parametrize("factor", [10, 0.1, 1000, 0.001])
def test_other_units_are_recognized_and_the_option_named(factor):
    words = rf"c.vtp: expected it inside s.vtp, got 0 % .* {1 / factor:g} times .* name that"
    with pytest.raises(InputError, match=words):
        check_same_space(
            Surface(*moved_tube()), factor * axis(), surface_name="s.vtp", centerline_name="c.vtp"
        )


@pytest.mark.parametrize(
    ("line", "words"),
    [
        (axis() * (-1, -1, 1), "(?!.*units).*one is in RAS and the other in LPS"),
        (axis() * (-0.1, -0.1, 0.1), r".*different units .*also, one is in RAS"),
        (axis() + np.array([40, -13, 7]), ".*check that the two belong together"),
        (0.1 * axis(30, 36), ".*it would fit 10 times as large"),
    ],
)
def test_frames_units_and_other_patients_are_told_apart(line, words):
    with pytest.raises(InputError, match=f"^{words}"):
        check_same_space(Surface(*moved_tube()), line)


@pytest.fixture(scope="module")
def a_fork():
    """A trunk along z and two unlike limbs, its lines through the trunk's whole length."""
    return branching_pulmonary_artery(edge_length=1.2)


def turned(points):
    return points * (-1.0, -1.0, 1.0)


@pytest.mark.parametrize("share", [0.1, 0.25, 0.4, 0.48])
def test_a_line_of_the_other_frame_is_refused_though_most_of_it_lies_inside(a_fork, share):
    """The trunk lies about the axis, where both frames agree."""
    points = a_fork.centerline.points
    in_both = a_fork.surface.contains(turned(points))
    assert 0 < in_both.sum() < len(points)
    own, both = points[~in_both], points[in_both]
    line = turned(np.concatenate([both, own])[: round(len(both) / (1 - share))])
    assert a_fork.surface.contains(line).mean() == pytest.approx(1 - share, abs=0.02)
    words = "inside; one is in RAS and the other in LPS .it would fit with x and y negated"
    with pytest.raises(InputError, match=words):
        check_same_space(a_fork.surface, line)


@pytest.mark.parametrize(
    ("factor", "turn", "words"),
    [
        (1, -1, "one is in RAS and the other in LPS"),
        (0.1, 1, "it would fit 10 times as large"),
        (1000, 1, "it would fit 0.001 times as large"),
    ],
)
def test_lines_far_from_their_wall_are_told_to_be_so_before_a_tree_is_made_of_them(
    tmp_path, factor, turn, words
):
    """Without radii the wall tells how wide the lumen is: far from it all lines seem to be one."""
    surface = tmp_path / "surface.vtp"
    write_wall(surface, *moved_tube())
    points = factor * axis() * (turn, turn, 1)
    line = tmp_path / "line.vtp"
    write_line(line, points)
    with pytest.raises(InputError, match=f"expected it inside .*surface.vtp, .*{words}"):
        read_input_files(surface, line)


@pytest.mark.parametrize("beyond", [1.1, 1.3, 1.8])
@pytest.mark.parametrize("aside", [0.0, 0.5])
def test_what_sticks_out_of_a_vessel_that_looks_alike_in_both_frames_is_no_reason(beyond, aside):
    """A tube about the axis: its line is longer, and lies as well inside with x and y negated."""
    points, triangles = open_tube()
    z = np.linspace(-30 * (beyond - 1), 30 * (beyond + 1), 80)
    line = np.stack([aside + 0 * z, 0.02 * z, z], axis=1)
    (told,) = check_same_space(Surface(points + np.array([0.3, 0, 0]), triangles), line)
    assert told.kind == "partly-outside"
    outside = np.mean((z < 0) | (z > 60))
    assert told.numbers["outside_percent"] == pytest.approx(100 * outside)


def test_a_vessel_that_fits_as_well_in_another_frame_keeps_its_own():
    """A little less of the line lies outside with x and y negated, as happens by chance."""
    points, triangles = open_tube()
    z = np.linspace(1.0, 59.0, 150)
    line = np.stack([0 * z, 0 * z, z], axis=1)
    line[:9, 0], line[9:15, 0] = -5.0, 5.0
    surface = Surface(points + np.array([0.5, 0, 0]), triangles)
    assert surface.contains(turned(line)).mean() > surface.contains(line).mean()
    (told,) = check_same_space(surface, line)
    assert told.kind == "partly-outside"


@pytest.mark.parametrize("factor", [10, 0.1])
def test_a_line_in_another_unit_is_refused_though_half_of_it_lies_inside(factor):
    """Of a wide vessel that begins at the origin, where lines in cm and in mm meet."""
    points, triangles = open_tube(radius=8.0, length=90.0)
    z = np.r_[np.linspace(0.5, 8.9, 60), np.linspace(9.1, 89, 60)]
    line = np.stack([0 * z, 0 * z, z], axis=1) * factor
    inside = Surface(points, triangles).contains(line).mean()
    if factor > 1:
        assert inside == pytest.approx(0.5, abs=0.02)
        with pytest.raises(InputError, match=r"different units \(it would fit 0\.1 times as large"):
            check_same_space(Surface(points, triangles), line)
    else:
        assert check_same_space(Surface(points, triangles), line) == ()  # it fits as it is


def test_the_size_of_a_vessel_is_expected():
    points, triangles = octahedron(radius=30)
    assert size_warnings(Surface(points, triangles), "s") == ()
    (small,) = size_warnings(Surface(points / 10, triangles), "s.stl", "mm")
    assert "s.stl: read in mm, it is 6 mm long and about" in str(small)
    assert "name the unit of the file if it is another" in str(small)
    assert len(size_warnings(Surface(points * 100, triangles), "s")) == 1
    (tube,) = size_warnings(Surface(open_tube()[0] / 10, open_tube()[1]), "tube")
    assert "wide" not in str(tube)  # the volume of an open surface says nothing
    thin = points / 30 * (0.5, 0.5, 40)  # 80 mm long, 1 mm wide
    assert len(size_warnings(Surface(thin, triangles), "s")) == 1


@pytest.mark.parametrize("away", [(100, 0, 0), (3000, 0, 0), (0, 0, 9000)])
def test_a_line_that_fits_only_as_a_spot_is_not_blamed_on_units(away):
    points, triangles = open_tube()  # it passes by the origin, where everything shrinks to
    line = axis() - HERE + away
    with pytest.raises(InputError, match="it lies elsewhere, and neither other units") as caught:
        check_same_space(Surface(points, triangles), line)
    assert "times as large" not in str(caught.value)


@pytest.mark.parametrize("name", ["aorta_iliac", "pulmonary"])
def test_a_vessel_in_cm_that_is_read_in_mm_is_told(data_dir, name):
    """An aorta of 2 mm got stents of 1.6 mm without a word."""
    path = data_dir / f"{name}_surface_cm.vtp"
    assert [one.kind for one in read_surface(path).warnings] == ["unusual-size"]
    assert read_surface(path, units="cm").warnings == ()
