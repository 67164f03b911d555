"""The wall of a segment that has no surface yet: the application shows such a one in slices only."""

import slicer
from slicer.i18n import tr as _
from slicer.util import VTKObservationMixin
from vtkmodules.vtkCommonCore import vtkCommand

from . import Clock, Conversion, Display
from .Marks import createWall, removeMark
from .Portions import SteppedRun, working

SETTLE_MS = 250
"""The segment has to rest so long, so that nothing is made while it is being edited."""


class SegmentWall(VTKObservationMixin):
    """Shows the wall of the segment that is chosen as a mark in the 3D views, where the segment is to be seen there.

    `wallOf(parameterNode)` are portions that return the `VesselInput`. The segmentation, an input, does not change.
    """

    def __init__(self, wallOf):
        VTKObservationMixin.__init__(self)
        self._wallOf = wallOf
        self._parameterNode = self._vessel = self._mark = self._shown = self._seen = None
        self._timer = Clock.timer(self._begin, SETTLE_MS)
        self._run = SteppedRun(lambda _value: None, lambda _error: None)  # others tell errors

    def show(self, parameterNode):
        """Show the wall for a parameter node, or none."""
        self._parameterNode = parameterNode
        vessel = parameterNode and parameterNode.vessel
        if vessel is not self._vessel:
            self.removeObservers()
            self._vessel = vessel
            for event in _EVENTS if _isSegmentation(vessel) else ():
                self.addObserver(vessel, event, self._follow)
        self._follow()

    def _follow(self, _caller=None, _event=None):
        wanted = self._wanted()
        if wanted is not None and wanted == self._shown:
            return
        self._run.cancel()
        if wanted is None:
            self._timer.stop()
            self._replace(None, None)
        else:
            self._timer.start()

    def _wanted(self):
        """A value that differs whenever the wall does; None where there is none to be shown."""
        if self._parameterNode is None or not _isSegmentation(self._vessel):
            return None
        segmentID, display = (
            Conversion.segmentOf(self._parameterNode),
            self._vessel.GetDisplayNode(),
        )
        segment = self._vessel.GetSegmentation().GetSegment(segmentID or "")
        if segment is None or display is None or _hasSurface(segment):
            return None
        isSeen = display.GetVisibility() and display.GetVisibility3D()
        isSeen = isSeen and display.GetSegmentVisibility(segmentID)
        if not isSeen or not display.GetSegmentVisibility3D(segmentID):
            return None
        return Conversion.changeStamp(self._vessel), segmentID, segment.GetColor()

    def _begin(self):
        self._run.start(self._made(self._wanted()))

    def _made(self, wanted):
        wall = yield from working(self._wallOf(self._parameterNode), lambda: 0.0)
        if wanted != self._wanted():
            return
        _stamp, segmentID, color = wanted
        self._replace(createWall(_("Wall of the segment"), wall.polyData, color), wanted)
        chosen = self._vessel.GetID(), segmentID
        if chosen != self._seen:  # who looks at a part of it meanwhile goes on to
            self._seen = chosen
            Display.bringIntoView(wall.polyData)

    def _replace(self, mark, shown):
        removeMark(self._mark)
        self._mark, self._shown = mark, shown


_EVENTS = (
    vtkCommand.ModifiedEvent,
    slicer.vtkMRMLDisplayableNode.DisplayModifiedEvent,
    slicer.vtkMRMLTransformableNode.TransformModifiedEvent,
)


def _isSegmentation(vessel):
    return vessel is not None and vessel.IsA("vtkMRMLSegmentationNode")


def _hasSurface(segment):
    name = slicer.vtkSegmentationConverter.GetSegmentationClosedSurfaceRepresentationName()
    return segment.GetRepresentation(name) is not None
