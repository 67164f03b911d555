"""Handles that are released beside the centerline, or have more points than are used."""

from slicer.i18n import tr as _

from . import Conversion, Handles, Plans
from .ParameterNode import stentsOf
from .PlanFields import Placement


class Snapping:
    """Moves handles onto the centerline. Remembers how far handles were moved that are still there, and which points
    lie in no vessel."""

    def __init__(self):
        self._sentences, self._aside = {}, {}

    def snap(self, stent, vessel):
        """Move the points of a stent's handle onto the centerline of the library's `Vessel`; a curve stays as it was drawn.

        Raises `InputError` if the library refuses the place, for example outside of the lumen; then the handle stays
        where it is.
        """
        handle = stent.handle
        if stent.placement == Placement.ALONG_CURVE or handle.IsA("vtkMRMLMarkupsCurveNode"):
            return
        cautions = vessel.place_cautions(Plans.plannedStent(stent))
        sentences = [f"{stent.label}: {caution}" for caution in cautions]
        if Handles.snapHandle(handle, stent.placement, vessel.centerline):
            self._sentences[handle.GetID()] = (Conversion.changeStamp(handle), sentences)

    def leave(self, handle, index):
        """Remember that a point of a handle was placed where no vessel is seen."""
        place = handle.GetNthControlPointPositionWorld(index)
        self._aside[handle.GetID(), handle.GetNthControlPointID(index)] = tuple(place)

    def reported(self, parameterNode):
        """Sentences about handles that were moved far or placed beside the vessel and not moved since, or that have
        more points than are used."""
        found = []
        for stent in stentsOf(parameterNode):
            stamp, sentences = self._sentences.get(
                stent.handle and stent.handle.GetID(), (None, [])
            )
            if sentences and stamp == Conversion.changeStamp(stent.handle):
                found += sentences
            found += self._besideVessel(stent) + _spare(stent)
        return "\n".join(dict.fromkeys(found))

    def _besideVessel(self, stent):
        """Sentences for points that still lie where they were placed beside the vessel."""
        handle = stent.handle
        text = _("{label}: no vessel is seen where point {number} was placed; drag it into one.")
        return [
            text.format(label=stent.label, number=index + 1)
            for index in ([] if handle is None else Conversion.placedIndices(handle))
            if self._aside.get((handle.GetID(), handle.GetNthControlPointID(index)))
            == tuple(handle.GetNthControlPointPositionWorld(index))
        ]


def _spare(stent):
    """A sentence if a handle has more points than its placement uses."""
    if stent.handle is None or not stent.placement.needsCenterline:
        return []
    count, placed = stent.placement.pointCount, len(Conversion.placedIndices(stent.handle))
    if placed <= count:
        return []
    if count == 1:
        text = _("{label}: of the {placed} points of {handle} only the first counts.")
    else:
        text = _("{label}: of the {placed} points of {handle} only the first two count.")
    return [text.format(label=stent.label, placed=placed, handle=stent.handle.GetName())]
