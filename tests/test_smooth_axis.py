"""Axes that are smoothed, drawn by hand, or bend too tightly somewhere."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from tube_files import deploy

from SDFStentLib.cli import main
from SDFStentLib.deformation import DeploymentSettings
from SDFStentLib.geometry import Line, smoothed_line
from SDFStentLib.phantoms import hairpin_tube, straight_tube
from SDFStentLib.plan import load_plan
from SDFStentLib.stent import AlongAxis, Stent, stent_axis
from SDFStentLib.treatment import AxisChange, Preview, Treatment, axis_in_vessel


def arc(radius=20.0, angle=2.0, count=801):
    at = np.linspace(0, angle, count)
    return radius * np.stack([np.cos(at), np.sin(at), 0 * at], axis=1)


def shaky(points, by, seed=3):
    return points + np.random.default_rng(seed).normal(0, by, points.shape)


# The line


def test_no_smoothing_leaves_every_bit():
    np.testing.assert_array_equal(smoothed_line(Line(arc()), 0).points, arc())


def test_an_arc_moves_inwards_as_a_mean_by_a_normal_distribution_does():
    """The mean of cos(s / r) with that weight is exp(-sigma^2 / (2 r^2)), by integration."""
    radius, sigma = 20.0, 2.0
    line = arc(radius)
    middle = smoothed_line(Line(line), sigma).points[len(line) // 2]
    assert np.linalg.norm(middle) == pytest.approx(
        radius * np.exp(-(sigma**2) / (2 * radius**2)), abs=1e-3
    )


def test_each_place_is_the_weighted_mean_around_it():
    """Against the sum over a fine line, written out, away from the ends."""
    points = shaky(np.linspace([0, 0, 0], [40, 0, 0], 41), 0.3)
    at = Line(points).arc_lengths
    fine = np.linspace(0, at[-1], 40_001)
    line = np.stack([np.interp(fine, at, one) for one in points.T], axis=1)
    found = smoothed_line(Line(points), 1.5).points
    for number in (12, 20, 27):
        weights = np.exp(-0.5 * ((fine - at[number]) / 1.5) ** 2)
        np.testing.assert_allclose(found[number], weights @ line / weights.sum(), atol=0.02)


# The axis of a stent


def test_a_shaky_axis_is_smoothed_in_a_treatment_and_its_preview_alike():
    tube = straight_tube(radius=3.0, length=40.0)
    rough = shaky(tube.axis_at(np.linspace(8, 32, 60)), 0.25)
    stent = Stent(7.0, placement=AlongAxis(rough))
    settings = DeploymentSettings(axis_smoothing=3.0)
    result = Treatment(tube.surface, [stent], None, settings).result
    (treated,) = result.stents
    np.testing.assert_allclose(
        treated.axis.points, smoothed_line(Line(rough), 3.0).points, atol=1e-12
    )
    seen = Preview(tube.surface).of([stent], settings)
    np.testing.assert_array_equal(seen.stents[0].axis.points, treated.axis.points)
    assert result.certificate.passed
    plain = Treatment(tube.surface, [stent]).result.stents[0].axis.points
    np.testing.assert_array_equal(plain, rough)


def test_a_stent_with_a_length_keeps_it_where_the_wall_stops_its_smoothing():
    made = hairpin_tube()
    axis = made.axis_at(np.linspace(5, 45, 120))
    stent = Stent(5.0, placement=AlongAxis(axis), length=30.0, foreshortening_fraction=0.0)
    found = axis_in_vessel(stent, None, made.surface, AxisChange(smoothing_length=15.0))
    assert "smoothed-less" in {one.kind for one in found.warnings}
    assert Line(found.points).length == pytest.approx(30.0, abs=1e-9)
    assert np.abs(found.points - stent_axis(stent).points).max() > 0.1


def test_smoothing_keeps_the_axis_off_the_wall_and_says_where_it_stopped():
    """Around a hairpin, whose smooth line would leave the lumen for the other leg."""
    made = hairpin_tube()
    axis = made.axis_at(np.linspace(5, 45, 120))
    stent = Stent(5.0, placement=AlongAxis(axis))
    found = axis_in_vessel(stent, None, made.surface, AxisChange(smoothing_length=15.0))
    (caution,) = [one for one in found.warnings if one.kind == "smoothed-less"]
    assert 0 < caution.numbers["fraction"] < 1
    # Every place is still in the lumen: nearer to the vessel's own axis than its radius.
    middle = made.axis_at(np.linspace(0, 60, 2001))
    radius = float(np.median(np.linalg.norm(made.points[:, None] - middle[::20], axis=2).min(1)))
    away = np.linalg.norm(found.points[:, None] - middle, axis=2).min(axis=1)
    assert away.max() < 0.75 * radius
    assert np.linalg.norm(found.points - caution.place, axis=1).min() < 1.0


def test_the_shell_smooths_saves_and_replays(a_folder):
    rng = np.random.default_rng(2)
    points = np.stack([*rng.normal(0, 0.02, (2, 30)), np.linspace(1.2, 2.8, 30)], axis=1)
    markups("hand.mrk.json", points)
    options = ["--smooth-axis", "2", "--save-plan", "p.json", "--report", "r.json", "--quiet"]
    assert deploy(*options, place=["--axis", "hand.mrk.json"], line=None) == 0
    assert load_plan("p.json").settings.axis_smoothing == 2
    assert main(["run", "p.json", "-o", "again", "--quiet"]) == 0
    one, other = (
        json.loads(Path(path).read_text(encoding="utf-8"))
        for path in ("r.json", "again/report.json")
    )
    assert one["settings"]["axis_smoothing_mm"] == 2
    assert one["stents"] == other["stents"]
    assert deploy("--smooth-axis", "-1", place=["--axis", "hand.mrk.json"], line=None) == 2


# Drawn by hand


def markups(path, points):
    """A curve as Slicer saves it, in LPS; coordinates in the file's unit."""
    controls = [{"id": str(n), "position": list(p)} for n, p in enumerate(points.tolist(), 1)]
    curve = {"type": "Curve", "coordinateSystem": "LPS", "controlPoints": controls}
    Path(path).write_text(json.dumps({"markups": [curve]}), encoding="utf-8")


