"""Stents: sizes, placements, junctions, ends of the centerline, bends, straightening."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from trees import unbranched

from SDFStentLib.centerline import Centerline
from SDFStentLib.cli import main
from SDFStentLib.geometry import Line
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
