"""The ways to say where a stent goes; `stent.stent_axis` makes an axis of each."""

from __future__ import annotations

from dataclasses import dataclass

from .polyline import without_repeats
from .validation import Floats, InputError, Points, as_point, as_points, read_only


@dataclass(frozen=True, eq=False)
class AtCenter:
    """The stent's middle is nearest to this point: half of it above, half below."""

    point: Floats

    def __post_init__(self) -> None:
        _keep_point(self, "point", "center")


@dataclass(frozen=True, eq=False)
class AtDistalEnd:
    """The stent's distal end is nearest to this point: it reaches up towards the root."""

    point: Floats

    def __post_init__(self) -> None:
        _keep_point(self, "point", "distal end")


@dataclass(frozen=True, eq=False)
class AtProximalEnd:
    """The stent's proximal end is nearest to this point: it reaches down to the outlets."""

    point: Floats

    def __post_init__(self) -> None:
        _keep_point(self, "point", "proximal end")


@dataclass(frozen=True, eq=False)
class BetweenPoints:
    """The stent lies on the way between two points, across junctions; their order is free."""

    start: Floats
    end: Floats

    def __post_init__(self) -> None:
        _keep_point(self, "start", "stent start")
        _keep_point(self, "end", "stent end")


@dataclass(frozen=True, eq=False)
class AlongAxis:
    """The curve (n, 3) itself is the axis, first point proximal; no centerline is needed."""

    points: Points

    def __post_init__(self) -> None:
        points = without_repeats(as_points(self.points, "stent axis", minimum=1))
        if len(points) < 2:
            raise InputError(
                "stent axis: expected a curve through at least two different points, "
                f"got {len(self.points)} point(s) at one place; draw a longer curve."
            )
        object.__setattr__(self, "points", read_only(points))


Placement = AtCenter | AtDistalEnd | AtProximalEnd | BetweenPoints | AlongAxis

PLACEMENT_NAMES = [kind.__name__ for kind in Placement.__args__]


def _keep_point(placement: object, field_name: str, name: str) -> None:
    point = as_point(getattr(placement, field_name), name)
    object.__setattr__(placement, field_name, read_only(point))