def test_a_curve_drawn_by_hand_is_the_axis_as_slicer_shows_it(a_folder):
    """A few control points, and the spline through them: no corners where they are."""
    beside = [[0, 0], [0.02, 0.03], [-0.03, 0.02], [0, -0.02], [0, 0]]
    points = np.column_stack([beside, [1.2, 1.6, 2.0, 2.4, 2.8]])
    markups("hand.mrk.json", points)
    report = ["--report", "r.json", "--save-plan", "p.json", "--quiet"]
    assert deploy(*report, place=["--axis", "hand.mrk.json"], line=None) == 0
    told = json.loads(Path("r.json").read_text(encoding="utf-8"))
    spline = CubicSpline(np.arange(5), 10 * points, bc_type="clamped")(np.linspace(0, 4, 41))
    axis = told["stents"][0]["axis"]
    assert axis["length_mm"] == pytest.approx(Line(spline).length, abs=1e-6)
    np.testing.assert_allclose(np.abs(axis["start_mm"]), np.abs(10 * points[0]), atol=1e-9)
    assert told["certificate"]["passed"]
    (used,) = load_plan("p.json").stents
    assert used.placement.file.path.endswith("hand.mrk.json")
    assert len(used.placement.points) == len(spline)


# Too tight


def test_smoothing_takes_a_tight_bend_and_its_warning_away():
    corner = np.array([[0, 0, 40], [12, 0, 40], [12, 12, 40.0]])
    line = np.array([np.interp(np.linspace(0, 2, 100), [0, 1, 2], one) for one in corner.T]).T
    tube = straight_tube(radius=30.0, length=80.0, edge_length=6.0)
    stent = Stent(9.0, placement=AlongAxis(line))
    kinds = [
        {one.kind for one in axis_in_vessel(stent, None, tube.surface, AxisChange(0.0, s)).warnings}
        for s in (0.0, 4.0)
    ]
    assert kinds == [{"tight-bend"}, set()]
