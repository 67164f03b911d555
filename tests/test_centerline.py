"""Centerlines: every form of file, trees with closed forms, identities, degenerate input."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from seeds import seeds

from SDFStentLib.centerline import Centerline, line_graph, overlaps
from SDFStentLib.centerline.line_graph import LineGraph, near_pairs
from SDFStentLib.centerline.point_tree import ancestry_of
from SDFStentLib.geometry import Line, closest_on_segments, distances_to_segments
from SDFStentLib.validation import InputError

# Lengths up to 1000 mm: rounding of sums of a thousand terms stays below this, mm.
ROUNDING = 1e-9

INLET, FORK = np.array([0.0, 0, 0]), np.array([0.0, 0, -40])
WIDE_OUTLET, LONG_OUTLET = np.array([20.0, 0, -60]), np.array([-30.0, 0, -70])


def a_line(start: np.ndarray, end: np.ndarray, step: float = 1.0) -> np.ndarray:
    return Line(np.array([start, end])).resampled(step).points


def fork_lines(trunk_step: float = 1.0) -> list[np.ndarray]:
    """Two polylines from the inlet, each all the way, as vmtkcenterlines writes them."""
    trunk = a_line(INLET, FORK, trunk_step)
    return [np.concatenate([trunk, a_line(FORK, end)[1:]]) for end in (WIDE_OUTLET, LONG_OUTLET)]


def fork_radius(points: np.ndarray) -> np.ndarray:
    """5 in the trunk, 4 in the wide daughter, 3 in the long one."""
    below = points[:, 2] < FORK[2] - 1e-6
    return np.where(below, np.where(points[:, 0] > 0, 4.0, 3.0), 5.0)


def stacked(lines: list[np.ndarray]) -> tuple[np.ndarray, list[np.ndarray]]:
    """Unshared points and their index lists."""
    ends = np.cumsum([len(line) for line in lines])
    indices = [np.arange(end - len(line), end) for end, line in zip(ends, lines, strict=True)]
    return np.concatenate(lines), indices


def a_fork(**options: object) -> Centerline:
    points, lines = stacked(fork_lines())
    return Centerline.from_lines(points, lines, fork_radius(points), **options)


def total_length(tree: Centerline) -> float:
    return sum(Line(tree.points[branch]).length for branch in tree.branches)


FORK_LENGTH = 40 + np.linalg.norm(WIDE_OUTLET - FORK) + np.linalg.norm(LONG_OUTLET - FORK)


def assert_is_the_fork(tree: Centerline, tolerance: float = 1e-6) -> None:
    assert len(tree.roots) == 1
    np.testing.assert_allclose(tree.points[tree.roots[0]], INLET, atol=tolerance)
    ends = tree.points[tree.leaves]
    assert len(ends) == 2
    for outlet in (WIDE_OUTLET, LONG_OUTLET):
        assert np.linalg.norm(ends - outlet, axis=1).min() <= tolerance
    assert len(tree.junctions) == 1
    # Daughters 45 degrees and more apart part within 0.1 radius / sin: below 1 mm from the fork.
    assert np.linalg.norm(tree.points[tree.junctions[0]] - FORK) < 1.0
    assert total_length(tree) == pytest.approx(FORK_LENGTH, abs=1.0)


# ---- the forms of design section 5


def shuffled(points: np.ndarray, lines: list[np.ndarray], order: np.ndarray):
    """The same lines through points that are stored in another order."""
    position = np.argsort(order)
    return points[order], [position[line] for line in lines]


def forms() -> dict[str, tuple[np.ndarray, list[np.ndarray]]]:
    """Points and lines of the one fork."""
    wide, long = fork_lines()
    points, lines = stacked([wide, long])
    rng = np.random.default_rng(3)
    tracts = [part for line in (wide, long) for part in (line[:30], line[29:45], line[44:])]
    twice = [np.repeat(line, 2) for line in lines]
    return {
        "lines from the inlet": (points, lines),
        "points out of order": shuffled(points, lines, rng.permutation(len(points))),
        "points against the cells": shuffled(points, lines, np.arange(len(points))[::-1]),
        "lines to the inlet": (points, [line[::-1] for line in lines]),
        "a trunk sampled by each line": stacked([wide, fork_lines(0.77)[1]]),
        "a trunk followed roughly": (points + 1e-3 * rng.normal(size=points.shape), lines),
        "tracts that repeat a group per line": stacked(tracts),
        "a gap below the local radius": stacked([wide, long[43:]]),
        "repeats and lines that are there twice": (points, [*twice, lines[0][::-1], lines[1][:20]]),
    }


@pytest.mark.parametrize("form", forms())
def test_every_form_of_the_fork_is_that_fork(form):
    points, lines = forms()[form]
    tree = Centerline.from_lines(points, lines, fork_radius(points))
    is_rough = "roughly" in form
    assert_is_the_fork(tree, tolerance=0.01 if is_rough else 1e-6)
    assert is_rough or set(tree.inscribed_radius) == {3.0, 4.0, 5.0}


@pytest.mark.parametrize("backward", [False, True])
@pytest.mark.parametrize("as_cells", [False, True])
def test_one_line_begins_at_its_wider_end_however_it_is_stored(backward, as_cells):
    """Stored backward, `--distal` was another place without a word."""
    points = a_line(INLET, WIDE_OUTLET, 1.0)
    radius = np.linspace(5, 3, len(points))
    if backward:
        points, radius = points[::-1], radius[::-1]
    whole = np.arange(len(points))
    lines = list(np.column_stack([whole[:-1], whole[1:]])) if as_cells else [whole]
    tree = Centerline.from_lines(points, lines, radius)
    np.testing.assert_array_equal(tree.points[tree.roots[0]], INLET)
    alike = Centerline.from_lines(points, lines, np.full(len(points), 4.0))
    np.testing.assert_array_equal(alike.points[alike.roots[0]], points[0])


def test_a_line_that_touches_the_inside_of_a_segment_is_joined_there_without_a_gap():
    points = np.array([[0.0, 0, 0], [10, 0, 0], [5, 0, 0], [5, 60, 0], [5, -60, 0]])
    tree = Centerline.from_lines(points, [[0, 1], [3, 2, 4]], np.full(5, 0.1))
    assert len(tree.points) == 5
    assert tree.points[tree.junctions].tolist() == [[5, 0, 0]]
    assert len(tree.children(int(tree.junctions[0]))) == 3


def wandering(count: int, seed: int) -> list[np.ndarray]:
    """Lines from one inlet, all the way, each up to 0.4 mm to and fro beside the others."""
    random = np.random.default_rng(seed)
    pieces = []
    for tip in np.column_stack([30 * random.normal(size=(count, 2)), np.full(count, -70.0)]):
        piece = np.vstack([a_line(INLET, FORK), a_line(FORK, tip)[1:]])
        steps = np.cumsum(random.normal(size=piece.shape), axis=0)
        wave = np.column_stack([np.convolve(x, np.ones(15) / 15, mode="same") for x in steps.T])
        pieces.append(piece + 0.4 * wave / np.abs(wave).max())
    return pieces


@pytest.mark.parametrize("seed", range(2))
def test_no_vessel_ends_at_a_capped_inlet_where_lines_begin(seed):
    """A cap leaves no sphere there, in which the zigzag of the first points would be one place."""
    random = np.random.default_rng(seed)
    lines = []
    for angle in np.linspace(0, 2 * np.pi, 12, endpoint=False):
        height = np.arange(0, 80, 0.25)
        aside = 0.6 * np.clip(height - 30, 0, None)
        line = np.stack([np.cos(angle) * aside, np.sin(angle) * aside, height], axis=1)
        wave = np.cumsum(random.normal(size=line.shape), axis=0)
        wave = np.stack([np.convolve(x, np.ones(15) / 15, mode="same") for x in wave.T], axis=1)
        radius = np.where(height < 30, 8.0, 3.0)[:, None]
        lines.append(line + 0.05 * radius * wave / np.abs(wave).max())
    round_ = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    ring = np.stack([np.cos(round_), np.sin(round_), 0 * round_], axis=1)
    trunk = [8 * ring + [0, 0, z] for z in np.arange(0, 31.0)]
    cap = [size * ring for size in np.arange(0, 8, 0.4)]
    branches = [line[at] + 3 * ring for line in lines for at in range(124, 320, 4)]
    ends = np.cumsum([len(line) for line in lines])
    tree = Centerline.from_lines(
        np.concatenate(lines),
        np.split(np.arange(ends[-1]), ends[:-1]),
        wall=np.concatenate([*trunk, *cap, *branches]),
    )
    assert len(tree.leaves) == 12
    assert np.linalg.norm(tree.points[tree.roots], axis=1).max() < 1.0


@pytest.mark.parametrize("backward", [False, True])
@pytest.mark.parametrize("seed", range(5, 8))
def test_lines_that_begin_at_places_of_one_inlet_cross_and_begin_there(seed, backward):
    """No end of the graph was left there: with half of these seeds the tree began at an outlet."""
    pieces = wandering(30, seed)
    points, lines = stacked([piece[::-1] for piece in pieces] if backward else pieces)
    tree = Centerline.from_lines(points, lines)
    assert np.linalg.norm(tree.points[tree.roots] - INLET, axis=1).max() < 1.0


def test_pieces_too_far_apart_are_refused_with_gap_and_place():
    wide, long = fork_lines()
    points, lines = stacked([wide[:36], long[46:]])
    message = (
        r"got 2 pieces with a gap of 10\.2 mm at \(-2.143, .* the 10 mm that are bridged there"
    )
    with pytest.raises(InputError, match=message):
        Centerline.from_lines(points, lines, fork_radius(points))


# ---- real files


def read_lines(path, scale):
    vtk = pytest.importorskip("vtk")
    from vtk.util.numpy_support import vtk_to_numpy

    reader = vtk.vtkXMLPolyDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    data = reader.GetOutput()
    cells = vtk_to_numpy(data.GetLines().GetConnectivityArray())
    lines = np.split(cells, vtk_to_numpy(data.GetLines().GetOffsetsArray())[1:-1])
    radius = vtk_to_numpy(data.GetPointData().GetArray("MaximumInscribedSphereRadius"))
    return scale * vtk_to_numpy(data.GetPoints().GetData()).astype(float), lines, scale * radius


REAL_FILES = [  # file, scale to mm, inlet, longest and shortest way to an outlet
    ("vmtk_aorta_centerline_mm.vtp", 1, (222.1, 175.9, 21.7), (77.8, 76.2)),
    ("vmtk_aorta_centerline_branches_mm.vtp", 1, (222.1, 175.9, 21.7), (77.8, 76.2)),
    ("aorta_iliac_centerline_cm.vtp", 10, (-19.6, -16.3, 129.2), (449.0, 429.4)),
    ("pulmonary_centerline_cm.vtp", 10, (30.1, -68.5, 61.4), (159.8, 143.4)),
]


@pytest.mark.parametrize(("name", "scale", "inlet", "ways"), REAL_FILES)
@pytest.mark.parametrize(("reversed_lines", "with_radius"), [(False, False), (True, True)])
def test_real_centerlines_have_one_inlet_and_two_outlets(
    data_dir, name, scale, inlet, ways, reversed_lines, with_radius
):
    points, lines, radius = read_lines(data_dir / name, scale)
    lines = [line[::-1] for line in lines] if reversed_lines else lines
    tree = Centerline.from_lines(points, lines, radius if with_radius else None)
    assert (len(tree.roots), len(tree.leaves), len(tree.junctions)) == (1, 2, 1)
    np.testing.assert_allclose(tree.points[tree.roots[0]], inlet, atol=0.06)  # rounded literals
    # The second line of a fork bends to the first one where they part: up to 0.1 radius, 0.9 mm.
    np.testing.assert_allclose(np.sort(tree.arc_length[tree.leaves])[::-1], ways, atol=0.9)
    below = np.flatnonzero(tree.parent >= 0)
    used = points[np.unique(np.concatenate(lines))]
    found = closest_on_segments(tree.points[tree.parent[below]], tree.points[below], used)
    assert found.distances.max() <= 0.1 * np.nanmax(radius)


def test_a_real_tree_ends_only_where_one_of_its_lines_does(data_dir):
    """Lines that parted for a moment on their way left a branch of 0.1 mm within the trunk."""
    points, lines, radius = read_lines(data_dir / "su0243_centerline_mm.vtp", 1)
    tree = Centerline.from_lines(points, lines, radius)
    assert len(tree.leaves) == len(lines) == 92


# ---- what the tree answers


inside = st.floats(0.0, 1.0)


def on_tree(tree: Centerline, fraction: float) -> np.ndarray:
    """Some place on the tree, over all branches in turn."""
    below = np.flatnonzero(tree.parent >= 0)
    index = below[min(int(fraction * len(below)), len(below) - 1)]
    part = (fraction * len(below)) % 1.0
    return (1 - part) * tree.points[tree.parent[index]] + part * tree.points[index]


@settings(max_examples=60)
@given(inside, inside)
def test_a_path_and_its_way_back_are_the_same(one, other):
    tree = a_fork()
    start, end = on_tree(tree, one), on_tree(tree, other)
    there, back = tree.path(start, end), tree.path(end, start)
    assert there.length == pytest.approx(back.length, abs=ROUNDING)
    if len(there.points) == len(back.points):
        np.testing.assert_allclose(there.points, back.reversed().points, atol=1e-8)


# ---- degenerate input


@pytest.mark.parametrize(
    "lines", [[[0, 1, 2, 3, 0]], [[0, 1], [1, 2], [2, 3], [3, 0]], [[2, 3, 0, 1], [1, 2]]]
)
@pytest.mark.parametrize("inlet", [None, (1, 0, 0)])
def test_a_closed_loop_without_any_end_is_called_one(lines, inlet):
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    with pytest.raises(InputError, match=r"a closed loop, .* at \([01], [01], 0\); take a part"):
        Centerline.from_lines(square, lines, inlet=inlet)


grid_points = st.lists(st.tuples(*[st.integers(0, 3)] * 3), min_size=2, max_size=12)


@settings(max_examples=100, deadline=None)
@given(grid_points, st.data())
def test_whatever_the_lines_the_answer_is_one_tree_or_a_sentence(points, data):
    indices = st.integers(0, len(points) - 1)
    lines = data.draw(st.lists(st.lists(indices, min_size=1, max_size=8), max_size=5))
    radius = data.draw(st.sampled_from([None, 0.1, 1.0, 3.0]))
    radii = None if radius is None else np.full(len(points), radius)
    try:
        tree = Centerline.from_lines(points, lines, radii)
    except InputError:  # the sentences have tests of their own, below
        return
    assert len(tree.roots) == 1
    assert len(tree.points) >= 2
    below = np.flatnonzero(tree.parent >= 0)
    assert (tree.arc_length[below] > tree.arc_length[tree.parent[below]]).all()
    assert len(tree.ancestry(int(tree.leaves[0]))) >= 2


def test_points_on_different_trees_have_no_path():
    points = np.array([[0.0, 0, 0], [1, 0, 0], [9, 0, 0], [10, 0, 0]])
    forest = Centerline(points, np.ones(4), [-1, 0, -1, 2])
    assert forest.roots.tolist() == [0, 2]
    with pytest.raises(InputError, match="trees with different roots"):
        forest.path([0, 0, 0], [10, 0, 0])


@pytest.mark.parametrize("seed", range(8))
def test_the_way_from_the_root_does_not_depend_on_the_order_of_the_points(seed):
    random, count = np.random.default_rng(seed), 40
    # Runs of points after their parents, new branches and roots between them.
    parent = np.arange(-1, count - 1)
    for child in np.flatnonzero(random.random(count) < 0.2):
        parent[child] = random.integers(-1, child)
    number = random.permutation(count) if seed % 2 else np.arange(count)[::-1] if seed % 4 else None
    stored = np.arange(count) if number is None else number
    shuffled = np.empty(count, dtype=np.int64)
    shuffled[stored] = np.where(parent < 0, -1, stored[parent])
    for index in range(count):
        way = [index]
        while parent[way[-1]] >= 0:
            way.append(parent[way[-1]])
        np.testing.assert_array_equal(ancestry_of(shuffled, stored[index]), stored[way[::-1]])


def a_binary_tree(random: np.random.Generator) -> list[np.ndarray]:
    """A line from the inlet to each of 8 ends, points and radii (n, 4)."""

    def ways(begin: np.ndarray, way: np.ndarray, radius: float, depth: int) -> list[np.ndarray]:
        line = a_line(begin, begin + float(random.uniform(6, 9)) * radius * way)
        wide = np.column_stack([line, np.full(len(line), radius)])
        if not depth:
            return [wide]
        aside = np.cross(way, random.normal(size=3))
        aside /= np.linalg.norm(aside)
        return [
            np.vstack([wide, one[1:]])
            for side in (aside, -aside)
            for one in ways(line[-1], (way + 0.7 * side) / np.sqrt(1.49), 0.8 * radius, depth - 1)
        ]

    return ways(np.zeros(3), np.array([0.0, 0.0, 1.0]), 6.0, 3)


@pytest.mark.parametrize("seed", seeds(5, 20))
def test_lines_that_wander_in_their_lumen_make_no_ends(seed):
    random = np.random.default_rng([seed, 5])
    ways, wandering = a_binary_tree(random), []
    for line, radius in ((way[:, :3], way[:, 3]) for way in ways):
        wave = np.cumsum(random.normal(size=line.shape), axis=0)
        wave = np.column_stack([np.convolve(x, np.ones(15) / 15, mode="same") for x in wave.T])
        wandering.append(line + 0.1 * radius[:, None] * wave / np.abs(wave).max())
    points, indices = stacked(wandering)
    for radius in (np.concatenate(ways)[:, 3], None):
        tree = Centerline.from_lines(points, indices, radius)
        ends = {tuple(points[line[-1]]) for line in indices}
        assert {tuple(tree.points[leaf]) for leaf in tree.leaves} == ends
        assert np.linalg.norm(tree.points[tree.roots[0]]) < 1.0


# Nodes near segments of a centerline's lines, against all pairs, in bounded memory.


def a_graph(seed=5, count=60):
    rng = np.random.default_rng(seed)
    points = np.cumsum(rng.normal(size=(count, 3)), axis=0)
    edges = np.column_stack([np.arange(count - 1), np.arange(1, count)])
    return LineGraph(points, rng.uniform(0.2, 2.0, count), np.delete(edges, [19, 39], axis=0))


def all_pairs(graph, reach, piece=None):
    """Every node with every segment."""
    found = {}
    for number, (a, b) in enumerate(graph.edges):
        for node, point in enumerate(graph.points):
            squared, _ = distances_to_segments(point[None], graph.points[[a]], graph.points[[b]])
            is_apart = piece is None or piece[node] != piece[a]
            if node not in (a, b) and is_apart and squared[0] <= max(reach[a], reach[b]) ** 2:
                found[node, number] = np.sqrt(squared[0])
    return found


@pytest.mark.parametrize("block", [1, 40, 1 << 18])
@pytest.mark.parametrize("is_apart", [False, True])
def test_near_pairs_are_all_that_are_near_whatever_the_block(monkeypatch, block, is_apart):
    monkeypatch.setattr(line_graph, "PAIRS", block)
    graph = a_graph()
    piece = graph.component_labels() if is_apart else None
    expected = all_pairs(graph, graph.radius, piece)
    pairs = near_pairs(graph, graph.radius, piece)
    found = dict(
        zip(zip(pairs.nodes.tolist(), pairs.segments.tolist(), strict=True), pairs.distances,
            strict=True)
    )  # fmt: skip
    assert found.keys() == expected.keys()
    assert len(found) == len(pairs.nodes) > 0
    for key, distance in expected.items():
        assert found[key] == pytest.approx(distance, abs=1e-12)


def lines_beside_each_other(count, outlets, seed=0):
    """Lines from one inlet to several outlets, each with points of its own, 0.03 mm apart."""
    random = np.random.default_rng(seed)
    points, lines = [], []
    for number in range(count):
        along = np.sort(np.r_[0.0, random.uniform(0.0, 40.0, 98), 40.0])
        aside = 0.4 * (number % outlets) * np.maximum(along - 15.0, 0.0)
        line = np.column_stack([aside, 0 * along, along]) + random.normal(size=(100, 3)) * 0.01
        lines.append(100 * number + np.arange(100))
        points.append(line)
    return np.concatenate(points), lines, np.full(100 * count, 3.0)


@pytest.mark.parametrize("outlets", [1, 4])
def test_lines_that_share_no_point_become_one_tree_however_many_are_looked_at_together(
    outlets, monkeypatch
):
    made = lines_beside_each_other(24, outlets)
    trees = []
    for pairs in (1 << 40, 1 << 12, 1):
        monkeypatch.setattr(overlaps, "MOST_PAIRS", pairs)
        trees.append(Centerline.from_lines(*made))
    assert len(trees[0].leaves) == outlets
    for tree in trees[1:]:
        np.testing.assert_array_equal(tree.points, trees[0].points)
        np.testing.assert_array_equal(tree.parent, trees[0].parent)
