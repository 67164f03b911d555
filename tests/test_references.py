"""Against what a narrowing is measured: the nearest healthy vessel, and no throat or valley."""

from __future__ import annotations

import numpy as np
import pytest
from deployment_cases import phantom
from lesion_cases import SPACING, vessel_along

from SDFStentLib.centerline import Centerline, Stretch
from SDFStentLib.vessel import find_lesions
from SDFStentLib.vessel.lesion_sections import LesionLine, _smallest
from SDFStentLib.vessel.narrowings import narrowings
from SDFStentLib.vessel.plateaus import Plateau, Reference
from SDFStentLib.vessel.runs import SideBranch, _ostium, vessel_runs


def through(*places):
    """Diameters on smooth steps through (arc length, diameter)."""
    at, wide = np.array(places, dtype=float).T
    along = np.arange(0.0, at[-1] + SPACING / 2, SPACING)
    piece = np.clip(np.searchsorted(at, along, side="right") - 1, 0, len(at) - 2)
    share = (along - at[piece]) / (at[piece + 1] - at[piece])
    return wide[piece] + (wide[piece + 1] - wide[piece]) * share**2 * (3 - 2 * share)


def reference_of(diameter, parent=-1) -> float:
    (one,) = narrowings(vessel_along(diameter, parent))
    return float(one.reference.at(np.array([one.narrowest]))[0])


def test_a_vessel_that_widens_far_beyond_its_ostial_narrowing_is_measured_beside_it():
    """It was told against the 5.2 mm of its widest part: 65 % instead of 50 %."""
    widening = through((0, 1.8), (4, 3.6), (8, 3.6), (11, 5.2), (40, 5.2))
    assert reference_of(widening, parent=0) == pytest.approx(3.6, abs=0.1)


def test_both_sides_of_a_narrowing_count_where_one_goes_on_wider():
    """Healthy vessel of 3.7 mm beside it passed for a throat of the wider one."""
    widening = through((0, 3.7), (8, 3.7), (12, 2.0), (16, 4.0), (22, 4.2), (32, 5.5), (50, 5.5))
    assert reference_of(widening, parent=0) == pytest.approx(3.9, abs=0.3)


def test_a_lesion_reaches_to_the_station_beside_its_throat():
    """2.03 mm lay before the edge that a line to a station of 4.1 mm told; 2.10 were told."""
    steep = np.r_[4.1, 2.0, 2.6, 3.2, np.full(40, 3.7)]
    (one,) = narrowings(vessel_along(steep, parent=0))
    assert one.start == 0.0


def test_a_vessel_that_divides_into_narrower_ones_is_as_wide_as_it_is():
    """Against what its branches ask for, 6.2 mm, 38 % were told where 49 % are true."""
    wide = through(
        (0, 7.5), (12, 7.5), (14, 3.85), (20, 8.4), (22, 6.4), (24, 8.2), (26, 6.4), (29, 8)
    )
    branches = (SideBranch(29.0, 5.7, 1), SideBranch(29.0, 2.9, 2))
    (one,) = narrowings(vessel_along(wide)._replace(division=branches))
    usual = np.median(wide[np.argmin(wide) + 1 :])
    assert usual > 7.0
    assert one.reference.at(np.array([one.narrowest]))[0] == pytest.approx(usual, abs=0.1)


def test_a_valley_between_two_throats_is_no_healthy_vessel():
    valley = through((0, 5), (15, 5), (20, 2), (23, 3), (28, 3), (31, 2), (36, 5), (60, 5))
    assert reference_of(valley) == pytest.approx(5.0, abs=0.1)
    (one,) = narrowings(vessel_along(valley))
    assert one.start < 18
    assert one.end > 33


def test_two_throats_with_healthy_vessel_between_them_are_two():
    """In an aorta one of 71 % was not told: the deeper one, as the same part, ended before it."""
    proximal = ((0, 22), (24, 22), (62, 25), (72, 25), (94, 22), (98, 16), (106, 5.9), (116, 19))
    distal = ((122, 17), (130, 17), (136, 8.5), (140, 4.9), (144, 7.7), (146, 7), (156, 17))
    found = narrowings(vessel_along(through(*proximal, *distal, (176, 17), (200, 16), (216, 14))))
    assert [round(one.narrowest) for one in found] == [106, 140]


def test_healthy_vessel_too_short_for_a_plateau_divides_two_throats():
    """One of 40 % was not told: beyond the next one the vessel is hardly wider than it."""
    proximal = ((0, 12), (4, 12), (14, 8), (23, 6.5), (33, 5.9), (46, 7), (55, 11.8), (66, 11))
    distal = ((76, 9.8), (82, 9.8), (86, 6.7), (90, 5.3), (96, 6.6), (100, 6), (112, 5))
    found = narrowings(vessel_along(through(*proximal, (69, 7.2), (71, 6.2), *distal)))
    assert [round(one.narrowest) for one in found] == [33, 71, 90]


