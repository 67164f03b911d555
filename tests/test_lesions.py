"""Lesions: all that are there, none that are not, and the same numbers whatever is tried."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from deployment_cases import ANATOMIES, anatomy, phantom
from lesion_cases import SPACING, bifurcation_case, tapering, tube_case, vessel_along
from seeds import seeds
from trees import unbranched, with_radius

from benchmarks.phantoms.axis import planar_axis
from benchmarks.phantoms.mesh import swept_tube
from benchmarks.trees.surface import Wall
from benchmarks.trees.truth import Spheres
from SDFStentLib.centerline import USUAL, Centerline, LumenStretch
from SDFStentLib.deformation import deploy
from SDFStentLib.field import CapsuleChain
from SDFStentLib.geometry import Line, Surface
from SDFStentLib.lumen import flat_caps, inscribed_spheres
from SDFStentLib.plan import read_input_files
from SDFStentLib.report.lesions import lesion_facts, treated_lesion_facts
from SDFStentLib.stent import AtCenter, Stent, StentAxis
from SDFStentLib.treatment import PlacedStent, TreatedLesion, residual_of, treated_lesions
from SDFStentLib.validation import InputError
from SDFStentLib.vessel import find_lesions, lesion_after, lesion_against, lesions_within
from SDFStentLib.vessel.found_narrowings import found_narrowings
from SDFStentLib.vessel.lesion_sections import LesionLine, _smallest
from SDFStentLib.vessel.lesions import _each_once, _told
from SDFStentLib.vessel.narrowings import Plateau, _left, narrowings
from SDFStentLib.vessel.runs import Leaving, SideBranch, _ostium, vessel_runs

NEAR = 2.0
"""Percentage points within which a degree is right: a reference beside a junction is a little
narrowed or widened by it."""


def lesions_of(case):
    return find_lesions(case.surface, case.centerline)


def assert_as_built(case):
    found = list(lesions_of(case))
    for known in case.known:
        away = [np.linalg.norm(np.subtract(one.point, known.point)) for one in found]
        assert min(away, default=np.inf) < known.length / 4, f"{known} missed among {found}"
        one = found.pop(int(np.argmin(away)))
        assert one.percent_diameter == pytest.approx(known.percent, abs=NEAR)
    assert not found, f"invented: {found}"


@pytest.mark.parametrize("seed", seeds(4, 12))
def test_lesions_in_series_in_a_tapering_vessel_are_all_found_and_none_more(seed):
    assert_as_built(tube_case(seed, count=(1, 2, 3, 0)[seed % 4]))


@pytest.mark.parametrize("where", [None, "trunk", "ostium", "branch"])
def test_lesions_at_a_bifurcation_are_found_and_a_narrower_branch_is_none(where):
    assert_as_built(bifurcation_case(22, where, fineness=0.4))


def test_a_vessel_that_tapers_in_steps_has_no_lesion():
    axis = planar_axis([(90.0, 0.0)])

    def stepping(at):
        at = np.asarray(at)
        return 5.0 - np.clip((at - 20) / 6, 0, 1) - 1.5 * np.clip((at - 55) / 4, 0, 1)

    patch = swept_tube(axis, stepping, 0.8)
    line = unbranched(axis.point(np.linspace(0, 90, 91)))
    assert find_lesions(Surface(patch.points, patch.triangles), line) == ()


@pytest.mark.parametrize("cut", [22.0, 22.4, 26.0])
def test_a_narrowing_beside_an_end_is_told_against_the_vessel_on_its_other_side(cut):
    """Up to the end it regains little: that does not tell how wide the vessel was before."""
    along = np.arange(0.0, cut, 0.9)
    away = np.clip(np.abs(along - 20) / 2.5, 0, 1)
    diameter = 4 - 1.06 * (1 + np.cos(np.pi * away))
    for vessel in (vessel_along(diameter, 0, along), vessel_along(diameter[::-1], -1, along)):
        (found,) = narrowings(vessel)
        assert found.degree == pytest.approx(0.53, abs=0.02)


@pytest.mark.parametrize("cut", [22.8, 24.4, 26.0])
def test_a_flank_that_an_end_cuts_off_is_no_healthy_vessel(cut):
    """But what has nearly stopped becoming wider before the end is."""
    along = np.arange(0.0, cut + 0.1, 0.5)
    away = np.clip(np.abs(along - 20) / 6, 0, 1)
    diameter = 4 - 1.06 * (1 + np.cos(np.pi * away))
    for vessel in (vessel_along(diameter), vessel_along(diameter[::-1])):
        (found,) = narrowings(vessel)
        assert found.degree == pytest.approx(0.53, abs=0.02)
        sides = found.reference.proximal, found.reference.distal
        assert (None in sides) == (cut < 26)


@pytest.mark.parametrize(
    ("throat", "end", "is_told"), [(3.0, 3.6, 1), (3.0, 3.4, 0), (4.1, 4.9, 0)]
)
@pytest.mark.parametrize("order", [1, -1])
def test_a_throat_that_an_end_cuts_off_is_told_by_its_other_side(throat, end, is_told, order):
    """A throat of half was silent where it had hardly begun to widen before an outlet. What widens
    by less than a lesion asks for, or is no narrower than healthy ostia are, tapers."""
    course = through((0, 6.0), (20, 6.0), (26, throat), (28, end))[::order]
    told = narrowings(vessel_along(course))
    assert [round(one.degree, 1) for one in told] == [0.5] * is_told


def test_an_aneurysm_makes_no_lesion_of_the_vessel_beside_it():
    axis = planar_axis([(120.0, 0.0)])
    healthy = tapering(5.0, 4.0, 120.0)

    def radius(at):
        return healthy(at) * (1 + 0.9 * np.exp(-(((np.asarray(at) - 50) / 10) ** 2)))

    patch = swept_tube(axis, radius, 1.0)
    line = unbranched(axis.point(np.linspace(0, 120, 121)))
    assert find_lesions(Surface(patch.points, patch.triangles), line) == ()


def test_a_stenosis_across_a_junction_is_one_lesion():
    made = phantom("branching_pulmonary_artery")
    (first,) = find_lesions(made.surface, made.centerline)
    assert np.linalg.norm(np.subtract(first.point, made.throat.point)) < 1.0
    assert first.proximal is not None
    assert first.distal is not None
    assert first.reference_diameter == pytest.approx(made.throat.reference_diameter, rel=0.03)
    assert first.percent_diameter == pytest.approx(40, abs=3)


def forms_of(line):
    """The same centerline as files may hold it."""
    ways = [line.ancestry(leaf) for leaf in line.leaves]
    apart = np.concatenate([line.points[way] for way in ways])
    ends = np.cumsum([0, *map(len, ways)])
    lines = [np.arange(*pair) for pair in pairwise(ends)]
    radius, wider_end = (
        line.inscribed_radius,
        line.points[max(line.leaves, key=lambda n: line.points[n][0])],
    )
    return {
        "delivered": line,
        "resampled": line.resampled(2.0),
        "no radius": with_radius(line, np.full(len(radius), np.nan)),
        "backward": Centerline.from_lines(
            line.points, [way[::-1] for way in ways], radius, inlet=wider_end
        ),
        "overlapping": Centerline.from_lines(apart, lines),
        "many overlapping": Centerline.from_lines(apart, lines * 60),
    }


def test_the_pulmonary_artery_s_lesions_are_the_same_for_every_form_of_the_centerline(data_dir):
    vessel = anatomy(data_dir, "pulmonary")
    for form, line in forms_of(vessel.centerline).items():
        found = find_lesions(vessel.surface, line)
        # Which vessels are the main ones tells the root.
        # A fourth, of 23 %, is just as wide again as a lesion asks for, or just not.
        assert len(found) in (3, 4), form
        first, mild, second = sorted(found, key=lambda one: one.minimum_diameter)[:3]
        assert first.minimum_diameter == pytest.approx(4.95, abs=0.03), form
        assert first.percent_diameter == pytest.approx(51, abs=2), form
        assert second.minimum_diameter == pytest.approx(5.89, abs=0.03), form
        # Backward it goes on into the wide end of the trunk.
        assert second.percent_diameter == pytest.approx(49, abs=5 if form == "backward" else 2), (
            form
        )
        # Where it tapers: 18 % against the narrower side, 45 % against the wider.
        assert 18 < mild.percent_diameter < 45, form
        sides = sorted(place.diameter for place in (first.proximal, first.distal))
        np.testing.assert_allclose(sides, [9.5, 10.5], atol=0.2, err_msg=form)


@pytest.mark.parametrize("name", ["aorta_iliac", "vmtk_aorta"])
def test_aneurysms_junctions_and_rounded_outlets_are_no_lesions(data_dir, name):
    vessel = anatomy(data_dir, name)
    assert name in ANATOMIES
    forms = forms_of(vessel.centerline)
    for form in ("delivered", "no radius", "overlapping"):
        assert find_lesions(vessel.surface, forms[form]) == (), form


def test_the_degree_is_that_of_spheres_and_circles_measured_by_hand(data_dir):
    """The reference from the two places that the lesion names, by another route than its own."""
    vessel = anatomy(data_dir, "pulmonary")
    lesion = find_lesions(vessel.surface, vessel.centerline)[0]
    way = vessel.centerline.path(lesion.proximal.point, lesion.distal.point)
    widths = 2 * inscribed_spheres(vessel.points, vessel.triangles, way.points).radii
    along = np.linspace(0, 1, len(widths))
    at = widths.argmin()
    reference = np.interp(along[at], [0, 1], widths[[0, -1]])
    assert lesion.percent_diameter == pytest.approx(100 * (1 - widths[at] / reference), abs=1.0)
    assert lesion.percent_area == pytest.approx(
        100 * (1 - lesion.minimum_area / lesion.reference_area)
    )


@pytest.mark.parametrize("way", [1, -1])
def test_a_stent_that_ends_beside_the_throat_of_a_lesion_treats_it(way):
    """What was left of a lesion of 61 % was not told: the stent began 0.03 mm beyond the throat."""
    made = phantom("stenosed_tube", edge_length=0.8, length=60.0)
    lesions = find_lesions(made.surface, made.centerline)

    def treated(gap):
        along = np.linspace(30 + way * gap, 30 + way * (gap + 14), 100)
        axis = StentAxis(Line(made.axis_at(along)), np.full(100, 3.0), 14.0, 14.0)
        placed = PlacedStent(1, Stent(5.4, placement=AtCenter(axis.points[50]), length=14.0), axis)
        done = deploy(made.surface, CapsuleChain.along(made.axis_at(along)), 2.7).surface
        return treated_lesions(lesions, [placed], done)[0], [placed]

    beside, stents = treated(0.5)
    assert lesions_within(lesions, stents[0].axis.line) == lesions
    assert not lesions_within(lesions, stents[0].axis.line, beyond=0.0)
    assert beside.stents == (1,)
    assert beside.is_left_beyond
    left = residual_of([beside], stents)
    assert left.side == ("proximal" if way > 0 else "distal")
    assert left.percent == pytest.approx(beside.after.percent_diameter)
    assert left.percent == pytest.approx(100 * (1 - left.minimum / 6.0), abs=1.0)
    assert not treated(2.5)[0].stents


@pytest.mark.parametrize("order", [1, -1])
def test_what_is_left_lies_within_the_stent_beside_that_at_the_throat(order):
    """Its rest was told "before" the one at the throat, and lay in the other."""
    made = phantom("stenosed_tube", edge_length=0.8, length=60.0)
    lesions = find_lesions(made.surface, made.centerline)
    placed, surface = [], made.surface
    parts = [(18.0, 32.5, 2.7), (32.0, 42.0, 2.3)][::order]
    for number, (start, end, radius) in enumerate(parts, start=1):
        line, length = Line(made.axis_at(np.linspace(start, end, 100))), end - start
        axis = StentAxis(line, np.full(100, 3.0), length, length)
        stent = Stent(2 * radius, placement=AtCenter(axis.points[50]), length=length)
        placed.append(PlacedStent(number, stent, axis))
        surface = deploy(surface, CapsuleChain.along(axis.points), radius).surface
    treated = treated_lesions(lesions, placed, surface)
    assert residual_of(treated, placed).side == "within"


def test_a_reference_that_cannot_be_one_is_refused_in_a_sentence():
    made = phantom("stenosed_tube", edge_length=0.8)
    (lesion,) = find_lesions(made.surface, made.centerline)
    surface = made.surface, made.centerline
    with pytest.raises(InputError, match="one or two marked places, got 0"):
        lesion_against(lesion, [], *surface)
    with pytest.raises(InputError, match="two distal to it"):
        lesion_against(lesion, [[0, 0, 30], [0, 0, 35]], *surface)
    with pytest.raises(InputError, match="inside of the vessel"):
        lesion_against(lesion, [[9, 0, 30]], *surface)
    with pytest.raises(InputError, match="outside"):
        find_lesions(made.surface, made.centerline.with_points(made.centerline.points + 99))


def without_caps(surface):
    is_wall = np.ones(len(surface.triangles), dtype=bool)
    for cap in flat_caps(surface.points, surface.triangles):
        is_wall[cap.faces] = False
    return Surface(surface.points, surface.triangles[is_wall])


def assert_open_as_closed(surface, centerline):
    closed = find_lesions(surface, centerline)
    opened = find_lesions(without_caps(surface), centerline)
    assert len(opened) == len(closed) > 0
    for one, other in zip(opened, closed, strict=True):
        np.testing.assert_allclose(one.point, other.point, atol=1e-3)
        assert one.percent_diameter == pytest.approx(other.percent_diameter, abs=1e-3)


def test_a_vessel_is_inside_although_its_line_begins_outside_of_an_open_end():
    """The first sphere looks out of it; all stations that hang together with it were outside."""
    made = phantom("stenosed_tube", edge_length=0.8)
    end = made.points[:, 2] < 1e-6
    wavy = 0.3 * np.sin(3 * np.arctan2(made.points[:, 1], made.points[:, 0])) * end
    points = made.points + wavy[:, None] * [0, 0, 1]
    line = made.centerline.points.copy()
    line[0, 2] -= 0.2
    wall = Surface(points, made.triangles[made.face_ids == 1])
    (known,) = find_lesions(made.surface, made.centerline)
    (found,) = find_lesions(wall, made.centerline.with_points(line))
    # Its stations lie elsewhere.
    assert found.percent_diameter == pytest.approx(known.percent_diameter, abs=0.15)


def test_an_open_anatomy_has_the_lesions_of_the_closed_one(data_dir):
    """Its line begins in the plane of the inlet; two of four lesions were missed."""
    assert_open_as_closed(*anatomy(data_dir, "pulmonary"))


def leaving(diameter, start):
    """A vessel that leaves one along z at an arc length, and goes aside."""
    run = vessel_along(diameter, 0, start=start)
    beyond = run.along - start
    line = np.column_stack([beyond, 0 * beyond, start + 0.2 * beyond])
    return run._replace(line=Line(line))


@pytest.mark.parametrize(
    ("caliber", "ostium", "vessels"), [(3.5, 1.4, [0]), (3.5, 1.0, [0]), (5.0, 1.4, [0])]
)
def test_the_ostium_of_a_branch_within_its_parent_s_narrowing_is_the_same_lesion(
    caliber, ostium, vessels
):
    """The branch was told as a second one, or in place of it: it begins as narrow as the wall that
    it leaves, before the parent is narrowest. That is the parent's own."""
    along = np.arange(0, 60.1, 0.5)
    bump = np.clip(1 - np.abs(along - 30) / 6, 0, 1)
    parent = vessel_along(5 - 3.2 * bump)._replace(side_branches=(SideBranch(29.0, caliber, 1),))
    beyond = np.arange(0, 25.1, 0.5)
    child = leaving(caliber - (caliber - ostium) * np.clip(1 - beyond / 4, 0, 1), 29.0)
    assert len(narrowings(child)) == 1
    found = found_narrowings([parent, child], [0, 1])
    assert [one.vessel for one in found] == vessels
    # That it is narrowed, too, is known.
    assert [limb.vessel for one in found for limb in one.limbs] == [1]


