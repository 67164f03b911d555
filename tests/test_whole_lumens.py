"""A vessel before treatment is measured once, wherever its lines part."""

import gc
import weakref
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from lesion_cases import bifurcation_case

from benchmarks.phantoms import branching_pulmonary_artery, stenosed_tube
from SDFStentLib.centerline import BranchLumen, Centerline, joined_lumens
from SDFStentLib.deformation import DeploymentSettings
from SDFStentLib.geometry import Line, Surface
from SDFStentLib.lumen import in_caps, measured_at, measured_once
from SDFStentLib.stent import AtCenter, Stent
from SDFStentLib.treatment import Treatment
from SDFStentLib.vessel import find_lesions
from SDFStentLib.vessel.branch_lumen import branch_lumens


@pytest.fixture
def a_tube():
    return stenosed_tube()


def test_what_is_measured_once_meets_no_cap(a_tube):
    points = np.array([[0.0, 0.0, z] for z in (0.5, 1.0, 1.5)])
    along = np.tile([0.0, 0.0, 1.0], (3, 1))
    capped = measured_at(a_tube.surface, points, along, np.zeros(len(a_tube.triangles), dtype=bool))
    opened = measured_once(a_tube.surface, points, along)
    plain = measured_at(a_tube.surface, points, along, in_caps(a_tube.surface))
    np.testing.assert_array_equal(opened.spheres.radii, plain.spheres.radii)
    assert (opened.spheres.radii > capped.spheres.radii).any()


def test_nothing_that_was_measured_before_changes_an_answer_by_a_bit():
    """Plans that are compared and cases of a sweep share a vessel, and answer as if alone."""
    phantom = branching_pulmonary_artery()
    tree, (main, _) = phantom.centerline, phantom.vessels
    places = [main.axis.point(at)[0] for at in np.random.default_rng(62).uniform(18, 44, 6)]

    def answers(surface, place):
        stents = [Stent(7.0, placement=AtCenter(place), length=8.0, may_be_shortened=True)]
        (found,) = Treatment(surface, stents, tree).result.stents
        profiles = found.around_before, found.around_after
        return [
            *(one for each in profiles for one in (each.inscribed_diameter, each.centers)),
            *(np.array([one.before, one.after]) for one in found.neighbors),
        ]

    shared = Surface(phantom.points, phantom.triangles)
    for place in [*places, places[0]]:
        alone = answers(Surface(phantom.points, phantom.triangles), place)
        for one, own in zip(answers(shared, place), alone, strict=True):
            np.testing.assert_array_equal(one, own)


def test_the_surroundings_of_a_place_are_surveyed_once_for_all_diameters(a_tube):
    def survey(surface, height=20.0, diameter=6.0, line=a_tube.centerline):
        stent = Stent(diameter, placement=AtCenter([0, 0, height]), length=12.0)
        return Treatment(surface, [stent], line).survey

    surface = Surface(a_tube.points, a_tube.triangles)
    first = survey(surface)
    assert survey(surface, diameter=6.5) is first
    assert survey(surface, height=21.0) is not first
    again = survey(surface)  # the last one only is kept
    assert again is not first
    np.testing.assert_array_equal(again.axis.points, first.axis.points)
    np.testing.assert_array_equal(again.before.inscribed_diameter, first.before.inscribed_diameter)
    same_line = replace(a_tube.centerline)
    assert survey(surface, line=same_line) is not again
    gone = weakref.ref(surface)
    del surface
    gc.collect()
    assert gone() is None


def test_what_is_measured_beside_the_deployment_is_what_the_result_measures(a_tube):
    def treatment():
        stent = Stent(6.0, placement=AtCenter([0, 0, 20.0]), length=12.0)
        surface = a_tube.surface.with_points(a_tube.points)
        return Treatment(surface, [stent], a_tube.centerline, DeploymentSettings(certify=False))

    plain, beside = treatment().result.stents[0], treatment()
    with ThreadPoolExecutor(max_workers=1) as pool:
        survey = pool.submit(getattr, beside, "survey")
        for _ in beside:
            pass
        before = survey.result().before
    told = beside.result.stents[0]
    assert told.around_before is before
    for one, other in ((told.around_before, plain.around_before), (told.after, plain.after)):
        np.testing.assert_array_equal(one.inscribed_diameter, other.inscribed_diameter)
        np.testing.assert_array_equal(one.equivalent_diameter, other.equivalent_diameter)


NEAR = 2.0
"""Percentage points within which a degree is right beside a junction."""

# Lines that run through one lumen are one vessel, however early the file parts them.


@pytest.fixture(scope="module")
def divided():
    """A trunk that divides, without a lesion."""
    return bifurcation_case(22, None, fineness=0.4)


