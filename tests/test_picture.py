"""The picture for the heart team: what it shows, from where, and what happens without OpenGL."""

from __future__ import annotations

import stat
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from SDFStentLib import phantoms
from SDFStentLib.geometry.polyline import closest_points
from SDFStentLib.phantoms.phantoms import Phantom
from SDFStentLib.report.picture import picture
from SDFStentLib.report.picture.geometry import (
    WALL_COLOR,
    diameter_colors,
    section_ring,
    stent_lattice,
    wall_colors,
)
from SDFStentLib.report.picture.picture import render_before_after
from SDFStentLib.report.picture.view import View, best_view, label_side
from SDFStentLib.validation import DeploymentError, InputError

FRONT = View(np.zeros(3), np.array([0.0, 1, 0]), np.array([0.0, 0, 1]), 20.0)
"""A camera in front of the patient (RAS)."""


@pytest.fixture(scope="module")
def artery() -> Phantom:
    return phantoms.branching_pulmonary_artery(1.0)


@pytest.fixture(scope="module")
def stent_axis(artery: Phantom) -> np.ndarray:
    assert artery.throat is not None
    middle = artery.throat.arc_length
    return artery.axis_at(np.linspace(middle - 9, middle + 9, 30))


def pushed_out(points: np.ndarray, axis: np.ndarray, radius: float) -> np.ndarray:
    """The surface with all points at least `radius` from the axis: as good as a deployment."""
    foot = closest_points(axis, points)
    outward = (points - foot.points) / foot.distances[:, None]
    return points + np.maximum(radius - foot.distances, 0)[:, None] * outward


def pixels(path: Path) -> np.ndarray:
    """(height, width, 3) of a PNG, top row first."""
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOImage import vtkPNGReader

    reader = vtkPNGReader()
    reader.SetFileName(str(path))
    reader.Update()
    width, height, _ = reader.GetOutput().GetDimensions()
    values = vtk_to_numpy(reader.GetOutput().GetPointData().GetScalars())
    return values.reshape(height, width, -1)[::-1].astype(int)


def is_near(image: np.ndarray, color: tuple[float, float, float], within: int = 40) -> np.ndarray:
    return (np.abs(image - 255 * np.array(color)) < within).all(axis=2)


@pytest.fixture(scope="module")
def image(
    artery: Phantom, stent_axis: np.ndarray, tmp_path_factory: pytest.TempPathFactory
) -> np.ndarray:
    path = tmp_path_factory.mktemp("picture") / "before after \N{GREEK SMALL LETTER ALPHA}.png"
    after = pushed_out(artery.points, stent_axis, 3.5)
    try:
        render_before_after(path, artery.points, after, artery.triangles, stent_axis, 7.0)
    except DeploymentError as error:
        pytest.skip(f"nothing here renders: {error}")
    return pixels(path)


def test_the_picture_is_white_with_two_equal_panels(image: np.ndarray) -> None:
    assert image.shape == (700, 1200, 3)
    for corner in (image[0, 0], image[0, -1], image[-1, 0], image[-1, -1]):
        np.testing.assert_array_equal(corner, 255)
    is_drawn = (image[110:590] < 250).any(axis=2)
    # The vessel fills both panels alike: same camera.
    shares = is_drawn[:, :595].mean(), is_drawn[:, 605:].mean()
    assert min(shares) > 0.15
    assert shares[0] == pytest.approx(shares[1], rel=0.15)


def test_only_the_panel_before_shows_a_narrow_lumen(image: np.ndarray) -> None:
    panels = image[110:590, :595], image[110:590, 605:]
    # Violet for narrow: red and blue above green. The wall is red, the wide lumen green.
    narrow = [((p[..., 2] > p[..., 1] + 25) & (p[..., 0] < 150)).sum() for p in panels]
    assert narrow[0] > 300
    assert narrow[1] < 0.1 * narrow[0]
    green = [(p[..., 1] > np.maximum(p[..., 0], p[..., 2]) + 20).sum() for p in panels]
    assert green[1] > 2 * green[0]


