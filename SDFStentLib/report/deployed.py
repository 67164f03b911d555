"""Which stent was deployed: how wide, how long, and why it is shorter than it was packed."""

from __future__ import annotations

from ..stent import OfStent, Stent
from ..treatment import TreatedStent
from .shapes import prescribed_words

CUT = 0.1
"""By so much less than prescribed, mm, a stent is told to be cut; as its warning has it."""


def shortening_reason(stent: Stent) -> str | None:
    """Why so much is taken off the length of a stent; None where no length was given."""
    if stent.length is None and stent.foreshortening_fraction is None:
        return None
    if isinstance(stent.placement, OfStent) and not stent.foreshortening:
        return None
    if stent.foreshortening_fraction is not None:
        return "as given"
    if stent.device is None:
        return "the usual share, assumed without a device"
    return f"as known of {stent.device.name}"


def deployed_words(treated: TreatedStent) -> str:
    """A stent by its sizes, as deployed and as packed."""
    stent, axis = treated.stent, treated.axis
    name = "stent of" if stent.device is None else f"{stent.device.name},"
    size = prescribed_words(treated).replace(" mm", "")
    words = f"{name} {size} x {axis.deployed_length:.1f} mm"
    told = []
    if stent.balloon is not None:
        told.append(f"balloon {stent.balloon.diameter:g} mm")
    reason = shortening_reason(stent)
    if reason is not None and stent.foreshortening:
        percent = 100 * stent.foreshortening
        change = f"{abs(percent):.3g} % {'shorter' if percent > 0 else 'longer'}"
        told.append(f"{axis.nominal_length:g} mm as packed, {change} once expanded: {reason}")
        if axis.deployed_length < axis.prescribed_length - CUT:
            told.append(f"of {axis.prescribed_length:.1f} mm the rest lies beyond the centerline")
    return f"{words} ({'; '.join(told)})" if told else words
