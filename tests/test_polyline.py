"""Polylines: closed forms on lines, corners and circles; identities; degenerate input."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from SDFStentLib.geometry import (
    closest_on_segments,
    distances_to_segments,
    frames,
    minimum_bend_radius,
    polyline,
    tangents,
)
from SDFStentLib.geometry.segments import PAIRS_PER_BLOCK
from SDFStentLib.validation import InputError

CORNER = np.array([[0.0, 0, 0], [3, 0, 0], [3, 4, 0]])
# Coordinates up to 100 mm carry about 1e-14 relative rounding; sums of twenty stay far below.
ROUNDING = 1e-9

any_polyline = arrays(
    np.float64, st.tuples(st.integers(2, 20), st.just(3)), elements=st.floats(-100, 100, width=32)
).filter(lambda points: polyline.length(points) > 1e-3)


def an_arc(radius: float = 10.0, count: int = 200) -> np.ndarray:
    angles = np.linspace(0.0, np.pi / 2, count)
    return radius * np.column_stack([np.cos(angles), np.sin(angles), 0 * angles])


def test_lengths_of_a_corner_are_those_of_its_sides():
    assert polyline.segment_lengths(CORNER).tolist() == [3, 4]
    assert polyline.length(CORNER) == 7
    assert polyline.arc_lengths(CORNER).tolist() == [0, 3, 7]
    assert polyline.length(CORNER[:1]) == 0


def test_repeated_points_go_and_the_ends_stay_exact():
    points = np.array(
        [[0.0, 0, 0], [1e-10, 0, 0], [1, 0, 0], [1, 0, 0], [2 - 1e-10, 0, 0], [2, 0, 0]]
    )
    kept = polyline.without_repeats(points)
    assert kept.tolist() == [[0, 0, 0], [1, 0, 0], [2, 0, 0]]
    assert len(polyline.without_repeats(np.zeros((5, 3)))) == 1


def test_many_steps_below_the_tolerance_still_add_up():
    points = np.column_stack([np.linspace(0, 1, 101), np.zeros(101), np.zeros(101)])
    kept = polyline.without_repeats(points, tolerance=0.0999)
    assert len(kept) == 11
    assert kept[-1].tolist() == [1, 0, 0]


@given(any_polyline, st.floats(0.05, 50))
def test_resampling_keeps_the_ends_and_spaces_equally(points, spacing):
    total = polyline.length(points)
    if total / spacing > 2000:
        spacing = total / 2000
    result = polyline.resampled(points, spacing)
    assert len(result) == max(1, round(total / spacing)) + 1
    assert (result[0] == points[0]).all()
    assert (result[-1] == points[-1]).all()
    on_line = closest_on_segments(points[:-1], points[1:], result)
    assert on_line.distances.max() < ROUNDING


@given(any_polyline, st.floats(0, 1), st.floats(0, 1))
def test_cuts_add_up_to_the_whole(points, one, other):
    total = polyline.length(points)
    at = total * min(max(one, 0.01), 0.99)
    parts = polyline.cut(points, 0, at), polyline.cut(points, at, total)
    assert sum(map(polyline.length, parts)) == pytest.approx(total, abs=1e-7)
    np.testing.assert_allclose(parts[0][-1], polyline.point_at(points, at), atol=ROUNDING)
    np.testing.assert_allclose(parts[1][0], polyline.point_at(points, at), atol=ROUNDING)
    assert polyline.length(polyline.cut(points, -5, total + other)) == pytest.approx(total)


def test_a_point_at_an_arc_length_beyond_the_ends_is_the_end():
    np.testing.assert_array_equal(polyline.point_at(CORNER, [-1, 3, 5, 99])[[0, 1, 3]], CORNER)
    assert polyline.point_at(CORNER, 5.0).tolist() == [3, 2, 0]
    assert polyline.point_at(CORNER[:1], [1.0, 2.0]).tolist() == [[0, 0, 0]] * 2


def test_the_closest_point_beside_beyond_and_at_a_corner():
    found = polyline.closest_point(CORNER, [1, -2, 0])
    assert (found.point.tolist(), found.distance, found.arc_length) == ([1, 0, 0], 2, 1)
    assert polyline.closest_point(CORNER, [-3, 0, 4]).distance == 5
    assert polyline.closest_point(CORNER, [3, 9, 0]).arc_length == 7
    assert polyline.closest_point(CORNER, [4, -1, 0]).arc_length == 3
    assert polyline.closest_point(CORNER[:1], [0, 0, 2]).distance == 2


def test_closest_points_in_blocks_match_dense_sampling():
    rng = np.random.default_rng(7)
    points, queries = rng.normal(size=(30, 3)), rng.normal(size=(PAIRS_PER_BLOCK // 29 + 10, 3))
    found = polyline.closest_points(points, queries)
    np.testing.assert_allclose(
        np.linalg.norm(found.points - queries, axis=1), found.distances, atol=ROUNDING
    )
    np.testing.assert_allclose(
        polyline.point_at(points, found.arc_lengths), found.points, atol=ROUNDING
    )
    samples = polyline.resampled_to(points, 3000)
    some = np.r_[0:20, -20:0]
    brute = np.linalg.norm(samples[:, None] - queries[some], axis=2).min(axis=0)
    step = polyline.length(points) / 2999
    # A sample lies within half a step of the true foot.
    assert (found.distances[some] <= brute + ROUNDING).all()
    assert (brute <= found.distances[some] + step / 2 + ROUNDING).all()


def test_tangents_of_an_arc_are_perpendicular_to_its_radius():
    arc = an_arc()
    along = tangents(arc)
    np.testing.assert_allclose(np.linalg.norm(along, axis=1), 1, atol=ROUNDING)
    np.testing.assert_allclose(np.einsum("ij,ij->i", along, arc)[1:-1], 0, atol=ROUNDING)


def test_tangents_ignore_repeated_points_and_survive_a_turn_back():
    doubled = np.repeat(CORNER, 3, axis=0)
    expected = np.repeat(tangents(CORNER), 3, axis=0)
    np.testing.assert_allclose(tangents(doubled), expected, atol=ROUNDING)
    back = tangents([[0, 0, 0], [1, 0, 0], [0, 0, 0]])
    assert back.tolist() == [[1, 0, 0], [1, 0, 0], [-1, 0, 0]]


def test_frames_are_right_handed_and_do_not_twist_in_a_plane():
    result = frames(an_arc(), first_normal=[0, 0, 1])
    identities = result @ np.swapaxes(result, 1, 2)
    np.testing.assert_allclose(identities, np.broadcast_to(np.eye(3), identities.shape), atol=1e-9)
    np.testing.assert_allclose(np.linalg.det(result), 1, atol=ROUNDING)
    np.testing.assert_allclose(result[:, 1], np.tile([0, 0, 1], (len(result), 1)), atol=ROUNDING)


def test_frames_find_a_normal_when_none_or_a_parallel_one_is_given():
    line = [[0, 0, 0], [2, 0, 0]]
    for wanted in (None, [1, 0, 0]):
        assert abs(frames(line, wanted)[0, 1, 0]) < ROUNDING


@pytest.mark.parametrize("window", [None, 0.5, 3.0])
def test_the_bend_radius_of_an_arc_is_its_radius(window):
    # Points on chords of a fine arc lie inside it by the chord height, 8e-5 mm at 0.08 mm steps,
    # which over a window of 0.5 mm turns into 4 * 8e-5 * (10 / 0.5)^2 = 0.13 mm.
    assert minimum_bend_radius(an_arc(), window) == pytest.approx(10, abs=0.13)


def test_the_bend_radius_of_lines_corners_and_hairpins():
    assert minimum_bend_radius(CORNER[:2]) == np.inf
    assert minimum_bend_radius([[0, 0, 0], [1, 0, 0], [5, 0, 0]]) == np.inf
    assert minimum_bend_radius([[0, 0, 0], [1, 0, 0], [0.5, 0, 0]]) == 0
    corner = minimum_bend_radius([[0, 0, 0], [4, 0, 0], [4, 4, 0]], window=2.0)
    # The corner is met to a sixteenth of the window, which is second order in the radius.
    assert corner == pytest.approx(2 / (2 * np.sin(np.pi / 4)), rel=1 / 16**2 * 2)
    assert minimum_bend_radius(an_arc(), window=1e-9) > 0


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: polyline.resampled(CORNER, 0), "spacing: expected a number greater than 0"),
        (lambda: polyline.resampled(CORNER, np.nan), "spacing: expected a number"),
        (lambda: polyline.resampled(CORNER[:1], 1), "expected at least 2 points, got 1"),
        (lambda: polyline.resampled(np.zeros((4, 3)), 1), "expected two different points, got 4"),
        (lambda: polyline.resampled_to(CORNER, 1), "count: expected at least 2 points, got 1"),
        (lambda: tangents(np.ones((2, 3))), "expected two different points"),
        (lambda: polyline.cut(CORNER, 5, 5), "expected a start before the end"),
        (lambda: polyline.cut(CORNER, 8, 9), "on a polyline of 7 mm, got 8 to 9 mm"),
        (lambda: polyline.cut(CORNER, np.nan, 2), "expected a start before the end"),
        (lambda: minimum_bend_radius(CORNER, 0), "window: expected a number greater"),
        (lambda: polyline.without_repeats(CORNER * np.nan), "got NaN or infinity"),
        (lambda: polyline.closest_point(CORNER, [0, 0, np.inf]), "query: expected finite"),
    ],
)
def test_unusable_input_gives_one_sentence(call, message):
    with pytest.raises(InputError, match=message):
        call()


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
