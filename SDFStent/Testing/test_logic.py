"""The logic on real MRML, without a panel."""

import numpy as np
import pytest
import slicer
import vtk
from panel_helpers import expanded, theThroat


def test_every_step_updates_the_same_mesh_with_one_event(aLogic, theParameters):
    expanded(aLogic, theParameters)
    node = theParameters.outputVessel
    mesh, array, events = node.GetPolyData(), node.GetPolyData().GetPoints().GetData(), []
    node.AddObserver(slicer.vtkMRMLModelNode.MeshModifiedEvent, lambda *_: events.append(1))
    aLogic.deploy(theParameters)
    steps = len(aLogic.lastRun(theParameters).recorded)
    assert node.GetPolyData() is mesh
    assert mesh.GetPoints().GetData() is array
    assert len(events) == steps + 1  # one per radius step and one for the end
    events.clear()
    for _fraction in aLogic.steps(theParameters, live=True):
        pass
    assert len(events) == 1  # while dragging only the end is shown


@pytest.mark.parametrize("kind", ["linear", "nonlinear"])
def test_inputs_under_a_transform_give_the_result_of_hardened_ones(
    aLogic, theParameters, aScene, kind
):
    transform = aScene.AddNewNodeByClass("vtkMRMLTransformNode")
    if kind == "linear":
        matrix = vtk.vtkTransform()
        matrix.Translate(10, -20, 30)
        matrix.RotateX(40)
        transform.SetMatrixTransformToParent(matrix.GetMatrix())
    else:
        transform.SetAndObserveTransformToParent(aThinPlateSpline())
    nodes = (theParameters.vessel, theParameters.centerline, theParameters.stent.handle)
    for node in nodes:
        node.SetAndObserveTransformNodeID(transform.GetID())
    points = expanded(aLogic, theParameters)
    for node in nodes:
        node.HardenTransform()
    # Hardening stores coordinates as single precision.
    np.testing.assert_allclose(points, expanded(aLogic, theParameters), atol=1e-3)
    assert theParameters.outputVessel.GetParentTransformNode() is None


def aThinPlateSpline():
    source, target = vtk.vtkPoints(), vtk.vtkPoints()
    rng = np.random.default_rng(4)
    for corner in 60 * rng.random((8, 3)) - 30:
        source.InsertNextPoint(corner)
        target.InsertNextPoint(corner + rng.normal(scale=0.8, size=3))
    spline = vtk.vtkThinPlateSplineTransform()
    spline.SetSourceLandmarks(source)
    spline.SetTargetLandmarks(target)
    spline.SetBasisToR()
    return spline


def test_a_segmentation_gives_the_surface_of_the_model(aLogic, theParameters, aScene):
    points = expanded(aLogic, theParameters)
    segmentation = aScene.AddNewNodeByClass("vtkMRMLSegmentationNode")
    segmentation.SetSourceRepresentationToClosedSurface()
    segmentID = segmentation.AddSegmentFromClosedSurfaceRepresentation(
        theParameters.vessel.GetPolyData(), "lumen"
    )
    theParameters.vessel, theParameters.segmentID = segmentation, segmentID
    np.testing.assert_allclose(expanded(aLogic, theParameters), points, atol=1e-6)


def test_a_curve_tree_is_a_centerline(aLogic, theParameters, aScene):
    tree = addCurveTree(aScene, theParameters.centerline)
    theParameters.centerline = tree[0]
    run = aLogic.deploy(theParameters)
    assert len(run.centerline.leaves) == 2
    assert run.stents[0].after.mean == pytest.approx(8.5, rel=0.01)


def addCurveTree(scene, centerlineNode):
    """One curve per branch, nested in the subject hierarchy, as Extract Centerline leaves them."""
    from SDFStentSlicer import Conversion

    hierarchy = slicer.vtkMRMLSubjectHierarchyNode.GetSubjectHierarchyNode(scene)
    centerline, curves, parent = Conversion.centerlineOf(centerlineNode), [], None
    for number, branch in enumerate(centerline.branches):
        curve = scene.AddNewNodeByClass("vtkMRMLMarkupsCurveNode", f"Curve ({number})")
        curve.SetNumberOfPointsPerInterpolatingSegment(1)
        slicer.util.updateMarkupsControlPointsFromArray(curve, centerline.points[branch])
        item = hierarchy.GetItemByDataNode(curve) or hierarchy.CreateItem(
            hierarchy.GetSceneItemID(), curve
        )
        if parent is None:
            parent = item
        else:
            hierarchy.SetItemParent(item, parent)
        curves.append(curve)
    return curves


