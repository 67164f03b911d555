"""The plan: one value that holds everything that determines a result.

`plan_document` turns it into JSON and back, `plan_run` carries it out.
"""

from __future__ import annotations

import os
from dataclasses import dataclass, field, fields, is_dataclass, replace
from typing import Any

import numpy as np

from .placement import AlongAxis
from .settings import DeploymentSettings
from .stent import Stent
from .units import Frame, flipped, millimeters_per
from .validation import InputError, as_number
from .version import VERSION


@dataclass(frozen=True)
class InputFile:
    """A file that goes into a plan: its absolute path, and its SHA-256 where that is known."""

    path: str
    sha256: str | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.path, str | os.PathLike) or not os.fspath(self.path):
            raise InputError(f"input file: expected a path, got {self.path!r}.")
        object.__setattr__(self, "path", os.path.abspath(self.path))


@dataclass(frozen=True, eq=False)
class PlannedStent:
    """A stent of a plan.

    Attributes
    ----------
    stent : Stent
        Size and placement, mm.
    name : str
        What the user calls it; may be empty.
    enabled : bool
        Switched off, it stays in the plan and is skipped.
    axis_file : InputFile, optional
        The file from which the curve of an `AlongAxis` placement was read.
    """

    stent: Stent
    name: str = ""
    enabled: bool = True
    axis_file: InputFile | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.stent, Stent):
            raise InputError(f"planned stent: expected a Stent, got {type(self.stent).__name__}.")
        if self.axis_file is not None and not isinstance(self.stent.placement, AlongAxis):
            raise InputError(
                "planned stent: expected a placement along an axis with an axis file, got "
                f"{type(self.stent.placement).__name__}; leave out the file."
            )

    def __eq__(self, other: object) -> bool:
        return isinstance(other, PlannedStent) and _values(self) == _values(other)

    def __hash__(self) -> int:
        return hash(_values(self))


@dataclass(frozen=True, eq=False)
class Plan:
    """Stents in order, where they go, in what, and how. Plans with the same values are equal.

    Attributes
    ----------
    stents : tuple of PlannedStent
        In the order of deployment: later ones see the vessel as earlier ones left it. Lengths and
        points in mm, in the frame `frame`.
    surface, centerline : InputFile, optional
        Left out where a program has them in memory.
    units : {"mm", "cm", "m"}
        Unit of the files, and of the points in the plan's document.
    frame : "RAS", "LPS" or None
        Frame of the points; `None` is the surface's, whatever that is.
    settings : DeploymentSettings
    straightening_fraction : float
        Share of the way to its chord by which every stent straightens its axis, 0 to 1.
    sdfstent_version : str
        Of the program that made the plan.
    """

    stents: tuple[PlannedStent, ...] = ()
    surface: InputFile | None = None
    centerline: InputFile | None = None
    units: str = "mm"
    frame: Frame | None = None
    settings: DeploymentSettings = field(default_factory=DeploymentSettings)
    straightening_fraction: float = 0.0
    sdfstent_version: str = VERSION

    def __post_init__(self) -> None:
        object.__setattr__(self, "stents", tuple(self.stents))
        millimeters_per(self.units)
        if self.frame not in (None, "RAS", "LPS"):
            raise InputError(f"frame: expected RAS, LPS or none, got {self.frame!r}.")
        as_number(self.straightening_fraction, "straightening fraction", minimum=0, maximum=1)
        for number, planned in enumerate(self.stents, start=1):
            if not isinstance(planned, PlannedStent):
                raise InputError(
                    f"stent {number} of the plan: expected a PlannedStent, "
                    f"got {type(planned).__name__}."
                )

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Plan) and _values(self) == _values(other)

    def __hash__(self) -> int:
        return hash(_values(self))


def turned(planned: PlannedStent) -> PlannedStent:
    """The stent in the other patient frame, RAS or LPS: x and y of its placement negated."""
    placement = planned.stent.placement
    changes: dict[str, Any] = {name: flipped(value) for name, value in vars(placement).items()}
    stent = replace(planned.stent, placement=replace(placement, **changes))
    return replace(planned, stent=stent)


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
