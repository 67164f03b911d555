"""The smooth minimum over many capsules in one pass.

Source: SDFStent, arXiv 2605.22009, section 2; in pairs it is `geometry.smooth_minimum`. It depends
on the order of the capsules, by up to some hundredths of a mm where many are almost equally near.
The mean of the folds from both ends does not.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..validation import Floats

FORGOTTEN = 1e-13
"""Share of the value it began with below which a fold counts as having forgotten it."""


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
        Distances in units of 4 k, the weights, which are written, and room to calculate in.
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


def fold_from_both_ends(
    distances: Floats,
    weights: Floats,
    room: tuple[Floats, Floats],
    before: Floats | None = None,
    after: Floats | None = None,
) -> tuple[Floats, NDArray[np.bool_] | None]:
    """Mean of the folds in both orders; parameters and results as for `fold`.

    `room` is two arrays. Distances in the opposite order give the same to the last bit.
    """
    value, is_proven = fold(distances, weights, room[0], before, after)
    others = room[1]
    back, is_proven_back = fold(distances[::-1], others[::-1], room[0][::-1], after, before)
    for mean, other in ((value, back), (weights, others)):
        mean += other
        mean *= 0.5
    if is_proven is not None and is_proven_back is not None:
        is_proven &= is_proven_back
    return value, is_proven


def hard_minimum(distances: Floats, weights: Floats) -> Floats:
    """Minimum (n,) over rows; writes weight 1 to the first row that has it and 0 to the others."""
    weights[:] = 0
    np.put_along_axis(weights, distances.argmin(axis=0)[None], 1.0, axis=0)
    return distances.min(axis=0)
