"""A stent's parameters as the library's stent: its sizes, device, balloon and shape, and whether they fit together."""

import json
from dataclasses import replace
from functools import lru_cache
from types import SimpleNamespace

from SDFStentLib import stent as library
from SDFStentLib.plan import StentSizes, detailed_stent, read_details, read_place
from SDFStentLib.stent import dilated_again
from SDFStentLib.validation import InputError

from .ParameterNode import REMEDIES, Placement, stentsOf

KINDS = {
    Placement.CENTER: library.AtCenter,
    Placement.DISTAL_END: library.AtDistalEnd,
    Placement.PROXIMAL_END: library.AtProximalEnd,
    Placement.BETWEEN_POINTS: library.BetweenPoints,
    Placement.ALONG_CURVE: library.AlongAxis,
    Placement.AGAIN: library.OfStent,
    Placement.AT_LESION: library.AtLesion,
    Placement.ON_BRANCH: library.OnBranch,
}
"""What the library calls them."""

BY_POINT = {
    kind: KINDS[kind] for kind in (Placement.CENTER, Placement.DISTAL_END, Placement.PROXIMAL_END)
}

SIZES = (
    "diameter",
    "length",
    "foreshortening",
    "placement",
    "wholeCurve",
    "details",
    "deviceShortening",
    "redilation",
)
"""The parameters of a stent that say what it is, wherever it goes."""


def sizesOf(stent):
    """The values of `SIZES`."""
    return tuple(getattr(stent, name) for name in SIZES)


def detailsOf(stent):
    """Device, balloon, kept end and shape of a stent, as the library's `StentDetails`."""
    return read_details(stent.details)


def landmarkOf(stent):
    """The library's placement at a lesion or on a branch that is kept; None where there is none of the stent's kind."""
    kept = read_place(json.loads(stent.landmark), stent.label) if stent.landmark else None
    return kept if isinstance(kept, KINDS[stent.placement]) else None


def lengthOf(stent):
    """Length as packed, mm: of a device of one length that, whatever is set."""
    device = detailsOf(stent).device
    return (device and device.nominal_length) or stent.length


def hasLength(stent):
    """Whether a stent has a length, rather than that of its handle."""
    isPart = stent.placement == Placement.ALONG_CURVE and not stent.wholeCurve
    return isPart or not stent.placement.usesHandleLength


def hasFreeLength(stent):
    """Whether its length is what is set, rather than that of its device."""
    device = detailsOf(stent).device
    return hasLength(stent) and (device is None or device.nominal_length is None)


def asksForShortening(stent):
    """Whether a stent shall shorten as is known of its device, and that is not known."""
    device = detailsOf(stent).device
    isKnown = device is None or device.foreshortening_fraction is not None or device.lengths
    return stent.deviceShortening and not isKnown


def balloonOf(stent):
    """The balloon that leaves the stent's lumen, or None."""
    kept = detailsOf(stent).balloon
    try:
        return kept and unplaced(stent).balloon
    except InputError:
        return kept


def isLumenSet(stent):
    """Whether the diameter of a stent on a balloon was set after that of the balloon, which follows it."""
    return stent.diameter != detailsOf(stent).balloon.lumen_diameter


def shapeOf(stent):
    """What makes the stent another than a cylinder, or None."""
    kept = detailsOf(stent).shape
    try:
        return kept and unplaced(stent).shape
    except InputError:
        return kept


def stentAt(stent, placement=None, label=""):
    """The library's stent of these parameters at a place, or at none yet."""
    isAgain = stent.placement == Placement.AGAIN
    isByDevice = stent.deviceShortening and (isAgain or detailsOf(stent).device is not None)
    sizes = StentSizes(
        stent.diameter,
        lengthOf(stent) if hasLength(stent) else None,
        None if isByDevice else stent.foreshortening / 100,
    )
    return detailed_stent(stent.details, sizes, placement, label)


def unplaced(stent):
    """The library's stent at no place yet. Raises `InputError` where its sizes do not fit together, or to a place of its kind."""
    planned = stentAt(stent)
    planned.check_kind(KINDS[stent.placement])
    return planned


def numbersAgain(stents):
    """For every stent of a list the number, from 1, of the planned one that it dilates again; None where there is none.

    That is the stent as it lies by then: where it was dilated again before, as that. A stent that has a second diameter of its own
    counts twice.
    """
    numbers, latest, count = [], {}, 0
    for stent in stents:
        count += 1
        place = stent.handle.GetID() if stent.handle is not None else None
        isAgain = stent.placement == Placement.AGAIN
        numbers.append(latest.get(place) if isAgain else None)
        count += stent.redilation > 0
        # One that is off is not dilated again where another one lies there.
        if stent.enabled if place in latest else not isAgain:
            latest[place] = count
    return numbers


def dilatedBy(parameterNode):
    """The stent that the selected one dilates again, as its parameters, as it lies by then; None where it dilates none."""
    stent, stents = parameterNode.stent, stentsOf(parameterNode)[: max(parameterNode.selected, 0)]
    if stent.placement != Placement.AGAIN:
        return None
    same = [one for one in stents if one.handle is stent.handle]
    isOn = [one for one in same if one.enabled or one.placement != Placement.AGAIN]
    return isOn[-1] if isOn else None


def lumenLeft(stent):
    """The lumen that a stent leaves, dilated again where it is at once, mm; `InputError` where its sizes do not fit together."""
    return _inTheEnd(stent).diameter


def _inTheEnd(stent):
    """The library's stent, dilated again where it is at once."""
    planned = unplaced(stent)
    return dilatedAgain(planned, 1, stent.redilation) if stent.redilation > 0 else planned


def dilatedAgain(planned, number, diameter):
    """A stent of the library, which has a number in its plan, once more, at a second diameter, mm."""
    return replace(dilated_again(planned, number, diameter), name=nameAgain(planned.name))


def nameAgain(name):
    """How a stent that is dilated once more is called; nothing without a name."""
    return f"{name}, dilated again" if name else ""


def refusal(stent):
    """Why the sizes of a stent do not fit together, in the library's sentence; "" when they do."""
    return _refusal(sizesOf(stent))


@lru_cache(maxsize=256)
def _refusal(values):
    stent = SimpleNamespace(**dict(zip(SIZES, values, strict=True)))
    try:
        _inTheEnd(stent)
    except InputError as error:
        return error.sentence(REMEDIES)
    return ""


def foreshorteningOf(stent):
    """The foreshortening in use, percent; what is set where that of the device is not known."""
    try:
        return 100 * unplaced(stent).foreshortening
    except InputError:
        return stent.foreshortening
