"""The narrowings of all vessels of a tree, each once.

Which branch a vessel goes on in, and how wide vessels are beside each other, rough spheres tell as
well as exact ones; so they do where a vessel has no narrowing. Vessels that may have one are
measured exactly. Spheres that leave their vessel beside a throat count as what it is itself.

At a fork several vessels share a throat, which is that of the one from which the others come.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product

import numpy as np

from ..centerline import Centerline
from ..geometry import Surface
from ..lumen import NEARLY, InscribedSpheres, LocalSurface, with_own_spheres
from ..validation import Indices
from .branch_lumen import tree_lumen
from .caliber import EDGE_DEGREE, VesselWay, vessel_ways
from .narrowings import Narrowing, Plateau, narrowings
from .runs import VesselRun, vessel_runs
from .tree_around import limbs_of


def measured_runs(surface: Surface, centerline: Centerline) -> tuple[list[VesselRun], list[int]]:
    """The vessels of a tree as wide as they are themselves beside branches that leave at a throat.

    And the numbers of those that may have a narrowing. Errors as of `branch_lumens`.
    """
    tree = tree_lumen(surface, centerline)
    runs, wall = vessel_runs(tree.rough, limbs_of(centerline)), tree.spheres.surface
    stations = [tree.stations_of(run) for run in runs]
    own = own_runs(wall, runs, [tree.spheres.rough.at(which) for which in stations])
    asked = _asked(own)
    if asked:
        ends = np.cumsum([len(stations[number]) for number in asked])
        exact = tree.spheres.exact(np.concatenate([stations[number] for number in asked]))
        parts = [exact.at(part) for part in np.split(np.arange(ends[-1]), ends[:-1])]
        for number, run in zip(asked, own_runs(wall, [runs[n] for n in asked], parts), strict=True):
            own[number] = run
    return own, asked


def _asked(runs: Sequence[VesselRun]) -> list[int]:
    """Vessels with a possible narrowing, or with healthy vessel beside another's."""
    found, ways, numbers = set[int](), vessel_ways(runs), range(len(runs))
    every = [one for number in numbers for one in _of(ways[number], number, NEARLY - 1)]
    for one in every:
        found.add(one.vessel)
        found |= {one.way.vessel_at(side.arc_length) for side in one.sides if side is not None}
    found |= {limb.vessel for limb in _through(ways, numbers, every, NEARLY - 1)}
    return sorted(found)


def own_runs(
    wall: LocalSurface, runs: Sequence[VesselRun], spheres: Sequence[InscribedSpheres]
) -> list[VesselRun]:
    """Vessels with the spheres at their stations, except spheres that have left them.

    What is not known of a vessel stays so.
    """
    stations = np.concatenate([run.points for run in runs])
    ends = np.cumsum([len(run.along) for run in runs])
    lines: list[Indices] = np.split(np.arange(len(stations)), ends[:-1])
    centers = np.concatenate([found.centers for found in spheres])
    radii = np.concatenate([found.radii for found in spheres])
    is_known = np.isfinite(np.concatenate([run.diameter for run in runs]))
    found = InscribedSpheres(centers, np.where(is_known, radii, np.nan))
    ways = np.concatenate([run.line.directions for run in runs])
    diameter = 2 * with_own_spheres(wall, stations, ways, found, lines).radii
    return [run._replace(diameter=diameter[line]) for run, line in zip(runs, lines, strict=True)]


