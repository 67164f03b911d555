"""What the module did wrong in the real application, and must not do again in the host."""

import gc

import numpy as np
import pytest
import slicer
from panel_helpers import clickSample, deploy, offered, settle, theThroat
from vtkmodules.vtkCommonDataModel import vtkPolyData


def test_show_table_changes_to_a_layout_with_a_table_that_shows_ours(host, aStent, aScene):
    layout = aScene.GetFirstNodeByClass("vtkMRMLLayoutNode")
    layout.SetViewArrangement(slicer.vtkMRMLLayoutNode.SlicerLayoutOneUp3DView)
    deploy(host, aStent)
    aScene.AddNewNodeByClass("vtkMRMLTableNode", "Another")
    host.click(aStent.ui.showTableButton)
    assert layout.GetViewArrangement() == slicer.vtkMRMLLayoutNode.SlicerLayout3DTableView
    (view,) = slicer.util.getNodesByClass("vtkMRMLTableViewNode")
    assert view.GetTableNodeID() == aStent._parameterNode.outputTexts.GetID()
    layout.SetViewArrangement(slicer.vtkMRMLLayoutNode.SlicerLayoutFourUpPlotTableView)
    host.click(aStent.ui.showTableButton)  # a layout that has a table stays
    assert layout.GetViewArrangement() == slicer.vtkMRMLLayoutNode.SlicerLayoutFourUpPlotTableView


def test_a_visible_plot_is_never_drawn_from_half_a_table(host, aStent):
    from sdfstent_host.mrml import PlotView

    deploy(host, aStent)
    view = PlotView(aStent._parameterNode.outputChart)
    aStent.ui.diameterSlider.value = 8.0
    deploy(host, aStent)
    host.click(aStent.ui.copyStentButton)
    aStent.ui.stentTable.selectRow(0)
    assert view.drawn > 1
    view.close()
    assert host.errors() == []


def placePreview(node, position):
    """A point under the mouse, as place mode has it, moved to a position."""
    count = node.GetNumberOfControlPoints()
    if count and node.GetNthControlPointPositionStatus(count - 1) == node.PositionPreview:
        index = count - 1
    else:
        index = node.AddControlPointWorld(*position)
    node.SetNthControlPointPositionWorld(index, *position, node.PositionPreview)


def test_the_point_under_the_mouse_is_no_change(host, aStent):
    parameters = aStent._parameterNode
    deploy(host, aStent)
    aStent.ui.autoUpdateCheckBox.checked = True
    settle(host, aStent)
    for step in range(3):
        placePreview(parameters.stent.handle, theThroat() + step)
        host.process()
        assert not aStent.session.isBusy
        assert not aStent.logic.hasChanged(parameters)
        assert aStent.ui.lumenLabel.enabled


def test_the_point_under_the_mouse_is_no_part_of_a_curve(aLogic, aVessel, aScene):
    from SDFStentSlicer import Conversion

    curve = aScene.AddNewNodeByClass("vtkMRMLMarkupsCurveNode", "Axis")
    for point in ((0, 0, 0), (5, 5, 0), (10, 0, 0), (15, 5, 0)):
        curve.AddControlPointWorld(*point)
    placed, stamp = Conversion.curvePoints(curve), Conversion.changeStamp(curve)
    placePreview(curve, (40.0, 40.0, 0.0))
    assert slicer.util.arrayFromMarkupsCurvePoints(curve).max() > 30  # Slicer draws up to the mouse
    np.testing.assert_allclose(Conversion.curvePoints(curve), placed, atol=1e-9)
    assert Conversion.changeStamp(curve) == stamp
    assert curve.GetNumberOfControlPoints() == 5  # and is left as it is


def timers():
    from PySide6.QtCore import QTimer

    gc.collect()
    return sum(isinstance(found, QTimer) for found in gc.get_objects())


@pytest.mark.bench
def test_deploying_again_and_again_makes_no_timers(host, aStent):
    deploy(host, aStent)
    before = timers()
    deploy(host, aStent)
    aStent.session.start()
    host.click(aStent.ui.cancelButton)
    assert timers() == before


def test_a_run_that_fails_in_a_tick_logs_its_traceback(host, aStent, monkeypatch):
    def failing(*_):
        raise ZeroDivisionError("in the method")

    monkeypatch.setattr("SDFStentSlicer.Logic.Plans.plannedOf", failing)
    deploy(host, aStent)
    assert "Unexpected error: ZeroDivisionError" in aStent.ui.statusLabel.text
    (logged,) = host.errors()
    assert "Traceback" in logged
    assert "in failing" in logged


@pytest.fixture
def noSamples(monkeypatch):
    import SampleData

    monkeypatch.setattr(SampleData.SampleDataLogic, "sources", {})
    return SampleData.SampleDataLogic


def test_sample_data_comes_with_a_module_that_is_loaded_after_start_up(
    host, theModule, aScene, noSamples
):
    assert slicer.app.hasStarted
    entry = theModule.python
    for _ in range(2):  # and once only
        entry.SDFStent(theModule.parent)
    names = [s.sampleName for s in noSamples.sampleDataSourcesByCategory("SDF Stent")]
    assert names == ["StenosedPulmonaryArtery", "AortaWithCoarctation"]


def test_sample_data_waits_for_start_up_when_there_is_no_sample_data_yet(
    theModule, aScene, noSamples, monkeypatch
):
    monkeypatch.setattr(slicer.app, "hasStarted", False)
    monkeypatch.setattr(slicer.app, "startupFunctions", [])
    monkeypatch.delattr(slicer.modules, "sampledata")
    theModule.python.SDFStent(theModule.parent)
    assert noSamples.sources == {}
    slicer.app.completeStartup()
    assert len(noSamples.sources["SDF Stent"]) == 2