def test_a_narrowing_is_told_though_a_branch_as_wide_leaves_its_throat_still_narrower():
    """57 % of the vessel were dropped for 67 % of the branch, whose ostium is the same wall."""
    along = np.arange(0, 60.1, 0.5)
    parent = vessel_along(4.3 - 2.45 * np.clip(1 - np.abs(along - 30) / 4, 0, 1))
    parent = parent._replace(side_branches=(SideBranch(29.0, 5.0, 1),))
    beyond = np.arange(0, 25.1, 0.5)
    child = leaving(np.interp(beyond, [0, 1, 5], [1.4, 1.4, 4.3]), 29.0)
    outside = child._replace(line=Line(child.points + np.array([1.5, 0.0, 0.0])))
    assert [one.vessel for one in found_narrowings([parent, child], [0, 1])] == [0]
    # Beside the throat it is a place of its own.
    assert [one.vessel for one in found_narrowings([parent, outside], [0, 1])] == [0, 1]


def test_what_is_over_where_the_vessel_goes_on_in_a_branch_is_told_there_if_that_is_tighter():
    """Of one narrowing of 2.5 mm in a branch, 3.3 mm of the vessel before it were told, too."""
    along = np.arange(0, 60.1, 0.5)
    parent = vessel_along(np.interp(along, [24, 28, 30, 31.5], [5.5, 3.3, 3.5, 4.7]))
    beyond = np.arange(0, 25.1, 0.5)
    child = leaving(np.interp(beyond, [0, 1, 4], [2.4, 2.4, 4.7]), 31.5)
    runs = [parent, child._replace(caliber=4.7, beside=(5.0,))]
    (found,) = found_narrowings(runs, [0, 1])
    assert (found.vessel, [limb.vessel for limb in found.limbs]) == (1, [0])
    # A branch that is much narrower is another vessel.
    aside = child._replace(line=Line(child.points + np.array([2.5, 0.0, 0.0])), caliber=3.0)
    assert [one.vessel for one in found_narrowings([parent, aside], [0, 1])] == [0, 1]