@dataclass(frozen=True)
class FoundNarrowing:
    """A narrowing of a vessel of the tree."""

    vessel: int
    way: VesselWay
    narrow: Narrowing
    limbs: tuple[FoundNarrowing, ...] = ()
    """Narrowings of other vessels in the same throat."""

    @property
    def run(self) -> VesselRun:
        """The vessel with what lies before and beyond it."""
        return self.way.run

    @property
    def sides(self) -> tuple[Plateau | None, Plateau | None]:
        """Healthy vessel proximal and distal of it."""
        return self.narrow.reference.proximal, self.narrow.reference.distal

    @cached_property
    def narrowest(self) -> int:
        """Index of its narrowest station."""
        return int(np.abs(self.run.along - self.narrow.narrowest).argmin())

    def is_on(self, way: VesselWay) -> bool:
        """Whether a way passes its narrowest place."""
        along = self.narrow.narrowest
        return way.vessel_at(along) == self.way.vessel_at(along)

    @cached_property
    def is_at_ostium(self) -> bool:
        """Whether it begins where the vessel leaves its parent."""
        known = np.flatnonzero(np.isfinite(self.run.diameter))
        return self.run.parent >= 0 and bool(self.narrow.start <= self.run.along[known[0]])

    @property
    def healthy(self) -> float:
        """Healthy diameter of its vessel where it is narrowest, mm."""
        return float(self.narrow.reference.at(np.array([self.narrow.narrowest]))[0])

    def is_tighter_than(self, other: FoundNarrowing) -> bool:
        """Whether its residual lumen is a smaller share than another one's, by more than an
        edge."""
        left, others = 1 - self.narrow.degree, 1 - other.narrow.degree
        return left <= (1 - EDGE_DEGREE) * others

    def holds(self, other: FoundNarrowing) -> bool:
        """Whether another one is narrowest in the lumen of this one.

        That is the healthy lumen, but for one that is tighter: what is left where this one is
        narrowest. Beside that an ostium in its wall may be narrower still.
        """
        along, start = self.run.along, -np.inf if self.is_at_ostium else self.narrow.start
        inner = (along >= start) & (along <= self.narrow.end)
        away = np.linalg.norm(self.run.points[inner] - other.run.points[other.narrowest], axis=1)
        wide = self.narrow.reference.at(along[inner])
        if other.is_tighter_than(self):
            wide = self.run.diameter[self.narrowest]
        return bool((away < wide / 2).any())

    def continues(self, other: FoundNarrowing) -> bool:
        """Whether another one goes on in this one, which is tighter: in one throat.

        Its vessel goes on in this one's, it is narrowest before that, and they are no farther apart
        than it is wide.
        """
        is_onward = self.way.begins[0][1] != self.vessel
        begins = self.way.begin_of(self.vessel)
        if self.way.parent != other.vessel or not is_onward or other.narrow.narrowest > begins:
            return False
        places = (one.run.points[one.narrowest] for one in (self, other))
        is_near = np.linalg.norm(np.subtract(*places)) < other.healthy
        return bool(is_near and self.is_tighter_than(other))


def found_narrowings(runs: Sequence[VesselRun], asked: Sequence[int]) -> list[FoundNarrowing]:
    """The narrowings of some vessels, each once.

    What is narrowest in the lumen of a vessel's own one is a limb of that: a vessel comes before
    branches, which begin in its wall. Where its throat goes on in one branch, and is tighter there,
    it is a limb of that one; one from which several go on is its own. Where a vessel's throat goes
    on beyond a fork, what the way into another branch passes before it is a limb, too.
    """
    ways = vessel_ways(runs)
    every = [one for number in asked for one in _of(ways[number], number)]
    onward: dict[int, list[FoundNarrowing]] = defaultdict(list)
    for one, above in product(every, every):
        if one.continues(above):
            onward[id(above)].append(one)
    kept: list[FoundNarrowing] = []
    throats: dict[int, FoundNarrowing] = {}
    for one in sorted(every, key=lambda one: (one.way.rank, -one.narrow.degree)):
        throat = next((other for other in kept if other.holds(one)), None)
        if len(onward[id(one)]) == 1:
            (throat,) = onward[id(one)]
        if throat is None:
            kept.append(one)
        else:
            throats[id(one)] = throat
    limbs = defaultdict(list)
    for one in every:
        throat = throats.get(id(one))
        throat = throats.get(id(throat), throat)
        if throat is not None and throat.vessel != one.vessel:
            limbs[id(throat)].append(one)
    for one in _through(ways, asked, every):
        throat = next((other for other in kept if other.holds(one)), None)
        if throat is not None and all(limb.vessel != one.vessel for limb in limbs[id(throat)]):
            limbs[id(throat)].append(one)
    return [replace(one, limbs=tuple(limbs[id(one)])) for one in kept]


def _of(
    way: VesselWay, vessel: int, eased: float = 0.0, own: tuple[float, float] | None = None
) -> list[FoundNarrowing]:
    """The narrowings on the way of a vessel that are narrowest in that, or between arc lengths."""
    found = narrowings(way.run, eased, own or way.own, way.leaving)
    return [FoundNarrowing(vessel, way, one) for one in found]


def _through(
    ways: Sequence[VesselWay],
    numbers: Iterable[int],
    known: Sequence[FoundNarrowing],
    eased: float = 0.0,
) -> Iterator[FoundNarrowing]:
    """Narrowings on the ways from a vessel into others, narrowest before these begin.

    Each is in the lumen of known ones of that vessel, which are narrowest beyond, aside of the way.
    """
    for number in numbers:
        way = ways[number]
        before = [one for one in known if way.parent in one.way.vessels]
        if not before or way.parent not in way.vessels:
            continue
        own = ways[way.parent].own[0], way.begin_of(number)
        for one in _of(way, number, eased, own):
            holding = [other for other in before if other.holds(one)]
            if holding and not any(other.is_on(way) for other in holding):
                yield one
