"""The smooth minimum of the published method: a minimum whose gradient has no jump.

Source: SDFStent, arXiv 2605.22009, section 2.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..validation import Floats

FORGOTTEN = 1e-13
"""Share of its begin that is left in a folded value when it counts as nothing."""


class SmoothMinimum(NamedTuple):
    """Value of a smooth minimum and the share of the first argument in its gradient."""

    value: Floats
    share: Floats


def smooth_minimum(first: Floats, second: Floats, smoothing_width: float) -> SmoothMinimum:
    """Quadratic smooth minimum of two distances.

    Parameters
    ----------
    first, second : arrays of one shape
        Distances, mm.
    smoothing_width : float
        k of the paper, mm; 0 gives the hard minimum.

    Returns
    -------
    SmoothMinimum
        `value`, `min(a, b) - max(k - |a - b|, 0)^2 / (4 k)`, at most k/4 below the smaller
        argument, and `share` s in [0, 1]: the gradient is `s grad first + (1 - s) grad second`.
    """
    if smoothing_width == 0:
        share = (first <= second).astype(np.float64)
        return SmoothMinimum(np.minimum(first, second), share)
    share = np.clip(0.5 + (second - first) / (2 * smoothing_width), 0, 1)
    overlap = np.maximum(smoothing_width - np.abs(second - first), 0)
    return SmoothMinimum(np.minimum(first, second) - overlap**2 / (4 * smoothing_width), share)


def fold(
    distances: Floats,
    weights: Floats,
    room: Floats,
    before: Floats | None = None,
    after: Floats | None = None,
) -> tuple[Floats, NDArray[np.bool_] | None]:
    """Smooth minimum over rows, in order, with k = 1/4; writes the rows' shares in the gradient.

    The share of row j is `w_j prod_{i > j} (1 - w_i)` with the pairwise weights of
    `smooth_minimum`; shares of a point sum to one.

    Parameters
    ----------
    distances, weights, room : (m, n) arrays
        In units of 4 k; the weights are written, and the room is written over.
    before, after : (n,) arrays, optional
        Lower bounds of distances in rows that were left out at either side.

    Returns
    -------
    distance : (n,) array
    is_proven : (n,) bool array or None
        Whether the rows left out change nothing; None when there are none.
    """
    # Kept a quarter of a unit higher, the running value D becomes D - t^2 with t = w / 2 = D - d,
    # cut to [0, 1/2]; from d + 1/2 on it is what it is for d + 1/2.
    first = 0 if before is not None else 1
    value = before.copy() if before is not None else distances[0] + 0.25
    np.add(distances, 0.5, out=room)
    weights[:first] = 0.5
    square = np.empty_like(value)
    for half, distance, most in zip(weights[first:], distances[first:], room[first:], strict=True):
        np.minimum(value, most, out=value)
        np.subtract(value, distance, out=half)
        np.maximum(half, 0, out=half)
        np.multiply(half, half, out=square)
        value -= square
    weights += weights
    remaining = 1 - weights[-1]
    for row in weights[-2::-1]:
        row *= remaining
        remaining -= row
    is_proven = None
    if before is not None:
        is_proven = np.abs(remaining) < FORGOTTEN
    if after is not None:
        is_late = after >= value
        is_proven = is_late if is_proven is None else is_proven & is_late
    value -= 0.25
    return value, is_proven


def hard_minimum(distances: Floats, weights: Floats) -> Floats:
    """Minimum over rows; writes weight 1 to the first row that has it and 0 to the others."""
    weights[:] = 0
    np.put_along_axis(weights, distances.argmin(axis=0)[None], 1.0, axis=0)
    return distances.min(axis=0)