def test_words_scales_and_small_print_are_there(image: np.ndarray) -> None:
    is_dark = (image < 200).all(axis=2)
    for rows, columns in [
        (slice(45, 70), slice(120, 480)),  # before
        (slice(45, 70), slice(720, 1080)),  # after
        (slice(648, 662), slice(50, 250)),  # length scale
        (slice(622, 640), slice(510, 690)),  # title of the colour scale
        (slice(660, 676), slice(850, 1120)),  # research use only
    ]:
        assert is_dark[rows, columns].sum() > 30
    bar = image[655, 410:790]
    assert bar[2, 2] > bar[2, 1]  # violet at the left
    assert (bar[-3, :2] > 200).all()  # yellow at the right


def test_the_stent_lies_in_the_plane_of_the_picture(
    artery: Phantom, stent_axis: np.ndarray
) -> None:
    view = best_view(stent_axis, 3.5, (artery.points, artery.points))
    chord = stent_axis[-1] - stent_axis[0]
    assert abs(view.toward_camera @ chord) < 1e-9 * np.linalg.norm(chord)
    np.testing.assert_allclose(
        [view.up @ view.toward_camera, np.linalg.norm(view.up)], [0, 1], atol=1e-12
    )
    np.testing.assert_allclose(np.linalg.det([view.right, view.up, view.toward_camera]), 1)
    assert view.up[2] > 0.8  # the head is up
    assert view.toward_camera[1] > 0  # seen from the front


def test_opposite_fronts_give_opposite_views(artery: Phantom, stent_axis: np.ndarray) -> None:
    ras, lps = (
        best_view(stent_axis, 3.5, (artery.points, artery.points), anterior=(0.0, side, 0.0))
        for side in (1.0, -1.0)
    )
    assert ras.toward_camera @ lps.toward_camera < 0


def test_a_branching_is_seen_spread_out() -> None:
    s = np.linspace(0, 30, 60)[:, None]
    trunk, left, right = s * [0, 0, 1.0], s * [0, 0.6, -0.8], s * [0, -0.6, -0.8]
    view = best_view(trunk[10:30], 2.0, (np.vstack([trunk, left, right]),) * 2)
    # All points lie in the plane x = 0, which must be the plane of the picture.
    assert abs(view.toward_camera[0]) > 0.99


def test_a_neighboring_vessel_does_not_hide_the_stent() -> None:
    made = phantoms.tube_with_neighbor()
    view = best_view(made.axis_at(np.linspace(10, 30, 20)), 3.0, (made.points, made.points))
    assert abs(view.toward_camera[0]) < 0.5  # the neighbour stands at +x


def test_a_small_vessel_is_shown_whole_and_a_long_one_around_the_stent() -> None:
    tube = phantoms.straight_tube(length=40.0)
    axis = tube.axis_at(np.linspace(10, 30, 20))
    whole = best_view(axis, 3.0, (tube.points, tube.points))
    assert 20 < whole.half_height < 24
    long = phantoms.straight_tube(length=200.0)
    part = best_view(axis + np.array([0, 0, 80]), 3.0, (long.points, long.points))
    assert part.half_height < 50
    np.testing.assert_allclose(part.focus, [0, 0, 100], atol=2.0)  # half a ring of the mesh


def test_a_stent_along_the_body_axis_and_a_closed_axis_have_a_view_too() -> None:
    tube = phantoms.straight_tube()
    angle = np.linspace(0, 2 * np.pi, 20)
    loop = np.stack([5 * np.cos(angle), 5 * np.sin(angle), 0 * angle], axis=1)
    for axis in (tube.axis_at(np.linspace(5, 30, 9)), loop):
        view = best_view(axis, 2.0, (tube.points, tube.points))
        assert np.isfinite([*view.focus, *view.toward_camera, *view.up, view.half_height]).all()


