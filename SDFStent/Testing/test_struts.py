"""Stents drawn as rings and struts in place of tubes."""

import numpy as np
import pytest
import slicer
from panel_helpers import deploy

from SDFStentLib.geometry import Line


def distances(parameters, run):
    """Of all points of the stents' model from the axis, mm."""
    (stent,) = run.result.stents
    points = slicer.util.arrayFromModelPoints(parameters.outputStents)
    return Line(stent.axis.points).nearest(points).distances


def cells(parameters):
    """Lines and polygons of the stents' model."""
    data = parameters.outputStents.GetPolyData()
    return data.GetNumberOfLines(), data.GetNumberOfPolys()


def test_struts_are_shown_in_place_of_tubes_and_tubes_again(host, aStent):
    deploy(host, aStent)
    parameters, box = aStent._parameterNode, aStent.ui.showDeviceCheckBox
    node, tubes = parameters.outputStents, cells(parameters)
    assert tubes[0] == 0
    assert not box.checked
    box.checked = True
    host.process()
    lines, polygons = cells(parameters)
    assert polygons == 0
    assert lines % 16 == 0  # two struts for each of eight crowns, ring by ring
    assert parameters.outputStents is node  # so it stays where it is in the subject hierarchy
    run = aStent.logic.lastRun(parameters)
    assert np.median(distances(parameters, run)) == pytest.approx(8.5 / 2, abs=0.01)
    box.checked = False
    host.process()
    assert cells(parameters) == tubes
