"""A stent follows the vessel in which its place lies, whichever of many lines is the nearest."""

import numpy as np
import pytest
from lesion_cases import bifurcation_case
from test_whole_lumens import parted

from SDFStentLib.centerline import Centerline
from SDFStentLib.files import read_centerline, read_lines
from SDFStentLib.geometry import Line
from SDFStentLib.stent import AtCenter, AtDistalEnd, AtProximalEnd, BetweenPoints, Stent, stent_axis
from SDFStentLib.treatment import StentMiddle

HAND = 0.3
"""How far the hand moves a point beside a line, mm."""

JUMP = 3.0
"""Ends that move so far under a small move of the hand are on another way, mm."""

TREES = (
    "su0243",
    pytest.param("su0243 without radii", marks=pytest.mark.bench),
    pytest.param("tree_narrowed", marks=pytest.mark.bench),
    pytest.param("tree_narrowed without radii", marks=pytest.mark.bench),
)


@pytest.fixture(scope="module", params=TREES)
def tree(request, data_dir) -> Centerline:
    name, *without = request.param.split(maxsplit=1)
    file = data_dir / f"{name}_centerline_mm.vtp"
    if not without:
        return read_centerline(file, "mm")
    lines = read_lines(file, "mm")
    return Centerline.from_lines(lines.points, lines.lines)


def axis_of(tree: Centerline, placement, length=26.0):
    if isinstance(placement, BetweenPoints):
        return stent_axis(Stent(6.0, placement=placement), tree).points
    stent = Stent(6.0, placement=placement, length=length, may_be_shortened=True)
    return stent_axis(stent, tree).points


def ends_of(tree: Centerline, placement, length=26.0):
    return axis_of(tree, placement, length)[[0, -1]]


def beside(place, rng):
    way = rng.normal(size=3)
    return place + HAND * way / np.linalg.norm(way)


def way_to(tree: Centerline, leaf: int):
    return tree.points[tree.ancestry(int(leaf))]


def test_a_hand_that_trembles_leaves_the_ends_where_they_are(tree):
    rng = np.random.default_rng(5)
    tries, jumps = 0, 0
    for leaf in rng.permutation(tree.leaves)[:3]:
        way = way_to(tree, leaf)
        for at in np.arange(30.0, 70.0, 4.0):
            place, length = Line(way).at(at), rng.uniform(20, 34)
            first, *others = (axis_of(tree, AtCenter(beside(place, rng)), length) for _ in range(4))
            for other in others:
                tries += 1
                if np.linalg.norm(other[[0, -1]] - first[[0, -1]], axis=1).max() < JUMP:
                    continue
                jumps += 1
                # Only where the vessels themselves have parted, of which each is chosen once.
                between = [Line(axis).nearest(place[None]).points[0] for axis in (first, other)]
                radius = tree.project(place).inscribed_radius
                apart = 0.3 * radius if np.isfinite(radius) else 2 * HAND
                assert np.linalg.norm(between[1] - between[0]) > apart
    assert tries == 90
    assert jumps <= 0.015 * tries


def test_both_ends_follow_a_hand_that_goes_down_a_vessel(tree):
    """All the way down the vessel that is followed from the root, and from another place."""
    rng, step = np.random.default_rng(7), 1.0
    starts = [tree.points[tree.roots[0]]]
    starts += [Line(way_to(tree, leaf)).at(50.0) for leaf in rng.permutation(tree.leaves)[:1]]
    for start in starts:
        way = tree.path_from_proximal(start, 1000.0)
        at = np.arange(0.0, way.length - 1.0, step)
        places = np.array([Line(way.points).at(one) for one in at])
        ends = np.array([ends_of(tree, AtCenter(place), 20.0) for place in places])
        assert np.linalg.norm(np.diff(ends, axis=0), axis=2).max() < 4 * step


def test_the_second_point_decides_for_a_side_branch(tree):
    """Also where the way that goes on by itself leads elsewhere."""
    rng, elsewhere = np.random.default_rng(13), 0
    for leaf in rng.permutation(tree.leaves)[:20]:
        way = way_to(tree, leaf)
        at = tree.arc_length[leaf]
        start, end = Line(way).at(at - 30.0), Line(way).at(at - 2.0)
        elsewhere += np.linalg.norm(ends_of(tree, AtProximalEnd(start), 28.0)[1] - end) > JUMP
        found = ends_of(tree, BetweenPoints(start, end))
        np.testing.assert_allclose(found[1], end, atol=1e-9)
    assert elsewhere > 5


