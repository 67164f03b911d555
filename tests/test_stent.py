"""Stents: sizes, placements, junctions, ends of the centerline, bends, straightening."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline
from trees import unbranched
from tube_files import deploy

from benchmarks.phantoms import hairpin_tube, straight_tube
from SDFStentLib.centerline import Centerline
from SDFStentLib.cli import main
from SDFStentLib.deformation import DeploymentSettings
from SDFStentLib.geometry import Line, smoothed_line
from SDFStentLib.plan import load_plan
from SDFStentLib.stent import (
    AlongAxis,
    AtCenter,
    AtDistalEnd,
    AtProximalEnd,
    BetweenPoints,
    Stent,
    stent_axis,
    straight_way,
)
from SDFStentLib.treatment import AxisChange, Preview, Treatment, axis_in_vessel
from SDFStentLib.validation import InputError

ROUNDING = 1e-9  # algebra on coordinates of 100 mm


def a_tube(radius: float = 3.0) -> Centerline:
    """A straight centerline of 100 mm, root at z = 0, down to z = -100."""
    points = Line([[0, 0, 0], [0, 0, -100]]).resampled(2.0).points
    return unbranched(points, np.full(len(points), radius))


def an_arc(radius: float, degrees: float = 180.0) -> np.ndarray:
    angles = np.radians(np.linspace(0, degrees, 400))
    return radius * np.column_stack([np.cos(angles), np.sin(angles), 0 * angles])


# ---- placements


def test_at_the_center_half_of_the_deployed_length_lies_on_either_side():
    stent = Stent(6.0, placement=AtCenter([1, 0, -50]), length=20, foreshortening_fraction=0.1)
    axis = stent_axis(stent, a_tube())
    np.testing.assert_allclose(axis.points[[0, -1]], [[0, 0, -41], [0, 0, -59]], atol=ROUNDING)
    assert (axis.nominal_length, axis.prescribed_length) == (20, 18)
    assert axis.deployed_length == pytest.approx(18)
    assert axis.chord == pytest.approx(18)
    assert axis.inscribed_radius.tolist() == [3] * len(axis.points)
    assert axis.warnings == ()


def test_at_the_distal_end_it_reaches_up_and_at_the_proximal_end_down():
    ends = []
    for place in (AtDistalEnd, AtProximalEnd):
        stent = Stent(6.0, placement=place([0, 1, -50]), length=20, foreshortening_fraction=0)
        ends.append(stent_axis(stent, a_tube()).points[[0, -1], 2].tolist())
    np.testing.assert_allclose(ends, [[-30, -50], [-50, -70]], atol=ROUNDING)


@pytest.mark.parametrize("swapped", [False, True])
def test_between_two_points_the_order_of_the_points_is_free(swapped):
    ends = [[0, 1, -20], [0, 1, -55]]
    axis = stent_axis(Stent(6.0, placement=BetweenPoints(*ends[:: -1 if swapped else 1])), a_tube())
    np.testing.assert_allclose(axis.points[[0, -1]], [[0, 0, -20], [0, 0, -55]], atol=ROUNDING)
    assert axis.prescribed_length == axis.nominal_length == pytest.approx(35)


@settings(max_examples=50)
@given(st.floats(0, 100), st.floats(1, 60), st.floats(-0.2, 0.5))
def test_the_deployed_length_is_the_prescribed_one_or_is_said_to_be_shorter(at, nominal, lost):
    stent = Stent(
        6.0, placement=AtCenter([0, 0, -at]), length=nominal, foreshortening_fraction=lost
    )
    axis = stent_axis(stent, a_tube())
    half = nominal * (1 - lost) / 2
    expected = min(at + half, 100) - max(at - half, 0)
    assert axis.deployed_length == pytest.approx(expected, abs=1e-8)
    # Told to a tenth, what is less than that is nothing.
    assert bool(axis.warnings) == (axis.deployed_length < 2 * half - 0.1)
    assert (np.diff(axis.points[:, 2]) < 0).all()


# ---- what is said


@pytest.mark.parametrize(
    ("bend", "warned"), [(2.0, True), (2.9, True), (3.2, False), (50.0, False)]
)
def test_a_bend_tighter_than_the_stent_radius_is_said(bend, warned):
    axis = stent_axis(Stent(6.0, placement=AlongAxis(an_arc(bend))))
    # Points on the chords of a fine arc: right to well below one percent.
    assert axis.minimum_bend_radius(3.0) == pytest.approx(bend, rel=0.01)
    assert [f"{bend:.1f} mm against 3.0 mm" in str(text) for text in axis.warnings] == [
        True
    ] * warned


# ---- straightening


def pieces(line):
    return np.linalg.norm(np.diff(line, axis=0), axis=1)


@pytest.mark.parametrize("fraction", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("keeps", ["center", "proximal", "distal"])
def test_straightening_conserves_the_length_of_every_piece(fraction, keeps):
    rng = np.random.default_rng(7)
    wild = np.cumsum(rng.normal([1.0, 0.2, 0.1], 0.6, (60, 3)), axis=0)
    for line in (an_arc(10.0, 90), wild):
        found = straight_way(Line(line), keeps).at(fraction).points
        np.testing.assert_allclose(pieces(found), pieces(line), atol=1e-12)
        assert Line(found).length == pytest.approx(Line(line).length, abs=1e-6)
        chord = np.linalg.norm(found[-1] - found[0])
        if fraction == 1:
            assert chord == pytest.approx(Line(line).length, abs=1e-9)
        else:
            assert chord >= np.linalg.norm(line[-1] - line[0]) - 1e-9


def test_an_arc_loses_that_share_of_its_curvature():
    """Of radius r it becomes one of radius r / (1 - F) and as long, by the formula of an arc."""
    half = straight_way(Line(an_arc(10.0, 90))).at(0.5).points
    angle = np.radians(90) / 2
    assert np.linalg.norm(half[-1] - half[0]) == pytest.approx(2 * 20 * np.sin(angle / 2), abs=1e-3)
    middle = half[[0, -1]].mean(axis=0)
    sagitta = np.linalg.norm(half - middle, axis=1).min()
    assert sagitta == pytest.approx(20 * (1 - np.cos(angle / 2)), abs=0.01)


def test_a_piece_that_points_back_turns_round_and_a_closed_line_is_refused():
    back = np.array([[0, 0, 0], [6, 0, 0], [4, 0, 0], [4, 0, 0], [9, 0, 0.0]])
    np.testing.assert_allclose(
        pieces(straight_way(Line(back)).at(0.5).points), pieces(back), atol=1e-12
    )
    assert straight_way(Line(back)).at(1.0).length == pytest.approx(13.0)
    with pytest.raises(InputError, match="expected two ends apart to straighten it"):
        straight_way(Line(back[[0, 1, 0]])).at(0.5)


@pytest.mark.parametrize(("radius", "limit"), [(3.0, 6.0), (np.nan, 20.0)])
def test_a_placement_far_from_the_vessel_is_refused_with_its_distance(radius, limit):
    tube = a_tube(radius)
    near, far = AtCenter([0.99 * limit, 0, -50]), AtCenter([limit + 1, 0, -50])
    assert stent_axis(Stent(6.0, placement=near, length=9), tube).deployed_length > 8
    message = rf"center: .* within {limit:g} mm .* {limit + 1:g} mm away; check .* unit"
    with pytest.raises(InputError, match=message):
        stent_axis(Stent(6.0, placement=far, length=9), tube)


# ---- degenerate and wrong input


def test_two_points_at_one_place_and_ends_without_centerline_beyond_are_refused():
    for placement, size in (
        (BetweenPoints([0, 1, -50], [1, 0, -50]), None),
        (AtDistalEnd([0, 0, 0]), 9.0),
        (AtProximalEnd([0, 0, -100]), 9.0),
    ):
        with pytest.raises(InputError, match=r"expected some length of centerline .* got none at"):
            stent_axis(Stent(6.0, placement=placement, length=size), a_tube())


# Stents of which less than half can lie on the vessel are refused, unless that is asked for.

SIZES = ["--units", "cm", "--diameter", "6", "--foreshortening", "0"]
ALONG_LINE = ["--centerline", "line.vtp"]
# The tube is 40 mm long, from z = 0 to 4 cm, the curve 16 mm.
PLACES = {
    "below the end": ([*ALONG_LINE, "--distal", "0", "0", "0.02", "--length", "35.2"], 35.2, 0.2),
    "a short curve": (["--axis", "axis.vtp", "--length", "40"], 40.0, 16.0),
}


@pytest.fixture
def said(a_folder, capsys):
    """Exit code of a command in the folder of the tube, and what it says as warning or error."""

    def run(*words):
        return main([*words]), capsys.readouterr().err

    return run


def deployed(said, place, *more):
    return said("deploy", "tube.vtp", *SIZES, *place, "-o", "out.vtp", *more)


@pytest.mark.parametrize("name", PLACES)
def test_a_stent_of_which_less_than_half_fits_is_refused_unless_asked_for(said, a_folder, name):
    place, prescribed, available = PLACES[name]
    before = {path.name for path in a_folder.iterdir()}
    code, error = deployed(said, place)
    assert code == 2, error
    assert f"at least half of its {prescribed:.1f} mm" in error
    assert f"got {available:.1f} mm" in error
    assert "--shortened" in error
    assert {path.name for path in a_folder.iterdir()} == before

    code, error = deployed(said, place, "--shortened", "--save-plan", "plan.json")
    assert code == 0, error
    assert f"shortened: {prescribed:.1f} mm were prescribed, {available:.1f}" in error

    plan = json.loads((a_folder / "plan.json").read_text(encoding="utf-8"))
    assert plan["stents"][0]["may_be_shortened"] is True
    code, error = said("run", "plan.json", "-o", "again")
    assert code == 0, error
    del plan["stents"][0]["may_be_shortened"]
    (a_folder / "plan.json").write_text(json.dumps(plan), encoding="utf-8")
    code, error = said("run", "plan.json", "-o", "never")
    assert code == 2, error
    assert f"at least half of its {prescribed:.1f} mm" in error


def test_half_a_stent_on_the_vessel_is_enough(said):
    code, error = deployed(said, [*ALONG_LINE, "--center", "0", "0", "4", "--length", "20"])
    assert code == 0, error
    assert "is shortened" in error


def test_a_stent_that_is_dilated_again_is_not_refused_twice(said):
    place, *_ = PLACES["a short curve"]
    code, error = deployed(said, place, "--shortened", "--redilate", "7")
    assert code == 0, error


# Axes that are smoothed, drawn by hand, or bend too tightly somewhere.


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


def test_a_stent_from_end_to_end_is_packed_as_long_as_it_shortens_from_when_it_is_smoothed():
    tube = straight_tube(radius=3.0, length=40.0)
    rough = shaky(tube.axis_at(np.linspace(8, 32, 60)), 0.25)
    stent = Stent(7.0, placement=AlongAxis(rough), foreshortening_fraction=0.2)
    found = axis_in_vessel(stent, None, tube.surface, AxisChange(smoothing_length=3.0))
    assert found.deployed_length < stent_axis(stent).deployed_length - 1
    assert found.prescribed_length == found.deployed_length
    assert 0.8 * found.nominal_length == pytest.approx(found.deployed_length, rel=1e-12)


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
