"""Evaluation of a capsule chain's field: blocks of points, windows of capsules, proof of both.

Most capsules are too far from a point to take part in its smooth minimum. Points that come with
their nearest node, ordered so that neighbors follow each other, are folded over a window of
capsules only, and every point has to prove that the capsules outside change nothing:

* Capsules after the window cannot matter when all are farther than the folded distance plus k:
  the smooth minimum of two values that differ by k or more is the smaller one.
* The fold of the capsules before the window is not less than their smallest distance minus k.
  Begun with that lower bound, each later pairwise weight w leaves 1 - w of the difference to the
  true value, and less than that of a larger one; the fold has forgotten it where nothing is left.

A fold from the other end proves the same with the sides exchanged; a mean of both needs both.
A point without proof, such as one between the legs of a hairpin, is folded over the whole chain.
So a window decides how fast the field is, never what it is.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry import dot, norm
from ..validation import Floats, Points
from .fold import fold, fold_from_both_ends, hard_minimum

NOTHING = np.empty(0, dtype=np.int64)

BLOCK_POINTS = 2048
BLOCK_ELEMENTS = 1 << 16
"""Points, and pairs of point and capsule, worked on at once: as many as fit a core's cache."""

SINGLE_THREAD_SIZE = 200_000
"""Multiplications in a matrix product that BLAS does in the caller's thread."""

WINDOW, WINDOW_OF_BOTH = (10.0, 5.0), (8.0, 8.0)
"""Reach of a window before and after the nearest node, mm: nearly every point proves it enough."""

BESIDE = 3
"""Capsules beside the nearest nodes among which the nearest one is looked for."""

NO_DISTANCE, NO_SLOPE = 5e-8, 1e-6
"""Distance, in units of 4 k, and slope below which rounding decides."""


class Field(NamedTuple):
    """Distance field of a capsule chain at some points."""

    distance: Floats
    """(n,) smooth distance to the axis, mm; subtract the radius for the signed distance."""
    direction: Points
    """(n, 3) unit gradient; zero where the gradient vanishes (a point on the axis)."""
    slope: Floats
    """(n,) length of the gradient before it was made a unit vector, in [0, 1]."""


