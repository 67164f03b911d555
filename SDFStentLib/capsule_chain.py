"""The stent as a chain of capsules: one distance field for every radius.

The signed distance of the chain at radius r is `distance - r`, because the smooth minimum commutes
with adding a constant. So the field is evaluated once per point and position, never per radius.
Source: SDFStent, arXiv 2605.22009, section 2.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .polyline import length, resampled, without_repeats
from .validation import InputError, Points, as_number, as_points, read_only

BLOCK_ELEMENTS = 1 << 16
"""Points times capsules that are worked on at once: half a megabyte per temporary array."""

PRODUCT_COLUMNS = 1024
"""Columns of one matrix product: small enough that BLAS stays in the caller's thread."""


class Field(NamedTuple):
    """Distance field of a capsule chain at some points."""

    distance: NDArray[np.float64]
    """(n,) smooth distance to the axis, mm; subtract the radius for the signed distance."""
    direction: Points
    """(n, 3) unit gradient; zero where the gradient vanishes (a point on the axis)."""
    slope: NDArray[np.float64]
    """(n,) length of the gradient before it was made a unit vector, in [0, 1]."""


class AxisDistance(NamedTuple):
    """True distance to the axis polyline."""

    distance: NDArray[np.float64]
    """(n,), mm."""
    foot: Points
    """(n, 3) closest point of the axis."""


@dataclass(frozen=True)
class CapsuleChain:
    """Capsules along an axis, joined by the quadratic smooth minimum. Immutable.

    Attributes
    ----------
    nodes : (m + 1, 3) array
        Ends of the m capsules, mm, from the proximal to the distal end.
    smoothing_width : float
        k of the smooth minimum, mm; 0 gives the hard minimum.
    """

    nodes: Points
    smoothing_width: float = 0.4

    def __post_init__(self) -> None:
        nodes = as_points(self.nodes, "capsule chain nodes", minimum=2)
        if (np.linalg.norm(np.diff(nodes, axis=0), axis=1) == 0).any():
            raise InputError(
                "capsule chain nodes: expected distinct neighbors, got a repeated node; build the "
                "chain with CapsuleChain.along, which removes repeats."
            )
        object.__setattr__(self, "nodes", read_only(nodes))
        width = as_number(self.smoothing_width, "smoothing width", unit="mm", minimum=0)
        object.__setattr__(self, "smoothing_width", width)

    @classmethod
    def along(
        cls, axis: ArrayLike, *, capsule_length: float = 1.0, smoothing_width: float = 0.4
    ) -> CapsuleChain:
        """A chain along a stent axis, resampled to capsules of equal length.

        Parameters
        ----------
        axis : (n, 3) array_like
            Stent axis, mm, from the proximal to the distal end; repeats are removed.
        capsule_length : float
            Wanted capsule length, mm; the nearest length that divides the axis is used.

        Raises
        ------
        InputError
            An axis without length, or a capsule length that is not positive.
        """
        spacing = as_number(capsule_length, "capsule length", unit="mm", above=0)
        points = without_repeats(as_points(axis, "stent axis", minimum=2))
        if len(points) < 2:
            raise InputError("stent axis: expected a line with length, got a single place.")
        return cls(resampled(points, spacing), smoothing_width)

    @property
    def length(self) -> float:
        """Length of the axis, mm."""
        return length(self.nodes)

    def field(self, points: ArrayLike) -> Field:
        """Smooth distance to the axis and its gradient.

        The fold runs in order from the distal to the proximal end, as published. Works in blocks:
        memory stays bounded whatever the number of points.

        Parameters
        ----------
        points : (n, 3) array_like
            Where to evaluate, mm.
        """
        return self.trusted_field(as_points(points))

    def trusted_field(self, points: Points) -> Field:
        """`field` of points that are known to be sound, without checking them again."""
        return chain_field(points, self.nodes[::-1], self.smoothing_width)

    def axis_distance(self, points: ArrayLike) -> AxisDistance:
        """True distance to the axis polyline, without smoothing, and the closest axis point."""
        return polyline_distance(as_points(points), self.nodes)


def chain_field(points: Points, nodes: Points, smoothing_width: float) -> Field:
    """Field of the whole chain, folded over `nodes` in the given order, block by block."""
    field = Field(np.empty(len(points)), np.empty((len(points), 3)), np.empty(len(points)))
    for part, block in _blocks(points, nodes):
        distance, gradient = block.folded(points[part], smoothing_width)
        _store(field, part, distance, gradient)
    return field


def polyline_distance(points: Points, nodes: Points) -> AxisDistance:
    """Distance to the nearest capsule axis and the foot point there, block by block."""
    feet = np.empty((len(points), 3))
    for part, block in _blocks(points, nodes):
        feet[part] = block.feet(points[part])
    return AxisDistance(np.sqrt(np.einsum("ij,ij->i", points - feet, points - feet)), feet)


