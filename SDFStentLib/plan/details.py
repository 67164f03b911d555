"""What a stent is beyond its sizes and its place, as one text that a program can keep.

A program that shows only a stent's diameter, length and place, such as a panel, keeps the rest so:
nothing of a plan is lost on the way through it.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, fields, replace
from functools import lru_cache
from typing import Any, NamedTuple

from ..stent import Balloon, Device, Placement, Shape, Stent
from .json_document import parsed
from .typed import from_document, to_document


@dataclass(frozen=True)
class StentDetails:
    """What a stent is beyond its sizes and its place; as the attributes of `Stent`."""

    device: Device | None = None
    balloon: Balloon | None = None
    keeps: str = "center"
    shape: Shape | None = None
    may_be_shortened: bool = False


class StentSizes(NamedTuple):
    """The sizes of a stent; as the attributes of `Stent`."""

    diameter: float
    length: float | None = None
    foreshortening_fraction: float | None = None


def details_document(stent: Stent | StentDetails) -> dict[str, Any]:
    """The details of a stent as values of JSON; null where it has none."""
    return {one.name: to_document(getattr(stent, one.name)) for one in fields(StentDetails)}


def stent_details(stent: Stent | StentDetails) -> str:
    """What a stent is beyond sizes and place as JSON text; empty where that is nothing."""
    usual = details_document(StentDetails())
    kept = {key: value for key, value in details_document(stent).items() if value != usual[key]}
    return json.dumps(kept, ensure_ascii=False) if kept else ""


@lru_cache(maxsize=64)
def read_details(details: str) -> StentDetails:
    """What a text of `stent_details` says; `InputError` for one that cannot be read."""
    found = parsed(details, "stent details") if details else {}
    return from_document(StentDetails, found, "stent details")


def detailed_stent(
    details: str, sizes: StentSizes, placement: Placement | None = None, name: str = ""
) -> Stent:
    """A stent of some sizes with the details of another one.

    Where the diameter is another than theirs the balloon follows it by the same recoil, and a table
    in proportion. A device with a table of lengths shortens as that says, whatever fraction
    is given.

    Parameters
    ----------
    details : str
        As of `stent_details`.
    sizes : StentSizes
    placement, name
        As of `Stent`.

    Raises
    ------
    InputError
        Details that cannot be read, or that rule out the sizes.
    """
    found = read_details(details)
    if found.device is not None and found.device.lengths:
        sizes = sizes._replace(foreshortening_fraction=None)
    more = vars(found) | {
        "balloon": found.balloon and _that_leaves(found.balloon, sizes.diameter),
        "shape": found.shape and _for_diameter(found.shape, sizes.diameter),
    }
    return Stent(**sizes._asdict(), **more, placement=placement, name=name)


def details_words(details: str) -> str:
    """What the details are, for the user; empty where there are none."""
    found = parsed(details, "stent details") if details else {}
    words = []
    if "device" in found:
        words.append(f"device {found['device']['name']}")
    if "balloon" in found:
        recoil = 100 * float(found["balloon"]["recoil_fraction"])
        words.append(f"a balloon with {recoil:g} % of recoil")
    if "keeps" in found:
        words.append(f"its {found['keeps']} end kept on shortening")
    shape = found.get("shape", {})
    parts = [name for name in ("waist", "table") if name in shape]
    parts += [f"{name} of its own" for name in ("start", "end") if name in shape]
    if "shape" in found:
        words.append(f"a shape ({', '.join(parts) or 'flat caps'})")
    if found.get("may_be_shortened"):
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