def test_a_stent_that_is_placed_in_a_branch_leads_into_it(tree):
    """However near to its begin, where the vessel from which it comes goes on elsewhere."""
    by_end = 0
    for points in tree.branches:
        start, end = tree.arc_length[points[[0, -1]]]
        if end - start < 6:
            continue
        way = Line(tree.points[tree.ancestry(int(points[-1]))])
        place = StentMiddle(way, float(start) + 0.5, float(start), None)
        placement = place.placement(10.0, tree)
        by_end += isinstance(placement, AtDistalEnd)
        _, distal = ends_of(tree, placement, 10.0 / 0.9)
        wanted = tree.project(way.at(start + 5.5))
        # Lines of one lumen are so far apart.
        aside = np.nanmax([1.0, 0.6 * wanted.inscribed_radius])
        assert np.linalg.norm(distal - wanted.point) < aside
    assert by_end > 10


def test_lines_that_part_early_lead_where_those_lead_that_part_where_the_vessels_do():
    exact = bifurcation_case(22, None, fineness=0.4).centerline
    early = parted(exact, (0.3, 0.0), has_radius=True)
    fork = exact.arc_length[exact.junctions[0]]
    above = [lumen.start for lumen in early.lumens if lumen.start > 0]
    assert min(above) < 0.5 * fork
    known = ends_of(exact, AtCenter(Line(way_to(exact, exact.leaves[0])).at(fork - 5.0)), 20.0)
    for leaf in early.leaves:
        place = Line(way_to(early, leaf)).at(fork - 5.0)
        found = ends_of(early, AtCenter(place), 20.0)
        radius = np.nanmax(exact.inscribed_radius)
        assert np.linalg.norm(found - known, axis=1).max() < radius


def test_the_widest_vessel_is_followed_however_narrow_it_begins():
    """A lesion at its ostium is none of its caliber."""
    arms = [np.array([[0.0, 0, -40], [side, 0, -70]]) for side in (-20.0, 20.0)]
    points, lines, radii = [], [], []
    for number, arm in enumerate(arms):
        trunk = np.linspace([0.0, 0, 0], [0, 0, -40], 41)
        line = np.concatenate([trunk, np.linspace(*arm, 37)[1:]])
        radius = np.full(len(line), 4.0 - number)
        radius[:41] = 5.0
        if number == 0:
            radius[41:55] = 1.5
        lines.append(np.arange(len(line)) + sum(map(len, points)))
        points.append(line)
        radii.append(radius)
    tree = Centerline.from_lines(np.concatenate(points), lines, np.concatenate(radii))
    path = tree.path_around([0, 0, -30.0], 30)
    assert path.points[-1][0] < 0
    assert [choice.rule for choice in path.choices] == ["widest"]


@pytest.mark.parametrize(
    ("points", "parent", "length"),
    [
        ([[0.0, 0, 0]] * 3, [-1, 0, 0], 0.0),
        ([[0.0, 0, 0], [0, 0, 0], [0, 0, 8], [6, 0, 0]], [-1, 0, 1, 1], 5.0),
        ([[0.0, 0, 0], [0, 0, 8], [0, 0, 8], [0, 0, 8], [0, 0, 20]], [-1, 0, 1, 1, 3], 8.0),
    ],
    ids=["no length", "none at the root", "none at a junction"],
)
def test_branches_without_length_are_passed(points, parent, length):
    tree = Centerline(points, np.full(len(points), 2.0), parent)
    for place in (points[0], tree.project(points[0])):
        path = tree.path_from_proximal(place, length or 5.0)
        assert path.length == pytest.approx(length)
    for place in (points[2], tree.project(points[2])):
        path = tree.path_from_distal(place, 5.0)
        np.testing.assert_allclose(path.points[-1], points[2])
        assert path.length == pytest.approx(min(length, 5.0))
    assert tree.path(points[0], points[2]).length == pytest.approx(np.linalg.norm(points[2]))
