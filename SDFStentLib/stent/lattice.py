"""A stent to look at: rings and struts on its surface, of a design of our own.

No product looks like this: rings of zigzag struts, joined point to point (closed cells) or by
a few straight links (open cells).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..geometry import carried
from ..validation import Flags, Floats, Indices, InputError, Points, as_number, read_only
from .stent import Stent
from .stent_axis import StentAxis

LATTICE_CELLS = ("closed", "open")
"""Kinds of cells that can be drawn."""

PIECES = 6
"""Straight pieces of a strut, which follows the round surface."""

SLENDER = 1.7
"""Height of a ring over half the width of its cells, where the number of rings is free."""

MOST_RINGS = 500
"""Largest numbers of rings and crowns: beyond them nothing could be told apart in a drawing."""

GAP = 0.3
"""The gap of open cells: distance of two rings over the height of one."""


@dataclass(frozen=True)
class LatticeDesign:
    """Design of a stent's struts.

    Attributes
    ----------
    cells : {"closed", "open"}
        Whether neighboring rings are joined at every point, or by a few links.
    crowns : int
        Points of a ring on either side, 3 to 60.
    rings : int, optional
        Number of rings, at least 1; by default as many as make cells of usual proportions.
    link_every : int
        Crowns from one link of open cells to the next; divides their number.
    crimped_diameter : float
        Diameter before expansion, mm.

    Raises
    ------
    InputError
        Another kind of cell, or numbers out of range.
    """

    cells: str = "closed"
    crowns: int = 8
    rings: int | None = None
    link_every: int = 2
    crimped_diameter: float = 2.0

    def __post_init__(self) -> None:
        if self.cells not in LATTICE_CELLS:
            raise InputError(
                f"cells: expected one of {', '.join(LATTICE_CELLS)}, got {self.cells!r}; "
                "choose one."
            )
        limits = {"crowns": (3, 60), "rings": (1, MOST_RINGS), "link_every": (1, 60)}
        for name, (least, most) in limits.items():
            value = getattr(self, name)
            if value is not None and as_number(value, name, minimum=least, maximum=most) % 1:
                raise InputError(f"{name}: expected a whole number, got {value:g}; round it.")
        if self.crowns % self.link_every:
            raise InputError(
                f"link_every: expected a divisor of the {self.crowns} crowns, got "
                f"{self.link_every}; the links would not be even."
            )
        as_number(self.crimped_diameter, "crimped diameter", unit="mm", above=0, maximum=100)

    def expansion_at(self, radius: float, widest: float) -> float:
        """Expansion, 0 to 1, at a `radius`, of a stent that ends at `widest`, mm."""
        packed = min(self.crimped_diameter / 2, widest)
        return float(np.clip((radius - packed) / max(widest - packed, 1e-9), 0, 1))

    def ring_count(self, length: float, radius: float) -> int:
        """Number of rings of a deployed stent of that size, mm."""
        if self.rings is not None:
            return self.rings
        height = max(SLENDER * np.pi * radius / self.crowns, length / MOST_RINGS)
        return max(round(length / height), 2)


@dataclass(frozen=True, eq=False)
class Lattice:
    """Rings and struts of a stent, as lines.

    Attributes
    ----------
    points : (n, 3) array
        mm; where struts meet they share a point.
    lines : (m, p) array
        Points of every strut and link, from its proximal end.
    ring : (m,) array
        Number of the ring that a strut belongs to, from 0; of a link that of the ring before it.
    is_link : (m,) array
        Whether a line joins two rings.
    """

    points: Points
    lines: Indices
    ring: Indices
    is_link: Flags

    def __post_init__(self) -> None:
        for name in ("points", "lines", "ring", "is_link"):
            object.__setattr__(self, name, read_only(getattr(self, name)))

    @property
    def curves(self) -> Floats:
        """(m, p, 3) every line by its points, mm."""
        return np.asarray(self.points[self.lines])


def design_of(stent: Stent) -> LatticeDesign:
    """The design with the cells of the stent's device where they are known, else closed ones."""
    cells = None if stent.device is None else stent.device.cell
    return LatticeDesign(cells if cells in LATTICE_CELLS else "closed")