@pytest.mark.parametrize(("throat", "vessels"), [(47.0, [0, 1]), (44.0, [1])])
def test_what_is_narrowest_beyond_a_fork_is_its_own_though_a_branch_is_tighter(throat, vessels):
    """54 % of a vessel beyond a fork were dropped for 67 % of the branch that leaves there."""
    along = np.arange(0, 80.1, 0.5)
    parent = vessel_along(5.5 - 3.0 * np.clip(1 - np.abs(along - throat) / 6, 0, 1))
    beyond = np.arange(0, 25.1, 0.5)
    aside = leaving(np.interp(beyond, [0, 2, 3, 8], [1.8, 1.8, 1.8, 5.5]), 45.0)
    aside = aside._replace(line=Line(aside.points + np.array([1.5, 0.0, 0.0])))
    runs = [parent, aside._replace(caliber=5.5, beside=(5.5,))]
    assert [one.vessel for one in found_narrowings(runs, [0, 1])] == vessels


def test_the_way_into_a_branch_before_a_vessel_s_own_throat_is_told_with_it():
    """58 % on the way into a branch as wide were silent: the vessel is narrowest just beyond the
    fork, where it goes on aside of that way."""
    along = np.arange(0, 60.1, 0.5)
    parent = vessel_along(5.5 - 3.8 * np.clip(1 - np.abs(along - 31) / 6, 0, 1))
    parent = parent._replace(side_branches=(SideBranch(29.5, 5.0, 1),))
    beyond = np.arange(0, 25.1, 0.5)
    child = leaving(np.interp(beyond, [0, 1, 4], [2.6, 3.2, 5.0]), 29.5)
    runs = [parent, child._replace(caliber=5.0, beside=(5.5,))]
    (found,) = found_narrowings(runs, [0, 1])
    (limb,) = found.limbs
    assert (found.vessel, found.narrow.narrowest, limb.vessel) == (0, 31.0, 1)
    assert limb.narrow.narrowest == pytest.approx(29.5)
    assert limb.narrow.degree == pytest.approx(1 - 2.65 / 5.2, abs=0.05)
    # The vessel's own throat before the fork is that of both.
    before = parent._replace(diameter=5.5 - 3.8 * np.clip(1 - np.abs(along - 28) / 6, 0, 1))
    (found,) = found_narrowings([before, runs[1]], [0, 1])
    assert (found.narrow.narrowest, found.limbs) == (28.0, ())


def test_a_throat_from_which_several_branches_go_on_narrower_is_that_of_the_vessel_before():
    """44 % at the end of a trunk were dropped for 48 % and 47 % of two of three branches."""
    trunk = vessel_along(through((0, 10.6), (50, 10.6), (60, 5.9)))
    division = tuple(SideBranch(60.0, 8.3, number) for number in (1, 2, 3))
    branches = [
        leaving(through((0, begins), (8, 7), (30, 7)), 60.0)._replace(caliber=8.3, beside=(8.3,))
        for begins in (6.0, 3.3, 3.4)
    ]
    aside = [
        one._replace(line=Line(one.points + np.array([way, 0.0, 0.0])))
        for one, way in zip(branches, (0.0, -4.0, 4.0), strict=True)
    ]
    trunk = trunk._replace(division=division)
    told = [one.vessel for one in found_narrowings([trunk, *aside], [0, 1, 2, 3])]
    assert told[0] == 0
    # The throat of one of them is its own.
    two = [trunk, aside[0]._replace(diameter=aside[0].diameter + 1.0), aside[1]]
    assert [one.vessel for one in found_narrowings(two, [0, 1, 2])][-1] == 2