def test_only_the_wall_along_the_stent_takes_the_colour_of_the_diameter() -> None:
    tube = phantoms.straight_tube(length=40.0)
    axis = tube.axis_at(np.linspace(10, 30, 21))
    colors = wall_colors(
        tube.points, tube.triangles, FRONT, axis, np.full(21, 6.0), 3.3, (4.0, 6.0)
    )
    height = tube.points[:, 2]
    far = (height < 8) | (height > 32)
    is_stented = (height > 11) & (height < 29)
    np.testing.assert_allclose(colors[far, :3], np.tile(WALL_COLOR, (far.sum(), 1)))
    widest = diameter_colors(np.array([1.0]))
    np.testing.assert_allclose(colors[is_stented, :3], np.repeat(widest, is_stented.sum(), axis=0))
    assert ((colors >= 0) & (colors <= 1)).all()
    # Edge-on walls are denser than those that face the camera.
    sideways = np.abs(tube.points[:, 0]) > 2.9
    assert colors[far & sideways, 3].min() > 1.5 * np.median(colors[far & ~sideways, 3])


def test_the_struts_lie_on_the_cylinder_and_end_with_the_axis() -> None:
    axis = np.linspace([0, 0, 5], [0, 0, 25], 12)
    lattice = stent_lattice(axis, np.full(12, 3.0), 0.1)
    np.testing.assert_allclose(np.linalg.norm(lattice[..., :2], axis=-1), 3.1, atol=1e-9)
    np.testing.assert_allclose([lattice[..., 2].min(), lattice[..., 2].max()], [5, 25], atol=1e-9)


def test_a_shaky_axis_does_not_shake_the_struts() -> None:
    rng = np.random.default_rng(7)
    axis = np.linspace([0, 0, 0], [0, 0, 30], 61)
    shaky = axis + rng.normal(scale=0.05, size=axis.shape) * [1, 1, 0]
    lattice = stent_lattice(shaky, np.full(61, 4.0))
    # Sections stay level: a tilt of one chord's 0.05 * sqrt(2) / 0.5 would lift them by 0.57 mm,
    # averaged over the 8 chords within one radius it is an eighth of that, three sigma 0.2 mm.
    assert np.ptp(lattice[..., 2], axis=0).max() < 2 * 0.2


def test_a_section_ring_is_a_circle_across_the_axis() -> None:
    axis = np.linspace([1, 2, 0], [1, 2, 20], 5)
    ring = section_ring(axis, 7.0, 2.5) - [1, 2, 7]
    np.testing.assert_allclose(np.linalg.norm(ring[:, :2], axis=1), 2.5)
    np.testing.assert_allclose(ring[:, 2], 0, atol=1e-12)
    np.testing.assert_allclose(ring[0], ring[-1], atol=1e-12)


def test_a_label_is_put_where_there_is_no_vessel() -> None:
    z = np.linspace(-20, 20, 200)
    column = np.stack([0 * z, 0 * z, z], axis=1)
    wall = np.stack([0 * z - 4, 0 * z, z], axis=1)
    place = label_side(FRONT, np.vstack([column, wall]), np.zeros(3), 3.0, np.array([4.0, 2.0]))
    assert abs(place[0]) > 2.0  # half the label's width: beside the column
    # Seen from the front, x runs to the left: the wall at x = -4 is on the right.
    assert place[0] < 0


def test_colours_run_from_dark_to_light() -> None:
    lightness = diameter_colors(np.linspace(-0.5, 1.5, 50)) @ [0.2126, 0.7152, 0.0722]
    assert (np.diff(lightness) >= -1e-12).all()


