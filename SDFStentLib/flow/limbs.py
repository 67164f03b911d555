"""Meetings of limbs of a vessel: stretches of its lumen that end at others."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..centerline import Centerline, LumenStretch


def joined_limbs(
    stretches: Sequence[LumenStretch], centerline: Centerline
) -> tuple[list[LumenStretch], dict[int, int]]:
    """Stretches that are parted where limbs meet them again, and which ends limbs join.

    Returns
    -------
    list of LumenStretch
        Every one after that above it. Limbs go on to where they meet the others.
    dict of int to int
        By limb the stretch at whose end it ends.
    """
    found, joins = list(stretches), dict[int, int]()
    for leaf, meeting in centerline.loops.tolist():
        limb = _ending_at(found, centerline, leaf)
        # What has no lumen for itself is no limb.
        if limb is None:
            continue
        number, station = _nearest(found, centerline, meeting, limb)
        found[limb] = _up_to(found[limb], found[number], station)
        if 0 < station < len(found[number].points) - 1:
            found, joins = _parted(found, joins, number, station)
            limb += limb > number
        elif station == 0:
            number = found[number].above
        joins[limb] = number
    return found, joins


def _ending_at(stretches: Sequence[LumenStretch], tree: Centerline, leaf: int) -> int | None:
    branch = next(k for k, nodes in enumerate(tree.branches) if nodes[-1] == leaf)
    inner = {one.above for one in stretches}
    ending = (k for k, one in enumerate(stretches) if k not in inner and one.branch[-1] == branch)
    return next(ending, None)


def _nearest(
    stretches: Sequence[LumenStretch], tree: Centerline, node: int, limb: int
) -> tuple[int, int]:
    """Stretch and station nearest to a point of the tree."""
    place = tree.points[node]
    away = [
        (float(squared.min()), number, int(squared.argmin()))
        for number, one in enumerate(stretches)
        if number != limb
        for squared in [((one.points - place) ** 2).sum(axis=1)]
    ]
    _, number, station = min(away)
    return number, station


def _up_to(limb: LumenStretch, other: LumenStretch, station: int) -> LumenStretch:
    """A limb up to where it enters the lumen of another stretch, and on to its middle.

    In that lumen spheres are of the other vessel, as they are where a branch begins.
    """
    place, radius = other.points[station], np.nan_to_num(other.diameter[station] / 2)
    inside = np.linalg.norm(limb.points - place, axis=1) < radius
    outside = np.flatnonzero(~inside)
    kept = slice(int(outside[-1]) + 1 if len(outside) else 1)
    step = float(np.linalg.norm(place - limb.points[kept][-1]))
    if step == 0:
        return limb
    return limb._replace(
        points=np.vstack([limb.points[kept], place]),
        along=np.append(limb.along[kept], limb.along[kept][-1] + step),
        diameter=np.append(limb.diameter[kept], np.nan),
        branch=np.append(limb.branch[kept], limb.branch[-1]),
        branch_along=np.append(limb.branch_along[kept], limb.branch_along[-1]),
    )


def _parted(
    stretches: Sequence[LumenStretch], joins: dict[int, int], number: int, station: int
) -> tuple[list[LumenStretch], dict[int, int]]:
    """Stretches with one parted at a station; the numbers of later ones go up by one."""
    one = stretches[number]
    first, second = (
        one._replace(**{name: getattr(one, name)[part] for name in one._fields if name != "above"})
        for part in (slice(station + 1), slice(station, None))
    )

    def onward(k: int) -> int:
        """Index now of what was at the end of a stretch."""
        return k + (k >= number)

    moved = [other._replace(above=onward(other.above)) for other in stretches]
    found = [
        *moved[:number],
        first._replace(above=moved[number].above),
        second._replace(above=number),
        *moved[number + 1 :],
    ]
    return found, {k + (k > number): onward(end) for k, end in joins.items()}
