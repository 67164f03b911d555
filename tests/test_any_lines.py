"""Any lines of a vessel make one tree: pieces in any order and direction, with gaps, loops."""

import numpy as np
import pytest
from seeds import seeds

from SDFStentLib.centerline import Centerline
from SDFStentLib.geometry import Line, nearest_distances
from SDFStentLib.validation import InputError

Piece = tuple[np.ndarray, np.ndarray]
"""Points (n, 3) and radii (n,) of a line, mm."""

INLET = np.array([0.0, 0, -40])


def piece(start, end, first: float, last: float) -> Piece:
    points = Line(np.array([start, end], float)).resampled(1.0).points
    return points, np.linspace(first, last, len(points))


def a_tree(random: np.random.Generator) -> list[Piece]:
    """Pieces between junctions of a vessel that divides twice; the first begins at the inlet."""
    fork = np.zeros(3)
    left, right = (
        random.uniform((-30, -8, 25), (-18, 8, 40)),
        random.uniform((15, -8, 30), (30, 8, 60)),
    )
    one, other = (
        left + random.uniform((-20, -9, 15), (-9, 9, 25)),
        left + random.uniform((4, -9, 20), (12, 9, 30)),
    )
    radius = random.uniform(4.5, 6.5)
    sizes = radius * random.uniform(0.5, 0.8, size=4)
    return [
        piece(INLET, fork, radius, radius),
        piece(fork, left, sizes[0], sizes[0]),
        piece(fork, right, sizes[1], sizes[1]),
        piece(left, one, sizes[2] * 0.8, sizes[2] * 0.7),
        piece(left, other, sizes[3] * 0.8, sizes[3] * 0.7),
    ]  # fmt: skip


def tree_of(pieces: list[Piece], order=None, backward=(), **options) -> Centerline:
    """Each piece with points of its own, in an order and direction."""
    used = list(range(len(pieces))) if order is None else list(order)
    parts = [tuple(x[::-1] for x in pieces[n]) if n in backward else pieces[n] for n in used]
    ends = np.cumsum([len(points) for points, _ in parts])
    lines = np.split(np.arange(ends[-1]), ends[:-1])
    radii = np.concatenate([radius for _, radius in parts])
    return Centerline.from_lines(np.concatenate([p for p, _ in parts]), lines, radii, **options)


