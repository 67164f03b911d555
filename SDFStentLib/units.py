"""Units of length and patient frames, and the way from one to the other."""

from __future__ import annotations

from typing import Literal

from .validation import InputError, Place, Points, coordinates

Frame = Literal["RAS", "LPS"]
"""Patient frames: RAS (x to the right) as Slicer has it in memory, LPS as it writes files."""

MILLIMETERS = {"mm": 1.0, "cm": 10.0, "m": 1000.0}
"""Millimetres in the units that a file may use."""

MOST_FLOW = 10_000.0
"""mL/s, 600 L/min: more than ten times what a heart gives at its peak."""


def millimeters_per(units: str) -> float:
    """Millimetres in one of the file's units, `"mm"`, `"cm"` or `"m"`; `InputError` for others."""
    if not isinstance(units, str) or units not in MILLIMETERS:
        raise InputError(f"units: expected one of {', '.join(MILLIMETERS)}, got {units!r}.")
    return MILLIMETERS[units]


def as_frame(tag: str) -> Frame | None:
    """The frame that a tag names, in any case and also as Slicer's old numbers; `None` if unknown.

    Older markups files say `0` for RAS and `1` for LPS.
    """
    tag = tag.strip().upper()
    if tag in ("RAS", "0"):
        return "RAS"
    if tag in ("LPS", "1"):
        return "LPS"
    return None


def are_apart(one: Frame | None, other: Frame | None) -> bool:
    """Whether two frames are both known, and not the same."""
    return None not in (one, other) and one != other


def flipped(points: Points) -> Points:
    """Points (n, 3) or one point (3,) in the other patient frame, RAS or LPS: x and y negated."""
    return points * (-1.0, -1.0, 1.0)


def told_place(place: Place, units: str) -> str:
    """A place to a tenth of a millimeter, and in the unit of the file where that is another."""
    return f"{coordinates(place, '.1f')} mm{in_file(place, units)}"


def in_file(place: Place | None, units: str) -> str:
    """A place in mm in the unit of the file, to stand behind that in mm; empty where that is it."""
    if place is None or units == "mm":
        return ""
    numbers = coordinates([value / MILLIMETERS[units] for value in place])
    return f" (in the file {numbers[1:-1]} {units})"
