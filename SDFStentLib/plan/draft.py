"""A stent as it is edited: whether its values fit together, and what a change entails.

Its entry has all values of a stent, of which some may be kept while others count, and three more:
`whole_curve`, whether a curve is its axis from end to end; `device_shortening`, whether it shortens
as is known of its device; and `redilation`, the diameter to which it is dilated once more at once,
mm. Of its `placement` the kind may be all that is known.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property
from typing import Any, TypeVar

import numpy as np

from ..stent import (
    DEFAULT_FORESHORTENING,
    AlongAxis,
    Balloon,
    BetweenPoints,
    Device,
    OfStent,
    OfVessel,
    Placement,
    Shape,
    Stent,
    dilated_again,
)
from ..validation import InputError
from .document import PLACEMENTS
from .entry import Entry, part_of, stent_entry, stent_of
from .reader import read_place

T = TypeVar("T")

NEW_STENT = {
    **stent_entry(Stent(8.0, length=20.0, foreshortening_fraction=0.1, name="Stent")),
    "placement": {"center": None},
    "whole_curve": True,
    "device_shortening": False,
    "redilation": None,
}
"""Entry of a stent in which nothing is set."""


def placement_of(place: Mapping[str, Any] | None) -> Placement | None:
    """A placement from its document, points in mm as sequences; None for none.

    `InputError` for what is no place of its kind.
    """
    if place is None:
        return None
    kind = place_kind(place)
    if issubclass(kind, OfVessel):
        return read_place(place, "placement")
    if kind is AlongAxis:
        return AlongAxis(np.asarray(place["axis"]["points"]))
    return kind(*place.values())


def place_kind(place: Mapping[str, Any]) -> Any:
    """The class of a placement from its document, of which no more may be known."""
    return PLACEMENTS[next(iter(place))]


class Draft:
    """A stent as it is edited; nobody may change its entry."""

    def __init__(self, entry: Entry) -> None:
        self.entry = {**NEW_STENT, **entry}

    @property
    def kind(self) -> Any:
        """The class of its placement."""
        return place_kind(self.entry["placement"])

    @property
    def place(self) -> Placement | None:
        """Placement at a lesion or on a branch; None for another one, or without a place."""
        place = self.entry["placement"]
        is_known = issubclass(self.kind, OfVessel) and next(iter(place.values())) is not None
        return placement_of(place) if is_known else None

    @cached_property
    def text(self) -> str:
        """Text that differs with the stent and its kind of placement, not with place, name or
        switch."""
        own = {key: value for key, value in self.entry.items() if key not in _ELSEWHERE}
        return json.dumps([next(iter(self.entry["placement"])), own])

    # Its sizes

    @property
    def length(self) -> float:
        """The length as packed, mm; that of a device of one length, whatever is set."""
        return (self.entry["device"] or {}).get("nominal_length") or self.entry["length"]

    @property
    def has_length(self) -> bool:
        """Whether it has a length, rather than that of its place."""
        is_part = self.kind is AlongAxis and not self.entry["whole_curve"]
        return is_part or not issubclass(self.kind, _WITH_LENGTH)

    @property
    def has_free_length(self) -> bool:
        """Whether its length is set freely, rather than its device's."""
        return self.has_length and not (self.entry["device"] or {}).get("nominal_length")

    @property
    def foreshortening(self) -> float:
        """The fraction in use; what is set where that of the device is not known."""
        try:
            return self.unplaced.foreshortening
        except InputError:
            return float(self.entry["foreshortening_fraction"])

    @property
    def usual_foreshortening(self) -> float:
        """The fraction without a device."""
        return 0.0 if issubclass(self.kind, _WITH_LENGTH) else DEFAULT_FORESHORTENING

    @property
    def asks_for_shortening(self) -> bool:
        """Whether it shall shorten by its device's foreshortening, which is not known."""
        device = self.device
        is_known = device is None or device.foreshortening_fraction is not None or device.lengths
        return self.entry["device_shortening"] and not is_known

    @cached_property
    def device(self) -> Device | None:
        """Device of the entry; None without one."""
        return self._set(Device, "device")

    @cached_property
    def balloon(self) -> Balloon | None:
        """The balloon that leaves its lumen."""
        kept = self._set(Balloon, "balloon")
        try:
            return kept and self.unplaced.balloon
        except InputError:
            return kept

    @cached_property
    def shape(self) -> Shape | None:
        """Shape; None for a plain cylinder."""
        try:
            return self.unplaced.shape if self.entry["shape"] else None
        except InputError:
            return self._set(Shape, "shape")

    @property
    def is_lumen_set(self) -> bool:
        """Whether its diameter was set after that of its balloon, which follows it."""
        kept = self._set(Balloon, "balloon")
        return kept is not None and self.entry["diameter"] != kept.lumen_diameter

    def _set(self, kind: type[T], name: str) -> T | None:
        return part_of(kind, self.entry, name)

    # As a stent

    def at(self, place: Mapping[str, Any] | None) -> Stent:
        """The stent at a place, as a plan's document has it in mm, or at none yet.

        `InputError` where its sizes do not fit together, or for what is no place.
        """
        has_device = self.entry["device"] is not None or self.kind is OfStent
        by_device = self.entry["device_shortening"] and has_device
        own = {
            "length": self.length if self.has_length else None,
            "foreshortening_fraction": None if by_device else self.entry["foreshortening_fraction"],
        }
        return stent_of({**self.entry, **own}, placement_of(place))

    @property
    def unplaced(self) -> Stent:
        """The stent at no place yet.

        `InputError` where its sizes do not fit together, or to a place of its kind.
        """
        planned = self.at(None)
        planned.check_kind(self.kind)
        return planned

    @property
    def final(self) -> Stent:
        """The stent, dilated again where it is at once."""
        planned, diameter = self.unplaced, self.entry["redilation"]
        return again(planned, 1, diameter) if diameter else planned

    @cached_property
    def refusal(self) -> InputError | None:
        """Error by which its sizes do not fit together; None when they do."""
        try:
            _ = self.final
        except InputError as error:
            return error
        return None


_WITH_LENGTH = (BetweenPoints, AlongAxis, OfStent)
"""Places that say how long a stent is."""

_ELSEWHERE = ("name", "enabled", "placement")
"""Keys of an entry that do not say what a stent is."""


def again(stent: Stent, number: int, diameter: float) -> Stent:
    """A stent, which has a number in its plan, once more at a second diameter, mm."""
    return replace(dilated_again(stent, number, diameter), name=name_again(stent.name))


def name_again(name: str) -> str:
    """Name of a stent that is dilated once more; empty without a name."""
    return f"{name}, dilated again" if name else ""