def test_a_branch_whose_narrowest_sphere_is_that_of_its_parent_has_no_lesion_there():
    """2.04 mm of the vessel were told again as 2.02 mm of the branch that leaves its throat."""
    made = phantom("stenosed_tube", edge_length=0.8)
    (own,) = find_lesions(made.surface, made.centerline)
    width = own.minimum_diameter
    beside = np.add(own.point, [0.4 * width, 0.0, 0.0])
    again = replace(own, point=tuple(beside), generation=1, percent_diameter=80.0)
    apart = replace(again, point=tuple(np.add(beside, [0.4 * width, 0.0, 0.0])))
    assert _each_once([again, own]) == [own]
    assert _each_once([apart, own]) == [own, apart]
    # Of a throat through which less passes beside the other one nothing was told.
    tighter = replace(again, minimum_diameter=0.85 * own.minimum_diameter)
    assert _each_once([tighter, own]) == [own, tighter]


def test_a_narrowing_at_a_fork_is_told_against_healthy_vessel_on_both_sides_of_it():
    """A vessel that divides has healthy vessel in the branch in which it goes on, not in what its
    branches ask for, and that branch has some in it: 44 % of 10.6 mm, or 28 of 8.1, were told."""
    before = ((0, 10.6), (50, 10.4))
    division = (SideBranch(60.0, 8.0, 1), SideBranch(60.0, 8.0, 2))
    beside = leaving(through((0, 4.5), (6, 8.0), (30, 8.0)), 60.0)._replace(beside=(8.0,))
    beside = beside._replace(line=Line(beside.points + np.array([9.0, 0.0, 0.0])))
    for throat, vessel in ((57, 0), (63, 1)):
        whole = through(*before, (throat, 5.6), (68, 8.0), (100, 8.0))
        trunk = vessel_along(whole[:121])._replace(division=division)
        onward = vessel_along(whole[120:], 0, start=60.0)._replace(caliber=8.0, beside=(8.0,))
        (one,) = found_narrowings([trunk, onward, beside._replace(caliber=7.9)], [0, 1])
        assert one.vessel == vessel
        assert one.narrow.narrowest == pytest.approx(throat, abs=1.0)
        assert one.sides[0].diameter == pytest.approx(10.4, abs=0.2)
        assert one.sides[1].diameter == pytest.approx(8.0, abs=0.2)
        # Before it between the two, beyond it against what the other branch leaves of the trunk.
        most = 1 - 5.6 / (10.4 if vessel == 0 else 8.0)
        assert 0.99 * (1 - 5.6 / 8.0) <= one.narrow.degree <= most


def test_a_branch_as_wide_as_others_is_measured_against_what_its_parent_leaves_it():
    """Two alike of a trunk of 10 mm have 7.4 by the rule of flow: 50 % of 7.4 are not 63 of 10."""
    parent = vessel_along(np.full(121, 10.0))._replace(
        division=(SideBranch(60.0, 7.4, 1), SideBranch(60.0, 7.4, 2))
    )
    wide = vessel_along(np.full(80, 7.4), 0, start=60.0)._replace(caliber=7.4, beside=(7.4,))
    narrow = through((0, 3.7), (6, 7.3), (40, 7.3))
    branch = leaving(narrow, 60.0)._replace(caliber=7.4, beside=(7.4,))
    (one,) = found_narrowings([parent, wide, branch], [0, 1, 2])
    assert one.vessel == 2
    beyond = one.narrow.reference.beyond(one.narrow.narrowest)
    assert beyond == pytest.approx(10 * 0.5 ** (3 / 7), rel=0.01)
    assert one.narrow.degree == pytest.approx(0.5, abs=0.03)


@pytest.mark.parametrize(("throat", "least", "most"), [(55.0, 7.0, 7.6), (45.0, 8.0, 9.4)])
def test_a_vessel_loses_what_its_side_branch_takes_where_that_leaves(throat, least, most):
    """66 % were told of 60: of a vessel of 11.6 mm a branch of 9.5 leaves 7.6, not what lies
    between the two."""
    healthy = through((0, 10.0), (47, 10.0), (52, 7.4), (100, 7.4))
    along = SPACING * np.arange(len(healthy))
    bell = 1 - 0.5 * np.exp(-(((along - throat) / 3.0) ** 2))
    side = SideBranch(50.0, 7.4, 1)
    parent = vessel_along(healthy * bell)._replace(side_branches=(side,))
    branch = leaving(np.full(60, 7.4), 50.0)._replace(caliber=7.4, beside=(7.4,))
    (one,) = found_narrowings([parent, branch], [0])
    assert one.narrow.narrowest == pytest.approx(throat, abs=2.0)
    assert least <= one.healthy <= most


def test_junctions_take_their_shares_one_after_the_other():
    """No more than leaves the vessel as wide as it is beyond."""
    sides = [Leaving(30.0, 6.0), Leaving(40.0, 6.0), Leaving(80.0, 6.0)]
    first, second = _left(Plateau(10.0, 10.0), Plateau(60.0, 7.0), sides)
    assert first.diameter == pytest.approx((10.0 ** (7 / 3) - 6.0 ** (7 / 3)) ** (3 / 7))
    assert (10.0 ** (7 / 3) - 2 * 6.0 ** (7 / 3)) ** (3 / 7) < second.diameter == 7.0
    assert (first.arc_length, second.arc_length) == (30.0, 40.0)


def test_a_narrow_twig_at_the_end_of_a_trunk_takes_no_lesion_from_it():
    """65 % of the trunk were dropped for 48 % of a vessel of 3.7 mm that leaves its end."""
    trunk = vessel_along(through((0, 13), (34, 13), (46, 3.9)))
    division = (SideBranch(46.0, 10.6, 1), SideBranch(46.0, 3.7, 2))
    onward = vessel_along(through((0, 4.2), (8, 10.3), (24, 10.3)), 0, start=46.0)
    twig = leaving(through((0, 2.5), (10, 1.9), (20, 3.6), (40, 3.6)), 46.0)
    runs = [
        trunk._replace(division=division),
        onward._replace(caliber=10.6, beside=(3.7,)),
        twig._replace(caliber=3.7, beside=(10.6,)),
    ]
    assert found_narrowings(runs, [0, 1, 2])[0].vessel == 0


