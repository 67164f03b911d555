"""A stent's parameters as the library's stent: its sizes, device, balloon and shape, and whether they fit together."""

from dataclasses import replace
from functools import lru_cache
from types import SimpleNamespace

import numpy as np

from SDFStentLib import stent as library
from SDFStentLib.plan import StentSizes, detailed_stent, read_details
from SDFStentLib.stent import dilated_again
from SDFStentLib.validation import InputError

from .ParameterNode import REMEDIES, Placement, stentsOf

BY_POINT = {
    Placement.CENTER: library.AtCenter,
    Placement.DISTAL_END: library.AtDistalEnd,
    Placement.PROXIMAL_END: library.AtProximalEnd,
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
        return kept and somewhere(stent).balloon
    except InputError:
        return kept


def isLumenSet(stent):
    """Whether the diameter of a stent on a balloon was set after that of the balloon, which follows it."""
    return stent.diameter != detailsOf(stent).balloon.lumen_diameter


def shapeOf(stent):
    """What makes the stent another than a cylinder, or None."""
    kept = detailsOf(stent).shape
    try:
        return kept and somewhere(stent).shape
    except InputError:
        return kept


def stentAt(stent, placement, label=""):
    """The library's stent of these parameters at a place of its kind."""
    isAgain = stent.placement == Placement.AGAIN
    isByDevice = stent.deviceShortening and (isAgain or detailsOf(stent).device is not None)
    sizes = StentSizes(
        stent.diameter,
        lengthOf(stent) if hasLength(stent) else None,
        None if isByDevice else stent.foreshortening / 100,
    )
    return detailed_stent(stent.details, sizes, placement, label)


def somewhere(stent):
    """The library's stent at no place yet. Raises `InputError` where its sizes do not fit together."""
    places = {
        Placement.BETWEEN_POINTS: lambda: library.BetweenPoints(np.zeros(3), np.ones(3)),
        Placement.ALONG_CURVE: lambda: library.AlongAxis([[0, 0, 0], [1, 1, 1]]),
        Placement.AGAIN: lambda: library.OfStent(1),
    }
    place = places.get(stent.placement, lambda: BY_POINT[stent.placement](np.zeros(3)))
    return stentAt(stent, place())


WIDER = 2.0
"""To which a stent that is nowhere is dilated again, mm."""


def nowhere(stent):
    """A stent of the library that is switched off, 1 mm wide, in the place of one that cannot be made yet."""
    place = library.AtCenter(np.zeros(3))
    return library.Stent(1.0, placement=place, length=1.0, name=stent.label, enabled=False)


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
    return withRedilations([somewhere(stent)], [stent.redilation])[-1].diameter


def withRedilations(planned, redilations):
    """Stents in order, each followed by itself once more where it is dilated to a second diameter, mm, above 0."""
    following = []
    for stent, diameter in zip(planned, redilations, strict=True):
        following.append(stent)
        if diameter > 0:
            again = dilated_again(stent, len(following), diameter)
            following.append(replace(again, name=nameAgain(stent.name)))
    return following


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
        withRedilations([somewhere(stent)], [stent.redilation])
    except InputError as error:
        return error.sentence(REMEDIES)
    return ""


def foreshorteningOf(stent):
    """The foreshortening in use, percent; what is set where that of the device is not known."""
    try:
        return 100 * somewhere(stent).foreshortening
    except InputError:
        return stent.foreshortening
