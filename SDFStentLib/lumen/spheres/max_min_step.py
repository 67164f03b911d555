"""The step that raises the smallest of many linear functions most, for many centers at once."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...validation import Floats, Indices
from ..tolerances import ROUNDS


class LinearRows(NamedTuple):
    """Rows t <= distance + slope x, grouped by center.

    Attributes
    ----------
    distance, slope : (r,) and (r, 2) arrays
    starts : (n,) array
        First row of each center; every center has at least one.
    radii : (n,) array
        Smallest distance of each center.
    """

    distance: Floats
    slope: Floats
    starts: Indices
    radii: Floats


def largest_steps(rows: LinearRows, box: Floats) -> tuple[Floats, Floats]:
    """Step x (n, 2) in the box |x| <= box, and height t (n,), with t largest under all rows.

    Dual simplex, all centers at once: three rows are held with equality; the row that is
    violated most comes in for the one that keeps the rest in balance.
    """
    step, height = np.zeros((2, len(box))), np.empty(len(box))
    # The rest is thinned out in place as centers come to their ends.
    active, slope = np.arange(len(box)), np.ascontiguousarray(rows.slope.T)
    distance, starts = rows.distance, rows.starts
    counts = np.diff(np.r_[starts, len(distance)])
    lowest = _first_of_largest(-distance, starts, counts)
    # Of the three rows that hold a center: right sides (3, n), and columns of the inverse,
    # (row, coefficient, n). At first the lowest row and the corner of the box that it rises to.
    bound = np.stack([distance[lowest], box, box])
    sign = np.where(slope[:, lowest] >= 0, 1.0, -1.0)
    inverse = np.zeros((3, 3, len(box)))
    inverse[0, 2], inverse[1, 0], inverse[2, 1] = 1.0, sign[0], sign[1]
    inverse[1:, 2] = sign * slope[:, lowest]
    for _ in range(ROUNDS):
        x, y, t = solution = np.einsum("ijn,in->jn", inverse, bound)
        step[:, active], height[active] = np.clip(solution[:2], -box, box), t
        excess = np.repeat(t, counts) - distance
        excess -= slope[0] * np.repeat(x, counts)
        excess -= slope[1] * np.repeat(y, counts)
        worst = _first_of_largest(excess, starts, counts)
        everyone = np.arange(len(active))
        amounts = np.stack([excess[worst], np.abs(x) - box, np.abs(y) - box])
        kind = amounts.argmax(axis=0)
        is_row = kind == 0
        entering = np.where(is_row, -slope[:, worst], np.sign(solution[:2]))
        entering[0, kind == 2], entering[1, kind == 1] = 0.0, 0.0
        limit = np.where(is_row, distance[worst], box)

        weight = np.einsum("ijn,jn->in", inverse[:, :2], entering) + inverse[:, 2] * is_row
        usable = weight > 1e-12
        ratio = np.where(usable, inverse[:, 2] / np.where(usable, weight, 1.0), np.inf)
        leaving = ratio.argmin(axis=0)
        is_open = (amounts[kind, everyone] > 1e-10 * box) & usable[leaving, everyone]
        if not is_open.any():
            break
        if 2 * np.count_nonzero(is_open) <= len(active):
            is_kept = np.repeat(is_open, counts)
            slope, distance = slope.compress(is_kept, axis=1), distance.compress(is_kept)
            counts = counts[is_open]
            starts = np.cumsum(counts) - counts
            active, box, leaving, limit = (a[is_open] for a in (active, box, leaving, limit))
            inverse, bound, weight = (a[..., is_open] for a in (inverse, bound, weight))
            is_open, everyone = is_open[is_open], everyone[: len(active)]
        swap = everyone[is_open]
        bound[leaving[swap], swap] = limit[swap]
        incoming = inverse[leaving[swap], :, swap].T / weight[leaving[swap], swap]
        inverse[:, :, swap] -= weight[:, None, swap] * incoming
        inverse[leaving[swap], :, swap] = incoming.T
    return step.T, height


def _first_of_largest(values: Floats, starts: Indices, counts: Indices) -> Indices:
    """Position of the largest value in each group."""
    hits = np.flatnonzero(values == np.repeat(np.maximum.reduceat(values, starts), counts))
    return hits[np.searchsorted(hits, starts)]
