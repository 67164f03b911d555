"""Polylines: closed forms on lines, corners and circles; identities; degenerate input."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from SDFStentLib.geometry import (
    Line,
    as_line,
    closest_on_segments,
    distances_to_segments,
    frames,
    tightest_bend,
)
from SDFStentLib.geometry.segments import PAIRS_PER_BLOCK
from SDFStentLib.validation import InputError

CORNER = np.array([[0.0, 0, 0], [3, 0, 0], [3, 4, 0]])
# Coordinates up to 100 mm carry about 1e-14 relative rounding; sums of twenty stay far below.
ROUNDING = 1e-9

any_polyline = arrays(
    np.float64, st.tuples(st.integers(2, 20), st.just(3)), elements=st.floats(-100, 100, width=32)
).filter(lambda points: Line(points).length > 1e-3)


def an_arc(radius: float = 10.0, count: int = 200) -> np.ndarray:
    angles = np.linspace(0.0, np.pi / 2, count)
    return radius * np.column_stack([np.cos(angles), np.sin(angles), 0 * angles])


def test_lengths_of_a_corner_are_those_of_its_sides():
    assert Line(CORNER).pieces.tolist() == [3, 4]
    assert Line(CORNER).length == 7
    assert Line(CORNER).arc_lengths.tolist() == [0, 3, 7]
    assert Line(CORNER[:1]).length == 0


def test_repeated_points_go_and_the_ends_stay_exact():
    points = np.array(
        [[0.0, 0, 0], [1e-10, 0, 0], [1, 0, 0], [1, 0, 0], [2 - 1e-10, 0, 0], [2, 0, 0]]
    )
    kept = Line(points).without_repeats()
    assert kept.points.tolist() == [[0, 0, 0], [1, 0, 0], [2, 0, 0]]
    assert len(Line(np.zeros((5, 3))).without_repeats()) == 1


def test_many_steps_below_the_tolerance_still_add_up():
    points = np.column_stack([np.linspace(0, 1e-8, 101), np.zeros(101), np.zeros(101)])
    kept = Line(points).without_repeats().points
    assert 10 <= len(kept) <= 11
    assert kept[-1].tolist() == [1e-8, 0, 0]


@given(any_polyline, st.floats(0.05, 50))
def test_resampling_keeps_the_ends_and_spaces_equally(points, spacing):
    total = Line(points).length
    if total / spacing > 2000:
        spacing = total / 2000
    result = Line(points).resampled(spacing).points
    assert len(result) == max(1, round(total / spacing)) + 1
    assert (result[0] == points[0]).all()
    assert (result[-1] == points[-1]).all()
    on_line = closest_on_segments(points[:-1], points[1:], result)
    assert on_line.distances.max() < ROUNDING


@given(any_polyline, st.floats(0, 1), st.floats(0, 1))
def test_cuts_add_up_to_the_whole(points, one, other):
    line = Line(points)
    total = line.length
    at = total * min(max(one, 0.01), 0.99)
    before, beyond = line.cut(0, at), line.cut(at, total)
    assert before.length + beyond.length == pytest.approx(total, abs=1e-7)
    np.testing.assert_allclose(before.points[-1], line.at(at), atol=ROUNDING)
    np.testing.assert_allclose(beyond.points[0], line.at(at), atol=ROUNDING)
    assert line.cut(-5, total + other).length == pytest.approx(total)


def test_a_point_at_an_arc_length_beyond_the_ends_is_the_end():
    np.testing.assert_array_equal(Line(CORNER).at([-1, 3, 5, 99])[[0, 1, 3]], CORNER)
    assert Line(CORNER).at(5.0).tolist() == [3, 2, 0]
    assert Line(CORNER[:1]).at([1.0, 2.0]).tolist() == [[0, 0, 0]] * 2


def test_the_closest_point_beside_beyond_and_at_a_corner():
    found = Line(CORNER).nearest(np.array([[1.0, -2, 0], [-3, 0, 4], [3, 9, 0], [4, -1, 0]]))
    assert found.points[0].tolist() == [1, 0, 0]
    assert found.distances[:2].tolist() == [2, 5]
    assert found.arc_lengths[[0, 2, 3]].tolist() == [1, 7, 3]
    assert Line(CORNER[:1]).nearest(np.array([[0.0, 0, 2]])).distances.tolist() == [2]


def test_closest_points_in_blocks_match_dense_sampling():
    rng = np.random.default_rng(7)
    points, queries = rng.normal(size=(30, 3)), rng.normal(size=(PAIRS_PER_BLOCK // 29 + 10, 3))
    found = Line(points).nearest(queries)
    np.testing.assert_allclose(
        np.linalg.norm(found.points - queries, axis=1), found.distances, atol=ROUNDING
    )
    np.testing.assert_allclose(Line(points).at(found.arc_lengths), found.points, atol=ROUNDING)
    samples = Line(points).resampled_to(3000).points
    some = np.r_[0:20, -20:0]
    brute = np.linalg.norm(samples[:, None] - queries[some], axis=2).min(axis=0)
    step = Line(points).length / 2999
    # A sample lies within half a step of the true foot.
    assert (found.distances[some] <= brute + ROUNDING).all()
    assert (brute <= found.distances[some] + step / 2 + ROUNDING).all()


def test_tangents_of_an_arc_are_perpendicular_to_its_radius():
    arc = an_arc()
    along = Line(arc).directions
    np.testing.assert_allclose(np.linalg.norm(along, axis=1), 1, atol=ROUNDING)
    np.testing.assert_allclose(np.einsum("ij,ij->i", along, arc)[1:-1], 0, atol=ROUNDING)


def test_tangents_ignore_repeated_points_and_survive_a_turn_back():
    doubled = np.repeat(CORNER, 3, axis=0)
    expected = np.repeat(Line(CORNER).directions, 3, axis=0)
    np.testing.assert_allclose(Line(doubled).directions, expected, atol=ROUNDING)
    back = Line([[0, 0, 0], [1, 0, 0], [0, 0, 0]]).directions
    assert back.tolist() == [[1, 0, 0], [1, 0, 0], [-1, 0, 0]]


def test_frames_are_right_handed_and_do_not_twist_in_a_plane():
    result = frames(Line(an_arc()))
    identities = result @ np.swapaxes(result, 1, 2)
    np.testing.assert_allclose(identities, np.broadcast_to(np.eye(3), identities.shape), atol=1e-9)
    np.testing.assert_allclose(np.linalg.det(result), 1, atol=ROUNDING)
    np.testing.assert_allclose(result[:, 1], np.tile([0, 0, 1], (len(result), 1)), atol=ROUNDING)


@pytest.mark.parametrize("window", [None, 0.5, 3.0])
def test_the_bend_radius_of_an_arc_is_its_radius(window):
    # Points on chords of a fine arc lie inside it by the chord height, 8e-5 mm at 0.08 mm steps,
    # which over a window of 0.5 mm turns into 4 * 8e-5 * (10 / 0.5)^2 = 0.13 mm.
    assert tightest_bend(Line(an_arc()), window).radius == pytest.approx(10, abs=0.13)


def test_the_bend_radius_of_lines_corners_and_hairpins():
    assert tightest_bend(Line(CORNER[:2])).radius == np.inf
    assert tightest_bend(Line([[0, 0, 0], [1, 0, 0], [5, 0, 0]])).radius == np.inf
    assert tightest_bend(Line([[0, 0, 0], [1, 0, 0], [0.5, 0, 0]])).radius == 0
    corner = tightest_bend(Line([[0, 0, 0], [4, 0, 0], [4, 4, 0]]), window=2.0).radius
    # The corner is met to a sixteenth of the window, which is second order in the radius.
    assert corner == pytest.approx(2 / (2 * np.sin(np.pi / 4)), rel=1 / 16**2 * 2)
    assert tightest_bend(Line(an_arc()), window=1e-9).radius > 0


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: Line(CORNER).resampled(0), "spacing: expected a number greater than 0"),
        (lambda: Line(CORNER).resampled(np.nan), "spacing: expected a number"),
        (lambda: Line(CORNER[:1]).resampled(1), "expected two different points, got 1"),
        (lambda: Line(np.zeros((4, 3))).resampled(1), "expected two different points, got 4"),
        (lambda: Line(CORNER).resampled_to(1), "count: expected at least 2 points, got 1"),
        (lambda: Line(np.ones((2, 3))).directions, "expected two different points"),
        (lambda: Line(CORNER).cut(5, 5), "expected a start before the end"),
        (lambda: Line(CORNER).cut(8, 9), "on a polyline of 7 mm, got 8 to 9 mm"),
        (lambda: Line(CORNER).cut(np.nan, 2), "expected a start before the end"),
        (lambda: tightest_bend(Line(CORNER), 0).radius, "window: expected a number greater"),
        (lambda: Line(CORNER * np.nan), "got NaN or infinity"),
        (lambda: Line(np.zeros((0, 3))), "expected at least 1 points, got 0"),
    ],
)
def test_unusable_input_gives_one_sentence(call, message):
    with pytest.raises(InputError, match=message):
        call()


def test_a_line_and_what_follows_from_it_cannot_be_changed():
    points = np.repeat(CORNER, 2, axis=0)
    line = Line(points)
    points += 1.0
    assert (line.points == np.repeat(CORNER, 2, axis=0)).all()
    for one in (line, line.without_repeats(), line.resampled(1.0), line.cut(1, 2), line.reversed()):
        for array in (one.points, one.arc_lengths, one.directions):
            assert not array.flags.writeable
    assert Line(CORNER).reversed().reversed().points.tolist() == CORNER.tolist()
    assert as_line(line) is line


def test_of_many_segments_the_nearest_is_the_first_of_equals_as_of_few():
    rng = np.random.default_rng(4)
    for scale in (0.01, 1.0, 30.0):
        line = np.cumsum(rng.normal(size=(60, 3)) * scale + [1, 0, 0], axis=0) + 400.0
        line[20] = line[19]
        # Corners and middles too, where two segments are as near, and places far away.
        near = [line, (line[1:] + line[:-1]) / 2, line[rng.integers(60, size=300)]]
        queries = np.concatenate([*near, line[:50] * 3]) + 0.0
        queries[200:] += rng.normal(size=(len(queries) - 200, 3)) * 5
        starts, ends = line[:-1], line[1:]
        squared, _ = distances_to_segments(queries[:, None], starts, ends)
        found = closest_on_segments(starts, ends, queries)
        np.testing.assert_array_equal(found.segments, squared.argmin(axis=1))