def _blocks(points: Points, nodes: Points) -> Iterator[tuple[slice, _Block]]:
    """Parts of the points, each with the one block in which they are worked on."""
    size = min(len(points), max(256, BLOCK_ELEMENTS // len(nodes)))
    block = _Block(nodes, size)
    for start in range(0, len(points), max(size, 1)):
        yield slice(start, start + size), block


class _Block:
    """Distances of a block of points to all capsule axes; its arrays serve block after block.

    Works on squared node distances `S_j = |p - a_j|^2`, from one small matrix product in
    coordinates centred on the nodes. With `t = 1/2 + (S_j - S_j+1) / (2 l^2)` and `h = clip(t)`
    the squared capsule distance is `S_j - h (S_j - S_j+1 + l^2 (1 - h))`.
    """

    def __init__(self, nodes: Points, size: int) -> None:
        self._centre = nodes.mean(axis=0)
        self._ends = nodes - self._centre
        self._axes = np.diff(nodes, axis=0)
        self._lengths = np.einsum("ij,ij->i", self._axes, self._axes)[:, None]
        count = len(nodes) - 1
        self._squared = np.empty((len(nodes), size))
        self._fractions, self._distances, self._spare = np.empty((3, count, size))

    def folded(
        self, points: Points, smoothing_width: float
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Folded distance (n,) and gradient (3, n)."""
        local = (points - self._centre).T
        fractions, distances = self._capsule_squares(local)
        np.sqrt(distances, out=distances)
        distance, weights = fold(distances, smoothing_width, self._spare[:, : len(points)])
        weights /= distances
        gradient = local * weights.sum(axis=0)
        gradient -= product(self._ends[:-1].T, weights)
        weights *= fractions
        gradient -= product(self._axes.T, weights)
        return distance, gradient

    def feet(self, points: Points) -> Points:
        """The closest point of the axis to each."""
        fractions, squares = self._capsule_squares((points - self._centre).T)
        nearest = squares.argmin(axis=0)
        fraction = fractions[nearest, np.arange(len(points))]
        return self._ends[nearest] + self._centre + fraction[:, None] * self._axes[nearest]

    def _capsule_squares(
        self, local: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Fractions of the closest points and squared distances, (m, n), of (3, n) points."""
        count = local.shape[1]
        squared = product(-2 * self._ends, local, self._squared[:, :count])
        squared += np.einsum("ij,ij->i", self._ends, self._ends)[:, None]
        squared += np.einsum("ij,ij->j", local, local)
        fractions, squares = self._fractions[:, :count], self._distances[:, :count]
        difference = np.subtract(squared[:-1], squared[1:], out=self._spare[:, :count])
        np.multiply(difference, 0.5 / self._lengths, out=fractions)
        fractions += 0.5
        # Two calls instead of np.clip, whose wrapper costs more than the work on a small block.
        np.maximum(fractions, 0, out=fractions)
        np.minimum(fractions, 1, out=fractions)
        np.multiply(fractions, -self._lengths, out=squares)
        squares += self._lengths
        squares += difference
        squares *= fractions
        np.subtract(squared[:-1], squares, out=squares)
        # A point on the axis has distance 0; the floor keeps the weights finite, its direction is
        # 0. Rounding may have made the square negative.
        np.abs(squares, out=squares)
        squares += 1e-30
        return fractions, squares


def fold(
    distances: NDArray[np.float64], smoothing_width: float, out: NDArray[np.float64] | None = None
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Smooth minimum over rows, in order, and the share of every row in the gradient.

    Returns the folded distance (n,) and weights (m, n) that sum to one over the rows. The weight
    of row j is `w_j prod_{i > j} (1 - w_i)` with the pairwise weights of `smooth_minimum`. They
    are written to `out` where that is given.
    """
    if smoothing_width == 0:
        weights = np.empty_like(distances) if out is None else out
        weights[:] = 0
        # Of equal rows the first wins, as in a fold with a strict comparison.
        nearest = distances.argmin(axis=0)
        np.put_along_axis(weights, nearest[None], 1.0, axis=0)
        return distances.min(axis=0), weights
    scale = 1 / (2 * smoothing_width)
    value = distances[0] * scale
    weights = np.multiply(distances, -scale, out=out)
    weights += 0.5
    weights[0] = 1
    shift, part = np.empty_like(value), np.empty_like(value)
    for row in weights[1:]:
        np.add(value, row, out=shift)
        # Two calls instead of np.clip, whose wrapper costs more than the work on a small block.
        np.maximum(shift, 0, out=row)
        np.minimum(row, 1, out=row)
        np.multiply(row, -0.5, out=part)
        part += shift
        part *= row
        value -= part
    remaining = 1 - weights[-1]
    for row in weights[-2::-1]:
        row *= remaining
        remaining -= row
    return value / scale, weights


def product(
    left: NDArray[np.float64],
    right: NDArray[np.float64],
    out: NDArray[np.float64] | None = None,
) -> NDArray[np.float64]:
    """Matrix product in column chunks, below the size at which BLAS starts threads of its own."""
    if out is None:
        out = np.empty((left.shape[0], right.shape[1]))
    for start in range(0, right.shape[1], PRODUCT_COLUMNS):
        part = slice(start, start + PRODUCT_COLUMNS)
        np.matmul(left, right[:, part], out=out[:, part])
    return out


def _store(
    field: Field, part: slice, distance: NDArray[np.float64], gradient: NDArray[np.float64]
) -> None:
    """Write one block into the whole field, with the gradient split into length and direction."""
    slope = np.sqrt(np.einsum("ij,ij->j", gradient, gradient))
    field.distance[part] = distance
    field.slope[part] = slope
    # Where neighbors cancel, the direction is undefined; zero moves nothing.
    defined = slope > 1e-12
    np.divide(gradient, slope, out=gradient, where=defined)
    gradient[:, ~defined] = 0
    field.direction[part] = gradient.T
