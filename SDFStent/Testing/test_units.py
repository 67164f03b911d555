"""Vessels in other units, and centerlines that do not say how wide the vessel is: what the panel makes of them."""

import numpy as np
import pytest
import slicer
from panel_helpers import deploy

from SDFStentLib.files import polydata_from_arrays, polydata_from_lines


def aModel(name, polyData):
    node = slicer.mrmlScene.AddNewNodeByClass("vtkMRMLModelNode", name)
    node.SetAndObservePolyData(polyData)
    node.CreateDefaultDisplayNodes()
    return node


def scaledBy(*factors):
    """A transform node that scales."""
    import vtk

    node = slicer.mrmlScene.AddNewNodeByClass("vtkMRMLLinearTransformNode")
    matrix = vtk.vtkMatrix4x4()
    for axis, factor in enumerate(factors):
        matrix.SetElement(axis, axis, factor)
    node.SetMatrixTransformToParent(matrix)
    return node


@pytest.fixture
def aTube():
    """A function: wall and centerline of a tube of 6 mm that is narrowed to 3.6, in another unit, with or without radii."""
    from SDFStentSlicer.SampleVessels import centerlinePolyData

    from benchmarks.phantoms import stenosed_tube

    made = stenosed_tube(edge_length=0.8)

    def inUnit(size=1.0, hasRadii=True):
        from vtk.util.numpy_support import vtk_to_numpy

        tree = made.centerline
        if hasRadii:
            lines = centerlinePolyData(tree)
            vtk_to_numpy(lines.GetPoints().GetData())[:] *= size
            vtk_to_numpy(lines.GetPointData().GetArray("Radius"))[:] *= size
        else:
            ways = [tree.ancestry(leaf) for leaf in tree.leaves]
            lines = polydata_from_lines(size * tree.points, ways)
        wall = polydata_from_arrays(size * made.points, made.triangles)
        return aModel("Tube", wall), aModel("Line", lines)

    return inUnit


def choose(host, panel, vessel, centerline):
    panel.ui.vesselSelector.setCurrentNode(vessel)
    panel.ui.centerlineSelector.setCurrentNode(centerline)
    host.processUntil(lambda: not panel.lesions.isBusy)


def seen(host, panel):
    """What the panel says of a vessel: the new stent's diameter, ends of sliders, the tightest lesion, and the lumen left."""
    host.click(panel.ui.addStentButton)
    ui = panel.ui
    sizes = (ui.diameterSlider.value, ui.diameterSlider.maximum, ui.lengthSlider.maximum)
    lesion = [ui.lesionTable.item(0, column).text() for column in range(4)]
    ui.diameterSlider.value, ui.lengthSlider.value = 6.0, 12.0
    deploy(host, panel)
    return sizes, lesion, ui.lumenLabel.text


def test_a_vessel_in_another_unit_below_a_transform_is_as_one_in_mm(host, aPanel, aTube):
    choose(host, aPanel, *aTube())
    inMillimeters = seen(host, aPanel)
    assert "unusual" not in aPanel.ui.lesionLabel.text
    host.newScene()
    nodes, transform = aTube(0.001), scaledBy(1000.0, 1000.0, 1000.0)
    for node in nodes:
        node.SetAndObserveTransformNodeID(transform.GetID())
    choose(host, aPanel, *nodes)
    tree = aPanel.logic.centerlineOf(aPanel._parameterNode)
    assert np.nanmax(tree.inscribed_radius) == pytest.approx(3.0, rel=0.01)
    assert seen(host, aPanel) == inMillimeters


def test_radii_are_not_those_of_a_vessel_that_is_stretched(host, aPanel, aTube):
    """Twice as wide one way only: no radius of the file says how wide it is, so that it is measured."""
    nodes, transform = aTube(), scaledBy(1.0, 2.0, 1.0)
    for node in nodes:
        node.SetAndObserveTransformNodeID(transform.GetID())
    choose(host, aPanel, *nodes)
    assert np.isnan(aPanel.logic.centerlineOf(aPanel._parameterNode).inscribed_radius).all()
    host.click(aPanel.ui.addStentButton)
    lumen = aPanel.ui.diameterSlider.value
    deploy(host, aPanel)
    before = aPanel.logic.lastRun(aPanel._parameterNode).result.stents[0].before
    assert lumen == pytest.approx(np.quantile(before.inscribed_diameter, 0.75), rel=0.05)


@pytest.mark.parametrize("kind", [pytest.param("a model", marks=pytest.mark.bench), "a curve"])
def test_a_centerline_without_radii_is_measured(host, aPanel, aTube, kind):
    """A new stent is as wide as the vessel there, whatever the file knows of it."""
    vessel, centerline = aTube(hasRadii=kind != "a model")
    choose(host, aPanel, vessel, centerline)
    if kind == "a curve":
        curve = slicer.mrmlScene.AddNewNodeByClass("vtkMRMLMarkupsCurveNode")
        points = aPanel.logic.centerlineOf(aPanel._parameterNode).points
        slicer.util.updateMarkupsControlPointsFromArray(curve, points[::4])
        choose(host, aPanel, vessel, curve)
    host.click(aPanel.ui.addStentButton)
    suggested = aPanel.ui.diameterSlider.value
    choose(host, aPanel, *aTube())
    host.click(aPanel.ui.addStentButton)
    assert suggested == pytest.approx(aPanel.ui.diameterSlider.value, abs=0.2)
    handle = aPanel._parameterNode.stent.handle.GetNthControlPointPositionWorld(0)
    wall = slicer.util.arrayFromModelPoints(vessel)
    nearest = 2 * np.linalg.norm(wall - handle, axis=1).min()
    assert nearest <= suggested + 0.2
    assert suggested <= 6.1


@pytest.mark.parametrize("hasCenterline", [True, False])
def test_a_vessel_of_an_unusual_size_is_said_to_be_one(host, aPanel, aTube, hasCenterline):
    vessel, centerline = aTube(0.1)
    host.process()  # what was loaded is chosen
    choose(host, aPanel, vessel, centerline if hasCenterline else None)
    parameters, words = aPanel._parameterNode, "Tube is 4 mm long and about 0.52 mm wide, unusual"
    assert (words in aPanel.ui.lesionLabel.text) == hasCenterline
    if hasCenterline:
        assert "below a transform that makes that mm: by 10 from cm" in aPanel.ui.lesionLabel.text
        host.click(aPanel.ui.addStentButton)
        parameters.stent.diameter, parameters.stent.length = 0.6, 1.2
    else:
        handle = aPanel.logic.addStent(parameters, diameter=0.6)
        for point in slicer.util.arrayFromModelPoints(centerline)[10:-10:4]:
            handle.AddControlPointWorld(*point)
    deploy(host, aPanel)
    assert words in aPanel.ui.warningLabel.text
