"""A stent: its size and where it goes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import KW_ONLY, dataclass, replace

from ..cautions import Caution
from ..parameter import check_parameters, parameter
from ..validation import InputError, check_is_a, printable
from .balloon import Balloon, check_lumen
from .device import (
    LEAST_FORESHORTENING,
    MOST_FORESHORTENING,
    Device,
    diameter_field,
    length_field,
    part_field,
)
from .placement import (
    PLACEMENT_NAMES,
    AlongAxis,
    AtCenter,
    AtDistalEnd,
    AtLesion,
    AtProximalEnd,
    BetweenPoints,
    ByValue,
    InputFile,
    OnBranch,
    Placement,
)
from .shape import Shape

DEFAULT_FORESHORTENING = 0.10
"""Usual foreshortening, as a fraction of the nominal length where one is given."""


KEPT = ("center", "proximal", "distal")
"""Places that can stay where they are when a stent shortens."""

_KEPT_BY_PLACE: dict[type, str] = {AtProximalEnd: "proximal", AtDistalEnd: "distal"}

_BY_LENGTH = (AtCenter, AtDistalEnd, AtProximalEnd, AtLesion, OnBranch)
"""Placements that say where one place of a stent is: its length says where its ends are."""


@dataclass(frozen=True, eq=False)
class Stent(ByValue):
    """A stent of constant diameter.

    Parameters
    ----------
    diameter : float
        Diameter of the deployed lumen, mm.
    placement : Placement, optional
        Placement in the vessel; without one it lies nowhere yet, and cannot be deployed.
    length : float, optional
        Nominal length, mm. Needed for a placement by one point, refused between two points;
        along an axis, None stands for the whole axis. That of the device where it has one.
    foreshortening_fraction : float, optional
        Part of the nominal length that is lost on expansion, -0.2 (it grows) to 0.5. Default:
        where a length is given that of the device at the diameter, or 0.10 without a device; else
        0. Without a length the axis or way is the nominal one.
    device : Device, optional
        Device that it is.
    balloon : Balloon, optional
        Balloon that expands it; the diameter is the one that it leaves.
    shape : Shape, optional
        Shape, if it is no cylinder of that diameter.
    keeps : str
        Place that stays when the stent shortens: its center, or its proximal or distal end.
        A stent that is placed by an end keeps that one.
    may_be_shortened : bool
        Whether it is deployed also with less than half of it on the vessel.
    name : str
        Name by the user; may be empty.
    enabled : bool
        Switched off, it stays in a plan and is skipped.

    Raises
    ------
    InputError
        A size that is not a number or out of range, or a length that the placement rules out; a
        diameter beyond the device's, another length than it has, or one whose shortening is not
        known.
    """

    diameter: float = diameter_field(
        "of the lumen that is deployed; with a recoil, that of the balloon",
        option="diameter",
        called="stent diameter",
    )
    _: KW_ONLY
    placement: Placement | None = None
    length: float | None = length_field(
        "nominal length; along a curve about its middle, none between two points",
        default=None,
        option="length",
        called="stent length",
    )
    foreshortening_fraction: float | None = part_field(
        "part of the nominal length that is lost on expansion; by default with a length that "
        f"of the device, or {DEFAULT_FORESHORTENING:g} without a device; else 0",
        LEAST_FORESHORTENING,
        MOST_FORESHORTENING,
        default=None,
        option="foreshortening",
        called="foreshortening",
    )
    device: Device | None = None
    balloon: Balloon | None = None
    keeps: str = parameter(
        "what stays where it is when the stent shortens; one that is placed by an end keeps that",
        default="center",
        names=KEPT,
        option="keep",
    )
    shape: Shape | None = None
    may_be_shortened: bool = parameter(
        "deploy it also where less than half of it can lie on the vessel",
        default=False,
        option="shortened",
    )
    name: str = ""
    enabled: bool = True

    def __post_init__(self) -> None:
        check_parameters(self)
        if self.balloon is not None:
            check_is_a(self.balloon, Balloon, "balloon")
            check_lumen(self.balloon, self.diameter)
        if self.shape is not None:
            check_is_a(self.shape, Shape, "shape")
            self.shape.check(self.diameter)
        if self.device is not None:
            self._fit_to(self.device)
        if self.keeps not in KEPT:
            raise InputError(
                f"stent: expected what it keeps as one of {', '.join(KEPT)}, got {self.keeps!r}; "
                "choose one."
            )
        if not isinstance(self.placement, Placement | None):
            raise InputError(
                f"stent placement: expected one of {', '.join(PLACEMENT_NAMES)}, "
                f"got {type(self.placement).__name__}; choose one."
            )
        if self.placement is not None:
            self.check_kind(type(self.placement))
        _ = self.foreshortening  # not known, it is missed here rather than in the vessel

    def at(self, placement: Placement | None) -> Stent:
        """The stent at another place, or at none; errors as of a new one."""
        return replace(self, placement=placement)

    @property
    def radius(self) -> float:
        """Half of the diameter, mm."""
        return self.diameter / 2.0

    @property
    def inflated_diameter(self) -> float:
        """Diameter of the balloon that expands it, or its own without one, mm."""
        return self.diameter if self.balloon is None else self.balloon.diameter

    @property
    def widest_diameter(self) -> float:
        """The diameter where it is widest, ends included, mm."""
        return self.diameter if self.shape is None else self.shape.widest(self.diameter)

    @property
    def axis_file(self) -> InputFile | None:
        """The file from which its curve was read, where it is placed along one."""
        return self.placement.file if isinstance(self.placement, AlongAxis) else None

    @property
    def foreshortening(self) -> float:
        """The foreshortening fraction in use."""
        if self.foreshortening_fraction is not None:
            return self.foreshortening_fraction
        if self.length is None:
            return 0.0
        if self.device is None:
            return DEFAULT_FORESHORTENING
        return self.device.foreshortening_at(self.diameter)

    @property
    def kept(self) -> str:
        """Place that stays when it shortens: that by which it is placed, else `keeps`."""
        return _KEPT_BY_PLACE.get(type(self.placement), self.keeps)

    def device_cautions(self) -> Iterator[Caution]:
        """Cautions for a use beyond its device's known sizes; none without a device.

        The device is opened as far as its balloon, or where the stent is widest.
        """
        if self.device is None:
            return
        widest = max(self.inflated_diameter, self.widest_diameter)
        for caution in self.device.cautions(self.diameter, self.length, widest):
            # Where the user says how much it loses, what its row knows of that does not matter.
            if caution.kind != "device-shortening" or self.foreshortening_fraction is None:
                yield caution

    def check_kind(self, kind: type) -> None:
        """Refuse a kind of placement that the sizes rule out anywhere.

        Raises
        ------
        InputError
            An end that is kept, though it is placed by the other one; no length for a placement by
            one point, or one between two.
        """
        by_end = _KEPT_BY_PLACE.get(kind)
        if by_end is not None and self.keeps not in ("center", by_end):
            raise InputError(
                f"stent: expected its {by_end} end to be kept, by which it is placed, got the "
                f"{self.keeps} one; place it by that, or by its middle."
            )
        own = None if self.device is None else self.device.nominal_length
        if own is not None and issubclass(kind, BetweenPoints):
            assert self.device is not None
            name = printable(self.device.name)
            raise InputError(
                f"stent placement: expected one point for {name}, which is {own:g} mm long, got "
                "two; place it by its middle or one end."
            )
        if self.length is not None and issubclass(kind, BetweenPoints):
            raise InputError(
                "stent length: expected none between two points, which determine it, "
                f"got {self.length:g} mm; leave out the length or one of the points."
            )
        if self.length is None and issubclass(kind, _BY_LENGTH):
            raise InputError(
                "stent length: expected a length in mm for a placement by one point, got none; "
                "give the length, or two points."
            )

    def _fit_to(self, device: Device) -> None:
        """Check the sizes against those of a device, and take over its length."""
        check_is_a(device, Device, "device")
        if self.balloon is not None:
            device.check_diameter(self.balloon.diameter, "balloon diameter")
        device.check_diameter(self.widest_diameter)
        own, name = device.nominal_length, printable(device.name)
        if own is not None and self.length not in (None, own):
            raise InputError(
                f"stent length: expected {own:g} mm, the length of {name}, got {self.length:g} mm; "
                "leave the length out, or choose another device."
            )
        if device.sold_lengths and self.length not in (None, *device.sold_lengths):
            listed = ", ".join(f"{length:g}" for length in device.sold_lengths)
            raise InputError(
                f"stent length: expected one in which {name} is sold ({listed} mm), got "
                f"{self.length:g} mm; choose one of them, or another device."
            )
        if self.foreshortening_fraction is not None and device.lengths:
            raise InputError(
                f"foreshortening: expected none with {name}, whose lengths are known, got "
                f"{self.foreshortening_fraction:g}; leave it out, or choose another device."
            )
        object.__setattr__(self, "length", self.length if own is None else own)