def test_a_branch_s_own_narrowing_beyond_its_parent_s_is_another_lesion():
    """Under a lesion of the main vessel the branch's own one was missing."""
    along = np.arange(0, 60.1, 0.5)
    bump = np.clip(1 - np.abs(along - 30) / 6, 0, 1)
    parent = vessel_along(8 - 4.8 * bump)._replace(side_branches=(SideBranch(29.0, 4.0, 1),))
    beyond = np.arange(0, 40.1, 0.5)
    own = 4 - 2.2 * np.clip(1 - np.abs(beyond - 7) / 3, 0, 1)
    found = found_narrowings([parent, leaving(own, 29.0)], [0, 1])
    assert [(one.vessel, round(100 * one.narrow.degree)) for one in found] == [(0, 60), (1, 55)]


@pytest.mark.parametrize(("throat", "vessel"), [(29.5, 0), (30.5, 1)])
def test_a_narrowing_across_a_division_is_told_with_the_narrower_of_its_parts(throat, vessel):
    """2.80 mm were told, of the vessel beyond, where 2.42 are the narrowest."""
    along = np.arange(0, 60.1, 0.5)
    whole = 5 - 3 * np.clip(1 - np.abs(along - throat) / 6, 0, 1)
    division = (SideBranch(30.0, 5.0, 1), SideBranch(30.0, 2.5, 2))
    parent = vessel_along(whole[:61])._replace(division=division)
    (one,) = found_narrowings([parent, vessel_along(whole[60:], 0, start=30.0)], [0, 1])
    assert (one.vessel, one.run.diameter[one.narrowest]) == (vessel, 2.0)


def test_a_long_throat_that_two_lines_run_through_is_told_once():
    """Their narrowest places were farther from each other than the throat is wide."""
    along = np.arange(0, 60.1, 0.5)
    one = vessel_along(np.interp(along, [18, 22, 38, 42], [5.0, 1.0, 1.02, 5.0]))
    other = vessel_along(np.interp(along, [18, 22, 38, 42], [5.0, 1.04, 1.01, 5.0]))
    assert len(found_narrowings([one, other], [0, 1])) == 1
    aside = other._replace(line=Line(other.points + np.array([9.0, 0.0, 0.0])))
    assert len(found_narrowings([one, aside], [0, 1])) == 2


def test_where_stations_are_unevenly_apart_a_slope_is_no_healthy_vessel():
    """The lower of the middle two of four stations said that a slope from 3.7 to 5.3 is flat."""
    along = [*np.arange(0, 6.2, 0.56), 7.1, 7.6, 9.1, 10.3, 11.4, *np.arange(13.0, 30.1, 1.0)]
    healthy = np.interp(along, [0.0, 1.5, 12.0, 30.0], [1.4, 1.4, 5.2, 5.2])
    (found,) = narrowings(vessel_along(healthy, 0, along))
    assert found.reference.distal.diameter == pytest.approx(5.2, rel=0.05)


def test_healthy_vessel_as_long_as_wide_before_a_narrowing_is_its_reference():
    """Windows round stations only were a twentieth of a mm too long to fit."""
    along = np.arange(0.0, 40.1, 1.03)
    ends = [0.0, 4.4, 8.0, 9.0, 13.0, 40.0]
    healthy = np.interp(along, ends, [4.2, 4.2, 1.8, 1.8, 5.4, 5.4])
    (found,) = narrowings(vessel_along(healthy, 0, along))
    assert found.reference.proximal.diameter == pytest.approx(4.2, rel=0.03)
    assert found.reference.distal.diameter == pytest.approx(5.4, rel=0.03)


# Against what a narrowing is measured: the nearest healthy vessel, and no throat or valley.


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


def test_healthy_vessel_between_a_trunk_and_a_throat_is_the_reference_though_it_is_short():
    """62 % were told of 57: the flank seemed to go on up to the trunk of 17.7 mm."""
    places = [0, 12, 16, 19, 23, 27, 30, 32, 34, 36, 37, 39, 40, 41, 43, 44, 45, 48, 70]
    widths = [16, 16, 17.3, 17.7, 17.1, 15, 13.7, 13, 12.6, 12.3]
    widths += [10.5, 8.2, 5.4, 6.1, 7.5, 9.8, 10.3, 10.4, 10.4]
    whole = np.interp(np.arange(0, 70.1, SPACING), places, widths)
    vessel = vessel_along(whole[64:], 0, start=32.0)._replace(caliber=12.0, beside=(6.0,))
    (one,) = found_narrowings([vessel_along(whole[:65]), vessel], [0, 1])
    assert one.narrow.reference.proximal.diameter < 14
    assert one.narrow.degree == pytest.approx(1 - 5.4 / 11.5, abs=0.02)


def test_a_trunk_two_junctions_before_a_throat_is_not_its_healthy_vessel():
    """83 % were told of 73, against a trunk of 17.6 mm 36 mm away: the vessel between tapers."""
    before = [10, 12, 14, 16, 18, 20, 22, 28, 30, 32, 34, 36, 38, 40, 42, 43.1]
    wide = [17.0, 17.4, 17.6, 17.7, 17.5, 17.1, 16.2, 9.7, 9.3, 10.0, 9.4, 7.5, 6.1, 5.3, 4.8, 4.1]
    beyond = [43.1, 45.5, *np.arange(46.2, 56.1, 0.6), *np.arange(57.1, 95.0, 1.2)]
    throat = [4.1, 3.5, 3.0, 2.7, 2.7, 2.5, 2.1, 1.8, 1.8, 2.0, 1.7, 1.5, 1.7, 2.1, 2.2, 2.2]
    throat += [2.5, 3.0, 3.4, 3.8, 4.2, 4.9, 5.5, 5.9]
    widths = np.pad(throat, (0, len(beyond) - len(throat)), mode="edge")
    trunk = vessel_along(np.array(wide), -1, before)
    vessel = vessel_along(widths, 0, beyond)
    division = (SideBranch(43.1, 6.1, 1), SideBranch(43.1, 3.9, 2))
    trunk, near = trunk._replace(division=division), vessel._replace(caliber=6.1, beside=(3.9,))
    (one,) = found_narrowings([trunk, near], [0, 1])
    assert one.narrow.reference.proximal is None
    assert one.narrow.degree == pytest.approx(1 - 1.5 / 5.9, abs=0.02)


def test_a_vessel_that_widens_far_beyond_its_ostial_narrowing_is_measured_beside_it():
    """It was told against the 5.2 mm of its widest part: 65 % instead of 50 %."""
    widening = through((0, 1.8), (4, 3.6), (8, 3.6), (11, 5.2), (40, 5.2))
    assert reference_of(widening, parent=0) == pytest.approx(3.6, abs=0.1)