class ChainField:
    """The field of a chain of nodes, folded in their order or from both ends. Immutable.

    Coordinates are centered on the nodes and divided by 4 k. For a capsule with middle `m`, unit
    direction `u` and length `l`, the offset along it is `x = u . (p - m)`, `c` is `x` clipped to
    `l / 2`, and the squared distance is `|p - m|^2 - c (2 x - c)`. Both terms are rows of matrix
    products with the lifted point `[x, y, z, 1, |p|^2]`.
    """

    def __init__(self, nodes: Points, smoothing_width: float, from_both_ends: bool) -> None:
        self.is_smooth = smoothing_width > 0
        self.from_both_ends = from_both_ends
        self.nodes = nodes
        self.scale = 1 / (4 * smoothing_width) if self.is_smooth else 1.0
        self.center = nodes.mean(axis=0)
        ends = (nodes - self.center) * self.scale
        axes = np.diff(ends, axis=0)
        lengths = norm(axes)
        middles = (ends[:-1] + ends[1:]) / 2
        units = axes / lengths[:, None]
        self.count = len(axes)
        self.to_ends = _squares_from(ends)
        self.to_middles = _squares_from(middles)
        self.along = np.column_stack([units, -dot(units, middles)])
        self.half_lengths = lengths[:, None] / 2
        self.middles = np.vstack([middles.T, np.ones(self.count)])
        self.units = units.T.copy()
        # The squared distance to a capsule axis is less than that to its nearer end by at most
        # this, where the foot is in the middle.
        self.slack = float(lengths.max()) ** 2 / 4
        reach = WINDOW_OF_BOTH if from_both_ends else WINDOW
        self.reach = [int(np.ceil(one * self.scale / lengths.mean())) for one in reach]

    def at(self, points: Points, near: NDArray[np.int32] | None = None) -> Field:
        """The field at some points.

        Parameters
        ----------
        points : (n, 3) array
            mm.
        near : (n,) array, optional
            Number of the node that is about nearest to each, see `nearest_nodes`. Without it, or
            without smoothing, all capsules are folded for every point.
        """
        field = Field(np.empty(len(points)), np.empty((len(points), 3)), np.empty(len(points)))
        near = near if self.is_smooth else None
        for part, block, window in self._blocks(points, near, *self.reach):
            unproven = block.folded(points[part], window, field, part)
            if len(unproven):
                unproven += part.start
                block.folded(points[unproven], slice(0, self.count), field, unproven)
        return field

    def axis_distance(self, points: Points, near: NDArray[np.int32] | None = None) -> Floats:
        """True distance to the axis (n,), mm; parameters as for `at`."""
        distance = np.empty(len(points))
        for part, block, window in self._blocks(points, near, BESIDE, BESIDE):
            distance[part], unproven = block.nearest(points[part], window)
            if len(unproven):
                unproven += part.start
                distance[unproven], _ = block.nearest(points[unproven], slice(0, self.count))
        return distance

    def nearest_nodes(self, points: Points) -> tuple[NDArray[np.int32], Floats]:
        """Number (n,) of the node nearest to each point, in the order of the fold, and a bound.

        The bound (n,) is below the true distance to the axis, mm, by less than half a capsule.
        """
        nearest, bound = np.empty(len(points), dtype=np.int32), np.empty(len(points))
        for start in range(0, len(points), BLOCK_POINTS):
            part = slice(start, start + BLOCK_POINTS)
            squares = _product(self.to_ends, self.lifted(points[part]))
            nearest[part] = squares.argmin(axis=0)
            bound[part] = squares.min(axis=0)
        return nearest, np.sqrt(np.maximum(bound - self.slack, 0)) / self.scale

    def lifted(self, points: Points) -> Floats:
        """Rows (5, n) x, y, z, 1 and the squared norm, in the chain's own coordinates."""
        lifted = np.empty((5, len(points)))
        np.subtract(points.T, self.center[:, None], out=lifted[:3])
        lifted[:3] *= self.scale
        lifted[3] = 1
        np.einsum("ij,ij->j", lifted[:3], lifted[:3], out=lifted[4])
        return lifted

    def window(self, near: NDArray[np.int32], before: int, after: int) -> slice:
        """The capsules round some nodes: as many before and after them as asked for."""
        first, last = int(near.min()) - before, int(near.max()) + after
        return slice(max(0, first), min(self.count, last))

    def _blocks(
        self, points: Points, near: NDArray[np.int32] | None, before: int, after: int
    ) -> Iterator[tuple[slice, _Block, slice]]:
        """Parts of the points, each with the reused block and the capsules to look at."""
        size = BLOCK_POINTS if near is not None else max(256, BLOCK_ELEMENTS // self.count)
        size = max(1, min(len(points), size))
        block = _Block(self, size)
        window = slice(0, self.count)
        for start in range(0, len(points), size):
            part = slice(start, min(start + size, len(points)))
            if near is not None:
                window = self.window(near[part], before, after)
            yield part, block, window


class _Block:
    """Scratch arrays for the work on a block of points, used for block after block."""

    def __init__(self, chain: ChainField, size: int) -> None:
        self._chain = chain
        self._distances, self._offsets, self._clipped, self._weights, self._back = np.empty(
            (5, chain.count + 1, size)
        )

    def folded(self, points: Points, window: slice, field: Field, where: Any) -> NDArray[np.int64]:
        """Write the field of some points to their places; return those that lack the proof."""
        chain = self._chain
        lifted = chain.lifted(points)
        distances, along = self._capsules(lifted, window)
        weights = self._weights[: len(distances), : len(points)]
        before, after = self._outside(lifted, window)
        room, back = (
            array[: len(distances), : len(points)] for array in (self._offsets, self._back)
        )
        is_proven: NDArray[np.bool_] | None = None
        if not chain.is_smooth:
            distance = hard_minimum(distances, weights)
        elif chain.from_both_ends:
            distance, is_proven = fold_from_both_ends(
                distances, weights, (room, back), before, after
            )
        else:
            distance, is_proven = fold(distances, weights, room, before, after)

        weights /= distances
        gradient = lifted[:3]
        pull = _product(chain.middles[:, window], weights)
        gradient *= pull[3]
        gradient -= pull[:3]
        weights *= along
        gradient -= _product(chain.units[:, window], weights)
        slope = np.sqrt(np.einsum("ij,ij->j", gradient, gradient))
        # On the axis and where neighbors cancel, the direction is undefined; zero moves nothing.
        gradient *= np.divide(1, slope, out=np.zeros_like(slope), where=slope > NO_SLOPE)
        field.distance[where] = distance / chain.scale
        field.direction[where] = gradient.T
        field.slope[where] = slope
        return NOTHING if is_proven is None else np.flatnonzero(~is_proven)

    def nearest(self, points: Points, window: slice) -> tuple[Floats, NDArray[np.int64]]:
        """True distance of some points to the axis, and the points that lack the proof."""
        lifted = self._chain.lifted(points)
        distance = self._capsules(lifted, window)[0].min(axis=0)
        unproven = NOTHING
        beside = [bound for bound in self._outside(lifted, window) if bound is not None]
        if beside:
            unproven = np.flatnonzero(np.min(beside, axis=0) < distance)
        return distance / self._chain.scale, unproven

    def _capsules(self, lifted: Floats, window: slice) -> tuple[Floats, Floats]:
        """Distances to the capsule axes and the clipped offsets along them, (capsules, n)."""
        chain = self._chain
        rows, count = window.stop - window.start, lifted.shape[1]
        distances, offsets, clipped = (
            array[:rows, :count] for array in (self._distances, self._offsets, self._clipped)
        )
        _product(chain.to_middles[window], lifted, distances)
        _product(chain.along[window], lifted[:4], offsets)
        limit = chain.half_lengths[window]
        # Two calls instead of np.clip, which takes several times as long.
        np.maximum(offsets, -limit, out=clipped)
        np.minimum(clipped, limit, out=clipped)
        offsets += offsets
        offsets -= clipped
        offsets *= clipped
        distances -= offsets
        # On the axis rounding would decide; with the floor the slope of such a point comes out as
        # 0.
        np.maximum(distances, NO_DISTANCE**2, out=distances)
        np.sqrt(distances, out=distances)
        return distances, clipped

    def _outside(self, lifted: Floats, window: slice) -> tuple[Floats | None, Floats | None]:
        """Lower bounds (n,) of the distances to capsules before and after the window."""
        chain = self._chain
        bounds: list[Floats | None] = []
        for ends in (slice(0, window.start + 1), slice(window.stop, chain.count + 1)):
            count = ends.stop - ends.start
            if count < 2:
                bounds.append(None)
                continue
            room = self._offsets[:count, : lifted.shape[1]]
            nearest = _product(chain.to_ends[ends], lifted, room).min(axis=0)
            nearest -= chain.slack
            np.maximum(nearest, 0, out=nearest)
            bounds.append(np.sqrt(nearest, out=nearest))
        return bounds[0], bounds[1]


def _squares_from(places: Points) -> Floats:
    """Rows that turn lifted points into squared distances from some places, by matrix product."""
    squares = dot(places, places)
    return np.column_stack([-2 * places, squares, np.ones(len(places))])


def _product(left: Floats, right: Floats, out: Floats | None = None) -> Floats:
    """Matrix product in column chunks, below the size at which BLAS starts threads of its own."""
    if out is None:
        out = np.empty((left.shape[0], right.shape[1]))
    columns = max(1, SINGLE_THREAD_SIZE // left.size)
    for start in range(0, right.shape[1], columns):
        part = slice(start, start + columns)
        np.matmul(left, right[:, part], out=out[:, part])
    return out
