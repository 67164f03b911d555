"""A stent's parameters as the library's stent: its sizes, device, balloon and shape, and whether they fit together."""

import json
from dataclasses import replace

from SDFStentLib import stent as library
from SDFStentLib.plan import part_of, read_place, stent_of
from SDFStentLib.stent import dilated_again
from SDFStentLib.validation import InputError

from .ParameterNode import stentsOf
from .PlanFields import REMEDIES, Placement

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

ELSEWHERE = ("name", "enabled", "placement")
"""What of a stent's entry does not say what it is."""


def sizesOf(stent):
    """A text with all that says what a stent is, wherever it goes."""
    own = {key: value for key, value in stent.entry.items() if key not in ELSEWHERE}
    return json.dumps([stent.placement.value, own])


def partOf(kind, stent, name):
    """Device, balloon or shape of a stent as it was set, as the library's; None where there is none."""
    return part_of(kind, stent.entry, name)


def deviceOf(stent):
    """The device of a stent, or None."""
    return partOf(library.Device, stent, "device")


def landmarkOf(stent):
    """The library's placement at a lesion or on a branch; None where there is none yet."""
    place = stent.entry["placement"]
    isKnown = stent.placement.isOfVessel and place[stent.placement.value] is not None
    return read_place(place, stent.label) if isKnown else None


def lengthOf(stent):
    """Length as packed, mm: of a device of one length that, whatever is set."""
    return (stent.device or {}).get("nominal_length") or stent.length


def hasLength(stent):
    """Whether a stent has a length, rather than that of its handle."""
    isPart = stent.placement == Placement.ALONG_CURVE and not stent.wholeCurve
    return isPart or not stent.placement.usesHandleLength


def hasFreeLength(stent):
    """Whether its length is what is set, rather than that of its device."""
    return hasLength(stent) and not (stent.device or {}).get("nominal_length")


def asksForShortening(stent):
    """Whether a stent shall shorten as is known of its device, and that is not known."""
    device = deviceOf(stent)
    isKnown = device is None or device.foreshortening_fraction is not None or device.lengths
    return stent.deviceShortening and not isKnown


def balloonOf(stent):
    """The balloon that leaves the stent's lumen, or None."""
    kept = partOf(library.Balloon, stent, "balloon")
    try:
        return kept and unplaced(stent).balloon
    except InputError:
        return kept


def isLumenSet(stent):
    """Whether the diameter of a stent on a balloon was set after that of the balloon, which follows it."""
    return stent.diameter != partOf(library.Balloon, stent, "balloon").lumen_diameter


def shapeOf(stent):
    """What makes the stent another than a cylinder, or None."""
    try:
        return stent.shape and unplaced(stent).shape
    except InputError:
        return partOf(library.Shape, stent, "shape")


def stentAt(stent, placement=None, label=""):
    """The library's stent of these parameters at a place, or at none yet."""
    isAgain = stent.placement == Placement.AGAIN
    isByDevice = stent.deviceShortening and (isAgain or stent.device is not None)
    own = {
        "name": label,
        "enabled": True,
        "length": lengthOf(stent) if hasLength(stent) else None,
        "foreshortening_fraction": None if isByDevice else stent.entry["foreshortening_fraction"],
    }
    return stent_of({**stent.entry, **own}, placement)


def unplaced(stent):
    """The library's stent at no place yet. Raises `InputError` where its sizes do not fit together, or to a place of its kind."""
    planned = stentAt(stent)
    planned.check_kind(KINDS[stent.placement])
    return planned


def numbersAgain(stents):
    """The number, from 1, of the planned stent that each of a list dilates again; None where there is none.

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