def test_a_throat_that_widens_slowly_is_measured_against_where_it_has():
    """54 % at an ostium were told as 29 % of a place within its flank, which is even; and of a
    throat at a fork 65 % as 36."""
    widths = [
        1.83, 1.91, 2.01, 2.19, 2.43, 2.6, 2.82, 3.04, 3.19, 3.55, 3.79, 3.92, 3.88, 3.75, 3.61,
        3.48, 3.57, 3.7, 3.83, 3.96, 3.81, 3.63, 3.48, 3.37, 3.26, 3.25, 3.33, 3.4, 3.47, 3.54,
    ]  # fmt: skip
    (one,) = narrowings(vessel_along(np.array(widths), 0, 1.9 + 0.94 * np.arange(len(widths))))
    assert one.reference.distal.diameter == pytest.approx(3.9, abs=0.2)
    trunk = vessel_along(through((0, 4.3), (50, 4.3), (55, 3.0), (56, 3.0), (60, 2.2)))
    onward = through(
        (0, 1.82), (1, 1.82), (2, 1.86), (3, 1.95), (4, 2.12), (5, 2.29), (6, 2.5), (7, 2.7),
        (10, 3.3), (14, 3.9), (20, 5.1), (23, 5.2), (24, 4.5), (40, 4.5),
    )  # fmt: skip
    vessel = vessel_along(onward, 0, start=60.0)._replace(caliber=4.5, beside=(5.1,))
    (one,) = found_narrowings([trunk, vessel], [1])
    assert one.narrow.degree == pytest.approx(0.6, abs=0.05)


def test_a_bump_in_an_ostial_throat_is_no_healthy_vessel():
    """22 % of the bump were told of 66: beyond the nearer of two throats nothing is wide soon."""
    places = [0.0, 0.7, 1.4, 2.0, 2.6, 3.3, 3.9, 4.5, 5.2, 5.9, 6.5, 7.2, 7.8]
    widths = [1.58, 1.20, 1.50, 1.50, 1.19, 1.52, 1.80, 1.64, 2.11, 2.63, 2.54, 2.86, 3.3]
    along = np.append(places, np.arange(8.5, 40.0, 0.7))
    (one,) = narrowings(vessel_along(np.interp(along, places, widths), 0, along))
    assert one.reference.proximal is None
    assert one.reference.distal.diameter == pytest.approx(3.3, abs=0.1)


def test_both_sides_of_a_narrowing_count_where_one_goes_on_wider():
    """Healthy vessel of 3.7 mm beside it passed for a throat of the wider one."""
    widening = through((0, 3.7), (8, 3.7), (12, 2.0), (16, 4.0), (22, 4.2), (32, 5.5), (50, 5.5))
    assert 3.7 <= reference_of(widening, parent=0) <= 5.5


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
    usual = np.quantile(wide[np.argmin(wide) + 1 :], USUAL)
    assert usual > 7.0
    assert one.reference.at(np.array([one.narrowest]))[0] == pytest.approx(usual, rel=0.04)


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


@pytest.mark.parametrize(
    ("begins", "ends", "is_onward", "count"),
    [(3.4, 3.5, False, 0), (3.1, 3.5, False, 1), (3.4, 3.5, True, 1), (4.1, 3.5, True, 0),
     (2.8, 16.0, False, 0)],
)  # fmt: skip
def test_a_vessel_that_begins_narrow_is_told_if_healthy_ones_hardly_begin_so(
    begins, ends, is_onward, count
):
    """Healthy branches begin narrower than they go on, and widen slowly."""
    widening = vessel_along(through((0, begins), (ends, 5), (40, 5)), parent=0, start=30.0)
    widening = widening._replace(beside=(6.0 if is_onward else 9.0,))
    found = found_narrowings([vessel_along(np.full(120, 8.0)), widening], [0, 1])
    assert len(found) == count


def test_a_vessel_that_tapers_far_beyond_its_narrow_ostium_is_no_aneurysm():
    """65 % were not told as, 50 mm farther on, the vessel was as narrow as at its ostium."""
    wide = through((0, 3.8), (2, 3.8), (10, 10), (14, 8.8), (20, 7.6), (60, 3.6), (80, 3.5))
    (one,) = narrowings(vessel_along(wide, parent=0))
    assert (one.narrowest < 3, round(one.degree, 1)) == (True, 0.6)
    # What is wider only as long as the ostium is is one.
    focal = through((0, 4.0), (2, 4.0), (10, 7.6), (18, 4.0), (60, 4.0))
    assert not narrowings(vessel_along(focal, parent=0))


def test_what_is_no_wider_than_its_trunk_lets_go_on_is_no_aneurysm():
    """66 % where a vessel divides were not told, as its branch tapers to its end farther on."""
    before = vessel_along(through((0, 8.0), (55, 8.0), (60, 3.9)))
    before = before._replace(division=(SideBranch(60.0, 5.8, 1), SideBranch(60.0, 4.9, 2)))
    course = through((0, 3.9), (0.5, 2.6), (2, 2.6), (6, 5.8), (11, 5.8), (15, 2.3), (40, 2.3))
    child = vessel_along(course, 0, start=60.0)._replace(caliber=5.8, beside=(4.9,))
    other = leaving(through((0, 4.2), (25, 4.9)), 60.0)._replace(caliber=5.9, beside=(5.8,))
    found = found_narrowings([before, child, other], [0, 1, 2])
    assert [(one.vessel, one.narrow.narrowest < 63.0) for one in found] == [(1, True)]


def test_a_minimum_stays_in_its_own_valley_though_another_one_is_deeper():
    """41 % of a vessel were silent: against the only healthy side its parent is narrower still."""
    course = through(
        (0, 3.9), (4, 2.0), (10, 3.9), (14, 3.9), (20, 3.3), (26, 3.87), (31, 2.68), (37, 5.5),
        (60, 5.4),
    )  # fmt: skip
    told = narrowings(vessel_along(course, parent=0), own=(15.0, 60.0))
    assert [one.narrowest for one in told] == [31.0]


@pytest.mark.parametrize(("end", "is_told"), [(33, True), (45, False)])
def test_a_vessel_that_soon_ends_beyond_is_no_aneurysm(end, is_told):
    """56 % at the ostium of a branch that tapers to its end were not told."""
    places = [0, 2.1, 3.2, 4.3, 6.4, 8.5, 10.7, 12.7, 14.5, 17.6, 20.6, 24, 28.4, 33, end]
    widths = [2.66, 3.8, 4.4, 4.1, 4.8, 5.5, 6.1, 6.3, 5.8, 4.9, 4.4, 3.6, 2.65, 2.2, 2.4]
    diameter = np.interp(np.arange(0, end + 0.1, SPACING), places, widths)
    assert bool(narrowings(vessel_along(diameter, parent=0))) == is_told


def test_a_vessel_is_no_aneurysm_of_its_ostium_where_it_divides():
    """42 % were silent, as the branches in which it divides are as narrow as its beginning."""
    course = through(
        (0, 5.9), (26, 5.5), (28.8, 5.5), (30, 3.1), (32, 4.1), (33.3, 4.3), (36.6, 5), (37.4, 5.5),
        (40.1, 6.2), (41, 5.8), (42, 4.6), (43.5, 2.9), (44, 2.6), (60, 2.4),
    )  # fmt: skip
    way = vessel_along(course, parent=0)._replace(beside=(6.8,))
    (one,) = narrowings(way, own=(30.0, 41.0))
    assert one.degree == pytest.approx(0.43, abs=0.05)
    # As a vessel of its own it goes on as narrow as it begins.
    assert not narrowings(way, own=(30.0, 60.0))


