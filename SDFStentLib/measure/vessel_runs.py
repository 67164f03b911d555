"""Branches of a tree joined to vessels: what a small side branch leaves does not end there.

Roots do not matter here. At a place where several branches meet, the widest is the trunk, wherever
the centerline begins; a line that is stored backward gives the same vessels.
"""

from __future__ import annotations

from statistics import median
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..validation import Points
from .tree_lumen import END_REACH, BranchLumen

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

SMALL_SIDE_BRANCH = 0.5
"""Up to this share of a vessel's diameter a side branch leaves the vessel as it is: by
`MURRAY_EXPONENT` the vessel is 8 % wider above it."""

MURRAY_EXPONENT = 7 / 3
"""Healthy diameters at a junction: D^(7/3) of the trunk is the sum of those of its branches, for
flow goes with D^(7/3) in arterial trees of several organs and species (exponent 2 1/3 in
pmc.ncbi.nlm.nih.gov/articles/PMC2716468). Of four rules that of these authors agreed with
coronary bifurcations of all types (Huo et al., doi:10.4244/EIJV7I11A206)."""

JUNCTION_REACH = 2.0
"""Inscribed radii of a junction over which its branches still share one lumen: on the three
anatomies their sections part 1.6 to 2.0 radii beyond it."""

PROBED = 3.0
"""Diameters of a junction beyond its reach over which its branches' width is looked at."""


class VesselEnd(NamedTuple):
    """How a vessel ends: at a cap or at a junction, as its trunk or as one of its branches."""

    node: int
    """The centerline point where it ends."""
    is_junction: bool
    is_trunk: bool
    expected: float
    """Healthy diameter of a trunk by its branches' diameters, mm; NaN elsewhere."""


class VesselRun(NamedTuple):
    """Stations along a vessel from end to end, across its small side branches."""

    points: Points
    """(n, 3) mm."""
    along: Floats
    """(n,) arc length, mm."""
    diameter: Floats
    """(n,) inscribed, mm; NaN where it is unknown or touches a cap."""
    steady: Floats
    """(n,) the median over half a diameter: what is taken for a reference, mm."""
    is_apart: Bools
    """(n,) whether the place is outside of the junctions at the vessel's ends."""
    branch: NDArray[np.int64]
    """(n,) index into `Centerline.branches`."""
    branch_along: Floats
    """(n,) arc length from the start of that branch, mm."""
    from_root: Floats
    """(n,) arc length from the root, mm."""
    ends: tuple[VesselEnd, VesselEnd]


class _Arm(NamedTuple):
    """A branch as it leaves a junction; `end` is 0 where it starts there and 1 where it ends."""

    number: int
    end: int


_Meeting = dict[int, list[_Arm]]


def vessel_runs(lumens: tuple[BranchLumen, ...]) -> list[VesselRun]:
    """The vessels of a tree, every branch in one of them."""
    meetings: _Meeting = {}
    for number, lumen in enumerate(lumens):
        for end, node in enumerate(lumen.nodes):
            meetings.setdefault(node, []).append(_Arm(number, end))
    lumens = _without_caps(lumens, [arms[0] for arms in meetings.values() if len(arms) == 1])
    ends: dict[_Arm, VesselEnd] = {}
    onward: dict[_Arm, _Arm] = {}
    reach: dict[_Arm, float] = {}
    for node, arms in meetings.items():
        if len(arms) == 1:
            ends[arms[0]] = VesselEnd(node, False, False, np.nan)
            continue
        radius = max(_at_junction(lumens, arm) for arm in arms) / 2
        widths = [_widths(lumens, arm, radius) for arm in arms]
        trunk = int(np.argmax([narrowest for narrowest, _ in widths]))
        widest = np.array([widest for _, widest in widths])
        order = np.argsort(-widest, kind="stable")
        if len(arms) == 2 or widest[order[2]] <= SMALL_SIDE_BRANCH * widest[order[1]]:
            first, second = arms[order[0]], arms[order[1]]
            onward[first], onward[second] = second, first
        beside = np.delete([narrowest for narrowest, _ in widths], trunk)
        expected = float(np.sum(beside**MURRAY_EXPONENT) ** (1 / MURRAY_EXPONENT))
        for place, arm in enumerate(arms):
            ends[arm] = VesselEnd(
                node, True, place == trunk, expected if place == trunk else np.nan
            )
            reach[arm] = JUNCTION_REACH * radius
    return [_run(lumens, chain, ends, reach) for chain in _chains(len(lumens), onward)]


