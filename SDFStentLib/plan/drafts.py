"""The stents of a plan as they are edited: one that is dilated again at once is one of them."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from ..stent import AlongAxis, BetweenPoints, OfStent, OfVessel, Placement, Stent, dilated_again
from ..validation import InputError
from .document import PLACEMENTS, placement_document
from .draft import Draft, again, name_again
from .entry import stent_entry


def numbers_again(drafts: Sequence[Draft], spots: Sequence[Hashable]) -> list[int | None]:
    """Number, from 1, of the stent of the plan that each draft dilates again.

    That is the stent as it lies by then: where it was dilated again before, as that. None where
    there is none.

    Parameters
    ----------
    drafts : sequence of Draft
    spots : sequence
        Keys of their places: equal where another one lies.
    """
    numbers: list[int | None] = []
    latest: dict[Hashable, int] = {}
    count = 0
    for draft, spot in zip(drafts, spots, strict=True):
        count += 1
        is_again = draft.kind is OfStent
        numbers.append(latest.get(spot) if is_again else None)
        count += bool(draft.entry["redilation"])
        # One that is off is not dilated again where another one lies there.
        if draft.entry["enabled"] if spot in latest else not is_again:
            latest[spot] = count
    return numbers


def earlier_of(drafts: Sequence[Draft], spots: Sequence[Hashable], index: int) -> Draft | None:
    """The draft that the one at an index dilates again, as it lies by then; None for none."""
    if not 0 <= index < len(drafts) or drafts[index].kind is not OfStent:
        return None
    there = [
        one
        for one, spot in zip(drafts[:index], spots[:index], strict=True)
        if spot == spots[index] and (one.entry["enabled"] or one.kind is not OfStent)
    ]
    return there[-1] if there else None


def stents_of(
    drafts: Sequence[Draft],
    places: Sequence[Mapping[str, Any] | None],
    has_named: bool = False,
) -> list[Stent]:
    """The stents of a plan, each followed by itself where it is dilated again at once.

    Parameters
    ----------
    drafts : sequence of Draft
    places : sequence of dict or None
        Place of each, as in a plan's document, in mm; None for one that is switched off and lies
        nowhere yet.
    has_named : bool
        Whether one that is off and cannot be is there by its name; it is refused otherwise.

    Raises
    ------
    InputError
        Sizes that do not fit together, or a place that is none.
    """
    stents: list[Stent] = []
    for draft, place in zip(drafts, places, strict=True):
        is_off, diameter = not draft.entry["enabled"], draft.entry["redilation"]
        if is_off and has_named and draft.refusal:
            name = draft.entry["name"]
            named = Stent(draft.entry["diameter"], name=name, enabled=False)
            stents += [named] * (2 if diameter else 1)
            continue
        stents.append(draft.at(None if is_off and draft.refusal else place))
        if diameter:
            stents.append(again(stents[-1], len(stents), diameter))
    return stents


def rows_of(drafts: Sequence[Draft]) -> list[int]:
    """Numbers by which a list of drafts counts each of its stents, from 1."""
    rows = enumerate(drafts, start=1)
    return [row for row, one in rows for _once in range(2 if one.entry["redilation"] else 1)]


def kind_only(placement: Placement | None) -> dict[str, Any]:
    """The document of a placement of which no more than the kind is known, a middle by default."""
    if isinstance(placement, BetweenPoints):
        return {"from": None, "to": None}
    keys = (key for key, kind in PLACEMENTS.items() if type(placement) is kind)
    return {next(keys, "center"): None}


class Row(NamedTuple):
    """A stent of a plan as a draft."""

    stent: Stent
    redilation: float | None = None
    """The diameter to which it is dilated again at once, mm."""
    original: int | None = None
    """Index among the rows of the stent that this one dilates again; None if it does not."""

    @property
    def entry(self) -> dict[str, Any]:
        """Entry; of its place the kind, unless that is one of a vessel."""
        stent = self.stent
        is_of_vessel = isinstance(stent.placement, OfVessel)
        place = placement_document(stent.placement) if is_of_vessel else kind_only(stent.placement)
        has_device = stent.device is not None or isinstance(stent.placement, OfStent)
        entry = {
            **stent_entry(stent),
            "name": stent.name or "Stent",
            "foreshortening_fraction": stent.foreshortening,
            "device_shortening": stent.foreshortening_fraction is None and has_device,
            "placement": place,
            "whole_curve": stent.length is None,
            "redilation": self.redilation,
        }
        return entry if stent.length is not None else {k: entry[k] for k in entry if k != "length"}

    @property
    def points(self) -> list[Any]:
        """Points (3,) of its place, mm; none where it has none of its own."""
        placement = self.stent.placement
        if isinstance(placement, AlongAxis):
            return list(placement.points)
        if isinstance(placement, BetweenPoints):
            return [placement.start, placement.end]
        return (
            []
            if placement is None or isinstance(placement, OfStent | OfVessel)
            else [placement.point]
        )


def rows_from(stents: Sequence[Stent]) -> list[Row]:
    """The stents of a plan as drafts.

    `InputError` for one that dilates again what is not above it.
    """
    rows: list[Row] = []
    row_of: dict[int, int] = {}
    for number, stent in enumerate(stents, start=1):
        if not isinstance(stent.placement, OfStent):
            row_of[number] = len(rows)
            rows.append(Row(stent))
            continue
        if stent.placement.number not in row_of:
            raise InputError(
                f"stent {number}: expected a stent above it to dilate again, got stent "
                f"{stent.placement.number}; name one above it."
            )
        row_of[number] = original = row_of[stent.placement.number]
        if _is_at_once(stent, number, stents, rows):
            rows[-1] = rows[-1]._replace(redilation=stent.inflated_diameter)
        else:
            rows.append(Row(stent, original=original))
    return rows


def _is_at_once(stent: Stent, number: int, stents: Sequence[Stent], rows: Sequence[Row]) -> bool:
    """Whether a stent is the immediate redilation of the last row."""
    first = number - 1
    assert isinstance(stent.placement, OfStent)
    if stent.placement.number != first or stents[first - 1] is not rows[-1].stent:
        return False
    try:
        made = dilated_again(rows[-1].stent, first, stent.inflated_diameter)
    except InputError:
        return False
    is_named = stent.name in (name_again(rows[-1].stent.name), "")
    return is_named and replace(made, name=stent.name) == stent
