"""Vessels of a tree: what side branches leave goes on; what divides ends.

From the root a vessel goes on at each junction in the branch that continues it, and from the ostium
of every other branch another vessel begins. A branch is as wide as the widest healthy part of what
it leads to: a lesion at its begin makes it no side branch of the vessel that it continues.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import NamedTuple

import numpy as np

from ..centerline import SAME_CALIBER, USUAL, BranchLumen, LumenStretch, LumenTree, joined_lumens
from ..geometry import Line
from ..validation import Flags, Floats, Indices, Points

MURRAY_EXPONENT = 7 / 3
"""Healthy diameters at a junction: D^(7/3) of the trunk is the sum of those of its branches, for
flow goes with D^(7/3) in arterial trees of several organs and species (exponent 2 1/3 in
pmc.ncbi.nlm.nih.gov/articles/PMC2716468). Of four rules that of these authors agreed with
coronary bifurcations of all types (Huo et al., doi:10.4244/EIJV7I11A206)."""

MAIN = 0.1
"""Share of the flow out of the vessel at the root, by the rule above, from which on a vessel that
comes from it is a main one. The narrowest left pulmonary arteries of the anatomies have 0.19,
however wide the trunk is; one of 18 segments has 0.06."""

CONTINUES = 0.7
"""Share of what the rule above expects of a vessel beyond a side branch that it has at least: it
may taper over a narrowing. Half of the area."""

LOCAL = 4.0
"""Diameters before a junction in which the caliber of the vessel is looked for, and beyond one in
which healthy vessel is that of a narrowing."""


class SideBranch(NamedTuple):
    """A branch that leaves a vessel, or one of those into which it divides at its end."""

    arc_length: float
    """The arc length of the junction, from the root, mm."""
    caliber: float
    """mm."""
    branch: int
    """Index into `Centerline.branches` of its first one."""


class Leaving(NamedTuple):
    """A vessel that takes its share of the flow of another one."""

    arc_length: float
    """The arc length of the junction, from the root, mm."""
    caliber: float
    """mm."""


class VesselRun(NamedTuple):
    """Stations along one vessel, from the root's side on, and how it begins and ends."""

    line: Line
    """Line through the n stations."""
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
    """Branches into which it divides at its end; empty at an outlet."""
    parent: int
    """Index of the parent vessel; -1 for one that begins at a root."""
    generation: int
    """Number of vessels between it and the root."""
    caliber: float
    """Caliber of the widest healthy part that it leads to, mm; 0 where nothing is known."""
    outlets: int
    """The number of ends of the centerline to which it leads."""
    beside: tuple[float, ...] = ()
    """Calibers of the vessels that leave its parent where it begins, or go on there, mm."""

    @property
    def is_onward(self) -> bool:
        """Whether no much wider vessel begins beside it: its parent goes on in it, too."""
        return bool(self.beside) and self.caliber >= SAME_CALIBER * max(self.beside)

    @property
    def leaving(self) -> tuple[Leaving, ...]:
        """What leaves it, and what began beside it."""
        begins = [Leaving(float(self.along[0]), caliber) for caliber in self.beside]
        sides = [Leaving(one.arc_length, one.caliber) for one in self.side_branches]
        return (*begins, *sides)

    @property
    def points(self) -> Points:
        """(n, 3) mm."""
        return self.line.points


def vessel_runs(lumens: Sequence[BranchLumen], limbs: Collection[int] = ()) -> list[VesselRun]:
    """The vessels of a tree, every branch in one of them, parents before what leaves them.

    `limbs` as of `LumenTree`.
    """
    tree = LumenTree(joined_lumens(lumens).stretches, limbs)
    found: list[VesselRun] = []
    waiting = [(number, -1) for number in tree.roots]
    # Ends: every branch waits once at most.
    while waiting:
        first, parent = waiting.pop(0)
        run, leaving = _run(tree, first, parent, found[parent].generation + 1 if parent >= 0 else 0)
        found.append(run)
        waiting += [(number, len(found) - 1) for number in leaving]
    return found


