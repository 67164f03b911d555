"""The step that raises the smallest of many linear functions most, for many centres at once."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..geometry import dot
from ..validation import Floats, Indices

_PIVOTS = 100
"""Most exchanges of a row. With more to do the height is too high; the climb measures it anew."""


class LinearRows(NamedTuple):
    """Rows t <= distance + slope x, grouped by centre.

    Attributes
    ----------
    distance, slope : (r,) and (r, 2) arrays
    starts : (n,) array
        First row of each centre; every centre has at least one.
    radii : (n,) array
        Smallest distance of each centre.
    """

    distance: Floats
    slope: Floats
    starts: Indices
    radii: Floats


def largest_steps(rows: LinearRows, box: Floats) -> tuple[Floats, Floats]:
    """Step x (n, 2) in the box |x| <= box, and height t (n,), with t largest under all rows.

    Dual simplex, all centres at once: three rows are held with equality; the row that is
    violated most comes in for the one that keeps the rest in balance.
    """
    count = len(box)
    group = np.repeat(np.arange(count), np.diff(np.r_[rows.starts, len(rows.distance)]))
    lowest = _first_of_largest(-rows.distance, rows.starts, group)
    held = np.zeros((count, 3, 3))
    bound = np.stack([rows.distance[lowest], box, box], axis=1)
    held[:, 0] = _with_height(rows.slope[lowest])
    held[:, 1, 0], held[:, 2, 1] = np.where(rows.slope[lowest] >= 0, 1.0, -1.0).T
    everyone = np.arange(count)
    for _ in range(_PIVOTS):
        inverse = _inverse_columns(held)
        solution = np.einsum("nij,ni->nj", inverse, bound)
        step, height = solution[:, :2], solution[:, 2]
        excess = height[group] - np.einsum("ni,ni->n", rows.slope, step[group]) - rows.distance
        worst = _first_of_largest(excess, rows.starts, group)
        entering = _with_height(rows.slope[worst])
        limit, amount = rows.distance[worst], excess[worst]
        for axis in (0, 1):
            beyond = np.abs(step[:, axis]) - box
            sideways = beyond > amount
            entering[sideways] = 0.0
            entering[sideways, axis] = np.sign(step[sideways, axis])
            limit, amount = np.where(sideways, box, limit), np.maximum(amount, beyond)
        is_open = amount > 1e-10 * box
        if not is_open.any():
            break
        weight = np.einsum("nij,nj->ni", inverse, entering)
        usable = weight > 1e-12
        ratio = np.where(usable, inverse[:, :, 2] / np.where(usable, weight, 1.0), np.inf)
        leaving = np.argmin(ratio, axis=1)
        swap = everyone[is_open & usable.any(axis=1)]
        held[swap, leaving[swap]] = entering[swap]
        bound[swap, leaving[swap]] = limit[swap]
    return np.clip(step, -box[:, None], box[:, None]), height


def _with_height(slope: Floats) -> Floats:
    """Coefficients (n, 3) of the row t - slope x <= distance, in the unknowns (x, t)."""
    return np.c_[-slope, np.ones(len(slope))]


def _inverse_columns(matrices: Floats) -> Floats:
    """Columns of the inverse of every (3, 3) matrix, as rows; singular ones give large numbers."""
    a, b, c = matrices[:, 0], matrices[:, 1], matrices[:, 2]
    columns = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1)
    determinant = dot(a, columns[:, 0])
    return columns / np.where(np.abs(determinant) > 1e-30, determinant, 1e-30)[:, None, None]


def _first_of_largest(values: Floats, starts: Indices, group: Indices) -> Indices:
    """Position of the largest value in each group."""
    largest = np.maximum.reduceat(values, starts)
    hits = np.flatnonzero(values == largest[group])
    return hits[np.searchsorted(group[hits], np.arange(len(starts)))]