def test_the_3d_view_looks_at_sample_data_that_comes(host, aScene):
    host.application.view.look((500, 510, 500, 510, 500, 510))
    slicer.app.showMainWindow(True)
    vessel, _centerline = clickSample("AortaWithCoarctation")
    slicer.app.showMainWindow(False)
    bounds = np.reshape(vessel.GetPolyData().GetBounds(), (3, 2))
    focus = host.application.view.renderer.GetActiveCamera().GetFocalPoint()
    assert np.all(bounds[:, 0] <= focus)
    assert np.all(focus <= bounds[:, 1])


def test_what_goes_with_a_node_is_not_removed_once_more(host, aStent, aScene):
    handle = aStent._parameterNode.stent.handle
    display = handle.GetDisplayNode()
    host.click(aStent.ui.removeStentButton)
    assert handle.GetScene() is display.GetScene() is None
    assert host.errors() == []


def folderOf(node):
    hierarchy = slicer.vtkMRMLSubjectHierarchyNode.GetSubjectHierarchyNode(slicer.mrmlScene)
    parent = hierarchy.GetItemParent(hierarchy.GetItemByDataNode(node))
    return parent, hierarchy.GetItemName(parent)


def outputsOf(parameters):
    chart = parameters.outputChart
    series = [chart.GetNthPlotSeriesNode(i) for i in range(chart.GetNumberOfPlotSeriesNodes())]
    return [
        parameters.outputVessel,
        parameters.outputCenterline,
        parameters.outputStents,
        parameters.outputTable,
        parameters.outputTexts,
        chart,
        *series,
    ]


def test_results_are_in_one_folder_per_parameter_set(aLogic, theParameters, aScene):
    aLogic.deploy(theParameters)
    other = aLogic.addParameterSet("Longer stent")
    other.vessel, other.centerline = theParameters.vessel, theParameters.centerline
    other.outputVessel = theParameters.outputVessel  # not its own: it gets another one
    aLogic.addStent(other, diameter=8.5, length=20.0)
    aLogic.deploy(other)
    first = {folderOf(node) for node in outputsOf(theParameters)}
    second = {folderOf(node) for node in outputsOf(other)}
    name = theParameters.parameterNode.GetName()
    assert [folder for _item, folder in first] == [f"{name} results"]
    assert [folder for _item, folder in second] == ["Longer stent results"]
    assert folderOf(theParameters.vessel) not in first | second
    aScene.RemoveNode(theParameters.outputTable)
    aLogic.deploy(theParameters)
    assert {folderOf(node) for node in outputsOf(theParameters)} == first


def test_only_what_fits_is_offered_and_what_may_yet_fit(host, aPanel, aVessel, aScene):
    ui, (vessel, centerline) = aPanel.ui, aVessel
    both = aScene.AddNewNodeByClass("vtkMRMLModelNode", "Both")
    aScene.AddNewNodeByClass("vtkMRMLModelNode", "Empty")
    lines = vtkPolyData()
    lines.DeepCopy(centerline.GetPolyData())
    lines.SetPolys(vessel.GetPolyData().GetPolys())
    both.SetAndObservePolyData(lines)  # as who adds a node does: afterward
    host.process()
    walls = [vessel.GetName(), "Both", "Empty"]
    assert offered(ui.vesselSelector) == offered(ui.deviceMeshSelector) == walls
    assert offered(ui.centerlineSelector) == [centerline.GetName(), "Both", "Empty"]


def test_vessel_and_centerline_stay_open_until_they_can_be_used(host, aPanel, aVessel):
    from SDFStentSlicer import Conversion, Showing

    from SDFStentLib.files import polydata_from_lines

    ui, (vessel, centerline) = aPanel.ui, aVessel
    aPanel._parameterNode.centerline, aPanel._parameterNode.vessel = vessel, centerline
    host.process()
    ui.centerlineSelector.setCurrentNode(centerline)
    assert not ui.inputsCollapsibleButton.collapsed  # a script may choose lines as a vessel
    ui.vesselSelector.setCurrentNode(vessel)
    assert ui.inputsCollapsibleButton.collapsed
    looks = [
        (one.GetDisplayNode().GetColor(), one.GetDisplayNode().GetOpacity()) for one in aVessel
    ]
    assert looks == [(Showing.VESSEL_COLOR, Showing.VESSEL_OPACITY), (Showing.LINE_COLOR, 1.0)]
    for chosen in (vessel, centerline, vessel):
        aPanel._parameterNode.centerline = chosen
        host.processUntil(lambda: not aPanel.lesions.isBusy)
        assert ui.inputsCollapsibleButton.collapsed == (chosen is centerline)
        assert ("expected a model of lines" in ui.lesionLabel.text) == (chosen is vessel)
        ui.inputsCollapsibleButton.collapsed = False  # to choose another one
    points, lines, _radii = Conversion.centerlineLines(centerline)
    centerline.SetAndObservePolyData(polydata_from_lines(points + 500.0, lines))
    ui.inputsCollapsibleButton.collapsed = True
    ui.centerlineSelector.setCurrentNode(centerline)
    host.processUntil(lambda: not aPanel.lesions.isBusy)
    assert "centerline" in ui.lesionLabel.text
    assert not ui.inputsCollapsibleButton.collapsed