@pytest.mark.parametrize(("short", "reference"), [(11.5, 10.7), (14.0, 9.8)])
def test_healthy_vessel_too_short_for_a_plateau_is_one_side_of_the_reference(short, reference):
    """44 % was told as 39, against the vessel distal of it alone; an ostium's flare is no side."""
    proximal = ((0, 8), (10, 8), (20, 6), (28, 6), (35, short), (41, short))
    along = through(*proximal, (46, 6), (52, 10), (64, 9.6), (70, 9.6))
    found = narrowings(vessel_along(along, parent=0))
    told = next(one for one in found if 42 < one.narrowest < 51)
    assert told.reference.at(np.array([told.narrowest]))[0] == pytest.approx(reference, abs=0.2)


@pytest.mark.parametrize(("throat", "is_known"), [(1.1, True), (np.nan, False)])
def test_no_area_is_told_without_a_section_at_the_throat(throat, is_known):
    """The smallest of the sections beside it was told: 49 % by diameter, 39 % by area."""
    made = phantom("stenosed_tube", edge_length=0.8)
    (lesion,) = find_lesions(made.surface, made.centerline)
    along = np.linspace(0.0, lesion.length, 5)
    circle = np.pi / 4 * lesion.minimum_diameter**2
    areas = circle * np.array([4.0, 3.0, throat, 3.0, 4.0])
    line = LesionLine(lesion.line, lesion.healthy, lesion.diameters, np.pi / 4)
    told = _smallest(line, along, areas, lesion.minimum_diameter)
    assert np.isfinite(told).all() == is_known


@pytest.mark.parametrize(("end", "count"), [(3.5, 1), (8.0, 0)])
def test_a_mild_narrowing_at_an_ostium_is_told_if_it_ends_soon(end, count):
    """Healthy branches begin as narrow, and widen slowly."""
    assert len(narrowings(vessel_along(through((0, 3.4), (end, 5), (40, 5)), parent=0))) == count


@pytest.mark.parametrize(("ostium", "reference"), [(2.2, 3.9), (3.0, 4.3)])
def test_a_vessel_seen_to_widen_toward_its_ostium_tapers_from_there(ostium, reference):
    """Narrowed beyond its funnel it was told against the narrower vessel distal of it alone."""
    tapering = 4.6 - 0.1 * np.arange(0, 30, SPACING).clip(0, 12)
    narrowed = through((0, ostium), (3, 2.2), (6, 4.0), (29.5, 4.0))
    told = reference_of(np.minimum(tapering, narrowed), parent=0)
    assert told == pytest.approx(reference, abs=0.1)


def test_a_station_more_or_less_of_an_ostium_makes_no_other_reference():
    """A vessel seen to widen by 14 or by 16 % was told against 3.9 or 4.3 mm."""
    tapering = 4.6 - 0.1 * np.arange(0, 30, SPACING).clip(0, 12)
    told = [
        reference_of(
            np.minimum(tapering, through((0, ostium), (3, 2.2), (6, 4.0), (29.5, 4.0))), parent=0
        )
        for ostium in np.linspace(2.2, 3.3, 45)
    ]
    assert np.ptp(told) > 0.3
    assert np.abs(np.diff(told)).max() < 0.1


def test_the_reference_falls_where_a_branch_as_wide_leaves():
    """Half of what it takes was left to the vessel beyond, 4.9 mm where 4.2 go on."""
    beyond = through((0, 6), (20, 6), (23, 2), (30, 4.2), (60, 4.2))
    vessel = vessel_along(beyond)._replace(side_branches=(SideBranch(20.0, 5.1, 1),))
    (one,) = narrowings(vessel)
    assert one.reference.at(np.array([one.narrowest]))[0] == pytest.approx(4.2, abs=0.05)


def test_a_long_gentle_narrowing_is_measured_beyond_its_foot():
    """Its slope passed for healthy vessel: seven points too low."""
    gentle = through((0, 4), (12, 3.9), (25, 2.2), (38, 3.55), (60, 3.3))
    assert 100 * (1 - 2.2 / reference_of(gentle)) == pytest.approx(100 * (1 - 2.2 / 3.73), abs=5)


@pytest.mark.parametrize(
    ("diameter", "is_own", "first"),
    [
        # The lumen of the parent goes over into that of the branch.
        ([6.0, 5.5, 4.5, 4.0, 4.0], [0, 0, 0, 1, 1], 3),
        # Its throat lies where the parent's sphere still reaches.
        ([6.0, 5.5, 1.2, 2.0, 4.0], [0, 0, 0, 1, 1], 2),
        ([6.0, np.nan, 4.0], [0, 0, 1], 2),
        ([6.0, 5.0], [0, 0], 2),
        ([4.0, 4.0], [1, 1], 0),
    ],
)
def test_a_vessel_begins_at_its_throat_though_that_lies_in_the_sphere_of_its_parent(
    diameter, is_own, first
):
    count = len(diameter)
    zeros = np.zeros(count, dtype=np.int64)
    one = Stretch(np.zeros((count, 3)), np.arange(count), np.array(diameter), zeros, zeros, 0)
    assert _ostium(one, np.array(is_own, dtype=bool)) == first


