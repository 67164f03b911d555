"""Units of length and patient frames, and conversions between them."""

from __future__ import annotations

from typing import Literal

from .validation import InputError, Place, Points, coordinates

Frame = Literal["RAS", "LPS"]
"""Patient frames: RAS (x to the right), which Slicer uses in memory, and LPS, in which it writes
files."""

MILLIMETERS = {"mm": 1.0, "cm": 10.0, "m": 1000.0}
"""Number of millimeters in each unit that a file may use."""

MOST_FLOW = 10_000.0
"""Largest accepted flow, mL/s; 600 L/min is more than ten times the peak flow of a heart."""


def millimeters_per(units: str) -> float:
    """Number of millimeters in one unit of the file, `"mm"`, `"cm"` or `"m"`; raises `InputError`
    for others."""
    if not isinstance(units, str) or units not in MILLIMETERS:
        raise InputError(f"units: expected one of {', '.join(MILLIMETERS)}, got {units!r}.")
    return MILLIMETERS[units]


def as_frame(tag: str) -> Frame | None:
    """The frame named by a tag, in any case or as one of Slicer's old numbers; `None` if unknown.

    Older markups files have `0` for RAS and `1` for LPS.
    """
    tag = tag.strip().upper()
    if tag in ("RAS", "0"):
        return "RAS"
    if tag in ("LPS", "1"):
        return "LPS"
    return None


def are_apart(one: Frame | None, other: Frame | None) -> bool:
    """Whether two frames are both known and differ."""
    return None not in (one, other) and one != other


def flipped(points: Points) -> Points:
    """Points (n, 3) or one point (3,) in the other patient frame, RAS or LPS: x and y negated."""
    return points * (-1.0, -1.0, 1.0)


def place_text(place: Place, units: str) -> str:
    """Place to a tenth of a millimeter, followed by that in the file's unit if another one."""
    return f"{coordinates(place, '.1f')} mm{in_file(place, units)}"


def in_file(place: Place | None, units: str) -> str:
    """The text with a place in the file's unit, to follow the place in mm; empty if the file is in
    mm."""
    if place is None or units == "mm":
        return ""
    numbers = coordinates([value / MILLIMETERS[units] for value in place])
    return f" (in the file {numbers[1:-1]} {units})"


def reason_of(error: Exception, units: str) -> str:
    """The sentence of a refusal, its place also in the unit of the file."""
    if isinstance(error, InputError):
        return error.sentence({}, in_file(error.place, units))
    return str(error)
