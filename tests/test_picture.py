"""The picture for the heart team: what it shows, from where, and what happens without OpenGL."""

import os
import stat
import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from benchmarks import phantoms
from SDFStentLib.deformation import DeploymentSettings
from SDFStentLib.files import encode_vtp, polydata_from_arrays
from SDFStentLib.plan import Plan, PlanResult, read_input_files, treatment_of
from SDFStentLib.report import before_after_picture
from SDFStentLib.report.picture import painting, picture
from SDFStentLib.report.picture.drawing import Box, Disc, Drawing, Stroke, Words, svg
from SDFStentLib.report.picture.painting import check_rendering, painted
from SDFStentLib.report.picture.picture import RED, before_after_scene
from SDFStentLib.report.picture.shapes import WALL_COLOR, strut_curves
from SDFStentLib.stent import AlongAxis, Stent
from SDFStentLib.validation import DeploymentError


@cache
def artery() -> phantoms.Phantom:
    return phantoms.branching_pulmonary_artery(1.0)


def carried_out(folder: Path, stents: tuple[Stent, ...], per_mm: float = 1.0) -> PlanResult:
    """Stents on axes of their own in the pulmonary artery, read from a file, no centerline."""
    data = polydata_from_arrays(per_mm * artery().points, artery().triangles)
    path = folder / "artery.vtp"
    path.write_bytes(encode_vtp(data))
    inputs = read_input_files(path, units="mm" if per_mm == 1 else "cm")
    plan = Plan(stents=stents, settings=DeploymentSettings(certify=False, untangle=False))
    return PlanResult(plan, inputs, treatment_of(plan, inputs).result)


def stent_at(start: float, end: float, diameter: float = 7.0) -> Stent:
    axis = artery().axis_at(np.linspace(start, end, 30))
    return Stent(diameter, placement=AlongAxis(axis))


@pytest.fixture(scope="module")
def stent_axis() -> np.ndarray:
    return artery().axis_at(artery().throat.arc_length + np.linspace(-9, 9, 30))


@pytest.fixture(scope="module")
def treated(tmp_path_factory: pytest.TempPathFactory, stent_axis: np.ndarray) -> PlanResult:
    stent = Stent(7.0, placement=AlongAxis(stent_axis))
    return carried_out(tmp_path_factory.mktemp("treated"), (stent,))


def pixels(png: bytes, folder: Path) -> np.ndarray:
    """(height, width, 3) of a PNG, top row first."""
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOImage import vtkPNGReader

    (folder / "picture.png").write_bytes(png)
    reader = vtkPNGReader()
    reader.SetFileName(str(folder / "picture.png"))
    reader.Update()
    width, height, _ = reader.GetOutput().GetDimensions()
    values = vtk_to_numpy(reader.GetOutput().GetPointData().GetScalars())
    return values.reshape(height, width, -1)[::-1].astype(int)


def drawn(folder: Path, drawing: Drawing) -> np.ndarray:
    try:
        return pixels(painted(drawing), folder)
    except DeploymentError as error:
        pytest.skip(f"nothing here renders: {error}")


@pytest.fixture(scope="module")
def image(treated: PlanResult, tmp_path_factory: pytest.TempPathFactory) -> np.ndarray:
    try:
        png = before_after_picture(treated, "\N{GREEK SMALL LETTER ALPHA}")
    except DeploymentError as error:
        pytest.skip(f"nothing here renders: {error}")
    return pixels(png, tmp_path_factory.mktemp("picture"))


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


def test_struts_are_drawn_after_treatment_and_can_be_hidden(
    treated: PlanResult, image: np.ndarray, tmp_path: Path
) -> None:
    bare = pixels(
        before_after_picture(treated, "\N{GREEK SMALL LETTER ALPHA}", hides_device=True), tmp_path
    )
    differs = (image != bare).any(axis=2)
    assert not differs[:, :600].any()
    # Steel is dark and gray; there is that much more of it, on the stented wall alone.
    assert image[differs].mean() < bare[differs].mean() - 10
    view = before_after_scene(treated, "")[1][1].view
    axis = view.pixels(treated.treatment.stents[0].axis.points) + np.array([600, 0])
    rows, columns = np.nonzero(differs)
    away = np.hypot(columns[:, None] - axis[:, 0], rows[:, None] - axis[:, 1]).min(axis=1)
    assert len(away) > 500
    assert away.max() < 3.5 * view.per_mm + 5  # the radius, and a strut's own width


def shown_words(result: PlanResult) -> list[str]:
    drawing, *_ = before_after_scene(result, "")
    return [mark.text for mark in drawing.marks if isinstance(mark, Words)]