def test_a_narrow_ostium_is_told_though_a_throat_and_a_taper_follow():
    """60 % were not told: far beyond, the vessel tapers to no more than its ostium."""
    course = through(
        (0, 4), (2, 4), (8, 10.4), (12, 11.4), (20, 7.7), (24, 6.9), (28, 2.7), (33, 7), (38, 7),
        (46, 3), (80, 2.5),
    )  # fmt: skip
    first, _ = narrowings(vessel_along(course, parent=0))
    assert (first.narrowest < 3, first.degree > 0.6) == (True, True)


def test_what_lies_before_a_junction_goes_on_beyond_it_only_where_the_other_side_does():
    """The healthy parent beyond a throat of its own passed for vessel beyond the junction: of a
    branch 84 % were told at its end, and its own throat of 58 % not at all."""
    before, leaving = Plateau(18.0, 17.7), [Leaving(65.0, 8.0)]
    assert list(_left(before, Plateau(63.0, 10.1), leaving)) == []
    (beyond,) = _left(before, Plateau(70.0, 10.1), leaving)
    assert 16 < beyond.diameter < 17


def test_a_valley_beside_a_deeper_throat_is_measured_up_to_that_only():
    """Between a trunk of 10.1 mm and healthy vessel of 6.2 mm beyond a throat a valley of 4.9 mm
    passed for the lesion: the throat was told as 50 % of 7.1 mm, not as 40."""
    valley = through(
        (0, 10.1), (12, 10.1), (22, 4.9), (32, 5.5), (36, 5.6), (41, 3.5), (46, 6.2), (75, 6.2)
    )
    (one,) = narrowings(vessel_along(valley))
    assert one.narrowest == pytest.approx(41, abs=1)
    assert one.degree == pytest.approx(1 - 3.5 / 5.9, abs=0.02)


def test_the_funnel_of_an_ostium_before_a_narrowing_is_no_healthy_vessel():
    """46 % of 4.4 mm were told as 53 % of 5.2."""
    funnel = through((0, 7.5), (3, 5.3), (7, 4.3), (8, 4.2), (13, 2.1), (17, 4.4), (40, 4.4))
    assert reference_of(funnel, parent=0) == pytest.approx(4.4, abs=0.2)


def test_a_vessel_that_goes_on_in_another_one_is_healthy_from_its_first_station():
    """33 % between 13 and 10.5 mm were not told: it is known for less than its diameter above."""
    wide = through((0, 13), (4, 12.8), (9, 8.6), (13, 10.4), (40, 10.4))
    vessel = vessel_along(wide, parent=0, start=30.0)._replace(beside=(5.0,))
    (one,) = found_narrowings([vessel_along(np.full(120, 13.5)), vessel], [0, 1])
    assert one.narrow.reference.proximal.diameter > 12
    assert 0.17 < one.narrow.degree < 0.34
    assert not narrowings(vessel)


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
    one = LumenStretch(np.zeros((count, 3)), np.arange(count), np.array(diameter), zeros, zeros, 0)
    assert _ostium(one, np.array(is_own, dtype=bool)) == first


def test_a_shallow_place_beside_a_throat_does_not_lend_it_its_farther_reference():
    """Vessel of 3.7 mm beside 4.2 and 4.6 passed for a lesion, and the throat for a part of it."""
    beside = through(
        (0, 4.3), (16, 4.2), (20, 3.7), (31, 3.65), (34, 3.7), (36.5, 3.75), (37.5, 1.9),
        (40, 2.3), (42.5, 3.5), (44.5, 3.8), (50, 4.6), (52, 4.7), (54, 4.6), (60, 4.0), (75, 4.0),
    )  # fmt: skip
    throat = next(one for one in narrowings(vessel_along(beside)) if one.start < 37.5 < one.end)
    assert throat.reference.at(np.array([37.5]))[0] == pytest.approx(3.8, abs=0.1)
    assert throat.end - throat.start < 9.5


def test_a_short_throat_near_an_ostium_is_no_plateau_of_itself():
    """Flat over its own width, 28 % of 5.8 mm were told as a vessel of 4.7."""
    wide = [5.78, 5.8, 5.96, 6.07, 6.15, 5.68, 4.73, 4.4, 4.69, 5.58, 6.02, 5.91, 5.8, 5.67, 5.52]
    ends = np.linspace(5.36, 4.1, 12)
    every = np.interp(np.arange(0.0, 26.0, SPACING), np.arange(27.0), [*wide, *ends])
    assert reference_of(every, parent=0) == pytest.approx(5.8, abs=0.2)


def test_a_throat_at_an_ostium_is_told_though_its_vessel_tapers_beyond():
    """Half of the lumen was missing, and not told: nothing is as wide as the taper goes on to."""
    tapering = through((0, 3), (4, 4.3), (8, 2.6), (14, 5.35), (16, 5.35), (24, 4.2), (60, 4.2))
    (one,) = narrowings(vessel_along(tapering, parent=0))
    assert one.narrowest == 8.0
    assert 4.0 <= one.reference.at(np.array([8.0]))[0] <= 5.4


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


def test_a_vessel_that_comes_out_of_a_wide_one_is_not_narrowed_by_its_funnel():
    """26 % were invented in a vessel that hardly changes: its funnel passed for healthy vessel."""
    funnel = through((0, 8.0), (7, 4.3), (27, 4.4), (45, 4.15), (62, 5.4), (80, 4.6))
    assert narrowings(vessel_along(funnel, parent=0)) == []


def test_a_narrowing_at_an_ostium_is_told_though_a_deeper_one_follows():
    """What lies between the two passed for an aneurysm."""
    series = through((0, 2.2), (6, 4.6), (14, 4.7), (19, 1.9), (24, 4.6), (40, 3.6))
    assert [round(one.narrowest) for one in narrowings(vessel_along(series, parent=0))] == [0, 19]


def bell(width, depth):
    """Diameters of a vessel of 5 mm with a Gauss bell so many diameters wide."""
    along = np.arange(0.0, 5.0 * (5.2 * width + 4) + SPACING, SPACING)
    return 5.0 * (1 - depth * np.exp(-(((along - along[-1] / 2) / (5.0 * width)) ** 2)))


@pytest.mark.parametrize("width", [0.4, 1.0, 2.0, 3.0, 4.0])
@pytest.mark.parametrize("depth", [0.2, 0.4, 0.85])
def test_a_bell_up_to_four_diameters_wide_is_told_as_deep_as_it_is(width, depth):
    """One of three diameters and 85 % was told as 40, against its own flank."""
    (one,) = narrowings(vessel_along(bell(width, depth)))
    assert one.degree == pytest.approx(depth, abs=0.03)


FORMS = {
    "cosine": lambda away: (1 + np.cos(np.pi * np.minimum(away, 1))) / 2,
    "bell": lambda away: np.exp(-4 * away**2),
    "trapezoid": lambda away: np.clip(2 - 2 * away, 0, 1),
}
"""Narrowings by the distance from their middle, of half of their length."""


