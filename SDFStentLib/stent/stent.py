"""A stent: its size and where it goes."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass

from ..validation import InputError, as_number
from .placement import (
    PLACEMENT_NAMES,
    AlongAxis,
    AtCenter,
    AtDistalEnd,
    AtProximalEnd,
    BetweenPoints,
    ByValue,
    InputFile,
    Placement,
)

MAXIMUM_DIAMETER = 100.0
"""Largest diameter that is taken for a stent's, mm; more is another unit or a slip."""

MAXIMUM_LENGTH = 500.0
"""Largest length that is taken for a stent's, mm."""

DEFAULT_FORESHORTENING = 0.10
"""Fraction of the nominal length that is lost on expansion where a nominal length is given."""


@dataclass(frozen=True, eq=False)
class Stent(ByValue):
    """A stent of constant diameter.

    Parameters
    ----------
    diameter : float
        Expanded diameter, mm.
    placement : Placement
        Where it goes.
    length : float, optional
        Nominal length, mm. Needed for a placement by one point, refused between two points;
        along an axis, None stands for the whole axis.
    foreshortening_fraction : float, optional
        Part of the nominal length that is lost on expansion, -0.2 (it grows) to 0.5. Default:
        0.10 where a length is given, else 0. Without a length the axis or way is the nominal one.
    name : str
        What the user calls it; may be empty.
    enabled : bool
        Switched off, it stays in a plan and is skipped.

    Raises
    ------
    InputError
        A size that is not a number or out of range, or a length that the placement rules out.
    """

    diameter: float
    _: KW_ONLY
    placement: Placement
    length: float | None = None
    foreshortening_fraction: float | None = None
    name: str = ""
    enabled: bool = True

    def __post_init__(self) -> None:
        as_number(self.diameter, "stent diameter", unit="mm", above=0, maximum=MAXIMUM_DIAMETER)
        if self.foreshortening_fraction is not None:
            as_number(self.foreshortening_fraction, "foreshortening", minimum=-0.2, maximum=0.5)
        if self.length is not None:
            as_number(self.length, "stent length", unit="mm", above=0, maximum=MAXIMUM_LENGTH)
        if not isinstance(self.placement, Placement):
            raise InputError(
                f"stent placement: expected one of {', '.join(PLACEMENT_NAMES)}, "
                f"got {type(self.placement).__name__}."
            )
        if self.length is not None and isinstance(self.placement, BetweenPoints):
            raise InputError(
                "stent length: expected none between two points, which determine it, "
                f"got {self.length:g} mm; leave out the length or one of the points."
            )
        if self.length is None and isinstance(
            self.placement, AtCenter | AtDistalEnd | AtProximalEnd
        ):
            raise InputError(
                "stent length: expected a length in mm for a placement by one point, got none; "
                "give the length, or two points."
            )

    @property
    def radius(self) -> float:
        """Half of the diameter, mm."""
        return self.diameter / 2.0

    @property
    def axis_file(self) -> InputFile | None:
        """The file from which its curve was read, where it is placed along one."""
        return self.placement.file if isinstance(self.placement, AlongAxis) else None

    @property
    def foreshortening(self) -> float:
        """The foreshortening fraction in use."""
        if self.foreshortening_fraction is not None:
            return self.foreshortening_fraction
        return 0.0 if self.length is None else DEFAULT_FORESHORTENING
