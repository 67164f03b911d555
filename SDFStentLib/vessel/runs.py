"""Vessels of a tree: what side branches leave goes on; what divides ends.

From the root a vessel goes on at each junction in the branch that continues it, and from the ostium
of every other branch another vessel begins. A branch is as wide as the widest healthy part of what
it leads to: a lesion at its begin makes it no side branch of the vessel that it continues.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..validation import Flags, Floats, Indices, Points
from .branch_lumen import BranchLumen
from .stretches import Stretch, stretches

MURRAY_EXPONENT = 7 / 3
"""Healthy diameters at a junction: D^(7/3) of the trunk is the sum of those of its branches, for
flow goes with D^(7/3) in arterial trees of several organs and species (exponent 2 1/3 in
pmc.ncbi.nlm.nih.gov/articles/PMC2716468). Of four rules that of these authors agreed with
coronary bifurcations of all types (Huo et al., doi:10.4244/EIJV7I11A206)."""

SAME_CALIBER = 0.8
"""Share of the caliber that the rule above leaves a vessel from which a branch continues it; also
the share of the widest branch's caliber from which another one is alike."""

LOCAL = 4.0
"""Diameters above a junction over which the caliber of the vessel that comes is looked for."""

_USUAL = 0.67
"""Quantile of a branch's own diameters that is its caliber, if what it leads to is no wider:
above that of a lesion of up to two thirds of its length."""

_JUNCTION = 6.0
"""Radii of a junction within which the vessels that meet there may lie in one another."""


class SideBranch(NamedTuple):
    """A branch that leaves a vessel, or one of those into which it divides at its end."""

    arc_length: float
    """Of the junction, from the root, mm."""
    caliber: float
    """mm."""
    branch: int
    """Index into `Centerline.branches` of its first one."""


class VesselRun(NamedTuple):
    """Stations along one vessel, from the root's side on, and how it begins and ends."""

    points: Points
    """(n, 3) mm."""
    along: Floats
    """(n,) arc length from the root, mm."""
    diameter: Floats
    """(n,) inscribed, mm; NaN where it is unknown or that of another vessel."""
    branch: Indices
    """(n,) index into `Centerline.branches`."""
    branch_along: Floats
    """(n,) arc length from the start of that branch, mm."""
    side_branches: tuple[SideBranch, ...]
    division: tuple[SideBranch, ...]
    """Into what it divides where it ends; empty at an outlet."""
    parent: int
    """Index of the vessel from which it comes; -1 for one that begins at a root."""
    generation: int
    """How many vessels lie between it and the root."""
    caliber: float
    """Of the widest healthy part of what it leads to, mm; 0 where nothing is known."""
    outlets: int
    """To how many ends of the centerline it leads."""


def vessel_runs(lumens: Sequence[BranchLumen]) -> list[VesselRun]:
    """The vessels of a tree, every branch in one of them, parents before what leaves them."""
    tree = _Tree(stretches(lumens))
    found: list[VesselRun] = []
    waiting = [(number, -1) for number in tree.roots]
    # Ends: every branch waits once at most.
    while waiting:
        first, parent = waiting.pop(0)
        run, leaving = _run(tree, first, parent, found[parent].generation + 1 if parent >= 0 else 0)
        found.append(run)
        waiting += [(number, len(found) - 1) for number in leaving]
    return found