def stent_lattice(
    stent: Stent,
    axis: StentAxis,
    design: LatticeDesign | None = None,
    expansion: float = 1.0,
) -> Lattice:
    """The struts of a stent where it lies, between crimped and deployed.

    Parameters
    ----------
    stent : Stent
    axis : StentAxis
        Axis of the stent, with its profile where it is no cylinder.
    design : LatticeDesign, optional
        `design_of` the stent by default.
    expansion : float
        0 crimped, 1 deployed. Diameters grow in proportion. The length goes evenly from the nominal
        one to that of the axis; what the stent keeps when it shortens stays where it is.

    Raises
    ------
    InputError
        An expansion that is not from 0 to 1.
    """
    design = design_of(stent) if design is None else design
    done = as_number(expansion, "expansion", minimum=0, maximum=1)
    deployed, widest = axis.deployed_length, stent.widest_diameter / 2
    packed = min(design.crimped_diameter / 2, widest)
    share = (packed + done * (widest - packed)) / widest
    longer = 1 + (1 - done) * (axis.nominal_length / axis.prescribed_length - 1)

    def radius(fractions: Floats) -> Floats:
        if axis.profile is None:
            return np.full(len(fractions), share * stent.radius)
        return share * axis.profile.at(fractions) / 2

    rings = design.ring_count(deployed, stent.radius)
    straight = straight_lattice(deployed * longer, radius, replace(design, rings=rings))
    lost = deployed * (longer - 1)
    shift = {"center": 0.0, "proximal": lost / 2, "distal": -lost / 2}[stent.kept]
    placed = carried(straight.points, axis.line, middle=deployed / 2 + shift, window=stent.radius)
    return replace(straight, points=placed)


def laid_along(points: ArrayLike, stent: Stent, axis: StentAxis) -> Points:
    """A straight body, such as a mesh of a stent, laid where a deployed stent is.

    Parameters
    ----------
    points : array_like, shape (n, 3)
        mm: along z, its middle at z = 0. Sizes stay as they are.
    stent : Stent
    axis : StentAxis
        Axis of the stent.

    Returns
    -------
    array, shape (n, 3)
        See `carried`.
    """
    return carried(points, axis.line, window=stent.radius)


def straight_lattice(
    length: float, radius: float | Callable[[Floats], Floats], design: LatticeDesign
) -> Lattice:
    """The struts of a straight stent along z, its middle at 0.

    Parameters
    ----------
    length : float
        mm.
    radius : float or callable
        mm; or what gives it at fractions (n,) of the length.
    design : LatticeDesign

    Raises
    ------
    InputError
        A size that is not above 0.
    """
    total = as_number(length, "length", unit="mm", above=0)
    if not callable(radius):
        same = as_number(radius, "radius", unit="mm", above=0)
        return straight_lattice(total, lambda fractions: np.full(len(fractions), same), design)
    widest = float(np.max(radius(np.linspace(0, 1, 101))))
    heights, turns, ends, ring = _net(design, design.ring_count(total, widest))
    # Between its ends a strut rises evenly and turns evenly.
    steps = np.linspace(0, 1, PIECES + 1)[1:-1]
    rise = heights[ends[:, 0], None] + steps * np.diff(heights[ends])
    # The shorter way round; a whole turn has twice as many steps as there are crowns.
    around = 2 * design.crowns
    way = (np.diff(turns[ends]) + design.crowns) % around - design.crowns
    turn = turns[ends[:, 0], None] + steps * way
    inner = len(heights) + np.arange(rise.size).reshape(rise.shape)
    fractions = np.concatenate([heights, rise.ravel()])
    angle = np.concatenate([turns, turn.ravel()]) * np.pi / design.crowns
    own = radius(fractions)
    points = np.stack([own * np.cos(angle), own * np.sin(angle), (fractions - 0.5) * total], axis=1)
    lines = np.concatenate([ends[:, :1], inner, ends[:, 1:]], axis=1)
    return Lattice(points, lines, ring, way[:, 0] == 0)


class _Net(NamedTuple):
    """Nodes and struts of a net."""

    heights: Floats
    """(n,) fractions of the length."""
    turns: Indices
    """(n,) in steps of half a crown."""
    ends: Indices
    """(m, 2) points of every strut, then of every link."""
    ring: Indices
    """(m,)"""


def _net(design: LatticeDesign, rings: int) -> _Net:
    crown, number = np.arange(design.crowns), np.arange(rings)
    if design.cells == "closed":
        height = np.arange(rings + 1) / rings
        parity = np.arange(rings + 1) % 2
        below, above = number, number + 1
    else:
        tall = 1 / (rings + GAP * (rings - 1))
        foot = number * (1 + GAP) * tall
        height = np.stack([foot, foot + tall], axis=1).ravel()
        parity = np.stack([number % 2, (number + 1) % 2], axis=1).ravel()
        below, above = 2 * number, 2 * number + 1
    heights = np.repeat(height, design.crowns)
    turns = (2 * crown + parity[:, None]).ravel()
    start = (below[:, None] * design.crowns + crown)[..., None]
    # From every point below to its two neighbors above, half a crown to either side.
    beside = crown[:, None] + parity[below][:, None, None] + [0, -1]
    end = above[:, None, None] * design.crowns + beside % design.crowns
    pairs = [np.stack(np.broadcast_arrays(start, end), axis=-1).reshape(-1, 2)]
    ring = [np.repeat(number, 2 * design.crowns)]
    if design.cells == "open" and rings > 1:
        is_linked = (crown + number[:-1, None]) % design.link_every == 0
        before, which = np.nonzero(is_linked)
        pairs.append(
            np.stack([above[before], below[before + 1]], axis=1) * design.crowns + which[:, None]
        )
        ring.append(before)
    return _Net(heights, turns, np.concatenate(pairs), np.concatenate(ring))