def assert_same(one: Centerline, other: Centerline) -> None:
    for name in ("points", "inscribed_radius", "parent", "loops"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


@pytest.mark.parametrize("seed", seeds(4, 200))
def test_pieces_in_any_order_and_direction_are_one_tree_to_the_bit(seed):
    random = np.random.default_rng(seed)
    pieces = a_tree(random)
    tree = tree_of(pieces)
    np.testing.assert_array_equal(tree.points[tree.roots], [INLET])
    assert (len(tree.leaves), len(tree.junctions)) == (3, 2)
    for _ in range(12):
        backward = np.flatnonzero(random.random(5) < 0.5)
        assert_same(tree_of(pieces, random.permutation(5), backward), tree)


def whole_lines(pieces: list[Piece]) -> list[Piece]:
    return [
        tuple(np.concatenate(x) for x in zip(*(pieces[n] for n in ways), strict=True))
        for ways in ((0, 1, 3), (0, 1, 4), (0, 2))
    ]


def segments(pieces: list[Piece]) -> list[Piece]:
    """As SimVascular's reduced-order form has them, each segment with points of its own."""
    return [
        (points[n : n + 2], radius[n : n + 2])
        for points, radius in pieces
        for n in range(len(points) - 1)
    ]


def with_joints(pieces: list[Piece]) -> list[Piece]:
    return [
        part
        for points, radius in pieces
        for part in ((points[:9], radius[:9]), (points[8:], radius[8:]))
    ]


def without_spheres(pieces: list[Piece]) -> list[Piece]:
    """Without what lies in the spheres of junctions, as VMTK leaves them unmerged."""
    parts = []
    for number, (points, radius) in enumerate(pieces):
        starts, ends = number > 0, number in (0, 1)
        away = [np.linalg.norm(points - points[side], axis=1) for side in (0, -1)]
        kept = (away[0] >= starts * radius[0]) & (away[1] >= ends * radius[-1] / 2)
        parts.append((points[kept], radius[kept]))
    return parts


FORMS = {
    "whole from the inlet": whole_lines,
    "segments": segments,
    "joints within a tube": with_joints,
    "gaps at junctions": without_spheres,
    "radii 0 at openings": lambda pieces: [
        (points, np.where(np.arange(len(radius)) % (len(radius) - 1) == 0, 0.0, radius))
        for points, radius in pieces
    ],
    "a radius that is no number": lambda pieces: [
        (points, np.where(np.arange(len(radius)) == 3, np.nan, radius)) for points, radius in pieces
    ],
}


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("seed", seeds(2, 40))
def test_every_form_in_any_order_has_the_same_ends_and_begins_at_the_inlet(form, seed):
    random = np.random.default_rng(seed)
    pieces = a_tree(random)
    tips = [pieces[2][0][-1], pieces[3][0][-1], pieces[4][0][-1]]
    parts = FORMS[form](pieces)
    first = tree_of(parts)
    np.testing.assert_allclose(first.points[first.roots], [INLET], atol=1e-9)
    away = np.linalg.norm(first.points[first.leaves][:, None] - tips, axis=2)
    assert away.shape == (3, 3)
    assert away.min(axis=0).max() < 1e-9
    length = sum(Line(points).length for points, _ in pieces)
    steps = first.points - first.points[first.parent]
    assert np.linalg.norm(steps[first.parent >= 0], axis=1).sum() == pytest.approx(length, rel=0.03)
    for _ in range(3):
        backward = np.flatnonzero(random.random(len(parts)) < 0.5)
        assert_same(tree_of(parts, random.permutation(len(parts)), backward), first)


@pytest.mark.parametrize("radii", [True, False])
@pytest.mark.parametrize("backward", [(), (0,), (1, 2), (0, 1, 2)])
def test_curves_drawn_from_a_junction_or_to_it_begin_at_an_end(backward, radii):
    pieces = [
        piece((0, 0, 0), (0, 0, 40), 6.0, 6.0),
        piece((0, 0, 40), (-20, 0, 70), 4.2, 4.2),
        piece((0, 0, 40), (22, 0, 68), 4.0, 4.0),
    ]
    pieces = pieces if radii else [(points, np.zeros(len(points))) for points, _ in pieces]
    tree = tree_of(pieces, backward=backward)
    root = tree.points[tree.roots[0]].tolist()
    assert root in ([[0.0, 0, 0]] if radii else [[0.0, 0, 0], [-20, 0, 70], [22, 0, 68]])
    assert len(tree.junctions) == 1
    assert len(tree.leaves) == 2


def test_a_vessel_is_measured_to_find_its_inlet_whatever_the_file_says_of_its_radius():
    random = np.random.default_rng(0)
    pieces = [(points, 7.0 - radius) for points, radius in a_tree(random)]
    seen = []

    def widths(ways):
        seen.extend(ways)
        return np.array([12.0 if np.allclose(way[0], INLET) else 5.0 for way in ways])

    tree = tree_of(pieces, widths=widths)
    np.testing.assert_array_equal(tree.points[tree.roots], [INLET])
    assert len(seen) == 4  # the ends, none of them a junction
    (place,) = [way for way in seen if np.allclose(way[0], pieces[2][0][-1])]
    np.testing.assert_array_equal(place, pieces[2][0][::-1])


def test_limbs_that_meet_again_are_a_loop_that_is_opened_where_they_meet():
    turn = np.linspace(-np.pi / 2, np.pi / 2, 61)
    arc = np.stack([22 * np.cos(turn), 0 * turn, 25 + 25 * np.sin(turn)], axis=1)
    pieces = [
        piece((0, 0, -30), (0, 0, 0), 5, 5),
        piece((0, 0, 0), (0, 0, 50), 4, 4),
        (arc, np.full(len(arc), 3.0)),
        piece((0, 0, 50), (0, 0, 80), 4.4, 4.4),
    ]
    tree = tree_of(pieces)
    np.testing.assert_array_equal(tree.points[tree.roots], [[0, 0, -30]])
    ((last, met),) = tree.loops
    np.testing.assert_allclose(tree.points[[last, met]], [arc[-2], [0, 0, 50]], atol=1e-9)
    assert set(tree.leaves) == {last, *np.flatnonzero(tree.points[:, 2] == 80)}
    assert len(tree.branches) == 3
    for order in ((3, 2, 1, 0), (2, 0, 3, 1)):
        assert_same(tree_of(pieces, order, backward=(0, 2)), tree)
    assert not tree_of(pieces[:2]).loops.size
    moved = tree.resampled(2.5)
    np.testing.assert_allclose(moved.points[moved.loops], tree.points[tree.loops], atol=2.5)
    with pytest.raises(InputError, match="expected pairs of point indices from 0 to 1"):
        Centerline(np.eye(2, 3), np.ones(2), np.array([-1, 0]), np.array([[0, 2]]))


@pytest.mark.parametrize("degrees", [120, 165, 170, 175, 180, 183, 188, 195])
def test_a_loop_is_opened_wherever_an_outlet_lies_on_it(degrees):
    """The step that shortest ways leave out may lie within the sphere of a junction."""
    turn = np.radians(np.arange(0, 361, 2))
    ring = 15 * np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])
    at = round(degrees / 2)
    ways = [ring[: at + 1], ring[at:]]
    pieces = [(way, np.full(len(way), 2.5)) for way in ways]
    pieces += [piece(ring[0], 2.5 * ring[0], 2.5, 2.5), piece(ring[at], 2.5 * ring[at], 2.5, 2.5)]
    tree = tree_of(pieces, inlet=2.5 * ring[0])
    ((last, met),) = tree.loops
    assert len(tree.leaves) == 2
    np.testing.assert_allclose(np.linalg.norm(tree.points[last] - tree.points[met]), 0.5, atol=0.1)
    assert nearest_distances(ring, tree.points).max() < 0.1
