"""Branches beside the stents of a treatment: each once, with its coverage by all stents."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from ..geometry import Line
from ..lumen import ExtendedAxis
from ..validation import Floats
from ..vessel import LISTED, NeighborLumen, Ostium
from .profile import Stage
from .value import PlacedStent, TreatedStent

_APART = 0.5
"""Distance of axes, in a stent's radii, within which another one lies in the same vessel."""

_SPACING = 0.1
"""The distance of the places of another stent that are looked at, mm."""


def covered_by_all(
    branches: Iterable[Ostium], axis: ExtendedAxis, stents: Iterable[Stage | PlacedStent]
) -> tuple[Ostium, ...]:
    """The ostia beside one stent, with the share that some cover together, which may be one.

    Parameters
    ----------
    branches : iterable of Ostium
    axis : ExtendedAxis
        Axis of the stent beside which they are.
    stents : iterable of Stage or PlacedStent
        Stents that cover, it or others.
    """
    along = [_along(axis, stent)[0] for stent in stents]
    spans = [(float(some.min()), float(some.max())) for some in along if len(some)]
    return tuple(replace(one, covered_share=one.share_within(spans)) for one in branches)


def _along(axis: ExtendedAxis, stent: Stage | PlacedStent) -> tuple[Floats, bool]:
    """Arc lengths (n,) of a stent on an axis in its vessel, mm, and whether all of it is there."""
    near = axis.line.nearest(Line(stent.axis.points).resampled(_SPACING).points)
    is_there = near.distances < _APART * stent.stent.radius
    return near.arc_lengths[is_there] - axis.before, bool(is_there.all())


def covered_where_moved(
    treated: TreatedStent, moved: PlacedStent, stents: Iterable[PlacedStent]
) -> tuple[int, int] | None:
    """Numbers of branches beside a stent that were covered, and that some stents cover now.

    None where it has moved to where nobody has looked for branches.
    """
    along, is_known = _along(treated.way, moved)
    reach = -LISTED, treated.axis.deployed_length + LISTED
    if not is_known or along.min() < reach[0] or along.max() > reach[1]:
        return None
    now = covered_by_all(treated.branches, treated.way, stents)
    before, after = (sum(not one.is_free for one in some) for some in (treated.branches, now))
    return before, after


class BranchBeside(NamedTuple):
    """A branch beside one stent or more."""

    stents: tuple[int, ...]
    """Numbers of the stents."""
    nearest: int
    """Number of the stent from which its place counts."""
    ostium: Ostium
    """The ostium as seen from there, but its share as the first of them found it: before others
    changed it."""
    lumen: NeighborLumen | None
    """The lumen where it lost most; None where its wall has not moved."""
    narrowed_by: tuple[int, ...]
    """Numbers of the stents on whose way it is narrowed."""


def branches_beside(stents: Sequence[TreatedStent]) -> tuple[BranchBeside, ...]:
    """The branches beside some stents, each once, in the order in which stents come to them."""
    groups: list[list[tuple[TreatedStent, Ostium]]] = []
    for stent in stents:
        for ostium in stent.branches:
            known = [
                group
                for group in groups
                if group[-1][0] is not stent and any(ostium.is_same(one) for _, one in group)
            ]
            if known:
                known[0].append((stent, ostium))
            else:
                groups.append([(stent, ostium)])
    return tuple(map(_once, groups))


def _once(views: Sequence[tuple[TreatedStent, Ostium]]) -> BranchBeside:
    nearest, seen = min(views, key=lambda view: _beyond(*view))
    ostium = replace(seen, covered_share=views[0][1].covered_share)
    found = {stent.number: lumen_into(own, stent) for stent, own in views}
    lumens = {number: one for number, one in found.items() if one and not np.isnan(one.before)}
    losses = {number: np.nan_to_num(lumen.loss, nan=-np.inf) for number, lumen in lumens.items()}
    worst = max(losses, key=losses.__getitem__, default=None)
    return BranchBeside(
        tuple(stent.number for stent, _ in views),
        nearest.number,
        ostium,
        None if worst is None else replace(lumens[worst], name=ostium.name),
        tuple(number for number, lumen in lumens.items() if lumen.is_narrowed),
    )


def lumen_into(ostium: Ostium, stent: TreatedStent) -> NeighborLumen | None:
    """The lumen of a branch beside a stent; None where its wall has not moved."""
    # Two branches may have one name.
    alike = [branch for branch in stent.branches if branch.name == ostium.name]
    for lumen in stent.neighbors:
        if lumen.name == ostium.name and ostium is min(alike, key=partial(_away, lumen)):
            return lumen
    return None


def _away(lumen: NeighborLumen, ostium: Ostium) -> float:
    """Distance at which a way passes the middle of an ostium, mm."""
    return float(lumen.path.nearest(ostium.center[None]).distances[0])


def _beyond(stent: TreatedStent, ostium: Ostium) -> float:
    """Distance from the middle of an ostium to a stent's nearer end, mm; 0 beside the stent."""
    middle = (ostium.start + ostium.end) / 2
    return max(-middle, middle - stent.axis.deployed_length, 0.0)