def test_a_curve_is_an_axis_without_a_centerline(aLogic, theParameters, aScene):
    from SDFStentSlicer import Conversion
    from SDFStentSlicer.ParameterNode import Placement

    path = Conversion.centerlineOf(theParameters.centerline).path_around(theThroat(), 12.0)
    curve = aScene.AddNewNodeByClass("vtkMRMLMarkupsCurveNode", "Axis")
    slicer.util.updateMarkupsControlPointsFromArray(curve, path.points[::3])
    theParameters.centerline = None
    stents = aLogic.stentList(theParameters)
    stents.replace([{**stents.values()[0], "placement": Placement.ALONG_CURVE, "handle": curve}], 0)
    run = aLogic.deploy(theParameters)
    assert run.stents[0].after.mean == pytest.approx(8.5, rel=0.01)
    assert theParameters.outputCenterline is None


def test_table_and_chart_hold_the_diameters_in_mm(aLogic, theParameters):
    run = aLogic.deploy(theParameters)
    table = theParameters.outputTable
    after = slicer.util.arrayFromTableColumn(table, "After (mm)")
    (treated,) = run.stents
    np.testing.assert_array_equal(after, treated.around_after.inscribed_diameter.round(2))
    assert table.GetUseColumnTitleAsColumnHeader()
    assert table.GetLocked()
    assert table.GetColumnTitle("After (mm)") == "After"
    assert table.GetColumnUnitLabel("After (mm)") == "mm"
    position, prescribed = (
        slicer.util.arrayFromTableColumn(table, name)
        for name in ("Position (mm)", "Prescribed (mm)")
    )
    inStent = np.isfinite(prescribed)
    np.testing.assert_array_equal(after[inStent], treated.after.inscribed_diameter.round(2))
    assert position[0] < -5
    assert position[-1] > treated.axis.deployed_length + 5
    assert position[inStent][0] == 0
    chart = theParameters.outputChart
    assert [
        chart.GetNthPlotSeriesNode(i).GetYColumnName()
        for i in range(chart.GetNumberOfPlotSeriesNodes())
    ] == ["Before (mm)", "After (mm)", "Prescribed (mm)"]
    assert "prescribed 8.5 mm" in theParameters.lumenSummary
    assert "watertight" in theParameters.certificateSummary


def test_maps_color_the_output_with_a_legend(aLogic, theParameters):
    from SDFStentSlicer.ParameterNode import SurfaceMap
    from SDFStentSlicer.Results import mapOf

    aLogic.deploy(theParameters)
    run, node = aLogic.lastRun(theParameters), theParameters.outputVessel
    for chosen in (SurfaceMap.DISPLACEMENT, SurfaceMap.AREA_STRETCH):
        expected = mapOf(run, chosen)
        theParameters.map = chosen
        aLogic.updateDisplay(theParameters)
        assert node.GetDisplayNode().GetActiveScalarName() == chosen.value
        assert node.GetDisplayNode().GetScalarVisibility()
        get = (
            slicer.util.arrayFromModelCellData
            if expected[1]
            else slicer.util.arrayFromModelPointData
        )
        np.testing.assert_allclose(get(node, chosen.value), expected[0], rtol=1e-6)
    theParameters.map = SurfaceMap.NONE
    aLogic.updateDisplay(theParameters)
    assert not node.GetDisplayNode().GetScalarVisibility()


def test_the_handle_snaps_to_the_centerline(aLogic, theParameters):
    from SDFStentSlicer import Conversion

    handle = theParameters.stent.handle
    handle.SetNthControlPointPositionWorld(0, *(theThroat() + np.array([1.0, 1.0, 0.0])))
    aLogic.snapHandle(theParameters, handle)
    snapped = handle.GetNthControlPointPositionWorld(0)
    assert Conversion.centerlineOf(theParameters.centerline).project(snapped).distance < 1e-6