def tube_input(**changes: Any) -> dict[str, Any]:
    tube = phantoms.straight_tube(length=20.0, edge_length=1.5)
    arguments = {
        "points_before": tube.points,
        "points_after": tube.points,
        "triangles": tube.triangles,
        "axis_points": [(0, 0, 5), (0, 0, 15)],
        "stent_diameter": 6.0,
    }
    return {**arguments, **changes}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"points_after": np.zeros((5, 3))}, "points_after: .* must have the same points"),
        ({"points_before": [[np.nan] * 3] * 3}, "points_before: expected finite coordinates"),
        ({"triangles": [[0, 1, 10**6]]}, "triangles: expected point indices"),
        ({"axis_points": [(0, 0, 5)]}, "axis_points: expected at least 2 points"),
        ({"axis_points": [(0, 0, 5)] * 2}, "axis_points: expected a line of some length"),
        ({"stent_diameter": 0.0}, "stent_diameter: expected a number greater than 0"),
        ({"stent_diameter": [6, 6, 6]}, "stent_diameter: expected one number above 0 or 2"),
        ({"diameter_before": [5, 5]}, "arc_length: expected the positions of the diameters"),
        ({"arc_length": [30, 40]}, "arc_length: expected ascending positions on the stent axis"),
        ({"arc_length": [5, 4]}, "arc_length: expected ascending positions on the stent axis"),
        ({"arc_length": [2, 4], "diameter_after": [1]}, "diameter_after: expected 2 diameters"),
        ({"arc_length": [2], "diameter_before": [np.nan]}, "diameter_before: .* got 0 known"),
        ({"path": "no/such/folder/x.png"}, "no/such/folder"),
    ],
)
def test_input_that_fits_nothing_is_refused(
    tmp_path: Path, changes: dict[str, Any], message: str
) -> None:
    arguments = {"path": tmp_path / "picture.png", **tube_input(**changes)}
    with pytest.raises(InputError, match=message):
        render_before_after(**arguments)
    assert not list(tmp_path.iterdir())


def interpreter(folder: Path, script: str) -> str:
    """A program that stands in for Python."""
    path = folder / "python"
    path.write_text(f"#!/bin/sh\n{script}\n", encoding="utf-8")
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return str(path)


@pytest.mark.skipif(sys.platform == "win32", reason="stands in for Python by a shell script")
@pytest.mark.parametrize(
    ("script", "message"),
    [
        ("kill -SEGV $$", "ended with code -11.*libegl1 libgl1"),  # VTK without OpenGL
        ("echo no OpenGL >&2; exit 1", "ended with code 1 .it said: no OpenGL.*libegl1"),
        ("exit 0", "ended with code 0.*libegl1"),  # well, but without a picture
        ("sleep 5", "could not be rendered: .* timed out"),
    ],
)
def test_a_renderer_that_dies_is_an_error_that_names_the_packages(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, script: str, message: str
) -> None:
    monkeypatch.setattr(sys, "executable", interpreter(tmp_path, script))
    monkeypatch.setattr(picture, "PATIENCE", 0.5 if "sleep" in script else 20)
    old = tmp_path / "picture.png"
    old.write_bytes(b"old")
    with pytest.raises(DeploymentError, match=message):
        render_before_after(old, **tube_input())
    assert old.read_bytes() == b"old"


def test_a_missing_interpreter_is_an_error_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "executable", str(tmp_path / "absent"))
    with pytest.raises(DeploymentError, match=r"could not be rendered: .*No such file"):
        render_before_after(tmp_path / "picture.png", **tube_input())


def test_given_diameters_are_written_on_the_picture(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: dict[str, Any] = {}

    def instead(arrays: dict[str, Any], words: dict[str, Any]) -> bytes:
        seen.update(words)
        return b"drawn"

    monkeypatch.setattr(picture, "_rendered", instead)
    written = render_before_after(
        tmp_path / "picture.png",
        **tube_input(),
        arc_length=[-3.0, 0.0, 4.0, 8.0, 13.0],
        diameter_before=[1.0, 5.0, np.nan, 3.6, 1.0],  # the first and last lie off the stent
        diameter_after=[1.0, 6.2, 6.0, 6.1, 1.0],
    )
    assert written.read_bytes() == b"drawn"
    assert seen["headings"] == ["Before: minimum lumen 3.6 mm", "After: minimum lumen 6.0 mm"]
    assert seen["marks"] == ["3.6 mm", "6.1 mm"]  # both where it was narrowest before
    assert seen["limits"] == (3.5, 6.5)
    assert seen["notes"][1] == "stent 6.0 x 10 mm"
    assert "Research use only" in seen["small_print"]
