"""Lesions before and after stenting, and the residual stenosis."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..geometry import Line, Surface
from ..lumen import DiameterProfile, moved_wall
from ..validation import Place
from ..vessel import Lesion, TreeLesions, is_touched, lesions_after, lesions_within
from .placing import NOTICED, uncovered_length
from .value import PlacedStent, TreatedStent

_LEAST_LEFT = 0.5
"""Percent, by diameter or by area; less is reported as 0 %, or as wider than the reference."""


@dataclass(frozen=True)
class TreatedLesion:
    """A lesion before and after a treatment, against the same reference.

    Attributes
    ----------
    number : int
        Number among the vessel's lesions, from 1.
    before, after : Lesion
        Lesion before any stent, and at the same part of the vessel after all of them.
    stents : tuple of int
        Numbers of the stents that cover its narrowest place, or end in the sphere there.
    is_left_beyond : bool
        Whether something is left of it, and what is narrowest then lies beyond all of the stents.
    """

    number: int
    before: Lesion
    after: Lesion
    stents: tuple[int, ...]
    is_left_beyond: bool = False


def treated_lesions(
    lesions: Sequence[Lesion],
    stents: Sequence[PlacedStent],
    after: Surface,
    before: Surface | None = None,
) -> tuple[TreatedLesion, ...]:
    """Lesions of a vessel before and after a treatment.

    Parameters
    ----------
    lesions : sequence of Lesion
        `find_lesions` of the vessel before treatment.
    stents : sequence of PlacedStent
        Stents in their places, such as those of a result.
    after : Surface
        Surface after all stents.
    before : Surface, optional
        Surface before any, the same triangles: lesions far from what has moved stay what they are.
    """
    moved = None if before is None else moved_wall(before, after)
    left = lesions_after(lesions, after, moved)
    treated = []
    for number, (lesion, rest) in enumerate(zip(lesions, left, strict=True), start=1):
        treating = tuple(one.number for one in stents if lesions_within([lesion], one.axis.line))
        is_within = any(lesions_within([rest], one.axis.line, beyond=0.0) for one in stents)
        is_beyond = not is_within and _is_left(rest)
        treated.append(TreatedLesion(number, lesion, rest, treating, is_beyond))
    return tuple(treated)


def _is_left(lesion: Lesion) -> bool:
    """Whether a stenosis is left; areas are asked for where diameters leave that open."""
    return lesion.percent_diameter >= _LEAST_LEFT or lesion.percent_area >= _LEAST_LEFT


def with_known_minima(
    stents: Sequence[TreatedStent], lesions: Sequence[TreatedLesion] | None
) -> tuple[TreatedStent, ...]:
    """Stents whose narrowest lumen is that of the lesion there, before and after: one number.

    Two searches for one place, along two lines, differ in their last digits, and in a throat of
    rough wall in the first one.
    """
    return tuple(_with_known(one, lesions or ()) for one in stents)


def _with_known(stent: TreatedStent, lesions: Sequence[TreatedLesion]) -> TreatedStent:
    line = stent.axis.line
    treated = [one for one in lesions if stent.number in one.stents]
    before = _tightest_within(line, [one.before for one in treated])
    after = _tightest_within(line, [one.after for one in treated])
    return replace(
        stent,
        before=_known_at(stent.before, line, before, is_same=True),
        after=_known_at(stent.after, line, after, is_same=False),
    )


def _tightest_within(line: Line, lesions: Sequence[Lesion]) -> Lesion | None:
    """The tightest lesion whose narrowest place is known and lies between the ends of a stent."""
    known = [one for one in lesions if not np.isnan(one.minimum_diameter)]
    within = lesions_within(known, line, beyond=0.0)
    return min(within, key=lambda lesion: lesion.minimum_diameter, default=None)


def _known_at(
    found: DiameterProfile, line: Line, lesion: Lesion | None, *, is_same: bool
) -> DiameterProfile:
    """Lumen with a lesion's narrowest place, if narrower than found, or the place found and
    `is_same`."""
    if lesion is None:
        return found
    at = float(line.nearest(np.array([lesion.point])).arc_lengths[0])
    is_told = lesion.minimum_diameter < found.minimum
    is_told |= is_same and abs(found.minimum_arc_length - at) <= NOTICED
    return replace(found, known=(at, lesion.minimum_diameter)) if is_told else found


@dataclass(frozen=True)
class Residual:
    """The narrowest place left in the treated vessels, against their healthy references.

    Attributes
    ----------
    percent : float
        Stenosis by diameter, percent; NaN where it is not known.
    minimum, reference : float
        Inscribed diameter there and that of the healthy vessel, mm.
    point : tuple of float
        Center of the sphere there, mm.
    lesion : int
        The number of the lesion in which it lies.
    side : str
        "within" a stent, "proximal" or "distal" of one, or "between" two.
    stent : int
        The number of that stent; of two the proximal one.
    distance : float
        Distance from the end of that stent along the vessel, mm; 0 within.
    """

    percent: float
    minimum: float
    reference: float
    point: Place
    lesion: int
    side: str
    stent: int
    distance: float

    def place(self) -> str:
        """The place where it lies, to follow a comma."""
        if self.side == "within":
            return f"within stent {self.stent}"
        away = f"{self.distance:.0f} mm" if round(self.distance) else "just"
        if self.side == "between":
            return f"between stents, {away} beyond stent {self.stent}"
        way = "before" if self.side == "proximal" else "beyond"
        return f"{away} {way} stent {self.stent}"


def nearest_lesion(
    stents: Sequence[PlacedStent], lesions: Sequence[TreatedLesion]
) -> TreatedLesion:
    """The lesion whose narrowest place is nearest to one of the stents; there is one."""
    points = np.array([one.after.point for one in lesions])
    apart = [one.axis.line.nearest(points).distances for one in stents]
    return lesions[int(np.min(apart, axis=0).argmin())]


def lesions_of_treated(
    lesions: Sequence[TreatedLesion], stents: Sequence[PlacedStent]
) -> tuple[TreatedLesion, ...]:
    """The lesions on which a treatment tells, with the numbers that they have among all.

    Those of the vessels in which a stent covers one, what the treatment has changed, and for a
    stent that covers none the nearest.
    """
    treated = {one.before.vessel for one in lesions if one.stents}
    covering = {number for one in lesions for number in one.stents}
    loose = [one for one in stents if one.number not in covering] if lesions else []
    nearest = {nearest_lesion([one], lesions).number for one in loose}
    return tuple(
        one
        for one in lesions
        if one.before.vessel in treated or one.after is not one.before or one.number in nearest
    )


def told_first(
    tree: TreeLesions, stents: Sequence[PlacedStent], after: Surface, before: Surface
) -> tuple[TreatedLesion, ...] | None:
    """`lesions_of_treated` by the first lesions of a tree; None where others may be among them.

    Parameters as of `treated_lesions`.
    """
    told = lesions_of_treated(treated_lesions(tree.first, stents, after, before), stents)
    treated = {one.before.vessel for one in told if one.stents}
    if not {one.number for one in stents} <= {number for one in told for number in one.stents}:
        return None
    moved, lines = moved_wall(before, after), [one.axis.line for one in stents]
    for other in tree.others:
        if other.vessel in treated or is_touched(other, moved) or _is_beside(other, lines):
            return None
    return told


def _is_beside(lesion: Lesion, lines: Sequence[Line]) -> bool:
    """Whether a line comes so near to a lesion that a stent along it may cover its narrowest place,
    wherever that is."""
    reach = lesion.reference_diameter + float(lesion.line.pieces.max(initial=0.0))
    return any(line.nearest(lesion.line.points).distances.min() <= reach for line in lines)


def residual_of(lesions: Sequence[TreatedLesion], stents: Sequence[PlacedStent]) -> Residual | None:
    """Narrowest place in the vessels in which stents cover a lesion, wherever it lies.

    Parameters
    ----------
    lesions : sequence of TreatedLesion
    stents : sequence of PlacedStent

    Returns
    -------
    Residual or None
        None where no stent covers a lesion. Of a lesion whose narrowest place is not known any more
        the percentage and the minimum are NaN: it may be the worst.
    """
    treated = {one.before.vessel for one in lesions if one.stents}
    there = [one for one in lesions if one.before.vessel in treated]
    if not there:
        return None
    percents = [one.after.percent_diameter for one in there]
    worst = there[int(np.argmax(np.where(np.isnan(percents), np.inf, percents)))]
    after = worst.after
    spans = _spans(after, _there(worst, stents))
    side, stent, distance = _beside(after.arc_length, spans)
    return Residual(
        after.percent_diameter,
        after.minimum_diameter,
        after.reference_diameter,
        after.point,
        worst.number,
        side,
        stent,
        distance,
    )


class _Span(NamedTuple):
    """The span along a vessel in which a stent lies, mm from the root."""

    start: float
    end: float
    stent: int


def _there(lesion: TreatedLesion, stents: Sequence[PlacedStent]) -> list[PlacedStent]:
    """The stents that lie in a lesion, also beside its narrowest place; else the nearest one."""
    length = lesion.before.line.length
    found = [
        one
        for one in stents
        if one.number in lesion.stents
        or uncovered_length(lesion.before, [one.axis.line]) < length - NOTICED
    ]
    point = np.array([lesion.after.point])
    return found or [min(stents, key=lambda one: float(one.axis.line.nearest(point).distances[0]))]


def _spans(lesion: Lesion, stents: Sequence[PlacedStent]) -> list[_Span]:
    """Extents of stents: distances of their ends along the lesion's line and beyond it."""
    line = lesion.line
    (start, end), directions = line.points[[0, -1]], line.directions
    found = []
    for stent in stents:
        ends = stent.axis.points[[0, -1]]
        along = lesion.start + line.nearest(ends).arc_lengths
        # What lies beyond the line goes on straight.
        along += np.minimum((ends - start) @ directions[0], 0.0)
        along += np.maximum((ends - end) @ directions[-1], 0.0)
        found.append(_Span(float(along.min()), float(along.max()), stent.row))
    return sorted(found)


def _beside(at: float, spans: Sequence[_Span]) -> tuple[str, int, float]:
    """The stent beside which a place lies, on which side, and how far from its end."""
    within = [span.stent for span in spans if span.start <= at <= span.end]
    if within:
        # Of a stent that was dilated again as another one, the one that lies there in the end.
        return "within", max(within), 0.0
    before = [span for span in spans if span.end < at]
    if not before:
        return "proximal", spans[0].stent, spans[0].start - at
    last = max(before, key=lambda span: span.end)
    side = "distal" if len(before) == len(spans) else "between"
    return side, last.stent, at - last.end
