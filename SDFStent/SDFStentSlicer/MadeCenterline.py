"""A centerline that is made of nothing but the vessel's surface, and the button for that."""

import time

from slicer.i18n import tr as _

from SDFStentLib.files import add_arrays, polydata_from_lines
from SDFStentLib.plan import vessel_of
from SDFStentLib.validation import InputError

from . import Conversion
from .Portions import SteppedRun, inPortions, working
from .SampleVessels import addModel


def portions(parameterNode, inputs):
    """Make a model of the vessel's centerline, in world coordinates, and choose it: a generator that yields None and returns the former one.

    What there is to say of it is in `status` afterward. Raises as `extract_centerline`, and where the vessel is another one by then.
    """
    node, segmentID = parameterNode.vessel, Conversion.segmentOf(parameterNode)
    stamp = Conversion.changeStamp(node), segmentID
    wall = yield from inputs.vesselInPortions(parameterNode)
    vessel, _why = vessel_of(wall.surface)
    found = yield from inPortions(vessel.extracted)
    chosen = parameterNode.vessel, Conversion.segmentOf(parameterNode)
    if (Conversion.changeStamp(chosen[0]), chosen[1]) != stamp:
        raise InputError(
            _(
                "Vessel {name}: expected it to stay as it is while its centerline is made, it has changed; make it again."
            ).format(name=node.GetName())
        )
    points, lines, radii = found.lines
    polyData = polydata_from_lines(points, lines)
    add_arrays(polyData, {"Radius": radii}, None)
    name = node.GetSegmentation().GetSegment(segmentID).GetName() if segmentID else node.GetName()
    made = addModel(node.GetScene(), _("{name} centerline").format(name=name), polyData)
    former, parameterNode.centerline = parameterNode.centerline, made
    parameterNode.status = "\n".join(map(str, found.warnings))
    return former


class CenterlineButton:
    """Makes a centerline of the vessel that is shown; while it does so, another click stops it.

    `attempt(action)` does what is asked for and says why when it cannot be done; `onMade(former)` is called with the centerline that was
    chosen before, or None.
    """

    def __init__(self, button, logic, attempt):
        self._button, self._logic, self._attempt, self._text = button, logic, attempt, button.text
        self.onMade = lambda _former: None
        self._parameterNode = self._vessel = self._former = self._begun = None
        self._run = SteppedRun(self._onProgress, self._finished)
        button.connect("clicked()", self._onClicked)

    @property
    def isRunning(self):
        """Whether a centerline is being made."""
        return self._run.isRunning

    def show(self, parameterNode):
        """The parameter node that is shown now, or None; what is made for another vessel is not made."""
        self._parameterNode = parameterNode
        if self.isRunning and self._vessel != _vesselOf(parameterNode):
            self.stop()

    def stop(self):
        """Make no centerline."""
        self._run.cancel()
        self._button.text = self._text

    def _onClicked(self):
        if self.isRunning:
            self.stop()
            return
        self._vessel, self._begun = _vesselOf(self._parameterNode), time.monotonic()
        self._onProgress(0.0)
        self._run.start(working(self._making(), self._seconds))

    def _making(self):
        self._former = yield from self._logic.centerlineInPortions(self._parameterNode)

    def _seconds(self):
        return time.monotonic() - self._begun

    def _onProgress(self, seconds):
        text = _("Stop, {seconds:.0f} s").format(seconds=seconds)
        if self._button.text != text:
            self._button.text = text

    def _finished(self, error):
        self._button.text = self._text
        self._attempt(lambda: self._end(error))

    def _end(self, error):
        if error is not None:
            raise error
        self.onMade(self._former)


def _vesselOf(parameterNode):
    """The node, and the vessel and the segment that it has."""
    if parameterNode is None:
        return None
    return parameterNode.parameterNode, parameterNode.vessel, Conversion.segmentOf(parameterNode)
