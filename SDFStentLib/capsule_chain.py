"""The stent as a chain of capsules: one distance field for every radius.

The signed distance of the chain at radius r is `distance - r`, because the smooth minimum commutes
with adding a constant. So the field is evaluated once per point and position, never per radius.
Source: SDFStent, arXiv 2605.22009, section 2.
"""

from __future__ import annotations

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
        return chain_field(as_points(points), self.nodes[::-1], self.smoothing_width)

    def axis_distance(self, points: ArrayLike) -> AxisDistance:
        """True distance to the axis polyline, without smoothing, and the closest axis point."""
        return polyline_distance(as_points(points), self.nodes)


def chain_field(points: Points, nodes: Points, smoothing_width: float) -> Field:
    """Field of the whole chain, folded over `nodes` in the given order, block by block."""
    count = len(points)
    field = Field(np.empty(count), np.empty((count, 3)), np.empty(count))
    block = max(256, BLOCK_ELEMENTS // len(nodes))
    for start in range(0, count, block):
        part = slice(start, start + block)
        distance, gradient = folded(points[part], nodes, smoothing_width)
        _store(field, part, distance, gradient)
    return field


def folded(
    points: Points, nodes: Points, smoothing_width: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Folded distance (n,) and gradient (3, n) of one block of points.

    Works on squared node distances `S_j = |p - a_j|^2`, from one small matrix product in
    coordinates centred on the nodes. With `t = 1/2 + (S_j - S_j+1) / (2 l^2)` and `h = clip(t)`
    the squared capsule distance is `S_j - l^2 h (2 t - h)`.
    """
    centre = nodes.mean(axis=0)
    ends = nodes - centre
    axes = np.diff(ends, axis=0)
    squared = squared_node_distances((points - centre).T, ends)
    distances, fractions = capsule_distances(squared, axes)

    distance, weights = fold(distances, smoothing_width)
    weights /= distances
    gradient = (points - centre).T * weights.sum(axis=0)
    gradient -= product(ends[:-1].T, weights)
    weights *= fractions
    gradient -= product(axes.T, weights)
    return distance, gradient


def squared_node_distances(local: NDArray[np.float64], ends: Points) -> NDArray[np.float64]:
    """|p - a_j|^2 of (3, n) points to (m, 3) nodes as an (m, n) array."""
    squared = product(-2 * ends, local)
    squared += np.einsum("ij,ij->i", ends, ends)[:, None]
    squared += np.einsum("ij,ij->j", local, local)
    return squared


def capsule_distances(
    squared: NDArray[np.float64], axes: Points
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Distances to the capsule axes and the fractions of their closest points, both (m, n)."""
    lengths = np.einsum("ij,ij->i", axes, axes)[:, None]
    fractions = squared[:-1] - squared[1:]
    fractions /= 2 * lengths
    fractions += 0.5
    twice = 2 * fractions
    np.maximum(fractions, 0, out=fractions)
    np.minimum(fractions, 1, out=fractions)
    twice -= fractions
    twice *= fractions
    twice *= lengths
    distances = np.subtract(squared[:-1], twice, out=twice)
    # A point on the axis has distance 0; the floor keeps the weights finite, its direction is 0.
    np.maximum(distances, 1e-30, out=distances)
    return np.sqrt(distances, out=distances), fractions


def fold(
    distances: NDArray[np.float64], smoothing_width: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Smooth minimum over rows, in order, and the share of every row in the gradient.

    Returns the folded distance (n,) and weights (m, n) that sum to one over the rows. The weight
    of row j is `w_j prod_{i > j} (1 - w_i)` with the pairwise weights of `smooth_minimum`.
    """
    if smoothing_width == 0:
        weights = np.zeros_like(distances)
        # Of equal rows the first wins, as in a fold with a strict comparison.
        nearest = distances.argmin(axis=0)
        np.put_along_axis(weights, nearest[None], 1.0, axis=0)
        return distances.min(axis=0), weights
    scale = 1 / (2 * smoothing_width)
    value = distances[0] * scale
    weights = distances * -scale
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


def product(left: NDArray[np.float64], right: NDArray[np.float64]) -> NDArray[np.float64]:
    """Matrix product in column chunks, below the size at which BLAS starts threads of its own."""
    out = np.empty((left.shape[0], right.shape[1]))
    for start in range(0, right.shape[1], PRODUCT_COLUMNS):
        part = slice(start, start + PRODUCT_COLUMNS)
        np.matmul(left, right[:, part], out=out[:, part])
    return out


def polyline_distance(points: Points, nodes: Points) -> AxisDistance:
    """Distance to the nearest capsule axis and the foot point there, block by block."""
    feet = np.empty((len(points), 3))
    axes = np.diff(nodes, axis=0)
    lengths = np.einsum("ij,ij->i", axes, axes)
    centre = nodes.mean(axis=0)
    block = max(256, BLOCK_ELEMENTS // len(nodes))
    for start in range(0, len(points), block):
        part = slice(start, start + block)
        local = (points[part] - centre).T
        distances, _ = capsule_distances(squared_node_distances(local, nodes - centre), axes)
        nearest = distances.argmin(axis=0)
        offset = points[part] - nodes[nearest]
        fraction = np.einsum("ij,ij->i", offset, axes[nearest]) / lengths[nearest]
        feet[part] = nodes[nearest] + np.clip(fraction, 0, 1)[:, None] * axes[nearest]
    return AxisDistance(np.linalg.norm(points - feet, axis=1), feet)


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
