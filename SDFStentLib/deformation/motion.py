"""The points that a deployment can move, and what a radius step needs to know about them.

This is the mutable working state of a running deployment; it never leaves the library.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..field import CapsuleChain, Field
from ..geometry import across, dot
from ..validation import Points
from .contact_search import ContactSearch

STRAIGHT = np.cos(np.deg2rad(2.0))
"""Cosine of the angle up to which directions count as the same: ripple of the field stays below."""

SAMPLE = 1500
"""Points at which the way ahead is checked; fewer where there are not so many."""

BIN_SIZE = 3.0
"""Edge of the cubes that group points, mm, in the stent's own frame.

Skipping resting cubes is exact; which points follow a curved field is decided cube by cube.
"""

CELLS_PER_BIN = 4
CELL_SIZE = BIN_SIZE / CELLS_PER_BIN
"""Edge of the cells, mm, whose points may share a guess: see `NewContacts`."""

NEWTON_STEPS = 2
"""Newton steps from the last radius step onto the level of the expanded stent."""

NODES_PER_BIN = 3
"""Axis nodes whose points are kept together; then cubes put them in order."""


class Motion:
    """Positions of the active points with their stored field.

    Attributes
    ----------
    indices : (n,) array
        Position of every active point in the caller's array: the wall first, then points that
        are only dragged along, each ordered for spatial coherence.
    positions, direction : (n, 3) arrays
        Current coordinates, mm, and direction of motion, as long as `pace`.
    level : (n,) array
        Distance field minus the tissue offset, mm, divided by the pace: the stent radius that
        reaches the point.
    pace : (n,) array or None
        Share of the largest radius that the stent has where it reaches the point: the way that its
        wall makes there while the radius grows by 1. None where the radius is the same everywhere.
    slope : (n,) array
        Rate at which `level` grows when the point moves along its direction.
    cell : (n,) array
        Number, ascending, of the small cell in which the point started; see `CELL_SIZE`.
    offset : (n,) array
        Tissue thickness kept between the stent and the point, mm.
    touchable : (n,) bool array
        Whether the stent can touch the point (wall) or only drag it along (centerline).
    drags : (n,) bool array
        Whether the point in contact drags others along; a cap of an outlet is no wall and does not.
    is_curved : (n,) bool array
        Whether the direction changes along the way, see `look_ahead`.
    estimated_error : float
        Largest estimated distance to the converged limit of the steps so far, mm; 0 where the
        step rule does not estimate it.
    """

    def __init__(
        self,
        chain: CapsuleChain,
        points: Points,
        touchable: NDArray[np.bool_],
        near: NDArray[np.int32] | None = None,
    ) -> None:
        self._origin = (chain.nodes[0] + chain.nodes[-1]) / 2
        if near is None:
            near, _ = chain.folding.nearest_nodes(points)
        local = points - self._origin
        self._frame = _own_frame(chain.nodes, local[touchable])
        place = _along(chain.folding.nodes, self._frame, near)
        order, self.cell = _spatial_order(local @ self._frame, touchable, place)
        self.chain = chain
        self.indices = order
        self.positions = points.take(order, axis=0)
        self._near = near[order]
        field = chain.folding.at(self.positions, self._near)
        shares = chain.shares
        self.pace = None if shares is None else shares.at(self.positions, chain.line)
        self.level, self.direction = self._paced(slice(None), field.distance, field.direction)
        self.slope = field.slope
        self.offset = np.zeros(len(points))
        self.touchable = touchable[order]
        self.drags = self.touchable
        self.is_curved = np.zeros(len(points), dtype=bool)
        self.estimated_error = 0.0
        self._extrapolated = np.zeros(len(points), dtype=bool)

    @cached_property
    def resting(self) -> RestingPoints:
        """The points grouped in cubes; made when first asked for, before anything moves."""
        return RestingPoints(self.positions - self._origin, self._origin, self._frame)

    def restricted(self, keep: NDArray[np.bool_]) -> None:
        """Drop the points that are not kept; only allowed before anything moves."""
        for name in (
            "indices", "positions", "level", "direction", "slope", "offset", "touchable",
            "drags", "cell", "is_curved", "_near", "_extrapolated",
        ):  # fmt: skip
            setattr(self, name, getattr(self, name)[keep])
        self.pace = None if self.pace is None else self.pace[keep]
        self.__dict__.pop("resting", None)

    def set_offset(self, offset: NDArray[np.float64]) -> None:
        """Keep a tissue thickness, mm, between the stent and every point."""
        change, _ = self._paced(slice(None), self.offset - offset, self.direction)
        self.level += change
        self.offset = offset

    @property
    def outward(self) -> Points:
        """(n, 3) unit directions of motion."""
        return self.direction if self.pace is None else self.direction / self.pace[:, None]

    def distance_at(self, level: Any) -> NDArray[np.float64]:
        """Distances (n,) from the axis, mm, of points on a common level or on their own, without
        tissue."""
        return np.asarray(level * (1.0 if self.pace is None else self.pace))

    def _paced(
        self, where: Any, distance: NDArray[np.float64], direction: Points
    ) -> tuple[NDArray[np.float64], Points]:
        """Levels and directions of motion of some points, from their field."""
        if self.pace is None:
            return distance, direction
        pace = self.pace[where]
        return distance / pace, direction * pace[:, None]

    def moved_to(self, where: NDArray[Any], positions: Points) -> None:
        """Move some points elsewhere and evaluate their field there."""
        field = self.field_at(where, positions)
        self.positions[where] = positions
        self.level[where], self.direction[where] = self._paced(
            where, field.distance - self.offset[where], field.direction
        )
        self.slope[where] = field.slope
        self._extrapolated[where] = False

    def field_at(self, where: NDArray[Any], positions: Points) -> Field:
        """The field that some points would have elsewhere, not far from where they are."""
        return self.chain.folding.at(positions, self._near[where])

    def axis_distance(self, where: NDArray[Any], positions: Points) -> NDArray[np.float64]:
        """True distance (k,) to the axis, mm, that some points would have elsewhere."""
        return self.chain.folding.axis_distance(positions, self._near[where])

    def advanced(self, where: NDArray[Any], amount: float | NDArray[np.float64]) -> None:
        """Move some points along their direction; their level is extrapolated, see `refreshed`."""
        amount = np.broadcast_to(amount, len(where))
        self.positions[where] += amount[:, None] * self.direction[where]
        self.level[where] += amount * self.slope[where]
        self._extrapolated[where] = True

    def held_on(self, where: NDArray[Any], level: float) -> None:
        """Set the level, mm, of points in contact, whatever was extrapolated."""
        self.level[where] = level

    def estimated(self, error: float) -> None:
        """Note the estimated distance of a step to the converged limit, mm; the largest one is
        kept."""
        self.estimated_error = max(self.estimated_error, error)

    def refreshed(self) -> None:
        """Evaluate the field of all points whose level was extrapolated."""
        where = np.flatnonzero(self._extrapolated)
        self.moved_to(where, self.positions.take(where, axis=0))

    def settled(self, level: float) -> None:
        """Evaluate all fields, and bring points that are still inside the stent onto its level."""
        self.refreshed()
        for _ in range(NEWTON_STEPS):
            inside = np.flatnonzero((self.level < level - 1e-12) & self.touchable)
            if not len(inside):
                return
            slope = np.maximum(self.slope[inside], 0.5)
            amount = (level - self.level[inside]) / slope
            target = self.positions[inside] + amount[:, None] * self.direction[inside]
            self.moved_to(inside, target)

    def freeze(self) -> None:
        """End the motion: later steps have positions of their own."""
        for values in (self.positions, self.level, self.direction, self.slope, self.offset):
            values.setflags(write=False)

    def look_ahead(self, distance: float) -> None:
        """Find the points whose direction changes on the way ahead, at half and at the whole
        distance, mm.

        Only a sample of many points is checked, and a whole cube counts as curved when one of its
        sampled points does. The sample of the wall does not depend on what is dragged along.
        """
        wall, others = (np.flatnonzero(self.touchable == which) for which in (True, False))
        sample = np.concatenate([one[:: max(1, len(one) // SAMPLE)] for one in (wall, others)])
        direction = self.outward[sample]
        curved = np.zeros(len(sample), dtype=bool)
        for share in (0.5, 1.0):
            ahead = self.field_at(sample, self.positions[sample] + share * distance * direction)
            curved |= dot(ahead.direction, direction) < STRAIGHT
        cube = self.resting.cube
        in_curved_cube = np.zeros(len(self.positions) + 1, dtype=bool)
        in_curved_cube[cube[sample[curved]]] = True
        self.is_curved = in_curved_cube[cube]


class RestingPoints:
    """Points that have not moved yet, in cubes, so that far ones are skipped together.

    A point outside the influence distance of every contact point rests, hence its cube keeps its
    size. A cube wakes, for good, when a contact point comes nearer to its center than the influence
    distance plus its radius; only awake points are searched one by one. Skipping is exact.
    """

    def __init__(self, positions: Points, origin: Points, frame: Points) -> None:
        """Positions are relative to an origin at the stent, so that shifts change nothing."""
        cubes = np.floor(positions @ frame / BIN_SIZE).astype(np.int64)
        change = np.any(np.diff(cubes, axis=0) != 0, axis=1)
        starts = np.concatenate([[0], np.flatnonzero(change) + 1]).astype(np.int64)
        if len(positions) == 0:
            starts = starts[:0]
        counts = np.diff(np.append(starts, len(positions)))
        sums = np.add.reduceat(positions, starts, axis=0) if len(starts) else np.empty((0, 3))
        centers = sums / counts[:, None]
        self._centers = centers + origin
        self.cube = np.repeat(np.arange(len(starts)), counts)
        offsets = positions - centers[self.cube]
        squares = dot(offsets, offsets)
        reach = np.maximum.reduceat(squares, starts) if len(starts) else squares
        self._reach = np.sqrt(reach)
        self._asleep = np.arange(len(starts))
        self.awake = np.zeros(len(positions), dtype=bool)

    def wake(self, contact: ContactSearch, influence_distance: float) -> None:
        """Wake the cubes that a contact point may influence."""
        if not len(self._asleep):
            return
        reach = self._reach[self._asleep] + influence_distance
        distances, _ = contact.nearest(self._centers[self._asleep], float(reach.max()))
        woken = distances <= reach
        if woken.any():
            cubes = np.zeros(len(self._centers), dtype=bool)
            cubes[self._asleep[woken]] = True
            self.awake |= cubes[self.cube]
            self._asleep = self._asleep[~woken]


def _own_frame(nodes: Points, wall: Points) -> Points:
    """Axes (3, 3), in columns, of a stent and the wall round it; they turn along with both.

    They run from one end to the other, toward the side where most of the wall lies, and across
    both. So the grouping of points depends neither on the coordinates' frame nor on the end at
    which the stent begins; sums and products keep their bits where two coordinates change sign.
    """
    middle = wall.sum(axis=0)
    along = _chord(nodes)
    along = along / np.linalg.norm(along)
    if middle @ along < 0:
        along = -along
    side = middle - (middle @ along) * along
    if not side.any():
        side = across(along[None])[0, 0]
    side = side / np.linalg.norm(side)
    return np.stack([along, side, np.cross(along, side)], axis=1)


def _chord(nodes: Points) -> Points:
    chord = nodes[-1] - nodes[0]
    if not chord.any():  # a closed ring
        chord = nodes[len(nodes) // 2] - nodes[0]
    return chord


def _along(nodes: Points, frame: Points, near: NDArray[np.int32]) -> NDArray[np.int32]:
    """Numbers of nodes counted along the stent's own frame, whichever way the nodes run."""
    return near if _chord(nodes) @ frame[:, 0] > 0 else len(nodes) - 1 - near


def _spatial_order(
    points: Points, touchable: NDArray[np.bool_], near: NDArray[np.int32]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Order of the points: wall before companions, each along the stent, then by cube and cell.

    So points that are worked on together share capsules and branches of a search tree. The second
    array holds the number of the cell of each point, in that order. `near` counts the nodes along
    the stent's own frame, as `_along` gives them.
    """
    if not len(points):
        return np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
    cells = np.floor(points / CELL_SIZE).astype(np.int64)
    cubes = cells // CELLS_PER_BIN
    cubes -= cubes.min(axis=0)
    # One number to sort by, from what counts most to what counts least.
    key = near // NODES_PER_BIN + np.where(touchable, 0, int(near.max()) // NODES_PER_BIN + 1)
    for axis, extent in enumerate(cubes.max(axis=0) + 1):
        key = key * extent + cubes[:, axis]
    for axis in range(3):
        key = key * CELLS_PER_BIN + cells[:, axis] % CELLS_PER_BIN
    order = np.argsort(key, kind="stable")
    key = key[order]
    return order, np.concatenate([[0], np.cumsum(key[1:] != key[:-1])])
