"""Tree of lumens: the width of each with all that it leads to, and the children it may go on in."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from ..validation import Flags, Floats
from .branch_lumen import UNKNOWN_RADIUS
from .stretches import LumenStretch

SAME_CALIBER = 0.8
"""Share of the widest branch's caliber from which on another branch counts as alike."""

USUAL = 0.67
"""Quantile of a branch's own diameters taken as its caliber, unless it leads to a wider one: a
lesion of up to two thirds of its length does not lower it."""

_JUNCTION = 6.0
"""Distance from a junction, in radii, within which its vessels may lie in one another."""


class LumenTree:
    """Stretches of lumen with their children, own diameters and calibers.

    Parameters
    ----------
    lumens : sequence of LumenStretch
        Stretches, each after the one above it.
    limbs : collection of int, optional
        Branches of the centerline that end where they meet the vessel again.

    Attributes
    ----------
    children : list of lists of int
    roots : list of int
    own : list of (n,) arrays of bool
        Whether each station lies outside of other vessels.
    calibers : (k,) array
        Diameter of the widest healthy part that a stretch leads to, mm; 0 where nothing is known.
    outlets : list of int
        Number of ends of the vessel to which a stretch leads; 1 for a limb.
    """

    def __init__(self, lumens: Sequence[LumenStretch], limbs: Collection[int] = ()) -> None:
        self.lumens, self._limbs = lumens, limbs
        self.children: list[list[int]] = [[] for _ in lumens]
        self.roots: list[int] = []
        for number, lumen in enumerate(lumens):
            (self.roots if lumen.above < 0 else self.children[lumen.above]).append(number)
        self.own = [np.isfinite(lumen.diameter) for lumen in lumens]
        self._part()
        self.calibers, self.outlets = self._calibers(), self._outlets()

    def _part(self) -> None:
        """Leave out stations inside of another vessel that meets theirs where they begin."""
        for above, children in enumerate(self.children):
            for child in children:
                for other in (above, *(one for one in children if one != child)):
                    self.own[child] &= ~_is_inside(self.lumens[child], self.lumens[other])

    def _calibers(self) -> Floats:
        calibers = np.zeros(len(self.lumens))
        # Those farther from the root are known before those above.
        for number in reversed(range(len(self.lumens))):
            own = self.lumens[number].diameter[self.own[number]]
            usual = float(np.quantile(own, USUAL)) if len(own) else 0.0
            calibers[number] = max([usual, *calibers[self.children[number]]])
        return calibers

    def _outlets(self) -> list[int]:
        counts = [0] * len(self.lumens)
        for number in reversed(range(len(self.lumens))):
            # A limb that meets the vessel again is no end of it.
            is_end = not self.children[number] and self.lumens[number].branch[-1] not in self._limbs
            counts[number] = is_end + sum(counts[child] for child in self.children[number])
        return [count or 1 for count in counts]

    def alike(self, number: int) -> list[int]:
        """The children of a stretch that may continue it: the widest one and those about as wide.

        The widest come first, and the longer of equals.
        """
        children = sorted(self.children[number], key=lambda one: -self.lumens[one].along[-1])
        children.sort(key=lambda child: -float(self.calibers[child]))
        limit = SAME_CALIBER * self.calibers[children[0]]
        return [child for child in children if self.calibers[child] >= limit]

    def straightest(self, number: int, children: Sequence[int]) -> int:
        """The one of some children that turns least; the first of equals."""
        turns = [round(self._straightness(number, child), 9) for child in children]
        return children[int(np.argmax(turns))]

    def _straightness(self, above: int, child: int) -> float:
        """Cosine of the turn from one branch into another, over a caliber on both sides."""
        reach = float(self.calibers[child]) or 2 * UNKNOWN_RADIUS
        before, after = self.lumens[above], self.lumens[child]
        node = before.points[-1]
        ways = [
            node - before.points[int(np.searchsorted(before.along, before.along[-1] - reach))],
            _point_after(after, reach) - node,
        ]
        lengths = [float(np.linalg.norm(way)) for way in ways]
        return float(ways[0] @ ways[1]) / max(lengths[0] * lengths[1], 1e-300)


def _point_after(lumen: LumenStretch, reach: float) -> Floats:
    at = int(np.searchsorted(lumen.along, lumen.along[0] + reach))
    return np.asarray(lumen.points[min(at, len(lumen.along) - 1)])


def _is_inside(lumen: LumenStretch, other: LumenStretch) -> Flags:
    """Whether each station (n,) of a branch lies in the lumen of another that meets it at its
    start."""
    node, radius = lumen.points[0], other.diameter / 2
    away = np.linalg.norm(other.points - node, axis=1)
    known = np.isfinite(radius)
    found = np.zeros(len(lumen.points), dtype=bool)
    if not known.any():
        return found
    reach = _JUNCTION * radius[known][np.argmin(away[known])]
    wall = known & (away <= reach)
    near = np.flatnonzero(lumen.along - lumen.along[0] <= reach)
    between = np.linalg.norm(lumen.points[near, None] - other.points[None, wall], axis=2)
    found[near] = (between < radius[wall]).any(axis=1)
    return found
