"""The ways to say where a stent goes; `stent_axis` makes an axis of each."""

from __future__ import annotations

import os
from dataclasses import dataclass, fields, is_dataclass
from typing import Any

import numpy as np

from ..geometry import Line
from ..validation import (
    Floats,
    InputError,
    Points,
    as_number,
    as_patient_points,
    as_place,
    as_point,
    in_short,
    place_words,
    read_only,
)

LOOP = 1e-3
"""Distance of the ends of a curve over its length up to which it is a closed loop."""

FARTHEST = 1e4
"""Farthest place along a vessel, mm; more is another unit or a slip."""

TURNED_BACK = -0.999
"""Cosine of the turn, 177 degrees, from which on a curve goes back the way that it came."""


@dataclass(frozen=True)
class InputFile:
    """Input file of a plan: its absolute path, and its SHA-256 where that is known."""

    path: str
    sha256: str | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.path, str | os.PathLike) or not os.fspath(self.path):
            raise InputError(f"input file: expected a path, got {self.path!r}; name a file.")
        object.__setattr__(self, "path", os.path.abspath(self.path))


class ByValue:
    """Dataclasses that are equal when all their values are, those of arrays included."""

    def __eq__(self, other: object) -> bool:
        return type(other) is type(self) and _values(self) == _values(other)

    def __hash__(self) -> int:
        return hash(_values(self))


@dataclass(frozen=True, eq=False)
class AtCenter(ByValue):
    """The stent's middle is nearest to this point: half of it above, half below."""

    point: Floats

    def __post_init__(self) -> None:
        _keep_point(self, "point", "center")


@dataclass(frozen=True, eq=False)
class AtDistalEnd(ByValue):
    """The stent's distal end is nearest to this point: it reaches up toward the root."""

    point: Floats

    def __post_init__(self) -> None:
        _keep_point(self, "point", "distal end")


@dataclass(frozen=True, eq=False)
class AtProximalEnd(ByValue):
    """The stent's proximal end is nearest to this point: it reaches down to the outlets."""

    point: Floats

    def __post_init__(self) -> None:
        _keep_point(self, "point", "proximal end")


@dataclass(frozen=True, eq=False)
class BetweenPoints(ByValue):
    """The stent lies on the way between two points, across junctions; their order is free."""

    start: Floats
    end: Floats

    def __post_init__(self) -> None:
        _keep_point(self, "start", "stent start")
        _keep_point(self, "end", "stent end")


@dataclass(frozen=True, eq=False)
class AlongAxis(ByValue):
    """The curve (n, 3) itself is the axis, first point proximal; no centerline is needed.

    `file` is the one from which the curve was read, where there is one.
    """

    points: Points
    file: InputFile | None = None

    def __post_init__(self) -> None:
        line = Line(as_patient_points(self.points, "stent axis", minimum=1)).without_repeats()
        if len(line) < 2:
            raise InputError(
                "stent axis: expected a curve through at least two different points, "
                f"got {len(self.points)} point(s) at one place; draw a longer curve."
            )
        _check_way(line)
        object.__setattr__(self, "points", line.points)


@dataclass(frozen=True, eq=False)
class OfStent(ByValue):
    """Placement at an earlier stent of the treatment: that one is dilated once more.

    `number` is the earlier one's in the plan, from 1.
    """

    number: int

    def __post_init__(self) -> None:
        if isinstance(self.number, bool) or not isinstance(self.number, int) or self.number < 1:
            raise InputError(
                "redilation: expected the number of an earlier stent, from 1, got "
                f"{self.number!r}; name one above it."
            )


@dataclass(frozen=True, eq=False)
class AtLesion(ByValue):
    """The place at a lesion of the vessel, by its number from 1 as `measure` lists them.

    With an `offset` the middle of the stent is so many mm distal of the middle of the lesion.
    Without one it is there, or, where the stent is shorter than the lesion, as much nearer to the
    narrowest place as it takes to have that in its middle half.
    """

    number: int
    offset: float | None = None

    def __post_init__(self) -> None:
        if isinstance(self.number, bool) or not isinstance(self.number, int) or self.number < 1:
            raise InputError(
                f"lesion: expected a number of the list, from 1, got {in_short(self.number)}; "
                "see `sdfstent measure`."
            )
        if self.offset is not None:
            as_number(self.offset, "offset", unit="mm", minimum=-FARTHEST, maximum=FARTHEST)


@dataclass(frozen=True, eq=False)
class OnBranch(ByValue):
    """The stent's middle is on a branch of the centerline, by number from 1 or by name.

    So many mm, or such a part of its length, from where the branch begins.
    """

    branch: int | str
    distance: float | None = None
    fraction: float | None = None

    def __post_init__(self) -> None:
        is_number = isinstance(self.branch, int) and not isinstance(self.branch, bool)
        if not (isinstance(self.branch, str) or (is_number and self.branch > 0)):
            raise InputError(
                "branch: expected its number, from 1, or its name, got "
                f"{in_short(self.branch)}; see `sdfstent measure`."
            )
        if (self.distance is None) == (self.fraction is None):
            got = "neither" if self.distance is None else "both"
            raise InputError(
                f"branch: expected a distance along it, mm, or a fraction, got {got}; give one."
            )
        if self.fraction is not None:
            as_number(self.fraction, "fraction", minimum=0, maximum=1)
        if self.distance is not None:
            as_number(self.distance, "distance", unit="mm", minimum=0, maximum=FARTHEST)


Placement = (
    AtCenter
    | AtDistalEnd
    | AtProximalEnd
    | BetweenPoints
    | AlongAxis
    | OfStent
    | AtLesion
    | OnBranch
)

PLACEMENT_NAMES = [kind.__name__ for kind in Placement.__args__]

OfVessel = AtLesion | OnBranch
"""Placements in terms of a vessel, which alone turns them into points."""


def _check_way(line: Line) -> None:
    """Refuse a curve on which a stent has no two ends, or no direction at some place."""
    points = line.points
    if np.linalg.norm(points[-1] - points[0]) <= LOOP * line.length:
        raise InputError(
            "stent axis: expected a curve with two ends, got a closed loop, which ends where it "
            f"begins, at {place_words(points[0])}",
            place=as_place(points[0]),
            end="; take a part of it.",
        )
    pieces = np.diff(points, axis=0)
    pieces /= np.linalg.norm(pieces, axis=1)[:, None]
    turns = (pieces[1:] * pieces[:-1]).sum(axis=1)
    if turns.min(initial=1.0) < TURNED_BACK:
        sharp = points[1 + turns.argmin()]
        raise InputError(
            "stent axis: expected a curve that goes on, got one that turns back on itself at "
            f"{place_words(sharp)}",
            place=as_place(sharp),
            end="; leave out the points behind.",
        )


def _keep_point(placement: object, field_name: str, name: str) -> None:
    point = as_patient_points(as_point(getattr(placement, field_name), name)[None], name)[0]
    object.__setattr__(placement, field_name, read_only(point))


def _values(value: Any) -> Any:
    """Nested tuples of plain values, to compare and to hash."""
    if is_dataclass(value):
        inner = ((item.name, _values(getattr(value, item.name))) for item in fields(value))
        return (type(value).__name__, *inner)
    if isinstance(value, np.ndarray):
        return _values(value.tolist())
    if isinstance(value, list | tuple):
        return tuple(_values(item) for item in value)
    return value