def steady(along: Floats, diameter: Floats) -> Floats:
    """Median of the known diameters within a quarter of a diameter on both sides."""
    values = np.full(len(along), np.nan)
    known = np.flatnonzero(np.isfinite(diameter))
    at, widths = along[known], diameter[known]
    low, high = (np.searchsorted(at, at + side * widths / 4) for side in (-1, 1))
    high = np.maximum(high, np.arange(len(known)) + 1)
    # Of so few values a plain sort is a tenth of NumPy's work.
    listed = widths.tolist()
    windows = zip(low.tolist(), high.tolist(), strict=True)
    values[known] = [median(listed[first:after]) for first, after in windows]
    return values


def _without_caps(lumens: tuple[BranchLumen, ...], arms: list[_Arm]) -> tuple[BranchLumen, ...]:
    """Without the diameters that a cap may limit, at the ends of some branches."""
    found = list(lumens)
    for arm in arms:
        lumen = found[arm.number]
        distance = lumen.along if arm.end == 0 else lumen.along[-1] - lumen.along
        is_near = distance < END_REACH * lumen.diameter / 2
        found[arm.number] = lumen._replace(diameter=np.where(is_near, np.nan, lumen.diameter))
    return tuple(found)


def _at_junction(lumens: tuple[BranchLumen, ...], arm: _Arm) -> float:
    known = _outward(lumens, arm)[1]
    known = known[np.isfinite(known)]
    return float(known[0]) if len(known) else 0.0


def _outward(lumens: tuple[BranchLumen, ...], arm: _Arm) -> tuple[Floats, Floats]:
    """Distances from the junction and the diameters there."""
    lumen = lumens[arm.number]
    if arm.end == 0:
        return lumen.along, lumen.diameter
    return (lumen.along[-1] - lumen.along)[::-1], lumen.diameter[::-1]


def _widths(lumens: tuple[BranchLumen, ...], arm: _Arm, radius: float) -> tuple[float, float]:
    """The narrowest and the widest diameter of an arm beyond a junction's reach.

    A lesion makes the narrowest smaller, an aneurysm the widest larger: the first tells a trunk
    from its branches, the second a small branch from one with a lesion.
    """
    distance, diameter = _outward(lumens, arm)
    known = np.isfinite(diameter)
    distance, diameter = distance[known], diameter[known]
    start = JUNCTION_REACH * radius
    beyond = diameter[(distance >= start) & (distance <= start + 2 * PROBED * radius)]
    if len(beyond):
        return float(beyond.min()), float(beyond.max())
    widest = float(diameter.max(initial=0.0))
    return widest, widest


def _chains(count: int, onward: dict[_Arm, _Arm]) -> list[list[_Arm]]:
    """Branches in order along each vessel; an arm here is the end at which a branch is entered."""
    chains, used = [], set()
    for number in range(count):
        if number in used:
            continue
        start = _Arm(number, 0)
        # Ends: arms are joined in pairs, so segments form chains, or rings back to this one.
        while start in onward and onward[start].number != number:
            before = onward[start]
            start = _Arm(before.number, 1 - before.end)
        chain = [start]
        # Ends: as above.
        while (leaving := _Arm(chain[-1].number, 1 - chain[-1].end)) in onward:
            if onward[leaving].number == start.number:
                break
            chain.append(onward[leaving])
        used |= {arm.number for arm in chain}
        chains.append(chain)
    return chains


def _run(
    lumens: tuple[BranchLumen, ...],
    chain: list[_Arm],
    ends: dict[_Arm, VesselEnd],
    reach: dict[_Arm, float],
) -> VesselRun:
    parts: list[tuple[NDArray[np.generic], ...]] = []
    length = 0.0
    for arm in chain:
        lumen, way = lumens[arm.number], slice(None, None, -1 if arm.end else 1)
        distance, diameter = _outward(lumens, arm)
        number = np.full(len(distance), lumen.branch)
        on_branch = lumen.along[way]
        columns = (lumen.points[way], length + distance, diameter, number)
        parts.append((*columns, on_branch, lumen.start + on_branch))
        length += float(distance[-1])
    first, last = chain[0], _Arm(chain[-1].number, 1 - chain[-1].end)
    points, at, width, branch, branch_along, from_root = map(
        np.concatenate, zip(*parts, strict=True)
    )
    # Where two branches join, the junction's own station is there twice.
    kept = np.r_[True, np.diff(at) > 0]
    at, width = at[kept], width[kept]
    is_apart = np.ones(len(at), dtype=bool)
    for arm, distance in ((first, at), (last, length - at)):
        is_apart &= distance >= reach.get(arm, 0.0)
    return VesselRun(
        points[kept],
        at,
        width,
        steady(at, width),
        is_apart,
        branch[kept],
        branch_along[kept],
        from_root[kept],
        (ends[first], ends[last]),
    )