def test_the_words_are_the_measured_diameters(treated: PlanResult) -> None:
    stent = treated.treatment.stents[0]
    words = shown_words(treated)
    narrow = np.argmin(stent.before.inscribed_diameter)
    assert f"Before: minimum lumen {stent.before.minimum:.1f} mm" in words
    assert f"After: minimum lumen {stent.after.minimum:.1f} mm" in words
    # Both where it was narrowest before.
    assert f"{stent.before.inscribed_diameter[narrow]:.1f} mm" in words
    assert f"{stent.after.inscribed_diameter[narrow]:.1f} mm" in words
    assert "stent 7.0 x 18 mm" in words
    assert any("Research use only" in each for each in words)


def test_two_stents_are_both_drawn_colored_and_marked(tmp_path: Path) -> None:
    both = carried_out(tmp_path, (stent_at(28, 36), stent_at(38, 44, 7.4)))
    drawing, walls = before_after_scene(both, "")
    first, second = both.treatment.stents
    for curves, stent in zip(strut_curves((first, second)), (first, second), strict=True):
        middle, axis = curves.mean(axis=(0, 1)), stent.axis.points.mean(axis=0)
        assert np.linalg.norm(middle - axis) < 0.5
        wall = np.linalg.norm(walls[1].points - stent.axis.points[15], axis=1)
        nearest = np.argsort(wall)[:5]
        assert (np.abs(walls[1].colors[nearest, :3] - WALL_COLOR).max(axis=1) > 0.2).all()
    words = [mark.text for mark in drawing.marks if isinstance(mark, Words)]
    lowest = min(first.before.minimum, second.before.minimum)
    assert f"Before: minimum lumen {lowest:.1f} mm" in words
    assert "stents 7.0 x 8 mm and 7.4 x 6 mm" in words
    red = [mark for mark in drawing.marks if isinstance(mark, Words) and mark.color == RED]
    assert len(red) == 4
    # A label at the same place in both panels, and no label over another.
    assert red[1].x - red[0].x == red[3].x - red[2].x == picture.WIDTH / 2
    assert max(abs(red[2].x - red[0].x) / 90, abs(red[2].y - red[0].y) / 28) > 1


# The drawing, as SVG and as PNG


def test_marks_are_painted_where_the_svg_has_them(tmp_path: Path) -> None:
    drawing = Drawing(
        100,
        60,
        (
            Box(10, 5, 20, 10, "#ff0000"),
            Disc(70, 15, 6, "#0000ff"),
            Stroke([(5, 50), (95, 50)], "#000000", 4, (10, 20)),
        ),
    )
    image = drawn(tmp_path, drawing)
    assert image.shape == (120, 200, 3)  # twice as fine
    np.testing.assert_array_equal(image[20, 40], [255, 0, 0])
    np.testing.assert_array_equal(image[35, 40], [255, 255, 255])
    np.testing.assert_array_equal(image[30, 140], [0, 0, 255])
    along = image[100, :, 0] < 128
    # Three whole dashes of 20 pixels, with gaps of 40 between them.
    np.testing.assert_array_equal(
        np.flatnonzero(np.diff(along.astype(int))) + 1, [10, 30, 70, 90, 130, 150]
    )
    text = svg(drawing)
    for words in ("x='10.00' y='5.00'", "cx='70.00' cy='15.00' r='6'", "stroke-dasharray='10 20'"):
        assert words in text


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
        ("exec sleep 60", "could not be rendered: .* timed out"),
    ],
)
def test_a_renderer_that_dies_is_an_error_that_names_the_packages(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, script: str, message: str
) -> None:
    monkeypatch.setattr(sys, "executable", interpreter(tmp_path, script))
    if "sleep" in script:
        monkeypatch.setattr(painting, "PATIENCE", 0.5)
    with pytest.raises(DeploymentError, match=message):
        painted(Drawing(8, 8, ()))


@pytest.mark.skipif(sys.platform == "win32", reason="stands in for Python by a shell script")
def test_slicer_starts_no_slicer_to_paint(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It embeds its Python, whose executable is the application itself, or nothing."""
    script = f'PATH={os.environ["PATH"]} exec "{sys.executable}" "$@"'
    Path(interpreter(tmp_path, script)).rename(tmp_path / "PythonSlicer")
    monkeypatch.setattr(sys, "executable", "")
    monkeypatch.setenv("PATH", "")
    with pytest.raises(DeploymentError, match="PythonSlicer"):
        check_rendering()
    monkeypatch.setenv("PATH", str(tmp_path))
    check_rendering()