def test_a_shallow_place_beside_a_throat_does_not_lend_it_its_farther_reference():
    """Vessel of 3.7 mm beside 4.2 and 4.6 passed for a lesion, and the throat for a part of it."""
    beside = through(
        (0, 4.3), (16, 4.2), (20, 3.7), (31, 3.65), (34, 3.7), (36.5, 3.75), (37.5, 1.9),
        (40, 2.3), (42.5, 3.5), (44.5, 3.8), (50, 4.6), (52, 4.7), (54, 4.6), (60, 4.0), (75, 4.0),
    )  # fmt: skip
    throat = next(one for one in narrowings(vessel_along(beside)) if one.start < 37.5 < one.end)
    assert throat.reference.at(np.array([37.5]))[0] == pytest.approx(3.75, abs=0.1)
    assert throat.end - throat.start < 8


def test_no_branch_is_measured_against_more_than_the_vessel_that_it_leaves():
    """Of 4.5 mm, one of 3.6 that widens to 5.5 beyond: 64 % was told of 44 %."""
    widening = through((0, 2.0), (4, 3.6), (12, 3.65), (20, 5.5), (40, 5.5))
    (one,) = narrowings(vessel_along(widening, parent=0)._replace(origin=4.5))
    assert one.reference.at(np.array([one.narrowest]))[0] == pytest.approx(3.6, abs=0.1)


def test_the_healthy_vessel_steps_where_a_branch_leaves_and_not_before():
    """At the station of the junction; a narrowing right beyond it was told against both sides."""
    parts = SideBranch(10.0, 4.4, 1)
    reference = Reference(Plateau(5.0, 4.6), Plateau(15.0, 3.6), (parts,))
    before, at = reference.at(np.array([10.0 - 1e-6, 10.0]))
    assert (before, at) == pytest.approx((4.6, 3.6))


def test_a_short_throat_near_an_ostium_is_no_plateau_of_itself():
    """Flat over its own width, 28 % of 5.8 mm were told as a vessel of 4.7."""
    wide = [5.78, 5.8, 5.96, 6.07, 6.15, 5.68, 4.73, 4.4, 4.69, 5.58, 6.02, 5.91, 5.8, 5.67, 5.52]
    ends = np.linspace(5.36, 4.1, 12)
    every = np.interp(np.arange(0.0, 26.0, SPACING), np.arange(27.0), [*wide, *ends])
    assert reference_of(every, parent=0) == pytest.approx(5.8, abs=0.2)


def test_a_throat_at_an_ostium_is_told_though_its_vessel_tapers_beyond():
    """Half of the lumen was missing, and not told: nothing is as wide as the taper goes on to."""
    tapering = through((0, 3), (4, 4.3), (8, 2.6), (14, 5.35), (16, 5.35), (24, 4.2), (60, 4.2))
    (one,) = narrowings(vessel_along(tapering, parent=0)._replace(origin=6.1))
    assert one.narrowest == 8.0
    # It is narrower at the ostium itself, so it does not taper from there.
    assert one.reference.at(np.array([8.0]))[0] == pytest.approx(5.35, abs=0.1)


def test_a_vessel_that_a_branch_leaves_narrower_is_no_aneurysm_before():
    """Healthy vessel of 3.7 mm between a throat and a branch was taken for one."""
    run = vessel_along(through((0, 2.2), (4, 2.2), (7, 3.7), (12, 3.7), (14, 2.5), (40, 2)), 0)
    assert narrowings(run) == []
    (one,) = narrowings(run._replace(side_branches=(SideBranch(13.0, 3.0, 1),)))
    assert one.reference.at(np.array([2.0]))[0] == pytest.approx(3.7, abs=0.1)


def test_a_vessel_goes_on_beyond_a_twig_though_it_tapers_there():
    """It ended within its narrowing, which had no healthy vessel before it: not told."""
    z = np.arange(0, 80.1, 0.5)
    trunk = np.column_stack([0 * z, 0 * z, z])
    beside = np.arange(0.5, 20.1, 0.5)
    twig = np.column_stack([0 * beside, beside, 40 + beside / 4])
    parent = np.r_[-1, np.arange(len(z) - 1), 80, len(z) + np.arange(len(beside) - 1)]
    radius = np.r_[np.interp(z, [38, 44, 50], [2.3, 1.2, 1.65]), np.full(len(beside), 0.75)]
    tree = Centerline(np.vstack([trunk, twig]), radius, parent)
    whole, side = vessel_runs(tree.lumens)
    assert (whole.outlets, side.outlets) == (2, 1)
    assert whole.along[-1] == pytest.approx(80.0)
    (found,) = narrowings(whole)
    assert found.reference.proximal.diameter == pytest.approx(4.6, rel=0.02)
    assert found.reference.distal.diameter == pytest.approx(3.3, rel=0.02)
