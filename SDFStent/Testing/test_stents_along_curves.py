"""Stents whose axis is a markups curve."""

import numpy as np
import pytest
import slicer
from panel_helpers import theThroat


def draw(panel, curve):
    """Put a curve along the throat, as a user does by clicking."""
    from SDFStentSlicer import Conversion

    tree = Conversion.centerlineOf(slicer.util.getNode("Artery centerline"))
    for point in tree.path_around(theThroat(), 15.0).points[::3]:
        curve.AddControlPointWorld(*point)


@pytest.fixture
def aCurveStent(host, aPanel, aVessel):
    """The panel with a vessel, no centerline, and a stent along a curve of three millimeter steps."""
    aPanel.ui.vesselSelector.setCurrentNode(aVessel[0])
    host.click(aPanel.ui.addStentButton)
    draw(aPanel, aPanel._parameterNode.stent.handle)
    aPanel.ui.diameterSlider.value = 8.5
    return aPanel


def test_add_without_a_centerline_makes_a_stent_along_an_empty_curve(host, aPanel, aVessel):
    assert not aPanel.ui.addStentButton.enabled
    aPanel.ui.vesselSelector.setCurrentNode(aVessel[0])
    assert "add a stent along a curve" in aPanel.ui.statusLabel.text
    host.click(aPanel.ui.addStentButton)
    stent = aPanel._parameterNode.stent
    assert stent.placement.name == "ALONG_CURVE"
    assert stent.foreshortening == 0.0
    assert stent.handle.IsA("vtkMRMLMarkupsCurveNode")
    assert stent.handle.GetNumberOfControlPoints() == 0
    assert "click along its axis" in aPanel.ui.statusLabel.text
    assert aPanel.ui.placeWidget.currentNode() is stent.handle


def test_a_placement_by_points_still_needs_a_centerline(aLogic, theParameters):
    from SDFStentSlicer.ParameterNode import Placement

    from SDFStentLib.validation import InputError

    theParameters.centerline = None
    with pytest.raises(InputError, match="Centerline: expected a model or a markups curve"):
        aLogic.addStent(theParameters, placement=Placement.DISTAL_END)


@pytest.mark.parametrize("className", ["vtkMRMLMarkupsCurveNode", "vtkMRMLMarkupsClosedCurveNode"])
def test_a_copy_of_a_stent_along_a_curve_has_the_same_axis(host, aCurveStent, aScene, className):
    from SDFStentSlicer import Conversion

    own = aScene.AddNewNodeByClass(
        className, "Own"
    )  # a spline, unlike the curves that the module makes
    own.SetCurveTypeToCardinalSpline()
    draw(aCurveStent, own)
    aCurveStent.ui.handleSelector.setCurrentNode(own)
    host.click(aCurveStent.ui.copyStentButton)
    copy = aCurveStent._parameterNode.stent.handle
    assert copy is not own
    np.testing.assert_array_equal(Conversion.curvePoints(copy), Conversion.curvePoints(own))
    assert aCurveStent.ui.deployButton.enabled, aCurveStent.ui.deployButton.toolTip
    host.click(aCurveStent.ui.removeStentButton)
    assert copy.GetScene() is None
    assert own.GetScene() is aScene
