"""Handles that are let go beside the centerline, or have more points than count."""

from slicer.i18n import tr as _

from SDFStentLib.stent import beside
from SDFStentLib.treatment import axis_in_vessel

from . import Conversion, Handles, Plans
from .ParameterNode import Placement, stentsOf


class Snapping:
    """Moves handles onto the centerline, and knows how far those were moved that are still there."""

    def __init__(self):
        self._told = {}

    def snap(self, stent, centerline, surface):
        """Move the points of a stent's handle onto the centerline; a curve stays as it is drawn.

        Raises `InputError` where the library refuses the place, outside of the lumen as well; then the handle stays where it is.
        """
        handle = stent.handle
        if stent.placement == Placement.ALONG_CURVE or handle.IsA("vtkMRMLMarkupsCurveNode"):
            return
        planned = Plans.plannedStent(stent)
        axis_in_vessel(planned, centerline, surface)
        sentences = [
            f"{stent.label}: {caution}" for caution in beside(planned.placement, centerline)
        ]
        if Handles.snapHandle(handle, stent.placement, centerline):
            self._told[handle.GetID()] = (Conversion.changeStamp(handle), sentences)

    def told(self, parameterNode):
        """What the user has to know about handles that were moved far, and not again since, or have points to spare; a line each."""
        told = []
        for stent in stentsOf(parameterNode):
            stamp, sentences = self._told.get(stent.handle and stent.handle.GetID(), (None, []))
            if sentences and stamp == Conversion.changeStamp(stent.handle):
                told += sentences
            told += _spare(stent)
        return "\n".join(dict.fromkeys(told))


def _spare(stent):
    """A sentence where a handle has more points than its placement takes."""
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