@pytest.mark.parametrize("form", list(FORMS))
@pytest.mark.parametrize(
    ("depth", "taper"),
    [(0.2, 0.0), (0.5, 0.0), (0.88, 0.0), (0.95, 0.0), (0.4, 0.3), (0.65, 0.3), (0.88, 0.3)],
)
@pytest.mark.parametrize("half", [2.5, 5.0, 10.0, 15.0])
def test_the_reference_of_a_narrowing_is_the_healthy_vessel_about_it(form, depth, taper, half):
    """A straight tube of 5 mm narrowed to 0.6 had its reference at 4.77 mm, up its steep flank."""
    along = np.arange(0.0, 2 * half + 30.1, SPACING)
    away = np.abs(along - along[-1] / 2)
    healthy = 5.0 * (1 + taper * (0.5 - along / along[-1]))
    wide = healthy * (1 - depth * FORMS[form](away / half))
    (one,) = narrowings(vessel_along(wide, along=along))
    found = one.reference.at(along[[wide.argmin()]])[0]
    assert found == pytest.approx(healthy[wide.argmin()], rel=0.01)


@pytest.mark.parametrize("seed", seeds(20, 300))
def test_a_taper_is_no_narrowing_and_an_hourglass_in_it_is_one(seed):
    """Where no healthy vessel was as wide as beside it, one of half of the lumen was not told."""
    random = np.random.default_rng(seed)
    first, last, length = random.uniform(11, 15), random.uniform(5, 7), random.uniform(35, 110)
    along = np.arange(0.0, length, random.uniform(0.5, 1.5))
    healthy = first + (last - first) * along / length
    assert narrowings(vessel_along(healthy, along=along)) == []
    reach, depth = random.uniform(8, min(26, length / 2)), random.uniform(0.35, 0.65)
    middle = random.uniform(reach / 2 + 6, length - reach / 2 - 5)
    share = np.clip(2 * np.abs(along - middle) / reach, 0, 1)
    diameter = healthy * (1 - depth * (1 + np.cos(np.pi * share)) / 2)
    (one,) = narrowings(vessel_along(diameter, along=along))
    ends = np.interp(middle + reach * np.array([-0.5, 0.5]), along, healthy)
    sides = 1 - diameter.min() / ends
    assert min(*sides, depth - 0.05) <= one.degree <= max(*sides, depth + 0.05)


@pytest.mark.parametrize("e", [0.01, 0.03])
@pytest.mark.parametrize("seed", seeds(10, 100))
def test_what_moves_the_caliber_by_little_moves_no_degree_by_more_than_twice_as_much(seed, e):
    random = np.random.default_rng(seed)
    diameter = bell(random.uniform(0.5, 2), random.uniform(0.3, 0.8))
    moved = diameter * (1 + random.uniform(-e, e) * np.linspace(-1, 1, len(diameter)))
    (one,), (other,) = (narrowings(vessel_along(each)) for each in (diameter, moved))
    assert other.degree == pytest.approx(one.degree, abs=2 * e)


@pytest.mark.parametrize("width", [8.0, 30.0])
def test_a_narrowing_without_healthy_vessel_in_reach_is_told_with_its_narrowest_place(width):
    """A branch between two junctions was told as no lesion, in silence: it widens up to both, or is
    narrow all along, against what it divides into."""
    along = np.arange(0.0, 20.1, 0.5)
    throat = 9.0 * (1 - 0.55 * np.exp(-(((along - 10.0) / width) ** 2)))
    ends = (SideBranch(20.0, 7.0, 1), SideBranch(20.0, 6.0, 2))
    branch = vessel_along(throat, 0)._replace(division=ends)
    (one,) = found_narrowings([vessel_along(np.full(60, 12.0)), branch], [0, 1])
    asked = (7.0 ** (7 / 3) + 6.0 ** (7 / 3)) ** (3 / 7)
    assert one.narrow.narrowest == 10.0
    assert one.sides == (None, None)
    assert one.healthy == pytest.approx(asked)
    assert one.narrow.degree == pytest.approx(1 - throat.min() / asked)


def test_the_branch_that_begins_in_a_patient_s_throat_is_told_as_an_independent_search_finds_it(
    data_dir,
):
    """Of the left artery's bifurcation only the artery was told: its branch, too, is narrowed."""
    names = [str(data_dir / f"su0243_{name}_mm.vtp") for name in ("surface", "centerline")]
    vessel = read_input_files(*names).vessel
    surface, lesion = vessel.surface, vessel.lesions[0]
    (limb,) = lesion.limbs
    wall = Wall(surface.points, surface.triangles, np.ones(1, dtype=int))
    spheres = Spheres(wall, limb.line.points, 15.0)
    near = np.abs(limb.line.arc_lengths - (limb.arc_length - limb.start)) < 3.0
    near &= np.isfinite(limb.diameters)
    columns = (limb.line.points[near], limb.line.directions[near], limb.diameters[near])
    found = [spheres.across(at, way, 0.6 * wide)[1] for at, way, wide in zip(*columns, strict=True)]
    assert limb.minimum_diameter == pytest.approx(2 * min(found), rel=0.03)
    share = limb.minimum_diameter / limb.reference_diameter
    assert limb.percent_diameter == pytest.approx(100 * (1 - share))
    words = f"In its throat, {limb.branch_name}: 43 % ("
    first, _, third = lesion_facts(1, lesion).sentences
    assert first.endswith("mm; other vessels in its throat: 43 %.")
    assert words in third
    # After treatment it is measured anew.
    middle = np.array(limb.point)
    grown = Surface(middle + 1.1 * (surface.points - middle), surface.triangles)
    after = lesion_after(lesion, grown)
    assert after.limbs[0].minimum_diameter == pytest.approx(1.1 * limb.minimum_diameter, rel=0.01)
    facts = treated_lesion_facts(TreatedLesion(1, lesion, after, (1,)))
    assert (
        f"{limb.branch_name}: 43 % (2.10 of 3.65 mm) -> 37 % (2.31 of" in facts.named("_left").words
    )
    assert words in facts.named("_limbs").words
    assert facts.as_dict()["after"]["limbs"][0]["percent_diameter"] < 40
    lost = replace(after.limbs[0], minimum_diameter=np.nan, percent_diameter=np.nan)
    facts = treated_lesion_facts(TreatedLesion(1, lesion, replace(after, limbs=(lost,)), (1,)))
    assert facts.named("_limbs").words.endswith("43 % (2.10 of 3.65 mm) -> not known.")


def test_what_is_narrowed_in_the_throat_of_no_lesion_is_one_itself():
    """Where a line jumps at a fork a vessel had a throat that was none as soon as it was measured,
    and the 43 % in the branch beside it were dropped with it."""
    case = bifurcation_case(3, "ostium")
    (lesion,) = find_lesions(case.surface, case.centerline)
    shallow = {"diameters": lesion.diameters + 1.0, "percent_diameter": -3.0}
    beside = replace(lesion, vessel=2, point=tuple(np.add(lesion.point, 20.0)))
    for limbs in ((lesion,), (lesion, beside), (lesion, replace(beside, percent_diameter=14.0))):
        deep = [one for one in limbs if one.percent_diameter > 15]
        assert _told([replace(lesion, **shallow, limbs=limbs)]) == deep
        (kept,) = _told([replace(lesion, limbs=limbs)])
        assert kept.limbs == tuple(deep[1:])
