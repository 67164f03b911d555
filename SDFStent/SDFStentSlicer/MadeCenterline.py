"""Centerline made of the vessel's surface alone."""

import threading

from slicer.i18n import tr as _

from SDFStentLib.files import add_arrays, polydata_from_lines
from SDFStentLib.plan import vessel_of
from SDFStentLib.validation import InputError

from . import Conversion
from .Portions import inPortions, working
from .SampleVessels import addModel


class _Left(Exception):
    """Nobody waits for the centerline any more."""


def portions(parameterNode, inputs):
    """Make a model of the vessel's centerline, in world coordinates, and choose it: a generator that yields the share that is done and returns the former one.

    What there is to say of it is in `status` afterward. Raises as `extract_centerline`, and where the vessel is another one by then.
    """
    node, segmentID = parameterNode.vessel, Conversion.segmentOf(parameterNode)
    stamp = Conversion.changeStamp(node), segmentID
    wall = yield from working(inputs.vesselInPortions(parameterNode), lambda: 0.0)
    found = yield from _extracted(vessel_of(wall.surface)[0])
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


def _extracted(vessel):
    """Extract the centerline of the library's `Vessel`; yields the share that is done. Closing the generator ends that soon, too."""
    shares, isLeft = [0.0], threading.Event()

    def show(share):
        if isLeft.is_set():
            raise _Left
        shares.append(share)

    try:
        return (
            yield from working(inPortions(lambda: vessel.extracted(show=show)), lambda: shares[-1])
        )
    finally:
        isLeft.set()
