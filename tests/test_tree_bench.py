"""The bench of trees: its truth where that is known by calculation, and its verdicts."""

import sys
from dataclasses import replace

import numpy as np
import pytest
from child_processes import PROJECT

sys.path.insert(0, str(PROJECT))

from benchmarks.trees import treated
from benchmarks.trees.case import TreeCase, save
from benchmarks.trees.hourglass import _is_one_vessel
from benchmarks.trees.hourglass import narrowed as hourglass_narrowed
from benchmarks.trees.judge import AS_LIMB, Reported, _off, judged
from benchmarks.trees.layout import VesselTree
from benchmarks.trees.narrowing import HOURGLASS, MadeNarrowing, narrowed, narrowings
from benchmarks.trees.surface import Wall, rims_of, wall_of
from benchmarks.trees.synthetic import random_tree
from benchmarks.trees.truth import Spheres, Truth, _is_passed, truths
from SDFStentLib.centerline import Centerline
from SDFStentLib.geometry import Surface
from SDFStentLib.plan import read_input_files
from SDFStentLib.vessel.branch_lumen import branch_lumens
from SDFStentLib.vessel.caliber import healthy_caliber
from SDFStentLib.vessel.found_narrowings import measured_runs
from SDFStentLib.vessel.runs import vessel_runs

pytestmark = pytest.mark.bench

WAY = np.array([0.6, 0.0, 0.8])


def line_tree(radius, length=60.0, start=(0.0, 0.0, 0.0)) -> VesselTree:
    """A straight vessel whose radius is a function of the arc length."""
    along = np.arange(0, length + 0.25, 0.5)
    return VesselTree(np.add(start, np.outer(along, WAY)), radius(along), np.arange(len(along)) - 1)


def swept_wall(radius, length=60.0, around=90, step=0.2) -> Wall:
    """The surface of revolution about the same line, finely meshed."""
    along = np.arange(0, length + step / 2, step)
    angle = np.linspace(0, 2 * np.pi, around, endpoint=False)
    first, second = np.array([0.0, 1.0, 0.0]), np.cross(WAY, [0.0, 1.0, 0.0])
    ring = np.outer(np.cos(angle), first) + np.outer(np.sin(angle), second)
    points = along[:, None, None] * WAY + radius(along)[:, None, None] * ring
    at = np.arange(len(along) * around).reshape(len(along), around)
    a, b = at[:-1], at[1:]
    c, d = np.roll(b, -1, axis=1), np.roll(a, -1, axis=1)
    quads = np.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 3)
    return Wall(points.reshape(-1, 3), quads, np.ones(len(quads), dtype=int))


def constant(size):
    return lambda at: np.full(np.shape(at), size)


def cosine(depth, begin, end):
    """Factor of a radius: a raised cosine."""
    return lambda at: (
        1
        - depth
        * np.where(
            (at > begin) & (at < end), (1 - np.cos(2 * np.pi * (at - begin) / (end - begin))) / 2, 0
        )
    )


def seeded(healthy, shape, parts, healthy_ends):
    """A tree and its wall before and after, and the narrowing."""

    def factor(at):
        return np.prod([cosine(*part)(at) for part in parts], axis=0)

    before = line_tree(healthy)
    vessel = np.arange(len(before.points))
    one = MadeNarrowing(shape, vessel, healthy_ends, (), factor(before.arc_length))
    after = narrowed(before, [one])
    return (
        (before, swept_wall(healthy)),
        (after, swept_wall(lambda at: healthy(at) * factor(at))),
        one,
    )


# The truth ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("depth", [0.4, 0.75])
def test_a_cosine_is_told_as_it_was_made(depth):
    before, after, one = seeded(constant(2.0), "focal", [(depth, 25.0, 37.0)], (25.0, 37.0))
    (truth,) = truths(before, after, one)
    assert truth.minimum == pytest.approx(4 * (1 - depth), rel=4e-3)
    assert truth.percent == pytest.approx(100 * depth, abs=0.3)
    assert np.linalg.norm(truth.place - 31 * WAY) < 0.15
    # Spheres of a steep flank touch it farther on: there they are smaller than the section.
    reach = 24 / np.pi * np.arccos(np.sqrt(0.1 / depth))
    assert reach - 0.6 <= truth.length <= reach + 1.2


