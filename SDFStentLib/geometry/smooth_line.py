"""A line without its short bends."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..validation import Points, as_number, as_points
from .polyline import arc_lengths, positive_length, resampled_to

STEPS = 16
"""Stations per length of smoothing."""

MOST_STATIONS = 8_000

REACH = 4.0
"""A place counts up to so many lengths of smoothing away; what is left out is below 1e-4."""


def smoothed_line(points: ArrayLike, smoothing_length: float) -> Points:
    """A polyline each of whose points is the mean of the line around it; both ends stay.

    Weights are those of a normal distribution along the arc. At its ends the line goes on as its
    own reflection in the end, so that a straight line stays as it is; an arc of radius r moves
    inwards by about `smoothing_length ** 2 / (2 r)`.

    Parameters
    ----------
    points : array_like, shape (n, 3)
        mm.
    smoothing_length : float
        Standard deviation of the weights, mm; 0 leaves the line as it is.

    Returns
    -------
    array, shape (n, 3)
        Where the points of the line are then.

    Raises
    ------
    InputError
        A line without length, or a smoothing that is below 0.
    """
    line = as_points(points, "polyline", minimum=2)
    sigma = as_number(smoothing_length, "smoothing length", unit="mm", minimum=0)
    total = positive_length(line)
    if sigma == 0:
        return line
    count = int(np.clip(STEPS * total / sigma, 16, MOST_STATIONS)) + 1
    even = resampled_to(line, count)
    spacing = total / (count - 1)
    side = int(np.clip(np.ceil(REACH * sigma / spacing), 1, count - 1))
    weights = np.exp(-0.5 * (np.arange(-side, side + 1) * spacing / sigma) ** 2)
    before = 2 * even[0] - even[side:0:-1]
    after = 2 * even[-1] - even[-2 : -side - 2 : -1]
    whole = np.concatenate([before, even, after])
    smooth = [np.convolve(column, weights / weights.sum(), mode="valid") for column in whole.T]
    stations = np.linspace(0.0, total, count)
    result = np.stack([np.interp(arc_lengths(line), stations, one) for one in smooth], axis=1)
    result[0], result[-1] = line[0], line[-1]
    return result
