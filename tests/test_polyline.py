"""Polylines: closed forms on lines, corners and circles; identities; degenerate input."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from SDFStentLib.geometry import Line, closest_on_segments, tightest_bend
from SDFStentLib.geometry.line import PAIRS_PER_BLOCK

CORNER = np.array([[0.0, 0, 0], [3, 0, 0], [3, 4, 0]])
# Coordinates up to 100 mm carry about 1e-14 relative rounding; sums of twenty stay far below.
ROUNDING = 1e-9

any_polyline = arrays(
    np.float64, st.tuples(st.integers(2, 20), st.just(3)), elements=st.floats(-100, 100, width=32)
).filter(lambda points: Line(points).length > 1e-3)


def an_arc(radius: float = 10.0, count: int = 200) -> np.ndarray:
    angles = np.linspace(0.0, np.pi / 2, count)
    return radius * np.column_stack([np.cos(angles), np.sin(angles), 0 * angles])


@settings(max_examples=30)
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


def test_the_bend_radius_of_lines_corners_and_hairpins():
    assert tightest_bend(Line(CORNER[:2])).radius == np.inf
    assert tightest_bend(Line([[0, 0, 0], [1, 0, 0], [5, 0, 0]])).radius == np.inf
    assert tightest_bend(Line([[0, 0, 0], [1, 0, 0], [0.5, 0, 0]])).radius == 0
    corner = tightest_bend(Line([[0, 0, 0], [4, 0, 0], [4, 4, 0]]), window=2.0).radius
    # The corner is met to a sixteenth of the window, which is second order in the radius.
    assert corner == pytest.approx(2 / (2 * np.sin(np.pi / 4)), rel=1 / 16**2 * 2)
    assert tightest_bend(Line(an_arc()), window=1e-9).radius > 0
