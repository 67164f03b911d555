"""The same stent once more, at a larger diameter."""

from __future__ import annotations

from dataclasses import replace

from ..validation import InputError
from .placement import OfStent
from .stent import Stent
from .stent_axis import StentAxis


def redilated(stent: Stent, first: Stent, axis: StentAxis) -> Stent:
    """What a stent that is placed by `OfStent` is: the earlier one, at another diameter.

    Its nominal length, device and shortening are those of the earlier one; with a table of lengths
    it shortens to the one at the new diameter.

    Parameters
    ----------
    stent : Stent
        At its new diameter.
    first : Stent
        The earlier one, as it was resolved itself.
    axis : StentAxis
        Where the earlier one lies.

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
    if stent.diameter <= first.diameter:
        raise InputError(
            f"redilation: expected more than the {first.diameter:g} mm of stent "
            f"{placement.number}, got {stent.diameter:g} mm; choose a larger diameter."
        )
    lost = stent.foreshortening_fraction
    known = first.device is not None and first.device.lengths
    return replace(
        stent,
        length=axis.nominal_length,
        device=first.device,
        foreshortening_fraction=first.foreshortening if lost is None and not known else lost,
    )