class _Tree:
    """Stretches of lumen with their children, own diameters and calibers."""

    def __init__(self, lumens: Sequence[Stretch]) -> None:
        self.lumens = lumens
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
            usual = float(np.quantile(own, _USUAL)) if len(own) else 0.0
            calibers[number] = max([usual, *calibers[self.children[number]]])
        return calibers

    def _outlets(self) -> list[int]:
        counts = [0] * len(self.lumens)
        for number in reversed(range(len(self.lumens))):
            counts[number] = sum(counts[child] for child in self.children[number]) or 1
        return counts

    def continuation(self, chain: Sequence[int]) -> int | None:
        """The child that continues a vessel which has come so far; None where it ends."""
        children = sorted(self.children[chain[-1]], key=lambda n: -float(self.calibers[n]))
        if not children:
            return None
        first, *others = (float(self.calibers[number]) for number in children)
        here = max(self._local_caliber(chain), first)
        left = here**MURRAY_EXPONENT - sum(other**MURRAY_EXPONENT for other in others)
        expected = max(left, 0.0) ** (1 / MURRAY_EXPONENT)
        are_alike = bool(others) and others[0] >= SAME_CALIBER * first
        ends = first < SAME_CALIBER * (here if are_alike else expected)
        if ends:
            return None
        if are_alike:
            wide = [n for n in children if self.calibers[n] >= SAME_CALIBER * first]
            turns = [self._straightness(chain[-1], n) for n in wide]
            return wide[int(np.argmax(turns))]
        return children[0]

    def _local_caliber(self, chain: Sequence[int]) -> float:
        """The widest of a vessel's own usual diameters not far above its end."""
        lumens = [self.lumens[number] for number in chain]
        diameter = np.concatenate(
            [np.where(self.own[n], self.lumens[n].diameter, np.nan) for n in chain]
        )
        along = np.concatenate([lumen.along for lumen in lumens])
        distance = along[-1] - along
        near = diameter[(distance <= LOCAL * diameter) & np.isfinite(diameter)]
        return float(np.quantile(near, _USUAL)) if len(near) else float(self.calibers[chain[-1]])

    def _straightness(self, above: int, child: int) -> float:
        """Cosine of the turn from one branch into another, over a caliber on both sides."""
        reach = float(self.calibers[child])
        before, after = self.lumens[above], self.lumens[child]
        node = before.points[-1]
        ways = [
            node - before.points[int(np.searchsorted(before.along, before.along[-1] - reach))],
            _point_after(after, reach) - node,
        ]
        lengths = [float(np.linalg.norm(way)) for way in ways]
        return float(ways[0] @ ways[1]) / max(lengths[0] * lengths[1], 1e-300)


def _point_after(lumen: Stretch, reach: float) -> Floats:
    at = int(np.searchsorted(lumen.along, lumen.along[0] + reach))
    return np.asarray(lumen.points[min(at, len(lumen.along) - 1)])


def _is_inside(lumen: Stretch, other: Stretch) -> Flags:
    """Which stations (n,) of a branch lie in the lumen of another that meets it at its start."""
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


def _run(tree: _Tree, first: int, parent: int, generation: int) -> tuple[VesselRun, list[int]]:
    """A vessel from its first branch on, and the branches with which others begin."""
    chain, leaving, sides = [first], [], []
    # Ends: at a leaf at the latest.
    while (onward := tree.continuation(chain)) is not None:
        others = [number for number in tree.children[chain[-1]] if number != onward]
        sides += [_side_branch(tree, number) for number in others]
        leaving += others
        chain.append(onward)
    division = tree.children[chain[-1]]
    lumens = [tree.lumens[number] for number in chain]
    along = np.concatenate([lumen.along for lumen in lumens])
    # Where two branches join, the junction's own station is there twice.
    kept = np.r_[True, np.diff(along) > 0]
    diameter = np.concatenate([lumen.diameter for lumen in lumens])
    if parent >= 0:
        diameter[: _ostium(lumens[0], tree.own[first])] = np.nan
    run = VesselRun(
        np.concatenate([lumen.points for lumen in lumens])[kept],
        along[kept],
        diameter[kept],
        np.concatenate([lumen.branch for lumen in lumens])[kept],
        np.concatenate([lumen.branch_along for lumen in lumens])[kept],
        tuple(sides),
        tuple(_side_branch(tree, number) for number in division),
        parent,
        generation,
        float(tree.calibers[first]),
        tree.outlets[first],
    )
    return run, leaving + division


def _ostium(lumen: Stretch, is_own: Flags) -> int:
    """At which station a vessel leaves its parent, whose lumen is wide.

    A throat at the ostium may lie within the parent's sphere, and is this vessel's all the same.
    """
    if not is_own.any():
        return len(is_own)
    first = int(np.argmax(is_own))
    before = np.where(np.isfinite(lumen.diameter[:first]), lumen.diameter[:first], np.inf)
    narrowest = int(np.argmin(before)) if first else 0
    return narrowest if first and before[narrowest] < lumen.diameter[first] else first


def _side_branch(tree: _Tree, number: int) -> SideBranch:
    lumen = tree.lumens[number]
    return SideBranch(float(lumen.along[0]), float(tree.calibers[number]), int(lumen.branch[-1]))