def parted(
    centerline: Centerline, shares: tuple[float, float], *, has_radius: bool = False
) -> Centerline:
    """A line to each outlet, moved aside by so much of the radius from a little after the inlet."""
    ways = [centerline.ancestry(int(leaf)) for leaf in centerline.leaves]
    if ways[0][0] != centerline.roots[0]:
        ways = [way[::-1] for way in ways]
    pieces = []
    for way, share in zip(ways, shares, strict=True):
        aside = share * centerline.inscribed_radius[way]
        aside *= np.clip(centerline.arc_length[way] / 10.0, 0, 1)
        pieces.append(centerline.points[way] + aside[:, None] * np.array([0.0, 1.0, 0.0]))
    ends = np.cumsum([0, *map(len, pieces)])
    lines = [np.arange(first, last) for first, last in pairwise(ends)]
    radius = np.concatenate([centerline.inscribed_radius[way] for way in ways])
    return Centerline.from_lines(np.concatenate(pieces), lines, radius if has_radius else None)


@pytest.mark.parametrize("has_radius", [False, True])
@pytest.mark.parametrize("shares", [(0.15, -0.15), (0.3, 0.0), (-0.1, 0.35), (-0.2, -0.05)])
def test_lines_that_begin_at_one_point_and_part_at_once_keep_their_inlet(
    divided, shares, has_radius
):
    exact = divided.centerline
    tree = parted(exact, shares, has_radius=has_radius)
    np.testing.assert_allclose(tree.points[tree.roots], exact.points[exact.roots], atol=1e-9)
    assert len(tree.leaves) == len(exact.leaves)


def test_lines_that_part_far_above_the_division_part_where_the_lumens_do(divided):
    known = joined_lumens(branch_lumens(divided.surface, divided.centerline)).stretches
    early = parted(divided.centerline, (0.15, -0.15))
    lumens = branch_lumens(divided.surface, early)
    trunk, *branches = joined_lumens(lumens).stretches
    assert len(known) == 3
    assert [one.above for one in branches] == [0, 0]
    # The file's lines part before half of the trunk is over.
    assert min(lumen.start for lumen in lumens if lumen.start > 0) < 0.5 * known[0].along[-1]
    radius = np.nanmedian(known[0].diameter) / 2
    assert trunk.along[-1] == pytest.approx(known[0].along[-1], abs=1.5 * radius)
    for one in branches:
        assert one.along[0] == trunk.along[-1]
        assert (np.diff(one.along) > 0).all()


@pytest.mark.parametrize("seed", [22, 204, 208, 215])
def test_what_is_told_does_not_depend_on_where_lines_part(seed):
    """Of three of these 5 to 7 points more than there are were told, by one line or by both."""
    case = bifurcation_case(seed, "ostium", fineness=0.4)
    (truth,) = case.known
    for line in (case.centerline, parted(case.centerline, (0.15, -0.15))):
        (found,) = find_lesions(case.surface, line)
        assert found.percent_diameter == pytest.approx(truth.percent, abs=NEAR)
        assert np.linalg.norm(np.subtract(found.point, truth.point)) < 0.1 * truth.length


@pytest.mark.parametrize("known", [(7, 6), (6, 7)])
def test_a_line_whose_width_is_known_sooner_at_the_inlet_has_not_left_the_other_s_lumen(known):
    """Of two lines of one trunk the second passed for a vessel of its own from the inlet on, and
    the first for one that a branch leaves there: 39 % were told of 32."""
    along = np.arange(0.0, 70.0)
    lumens = []
    for number, (first, way) in enumerate(zip(known, (1, -1), strict=True)):
        aside = way * (0.3 + np.maximum(0.0, along - 40.0))
        line = Line(np.column_stack([aside, 0 * along, along])[: 70 - number])
        diameter = np.where(along < first, np.nan, 10.0)[: len(line)]
        centers = np.where(np.isnan(diameter)[:, None], np.nan, line.points)
        nodes = (0, number + 1)
        lumens.append(BranchLumen(number, nodes, 0.0, line, line.arc_lengths, diameter, centers))
    trunk, *branches = joined_lumens(lumens).stretches
    assert [one.above for one in branches] == [0, 0]
    assert 39.0 < trunk.along[-1] < 45.0


def test_a_tree_that_parts_at_once_behind_its_root_is_measured(divided):
    tree = divided.centerline
    (root,) = tree.roots
    way = tree.points[root + 1] - tree.points[root]
    beside = tree.points[root] + 5 * way / np.linalg.norm(way) + [0, 1, 0]
    # Too short to be a branch, yet where it ends is no root.
    points = np.vstack([tree.points[root] - 5e-10 * way / np.linalg.norm(way), tree.points, beside])
    parent = np.r_[-1, np.where(tree.parent < 0, 0, tree.parent + 1), root + 1]
    parting = Centerline(points, np.full(len(points), np.nan), parent)
    starts = [lumen.start for lumen in branch_lumens(divided.surface, parting)]
    assert 0 < min(starts) < 1e-9