def test_a_throat_beside_which_a_wider_sphere_passes_is_no_narrowing():
    """A branch of 4.5 mm with 1.6 mm in its own plane ran so near its parent that 2.7 mm passed."""
    before, after, one = seeded(constant(2.0), "focal", [(0.5, 25.0, 37.0)], (25.0, 37.0))
    (truth,) = truths(before, after, one)
    way = np.array(truth.stations)[[truth.begin, truth.at, truth.end]]
    assert not _is_passed(after[1], way, truth.minimum)
    for narrower in (0.6, 0.7):  # as if a sphere of the lumen had been found in a part of it
        assert _is_passed(after[1], way, narrower * truth.minimum)
    assert not _is_passed(None, way, 0.6 * truth.minimum)


def test_healthy_vessel_parts_two_narrowings_and_nothing_less():
    apart = [(0.5, 15.0, 23.0), (0.6, 36.0, 44.0)]
    found = truths(*seeded(constant(1.7), "tandem apart", apart, (15.0, 44.0)))
    assert [one.percent for one in found] == pytest.approx([50, 60], abs=0.5)
    merged = [(0.5, 20.0, 30.0), (0.6, 25.0, 35.0)]
    (one,) = truths(*seeded(constant(1.7), "tandem merged", merged, (20.0, 35.0)))
    assert one.percent > 55
    near = [(0.5, 20.0, 28.0), (0.6, 29.0, 37.0)]
    with pytest.raises(ValueError, match=r"hardly healthy|parts"):
        truths(*seeded(constant(1.7), "tandem apart", near, (20.0, 37.0)))


def test_a_vessel_that_ends_is_not_narrowed_there():
    """A cap was the deepest of a narrowing that was too shallow to be told: 96 %."""
    before = line_tree(constant(2.0), length=30.0)
    factor = cosine(0.1, 14.0, 25.0)(before.arc_length)
    one = MadeNarrowing("focal", np.arange(len(before.points)), (14.0, 25.0), (), factor)
    after = narrowed(before, [one])
    walls = [wall_of(tree, 0.4, "capped") for tree in (before, after)]
    with pytest.raises(ValueError, match="0 parts"):
        truths((before, walls[0]), (after, walls[1]), one)


def test_where_a_vessel_was_as_narrow_before_is_no_narrowing_that_was_made():
    """A made one of 21 % was none, and a branch's own narrow beginning beside it was the truth."""
    before = line_tree(lambda at: 2.0 - 0.7 * np.exp(-(((at - 22.0) / 1.5) ** 2)), length=44.0)
    factor = cosine(0.12, 12.0, 18.0)(before.arc_length)
    one = MadeNarrowing("hourglass", np.arange(len(before.points)), (12.0, 30.0), (), factor)
    after = narrowed(before, [one])
    walls = [wall_of(tree, 0.4, "capped") for tree in (before, after)]
    with pytest.raises(ValueError, match="so before"):
        truths((before, walls[0]), (after, walls[1]), one)


def test_the_sphere_search_agrees_with_a_search_for_the_widest_way_through():
    """Through the voxels of a grid: the widest sphere that gets from one end to the other."""
    from scipy.ndimage import label
    from scipy.spatial import cKDTree

    tree = random_tree(np.random.default_rng(3), 20)
    (one,) = narrowings(tree, ["focal"], np.random.default_rng(3))
    after = narrowed(tree, [one])
    wall = wall_of(after, 0.4, "round")
    (truth,) = truths((tree, wall_of(tree, 0.4, "round")), (after, wall), one)
    ends = np.array(truth.stations)[[truth.begin, truth.end]]
    low, step = ends.min(axis=0) - 4, 0.15
    axes = [np.arange(low[k], ends[:, k].max() + 4, step) for k in range(3)]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    line = cKDTree(np.array(truth.stations))
    apart, at = line.query(grid.reshape(-1, 3))
    inside = apart < 0.95 * np.array(truth.diameter)[at] / 2
    room = np.zeros(len(apart))
    room[inside] = cKDTree(wall.points).query(grid.reshape(-1, 3)[inside])[0]
    room = room.reshape(grid.shape[:3])
    cells = [tuple(np.round((end - low) / step).astype(int)) for end in ends]

    def is_through(size):
        parts, _ = label(room >= size, np.ones((3, 3, 3)))
        return parts[cells[0]] == parts[cells[1]] > 0

    widest = max(size for size in np.arange(0.3, 4, 0.01) if is_through(size))
    # Points of the grid miss the middle, corners of triangles are farther away than their faces.
    assert 2 * widest == pytest.approx(truth.minimum, abs=0.12)


# The surfaces ------------------------------------------------------------------------------------


