"""A stent as the entry of a document, as it is edited: its values need not fit together yet.

The other form of a stent is `Stent`, which refuses what does not fit together.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import fields, replace
from functools import lru_cache
from typing import Any, TypeVar

from ..stent import Balloon, Placement, Shape, Stent
from .typed import from_document, to_document, typed_values, without_unset

T = TypeVar("T")

Entry = Mapping[str, Any]
"""Fields of a `Stent` with their values of JSON; those that are missing are as by default."""

FIELDS = tuple(one.name for one in fields(Stent) if one.name != "placement")
"""Fields of an entry, without the place, which depends on the unit and the frame of the
document."""


def stent_entry(stent: Stent) -> dict[str, Any]:
    """Entry of a stent: its values but its place."""
    return {name: to_document(getattr(stent, name)) for name in FIELDS}


def stent_of(entry: Entry, placement: Placement | None = None) -> Stent:
    """The stent of an entry, whose keys that a `Stent` has not are the business of others.

    Where the diameter is another than that which balloon and shape were for, the balloon follows it
    by the same recoil, and a table in proportion. A device with a table of lengths shortens as that
    says, whatever fraction is given. A part whose first size is null, such as the diameter of a
    waist, is none.

    Raises
    ------
    InputError
        Values that do not belong there, or that rule each other out.
    """
    own = {name: entry[name] for name in FIELDS if name in entry}
    stent = _unplaced(json.dumps(own))
    return stent if placement is None else stent.at(placement)


@lru_cache(maxsize=256)
def _unplaced(text: str) -> Stent:
    values = typed_values(Stent, without_unset(Stent, json.loads(text)), "stent")
    diameter, device = values["diameter"], values.get("device")
    if device is not None and device.lengths:
        values["foreshortening_fraction"] = None
    balloon, shape = values.get("balloon"), values.get("shape")
    values["balloon"] = balloon and _that_leaves(balloon, diameter)
    values["shape"] = shape and _for_diameter(shape, diameter)
    return Stent(**values)


def part_of(kind: type[T], entry: Entry, name: str) -> T | None:
    """A part of an entry, such as its balloon, as it was set; None where it is none.

    `InputError` for values that do not belong there.
    """
    document = without_unset(Stent, {name: entry.get(name)})[name]
    return None if document is None else from_document(kind, document, name)


def entry_words(entry: Entry) -> str:
    """Words for a stent beyond its sizes and its place, for the user; empty without any."""
    device, balloon = entry.get("device"), entry.get("balloon")
    shape = without_unset(Shape, entry.get("shape") or {})
    words = []
    if device:
        words.append(f"device {device['name']}")
    if balloon:
        words.append(f"a balloon with {100 * float(balloon['recoil_fraction']):g} % of recoil")
    if entry.get("keeps", "center") != "center":
        words.append(f"its {entry['keeps']} end kept on shortening")
    parts = [name for name in ("waist", "table") if shape.get(name)]
    parts += [f"{name} of its own" for name in ("start", "end") if shape.get(name)]
    if any(shape.values()):
        words.append(f"a shape ({', '.join(parts) or 'flat caps'})")
    if entry.get("may_be_shortened"):
        words.append("shortened where the vessel ends")
    return ", ".join(words)


def _that_leaves(balloon: Balloon, diameter: float) -> Balloon:
    if balloon.lumen_diameter == diameter:
        return balloon
    return replace(balloon, diameter=diameter / (1.0 - balloon.recoil_fraction))


def _for_diameter(shape: Shape, diameter: float) -> Shape:
    """A table in proportion to its largest diameter; other parts have diameters of their own."""
    if not shape.table:
        return shape
    factor = diameter / max(row[1] for row in shape.table)
    if factor == 1:
        return shape
    return replace(shape, table=tuple((at, wide * factor) for at, wide in shape.table))
