"""Signs of determinants of coordinates as they are stored: in float64 where that is certain, in
whole numbers elsewhere.

Arrays of points have the shape (coordinate, pair).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..validation import Flags, Floats, Indices

Exact = NDArray[Any]
"""Array of Python integers (dtype object), or of floats where both are good."""

_UNIT = 2.0**-53
"""Largest relative rounding of one operation."""

_TURN, _VOLUME = 4 * _UNIT, 8 * _UNIT
"""Bounds on the rounding, over the sum of the products' sizes: a little more than the 3 and 7 units
of Shewchuk 1997, doi 10.1007/PL00009321, tests A of orientation in the plane and in space."""


def turn_signs(start: Floats, end: Floats, place: Floats) -> Indices:
    """Whether each place (2, k) is left (1) or right (-1) of a line from start to end, or on it."""
    return _signs((start, end, place), _turn, _TURN)


def volume_signs(corners: tuple[Floats, Floats, Floats], place: Floats) -> Indices:
    """Side of a triangle's plane each place (3, k) lies on: 1 where the normal points, -1, or 0."""
    return _signs((*corners, place), _volume, _VOLUME)


def whole_numbers(values: Floats) -> Exact:
    """The same numbers times one power of two, as Python integers of any length."""
    mantissa, exponent = np.frexp(values)
    shift = exponent - exponent[values != 0].min(initial=0)
    digits = np.ldexp(mantissa, 53).astype(np.int64).astype(object)
    return digits * (2 ** np.where(values != 0, shift, 0).astype(object))


def signs(values: Exact) -> Indices:
    """Sign of every number: -1, 0 or 1; the shape stays."""
    return (values > 0).astype(np.int64) - (values < 0).astype(np.int64)


def _signs(points: tuple[Floats, ...], determinant: Any, bound: float) -> Indices:
    value, size = determinant(*points)
    found = signs(value)
    is_open: Flags = np.abs(value) <= bound * size
    # Where every product is 0, so is the determinant.
    open_pairs = np.flatnonzero(is_open & (size > 0))
    if len(open_pairs):
        whole = whole_numbers(np.stack([one[:, open_pairs] for one in points]))
        found[open_pairs] = signs(determinant(*whole)[0])
    return found


def _turn(start: Exact, end: Exact, place: Exact) -> tuple[Exact, Exact]:
    """The determinant, and the sum of the sizes of its products."""
    one, other = end - start, place - start
    left, right = one[0] * other[1], one[1] * other[0]
    return left - right, np.abs(left) + np.abs(right)


def _volume(first: Exact, second: Exact, third: Exact, place: Exact) -> tuple[Exact, Exact]:
    a, b, c = first - place, second - place, third - place
    value, size = 0, 0
    for one, other, last in ((a, b, c), (b, c, a), (c, a, b)):
        left, right = one[0] * other[1], one[1] * other[0]
        # As seen from the triangle: the place is the origin here.
        value = value - (left - right) * last[2]
        size = size + (np.abs(left) + np.abs(right)) * np.abs(last[2])
    return np.asarray(value), np.asarray(size)
