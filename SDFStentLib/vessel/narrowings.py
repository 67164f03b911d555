"""Narrowings of one vessel: minima of its caliber, by their persistence.

A narrowing is a minimum beyond which the vessel becomes wider again on both sides, on the one where
it becomes wider least by `SMALLEST_DEGREE` (the persistence of a minimum in a merge tree); at the
ostium of a side branch, and where an in- or outlet cuts it off as it begins to widen, the other
side alone tells, by `SMALLEST_ONE_SIDED`. It is measured between its shoulders, where the flank has
stopped becoming less steep, interpolated, beyond junctions, too, where a vessel goes on there.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ..centerline import USUAL
from ..validation import Floats
from .caliber import ANEURYSM, EDGE_DEGREE, KEPT, Basin, Caliber, basins, caliber_of
from .runs import LOCAL, MURRAY_EXPONENT, Leaving, VesselRun, left_by

SMALLEST_DEGREE = 0.15
"""Persistence of a narrowing, of the diameter; less is the unevenness of healthy vessels and of
segmentations."""

SMALLEST_ONE_SIDED = 0.35
"""Degree at an ostium, or where a vessel divides: of 252 side branches of a measured tree that
nobody narrowed half begin 4 % narrower than they go on, one in ten 26 %, one in fifty 34 %, and one
41 %."""

SMALLEST_ONWARD = 0.2
"""Degree where a vessel begins in which its parent goes on: 24 that nobody narrowed begin by 10 to
13 % narrower, one by 25 %."""

SMALLEST_ALONE = 0.5
"""Degree of a vessel between two junctions, against its branches: of 547 that nobody narrowed half
are 4 to 13 % narrower, one in fifty 33 to 41 %, none 50 %."""

ONE_SIDED_REACH = 2.0
"""Diameters within which a vessel is wider again beyond an ostium: what widens more slowly than
that tapers."""

REGAINED = 0.5
"""Share of what a narrowing loses, on the side where it becomes wider least, that healthy vessel
has regained: the valley between two throats has less."""

SETTLED = 0.02
"""Share of its flank's steepest slope by which a shoulder becomes less steep beyond at most; what
does so by more is flank yet. Bells of up to 95 % are measured against healthy vessel to 1 %."""


class Plateau(NamedTuple):
    """Healthy vessel on one side of a narrowing."""

    arc_length: float
    """The arc length of its middle, from the root, mm."""
    diameter: float
    """Median diameter, mm."""


class Reference(NamedTuple):
    """The healthy vessel along a narrowing, as quantitative angiography interpolates it."""

    proximal: Plateau | None
    distal: Plateau | None
    widest: float = np.nan
    """Healthy diameter of the vessel, mm, where no part of it is known as healthy."""
    left: tuple[Plateau, ...] = ()
    """Diameter of the vessel beyond each junction between the two, and its arc length, mm."""

    def at(self, along: Floats) -> Floats:
        """Healthy diameters (n,) at some arc lengths from the root, mm.

        A vessel tapers from one side to the other, and loses beyond a junction at least what the
        vessels that leave there take.
        """
        healthy = self.tapering(along)
        for one in self.left:
            beyond = _between([one, self.distal], along)
            healthy = np.where(along < one.arc_length, healthy, np.minimum(healthy, beyond))
        return healthy

    def tapering(self, along: Floats) -> Floats:
        """Healthy diameters (n,) but for what junctions take, mm."""
        known = [self.proximal, self.distal]
        return _between(known if any(known) else [Plateau(0.0, self.widest)], along)

    def beyond(self, along: float) -> float:
        """Diameter of the proximal vessel beyond the last junction before a place, mm; NaN where
        none takes more there than the vessel tapers."""
        here = np.array([along])
        passed = [one.diameter for one in self.left if one.arc_length <= along]
        return passed[-1] if (self.at(here) < self.tapering(here)).all() else np.nan


def _between(sides: Sequence[Plateau | None], along: Floats) -> Floats:
    places, widths = np.array([side for side in sides if side is not None]).T
    return np.asarray(np.interp(along, places, widths))


class Narrowing(NamedTuple):
    """Part of a vessel, arc lengths from the root, mm."""

    start: float
    end: float
    narrowest: float
    """The arc length of a station."""
    reference: Reference
    degree: float
    """The share by which it is narrower than the reference."""


_EVERYWHERE = (-np.inf, np.inf)


def narrowings(
    run: VesselRun,
    eased: float = 0.0,
    own: tuple[float, float] = _EVERYWHERE,
    leaving: Sequence[Leaving] = (),
) -> list[Narrowing]:
    """Narrowings of a vessel from its start to its end, and near ones within a margin.

    The deepest comes first: what lies in it is no other one. `run` may go on beyond `own` (see
    `VesselWay`): narrowings are narrowest there. What is `leaving` takes its share.
    """
    caliber, found = caliber_of(run), list[Narrowing]()
    if len(caliber.along) < 3:
        return found
    every = (_narrowing(run, caliber, one, eased, own, leaving) for one in basins(caliber))
    for one in sorted((one for one in every if one), key=lambda one: -one.degree):
        if all(one.end <= other.start or other.end <= one.start for other in found):
            found.append(one)
    return sorted(found, key=lambda one: one.start)


def _narrowing(
    run: VesselRun,
    caliber: Caliber,
    basin: Basin,
    eased: float,
    own: tuple[float, float],
    leaving: Sequence[Leaving],
) -> Narrowing | None:
    """The narrowing with a minimum, if that persists and lies in the vessel itself."""
    at = basin.lowest
    reference = _reference(run, caliber, at, eased, own)
    if reference is None:
        return None
    left = _left(reference.proximal, reference.distal, leaving)
    reference = reference._replace(left=tuple(left))
    along, diameter, _, _ = caliber
    degree = 1 - diameter / reference.at(along)
    healthy = np.flatnonzero(degree <= EDGE_DEGREE)
    first = int(healthy[healthy < at].max(initial=-1)) + 1
    last = int(healthy[healthy > at].min(initial=len(along))) - 1
    # What a junction takes at once does not tell on which side of it that is narrowest.
    begin, end = max(first, basin.first), min(last, basin.last)
    at = begin + int((diameter / reference.tapering(along))[begin : end + 1].argmin())
    if degree[at] < SMALLEST_DEGREE - eased or not own[0] <= along[at] <= own[1]:
        return None
    # Beside the narrowest station no line tells how narrow it is between that and the next ones.
    known = run.along[np.isfinite(run.diameter)]
    station = int(np.abs(known - along[at]).argmin())
    start, end = along[[first, last]].tolist()
    beside = known[max(station - 1, 0) : station + 2]
    start, end = min(start, float(beside[0])), max(end, float(beside[-1]))
    return Narrowing(start, end, float(known[station]), reference, float(degree[at]))


def _reference(
    run: VesselRun, caliber: Caliber, at: int, eased: float, own: tuple[float, float]
) -> Reference | None:
    """The healthy vessel about a minimum; None where that does not persist."""
    narrow, begins = float(caliber.diameter[at]), own[0]
    widest, smallest = _again(run, caliber, at, eased, own)
    persists = narrow <= (1 - smallest + eased) * widest
    is_ostial, is_one_sided = run.parent >= 0, False
    above, beyond = _one_sided(caliber, at, -1), _one_sided(caliber, at, 1, end=own[1])
    if not persists:
        # What an in- or outlet cuts off as it begins to widen counts as at an ostium.
        other = max(_cut_short(_from(caliber, begins), at, eased), default=0.0)
        persists = narrow <= (1 - SMALLEST_ONE_SIDED + eased) * other
        widest = other if persists else widest
    if is_ostial:
        is_told = beyond > above and narrow <= (1 - SMALLEST_ONE_SIDED + eased) * beyond
        # What lies between two places as narrow has regained little of what the vessel has beyond.
        is_one_sided = is_told and (not persists or widest < narrow + REGAINED * (beyond - narrow))
        widest = beyond if is_one_sided else widest
    if not (persists or is_one_sided):
        return _alone(run, narrow, eased)
    # How fast a vessel widens tells whether it tapers only, not how wide it is.
    wider = [_widest(caliber, at, way) for way in ((1,) if is_one_sided else (-1, 1))]
    widest = max(widest, min(wider))
    least = narrow + REGAINED * (widest - narrow)
    after = _healthy(caliber, at, 1, least, own[1])
    if after is None:
        # How wide a flank becomes up to an end does not tell how wide the vessel was before.
        least = max(least, narrow + REGAINED * (above - narrow))
    elif is_ostial:
        # What is narrower than the vessel that it feeds may be a throat at the ostium.
        least = max(least, narrow + REGAINED * (after.diameter - narrow))
    before = None if is_one_sided else _healthy(caliber, at, -1, least, own[0])
    if before is None and after is not None:
        least = max(least, narrow + REGAINED * (beyond - narrow))
        after = _healthy(caliber, at, 1, least, own[1])
    # What is wider again toward the ostium is its funnel only.
    is_funnel = is_ostial and not is_one_sided and before is None
    if is_funnel and narrow > (1 - SMALLEST_ONE_SIDED + eased) * _widest(caliber, at, 1):
        return _alone(run, narrow, eased)
    if before is not None and after is not None and before.arc_length < begins:
        # So far beyond a junction the caliber is that of other vessels.
        is_local = caliber.along[at] - before.arc_length <= LOCAL * after.diameter
        before = before if is_local else None
    return Reference(before, after, widest)


def _cut_short(caliber: Caliber, at: int, eased: float) -> Iterator[float]:
    """Widths of a vessel on the other sides of in- and outlets up to which it widens by as much as
    a lesion asks for."""
    least = caliber.diameter[at] / (1 - SMALLEST_DEGREE + eased)
    for way, is_cut in zip((-1, 1), caliber.is_cut, strict=True):
        _, diameter, kept = _side(caliber, at, way)
        is_own = (diameter >= (1 - EDGE_DEGREE) * diameter[0]).all() and kept[-1] > 0
        if is_cut and is_own and diameter[-1] >= least:
            yield _one_sided(caliber, at, -way)


def _again(
    run: VesselRun, caliber: Caliber, at: int, eased: float, own: tuple[float, float]
) -> tuple[float, float]:
    """Diameter of a vessel wider again on both sides of a minimum, mm, and the least
    persistence."""
    begins, narrow = own[0], float(caliber.diameter[at])
    sides = [_widest(caliber, at, way) for way in (-1, 1)]
    if narrow <= (1 - SMALLEST_DEGREE + eased) * _widest(_from(caliber, begins), at, -1):
        return min(sides), SMALLEST_DEGREE
    if begins <= caliber.along[0]:
        return min(sides), SMALLEST_DEGREE
    # Nothing of its own is wider before: it may begin narrower, as healthy vessels do.
    lets = left_by(_widest(caliber, at, -1, ONE_SIDED_REACH), run.beside)
    return min(sides[0], _one_sided(caliber, at, 1, lets, own[1])), SMALLEST_ONWARD


def _from(caliber: Caliber, begins: float) -> Caliber:
    """The caliber with no width kept before an arc length, mm."""
    return caliber._replace(kept=np.where(caliber.along >= begins, caliber.kept, 0.0))


def _alone(run: VesselRun, narrow: float, eased: float) -> Reference | None:
    """Reference by the branches of a vessel between two junctions, where it is much narrower."""
    calibers = np.array([one.caliber for one in run.division])
    # A branch of which nothing is known leaves open what the others ask for.
    is_between = run.parent >= 0 and len(calibers) > 0 and bool(calibers.all())
    asked = float((calibers**MURRAY_EXPONENT).sum() ** (1 / MURRAY_EXPONENT)) if is_between else 0.0
    is_narrow = narrow <= (1 - SMALLEST_ALONE + eased) * asked
    return Reference(None, None, asked) if is_narrow else None


def _left(
    before: Plateau | None, after: Plateau | None, leaving: Sequence[Leaving]
) -> Iterator[Plateau]:
    """Healthy vessel before junctions as it goes on beyond each of them.

    By the rule of flow, between what is wider than it and what is narrower than the vessel beyond.
    """
    if before is None or after is None:
        return
    least, passed = min(before.diameter, after.diameter), list[float]()
    for one in leaving:
        if before.arc_length < one.arc_length < after.arc_length:
            passed.append(one.caliber)
            yield Plateau(one.arc_length, max(left_by(before.diameter, passed), least))


def _side(caliber: Caliber, at: int, way: int) -> tuple[Floats, Floats, Floats]:
    """Distances (n,) from a place, with diameters and kept widths, on one side of it."""
    along, diameter, kept = (column[at:] if way > 0 else column[at::-1] for column in caliber[:3])
    return np.abs(along - along[0]), diameter, kept


def _widest(caliber: Caliber, at: int, way: int, reach: float = np.inf) -> float:
    """Largest width of a vessel on one side of a place, mm, kept for some of its diameters.

    Up to where it is narrower than there by more than an edge is: what lies beyond is of that.
    """
    away, diameter, kept = _side(caliber, at, way)
    narrower = np.flatnonzero(diameter < (1 - EDGE_DEGREE) * diameter[0])
    is_own = np.arange(len(away)) < narrower.min(initial=len(away))
    return float(kept[is_own & (away / reach <= kept)].max(initial=diameter[0]))


def _one_sided(
    caliber: Caliber, at: int, way: int, lets: float = 0.0, end: float = np.inf
) -> float:
    """Width again near a junction, but in an aneurysm.

    That is widest in its middle third, loses half of it as fast as a throat regains it, and beyond
    it the vessel stays as narrow, as far as counts at an ostium: what ends sooner tapers. It is
    wider than what a vessel before a junction `lets` go on, mm, and over before the vessel's `end`,
    an arc length: that goes on in narrower ones.
    """
    away, diameter, kept = _side(caliber, at, way)
    widest = _widest(caliber, at, way, ONE_SIDED_REACH)
    if widest < max(ANEURYSM * diameter[0], lets):
        return widest
    peak = int(np.argmax(kept == widest))
    half = away[peak:][diameter[peak:] <= diameter[0] + REGAINED * (widest - diameter[0])]
    back = peak + np.flatnonzero(diameter[peak:] <= diameter[0])
    if not len(back) or half[0] - away[peak] > ONE_SIDED_REACH * widest:
        return widest
    last = min(3 * away[peak], abs(end - float(caliber.along[at])))
    is_focal = away[back[0]] <= last and np.median(diameter[back[0] :]) <= diameter[0]
    stays = away[-1] - away[back[0]] >= ONE_SIDED_REACH * diameter[0]
    return float(diameter[0]) if is_focal and stays else widest


def _healthy(caliber: Caliber, at: int, way: int, least: float, junction: float) -> Plateau | None:
    """The shoulder of a minimum: the first part as wide as that where its flank has settled.

    What follows is hardly less steep, in this vessel over as far as the minimum is away: rough
    flanks have steps.
    """
    away, diameter, kept = _side(caliber, at, way)
    last = np.searchsorted(away, away + KEPT * kept, side="right")
    # The greatest from each place to its last.
    ends = np.stack([np.arange(len(last)), last], axis=1).ravel()
    tops = np.maximum.reduceat(np.append(kept, 0.0), ends)[::2]
    rise = np.divide(tops, kept, out=np.ones(len(kept)), where=kept > 0) - 1
    steepest = np.maximum.accumulate(rise)
    # A vessel that an in- or outlet cuts off goes on beyond, as steeply as before.
    slope = np.diff(diameter) / np.diff(away)
    is_steep = len(slope) > 0 and bool(slope[-1] > REGAINED * slope.max())
    is_flank = is_steep or not caliber.is_cut[way > 0]
    own = abs(junction - float(caliber.along[at]))
    beyond = np.where(away < own, np.minimum(2 * away, own), 2 * away)
    as_far = np.searchsorted(away, beyond, side="right").tolist()
    for first in np.flatnonzero(kept >= least).tolist():
        part = slice(first, last[first])
        is_cut_short = last[first] == len(away) and np.ptp(away[part]) < KEPT * kept[first]
        if is_cut_short and is_flank:
            return None
        if rise[first] > rise[first : as_far[first]].min() + SETTLED * steepest[first]:
            continue
        usual = float(np.quantile(diameter[part], USUAL))
        # What is wider than that slopes: the funnel of a junction.
        if (1 - EDGE_DEGREE) * usual <= tops[first]:
            middle = (away[first] + away[last[first] - 1]) / 2
            return Plateau(float(caliber.along[at] + way * middle), usual)
    return None
