"""Redilation: the same stent once more, at a larger diameter."""

from __future__ import annotations

from dataclasses import replace

from ..validation import InputError
from .balloon import Balloon, balloon_by_rule
from .placement import AtDistalEnd, AtProximalEnd, OfStent
from .stent import Stent
from .stent_axis import StentAxis

_KEPT: dict[type, str] = {AtDistalEnd: "distal", AtProximalEnd: "proximal"}


def dilated_again(stent: Stent, number: int, diameter: float) -> Stent:
    """The stent that dilates a stent of a plan once more.

    Parameters
    ----------
    stent : Stent
        The earlier one.
    number : int
        Number of that stent in the plan, from 1.
    diameter : float
        Diameter of the second balloon, if the first has one, else of the lumen, mm. The second
        recoils as the first, or by the rule in the lumen that the first has left.

    Raises
    ------
    InputError
        A diameter that is not larger, or beyond the device's.
    """
    balloon = None if stent.balloon is None else _second_balloon(stent, stent.balloon, diameter)
    by_end = _KEPT.get(type(stent.placement))
    again = Stent(
        diameter if balloon is None else balloon.lumen_diameter,
        placement=OfStent(number),
        balloon=balloon,
        keeps=by_end or stent.keeps,
        enabled=stent.enabled,
    )
    _check_larger(again, stent, number)
    if stent.device is not None:
        stent.device.check_diameter(diameter, "redilation")
    return again


def _second_balloon(stent: Stent, first: Balloon, diameter: float) -> Balloon:
    if first.is_given:
        return Balloon(diameter, first.recoil_fraction)
    # What it finds is the lumen that the first has left.
    return balloon_by_rule(diameter, stent.diameter)


def redilated(stent: Stent, first: Stent, axis: StentAxis) -> Stent:
    """The earlier stent at another diameter, for a stent that is placed by `OfStent`.

    Its nominal length, device and shortening are those of the earlier one; with a table of lengths
    it shortens to the one at the new diameter.

    Parameters
    ----------
    stent : Stent
        At its new diameter.
    first : Stent
        The earlier one, as it was resolved itself.
    axis : StentAxis
        Axis of the earlier one.

    Raises
    ------
    InputError
        A diameter that is not larger, or not possible with the device; a length or a device of
        its own.
    """
    placement = stent.placement
    assert isinstance(placement, OfStent)
    for what, own in (("length", stent.length), ("device", stent.device)):
        if own is not None:
            raise InputError(
                f"redilation: expected no {what} of its own, for it is stent {placement.number}, "
                "got one; leave it out."
            )
    _check_larger(stent, first, placement.number)
    lost = stent.foreshortening_fraction
    if lost is None:
        # Without a length it was as long as its way; else what its device, or the user, says holds.
        is_way = first.length is None
        lost = first.foreshortening if is_way else first.foreshortening_fraction
    return replace(
        stent, length=axis.nominal_length, device=first.device, foreshortening_fraction=lost
    )


def _check_larger(stent: Stent, first: Stent, number: int) -> None:
    if stent.diameter <= first.diameter:
        raise InputError(
            f"redilation: expected more than the {first.diameter:g} mm of stent {number}, got "
            f"{stent.diameter:g} mm; choose a larger diameter."
        )