@pytest.mark.parametrize("ends", ["round", "capped", "open"])
def test_surfaces_are_two_manifold_and_their_ends_are_what_they_should_be(ends):
    tree = random_tree(np.random.default_rng(5), 12)
    wall = wall_of(tree, 0.5, ends)
    edges = np.sort(np.vstack([wall.triangles[:, [k, (k + 1) % 3]] for k in range(3)]), axis=1)
    _, count = np.unique(edges, axis=0, return_counts=True)
    assert set(count.tolist()) == ({1, 2} if ends == "open" else {2})
    count_of_ends = len(tree.leaves) + 1
    assert len(rims_of(wall.triangles)) == (count_of_ends if ends == "open" else 0)
    assert len(np.unique(wall.faces)) == (1 + count_of_ends if ends == "capped" else 1)
    corners = wall.points[wall.triangles]
    volume = np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    assert volume > 0


# The verdicts ------------------------------------------------------------------------------------


def told(place, minimum, percent, reference=6.0, length=8.0):
    return Reported(np.asarray(place), minimum, percent, reference, length, "")


@pytest.mark.parametrize(
    ("percent", "error"), [(40.5, 0.0), (50.0, 0.0), (59.5, 0.0), (38.0, -12.0), (63.0, 13.0)]
)
def test_a_degree_between_those_against_both_sides_is_right(percent, error):
    """Where a vessel tapers no one place beside it is the reference."""
    truth = Truth(
        "", [], 6.0, 12.0, 50.0, 15.0, 10.0, 0, 0, 0, [], [0.0], [], []
    )  # against 15 mm 60 %, against 10 mm 40 %
    assert _off(percent, truth) == error


def test_an_hourglass_narrows_all_that_lies_in_its_vessel_and_nothing_else():
    """Its fork is narrowed for both branches, a branch beyond the lumen for none."""
    line = np.column_stack([np.zeros(61), np.zeros(61), np.arange(61.0)])
    beside = np.column_stack([np.arange(1.0, 21.0), np.zeros(20), np.full(20, 30.0)])
    parent = np.r_[-1, np.arange(60), 30, 61 + np.arange(19)]
    radius = np.r_[np.full(61, 4.0), np.full(20, 3.0)]
    tree = VesselTree(np.vstack([line, beside]), radius, parent)
    factor = 1 - 0.5 * np.clip(1 - np.abs(line[:, 2] - 30) / 8, 0, 1)
    one = MadeNarrowing(HOURGLASS, np.arange(61), (22.0, 38.0), (30.0,), factor)
    after = hourglass_narrowed(tree, [one]).radius
    np.testing.assert_allclose(after[:61], 4.0 * factor)
    np.testing.assert_allclose(after[61:64], 1.5)
    np.testing.assert_allclose(after[64:], 3.0)


def test_an_hourglass_is_at_a_fork_where_its_way_leaves_the_vessel_or_that_divides():
    line = np.column_stack([np.zeros(61), np.zeros(61), np.arange(61.0)])
    beside = np.column_stack([np.arange(1.0, 41.0), np.zeros(40), np.full(40, 30.0)])
    parent = np.r_[-1, np.arange(60), 30, 61 + np.arange(39)]
    way, aside = np.arange(61), np.r_[np.arange(31), 61 + np.arange(40)]
    for small, ways in ((2.0, [True, False]), (3.9, [False, False])):
        radius = np.r_[np.full(61, 4.0), np.full(40, small)]
        tree = VesselTree(np.vstack([line, beside]), radius, parent)
        found = [_is_one_vessel(tree, one, np.arange(20, 40)) for one in (way, aside)]
        assert found == ways
        assert _is_one_vessel(tree, aside, np.arange(32, 50))


@pytest.fixture(scope="module")
def halved():
    """A vessel of 6 mm with a narrowing to 3 mm, and what is true of it."""
    before, after, one = seeded(constant(3.0), "focal", [(0.5, 25.0, 37.0)], (25.0, 37.0))
    return after, truths(before, after, one)


@pytest.mark.parametrize(
    ("lesions", "words"),
    [
        ([(31.0, 3.0, 50.0)], "as it is"),
        ([(33.5, 3.05, 46.0)], "as it is"),
        ([], "missed"),
        ([(29.0, 3.0, 50.0), (33.0, 3.3, 45.0)], "split"),
        ([(35.0, 3.0, 50.0)], "place"),
        ([(31.0, 3.2, 50.0)], "minimum"),
        ([(31.0, 3.0, 56.0)], "percent"),
        ([(50.0, 3.0, 50.0)], "missed"),
    ],
)
def test_verdicts(halved, lesions, words):
    after, found = halved
    given = [told(at * WAY, minimum, percent) for at, minimum, percent in lesions]
    (verdict,), invented = judged(*after, found, given)
    assert verdict.words == words
    assert len(invented) == sum(at == 50.0 for at, _, _ in lesions)