def left_by(width: float, others: Sequence[float]) -> float:
    """Width of a vessel beyond others that leave it, by the rule of flow; 0 where they take all."""
    left = width**MURRAY_EXPONENT - sum(other**MURRAY_EXPONENT for other in others)
    return max(left, 0.0) ** (1 / MURRAY_EXPONENT)


def _usual_near(diameter: Floats, distance: Floats, otherwise: float) -> float:
    """The usual one of the diameters (n,) that are not far from a junction; NaN are unknown."""
    near = diameter[distance <= LOCAL * diameter]
    return float(np.quantile(near, USUAL)) if len(near) else otherwise


def is_main(run: VesselRun, runs: Sequence[VesselRun]) -> bool:
    """Whether a vessel begins at the root, or is one of the large ones that come from that."""
    if run.generation != 1:
        return run.generation == 0
    root = runs[run.parent]
    leaving = [one.caliber for one in (*root.side_branches, *root.division)]
    if not root.division:
        leaving.append(root.caliber)
    flow = np.array(leaving) ** MURRAY_EXPONENT
    return bool(run.caliber**MURRAY_EXPONENT >= MAIN * flow.sum())


def _continuation(tree: LumenTree, chain: Sequence[int]) -> int | None:
    """The child that continues a vessel which has come so far; None where it ends."""
    children = tree.children[chain[-1]]
    if not children:
        return None
    first, *others = sorted((float(tree.calibers[number]) for number in children), reverse=True)
    here = max(_local_caliber(tree, chain), first)
    expected = left_by(here, others)
    # A branch of which nothing is known may be as wide.
    is_twig = not others or 0 < others[0] < SAME_CALIBER * first
    ends = first < (CONTINUES * expected if is_twig else SAME_CALIBER * here)
    return None if ends else tree.straightest(chain[-1], tree.alike(chain[-1]))


def _local_caliber(tree: LumenTree, chain: Sequence[int]) -> float:
    """The widest of a vessel's own usual diameters not far above its end."""
    lumens = [tree.lumens[number] for number in chain]
    diameter = np.concatenate(
        [np.where(tree.own[n], tree.lumens[n].diameter, np.nan) for n in chain]
    )
    along = np.concatenate([lumen.along for lumen in lumens])
    return _usual_near(diameter, along[-1] - along, float(tree.calibers[chain[-1]]))


def _run(tree: LumenTree, first: int, parent: int, generation: int) -> tuple[VesselRun, list[int]]:
    """A vessel from its first branch on, and the branches with which others begin."""
    chain, leaving, sides = [first], [], []
    # Ends: at a leaf at the latest.
    while (onward := _continuation(tree, chain)) is not None:
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
        Line(np.concatenate([lumen.points for lumen in lumens])[kept]),
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
        tuple(float(tree.calibers[one]) for one in _siblings(tree, first)),
    )
    return run, leaving + division


def _siblings(tree: LumenTree, number: int) -> list[int]:
    """Other branches of the tree that leave where this one does."""
    above = tree.lumens[number].above
    return [] if above < 0 else [one for one in tree.children[above] if one != number]


def _ostium(lumen: LumenStretch, is_own: Flags) -> int:
    """The station at which a vessel leaves its parent, whose lumen is wide.

    A throat at the ostium may lie within the parent's sphere, and is this vessel's all the same.
    """
    if not is_own.any():
        return len(is_own)
    first = int(np.argmax(is_own))
    before = np.where(np.isfinite(lumen.diameter[:first]), lumen.diameter[:first], np.inf)
    narrowest = int(np.argmin(before)) if first else 0
    return narrowest if first and before[narrowest] < lumen.diameter[first] else first


def _side_branch(tree: LumenTree, number: int) -> SideBranch:
    lumen = tree.lumens[number]
    return SideBranch(float(lumen.along[0]), float(tree.calibers[number]), int(lumen.branch[-1]))
