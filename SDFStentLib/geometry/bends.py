"""Frames along a line, its tightest bend, and the line smoothed so that short bends vanish."""

from __future__ import annotations

from itertools import pairwise
from math import sqrt
from typing import NamedTuple

import numpy as np

from ..validation import Floats, Points, as_number
from .line import Line
from .rows import dot

_NONE = 1e-9
"""Length below which a vector across a unit vector has no direction."""

STEPS = 16
"""Stations per length of smoothing."""

MOST_STATIONS = 8_000

REACH = 4.0
"""Distance, in lengths of smoothing, up to which a place counts; what is left out is below 1e-4."""


def frames(line: Line) -> Floats:
    """Right-handed frames of minimal twist.

    Returns
    -------
    array, shape (n, 3, 3)
        Rows are tangent, normal, binormal. The first normal is the coordinate axis farthest from
        the tangent, without its part along that; from point to point the normal is turned by the
        smallest rotation that takes one tangent to the next.
    """
    return frames_along(line.directions)


def frames_along(along: Floats) -> Floats:
    """`frames` for unit tangents (n, 3)."""
    normals = np.empty_like(along)
    normals[0] = _normal_to(along[0])
    # Plain numbers: arrays of three cost ten times as much.
    normal = normals[0].tolist()
    for i, (before, after) in enumerate(pairwise(along.tolist()), start=1):
        share = _dot(normal, after) / max(1.0 + _dot(before, after), 1e-12)
        turned = [n - share * b for n, b in zip(normal, before, strict=True)]
        away = _dot(turned, after)
        across = [n - away * a for n, a in zip(turned, after, strict=True)]
        size = sqrt(_dot(across, across))
        normal = _normal_to(along[i]).tolist() if size < _NONE else [n / size for n in across]
        normals[i] = normal
    return np.stack([along, normals, np.cross(along, normals)], axis=1)


def _dot(one: list[float], other: list[float]) -> float:
    return one[0] * other[0] + one[1] * other[1] + one[2] * other[2]


def _normal_to(tangent: Floats) -> Floats:
    normal = np.eye(3)[np.abs(tangent).argmin()]
    normal = normal - (normal @ tangent) * tangent
    return normal / np.linalg.norm(normal)


class Bend(NamedTuple):
    """A bend of a polyline."""

    radius: float
    """mm; infinity when straight."""
    point: Points
    """Place (3,) of the bend, mm."""


def tightest_bend(line: Line, window: float | None = None) -> Bend:
    """The tightest bend of a line and the place of that bend.

    Parameters
    ----------
    line : Line
        mm.
    window : float, optional
        Arc length, mm, from the middle one of the three compared points to each outer one, so
        that jitter of a dense centerline does not count as a bend; at most half the length.
        A corner of angle a then has the radius `window / (2 sin(a / 2))`. Default: neighbors.

    Returns
    -------
    Bend
        Smallest radius of the circles through three points (exact on a circular arc), and the
        middle one of these; the first of equals.
    """
    line = line.without_repeats()
    points = line.points
    if len(points) < 3:
        return Bend(float("inf"), points[0])
    before, middle, after = points[:-2], points[1:-1], points[2:]
    if window is not None:
        total = line.length
        reach = min(as_number(window, "window", unit="mm", above=0), total / 2.0)
        # Steps of an eighth of the window (a corner is met to a sixteenth), memory bounded.
        count = 2 + int(min(8.0 * (total - 2.0 * reach) / reach, 50_000))
        at = np.linspace(reach, total - reach, count)
        before, middle, after = (line.at(at + shift) for shift in (-reach, 0.0, reach))
    first, second = middle - before, after - middle
    sides = [np.linalg.norm(side, axis=1) for side in (first, second, first + second)]
    product = sides[0] * sides[1] * sides[2]
    twice = 2.0 * np.linalg.norm(np.cross(first, second), axis=1)
    # Straight on (or turned back by 180 degrees) the circle degenerates to a line (or a point).
    flat = twice <= 1e-12 * sides[0] * sides[1]
    turned_back = dot(first, second) < 0
    radii = np.where(turned_back, 0.0, np.inf)
    radii[~flat] = product[~flat] / twice[~flat]
    tightest = int(radii.argmin())
    return Bend(float(radii[tightest]), middle[tightest])


def smoothed_line(line: Line, smoothing_length: float) -> Line:
    """A smoothed line: each point is the weighted mean of the line around it; both ends stay.

    Weights are those of a normal distribution along the arc. At its ends the line goes on as its
    own reflection in the end, so that a straight line stays as it is; an arc of radius r moves
    inward by about `smoothing_length ** 2 / (2 r)`.

    Parameters
    ----------
    line : Line
        mm.
    smoothing_length : float
        Standard deviation of the weights, mm; 0 leaves the line as it is.

    Raises
    ------
    InputError
        A line without length, or a smoothing that is below 0.
    """
    sigma = as_number(smoothing_length, "smoothing length", unit="mm", minimum=0)
    line.check_length()
    if sigma == 0:
        return line
    total = line.length
    count = int(np.clip(STEPS * total / sigma, 16, MOST_STATIONS)) + 1
    even = line.resampled_to(count).points
    spacing = total / (count - 1)
    side = int(np.clip(np.ceil(REACH * sigma / spacing), 1, count - 1))
    weights = np.exp(-0.5 * (np.arange(-side, side + 1) * spacing / sigma) ** 2)
    before = 2 * even[0] - even[side:0:-1]
    after = 2 * even[-1] - even[-2 : -side - 2 : -1]
    whole = np.concatenate([before, even, after])
    smooth = [np.convolve(column, weights / weights.sum(), mode="valid") for column in whole.T]
    stations = np.linspace(0.0, total, count)
    result = np.stack([np.interp(line.arc_lengths, stations, one) for one in smooth], axis=1)
    result[0], result[-1] = line.points[0], line.points[-1]
    return Line(result)