@pytest.mark.parametrize(
    ("lesions", "limbs", "words"),
    [
        ([], [(31.0, 3.0, 50.0)], AS_LIMB),
        ([], [(31.0, 3.2, 50.0)], f"minimum, {AS_LIMB}"),
        ([], [(31.0, 3.0, 56.0)], "missed"),
        ([], [(31.0, 3.0, 50.0), (31.5, 3.0, 50.0)], "missed"),
        ([(31.0, 3.0, 56.0)], [(31.0, 3.0, 50.0)], AS_LIMB),
        ([(31.0, 3.0, 50.0)], [(31.0, 3.0, 56.0)], "as it is"),
    ],
)
def test_a_narrowing_that_is_told_as_a_limb_counts_by_itself(halved, lesions, limbs, words):
    after, found = halved
    given = [told(at * WAY, minimum, percent) for at, minimum, percent in lesions]
    mine = tuple(told(at * WAY, minimum, percent) for at, minimum, percent in limbs)
    other = replace(told(np.array([0.0, 99.0, 0.0]), 2.0, 50.0), limbs=mine)
    (verdict,), _ = judged(*after, found, [*given, other])
    assert (verdict.words, verdict.is_right) == (words, words == "as it is")


def test_a_treatment_is_judged_by_what_is_left_in_the_surface(halved, tmp_path):
    (tree, wall), found = halved
    facts = {"number": 0, "wander": 0.0, "has_radius": True}
    save(TreeCase("0000", tree, wall, found, facts), tmp_path / "0000")
    (one,) = treated.of_case(tmp_path / "0000")
    assert (one["failure"], one["is_certified"]) == ("", True)
    assert list(treated.sentences([one])) == []
    assert "1 of 1" in treated.table([one])
    assert abs(one["lumen"]) < 1
    (said,) = treated.sentences([{**one, "lesion": 6.0}])
    assert said == "0000, narrowing 0 (focal): lesion after, points: +6.0"


# What vessels are called -------------------------------------------------------------------------


def widest_over_its_own_half(along, diameter):
    """How wide a vessel stays over half of its own diameter, and at most is, mm."""
    half = np.abs(along[:, None] - along) <= diameter[:, None] / 4
    return np.where(half, diameter, np.inf).min(axis=1).max(), diameter.max()


def test_a_vessel_is_called_by_its_healthy_caliber_though_most_of_it_is_narrow():
    tree = line_tree(lambda at: 2.5 * cosine(0.6, 8.0, 52.0)(at))
    wall = swept_wall(lambda at: 2.5 * cosine(0.6, 8.0, 52.0)(at))
    line = Centerline(tree.points, tree.radius, tree.parent)
    (run,) = vessel_runs(branch_lumens(Surface(wall.points, wall.triangles), line))
    assert healthy_caliber(run) == pytest.approx(5.0, rel=0.03)


def test_vessels_of_a_patient_are_called_as_wide_as_an_independent_search_finds_them(data_dir):
    """5.1 mm were told of a branch whose lesion was measured against 6.6 mm."""
    names = [str(data_dir / f"su0243_{name}_mm.vtp") for name in ("surface", "centerline")]
    vessel = read_input_files(*names).vessel
    runs, _ = measured_runs(vessel.surface, vessel.centerline)
    wall = Wall(vessel.surface.points, vessel.surface.triangles, np.ones(1, dtype=int))
    for number in sorted({lesion.vessel for lesion in vessel.lesions[:2]}):
        run = runs[number]
        known = np.flatnonzero(np.isfinite(run.diameter))
        spheres = Spheres(wall, run.points[known], 15.0)
        ways = np.gradient(run.points, axis=0)[known]
        ways /= np.linalg.norm(ways, axis=1)[:, None]
        found = [
            2 * spheres.across(place, way, 0.6 * wide)[1]
            for place, way, wide in zip(run.points[known], ways, run.diameter[known], strict=True)
        ]
        low, high = widest_over_its_own_half(run.along[known], np.array(found))
        assert 0.85 * low <= healthy_caliber(run) <= 1.01 * high, number
