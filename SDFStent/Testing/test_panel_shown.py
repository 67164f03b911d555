"""What is seen beside the panel: views, the vessel behind its stented copy, and what is left when stents go."""

import zipfile

import pytest
import slicer
from panel_helpers import deploy, settle, theThroat

LAYOUTS = (
    "FourUpView",
    "ConventionalView",
    "ConventionalWidescreenView",
    "OneUp3DView",
    "Dual3DView",
)


SEGMENTS = ("bone", "lumen")


def test_plot_and_table_take_no_3d_view_away(host, aStent, aScene):
    layout = aScene.GetFirstNodeByClass("vtkMRMLLayoutNode")
    deploy(host, aStent)
    for arrangement in LAYOUTS:
        layout.SetViewArrangement(getattr(layout, f"SlicerLayout{arrangement}"))
        for kind in ("Plot", "Table"):
            host.click(getattr(aStent.ui, f"show{kind}Button"))
            shown = layout.GetLayoutDescription(layout.GetViewArrangement())
            assert '"vtkMRMLViewNode"' in shown, arrangement
            assert f'"vtkMRML{kind}ViewNode"' in shown, arrangement


def test_the_roomy_views_are_there_while_the_module_is_and_show_the_plot(host, aStent, aScene):
    layout = aScene.GetFirstNodeByClass("vtkMRMLLayoutNode")
    layout.SetViewArrangement(layout.SlicerLayoutFourUpView)
    ui = aStent.ui
    ui.roomyViewsButton.checked = True
    roomy = layout.GetViewArrangement()
    shown = layout.GetLayoutDescription(roomy)
    assert '"vtkMRMLViewNode"' in shown
    assert '"vtkMRMLSliceNode"' not in shown
    deploy(host, aStent)
    selection = slicer.app.applicationLogic().GetSelectionNode()
    chart = aStent._parameterNode.outputChart
    assert selection.GetActivePlotChartID() == chart.GetID()
    host.click(ui.showPlotButton)
    assert layout.GetViewArrangement() == roomy
    aStent.exit()
    assert layout.GetViewArrangement() == layout.SlicerLayoutFourUpView
    aStent.enter()
    assert layout.GetViewArrangement() == roomy
    layout.SetViewArrangement(layout.SlicerLayoutOneUp3DView)  # as the user likes
    assert not ui.roomyViewsButton.checked  # so that one click brings them back
    assert layout.GetSaveWithScene()
    aStent.exit()
    assert layout.GetViewArrangement() == layout.SlicerLayoutOneUp3DView


def test_the_plot_comes_in_the_roomy_views_where_there_is_none(host, aStent, aScene):
    layout, ui = aScene.GetFirstNodeByClass("vtkMRMLLayoutNode"), aStent.ui
    layout.SetViewArrangement(layout.SlicerLayoutFourUpView)
    deploy(host, aStent)
    for former in (layout.SlicerLayoutFourUpView, layout.SlicerLayout3DTableView):
        layout.SetViewArrangement(former)
        host.click(ui.showPlotButton)
        assert ui.roomyViewsButton.checked
        shown = layout.GetLayoutDescription(layout.GetViewArrangement())
        assert '"vtkMRMLViewNode"' in shown
        assert '"vtkMRMLPlotViewNode"' in shown
        assert '"vtkMRMLSliceNode"' not in shown  # Slicer's own one with these is 930 pixels wide
    selection = slicer.app.applicationLogic().GetSelectionNode()
    assert selection.GetActivePlotChartID() == aStent._parameterNode.outputChart.GetID()
    aStent.exit()
    assert layout.GetViewArrangement() == layout.SlicerLayout3DTableView
    aStent.enter()
    ui.roomyViewsButton.checked = False


def test_the_title_of_a_plot_tells_its_lines_apart_and_nothing_lies_over_them(host, aStent):
    deploy(host, aStent)
    chart = aStent._parameterNode.outputChart
    assert not chart.GetLegendVisibility()
    assert chart.GetTitle() == "Stent 1: red before, blue after, dashed prescribed"
    lines = [chart.GetNthPlotSeriesNode(index) for index in range(3)]
    assert [line.GetName() for line in lines] == ["Before (mm)", "After (mm)", "Prescribed (mm)"]
    red, blue = (line.GetColor() for line in lines[:2])
    assert max(red) == red[0]
    assert max(blue) == blue[2]
    assert lines[2].GetLineStyle() == lines[2].LineStyleDash


def test_a_plot_that_is_none_of_a_plan_stays_in_the_views(host, aStent, aScene):
    selection = slicer.app.applicationLogic().GetSelectionNode()
    chart = aScene.AddNewNodeByClass("vtkMRMLPlotChartNode", "Of the user's own")
    selection.SetActivePlotChartID(chart.GetID())
    deploy(host, aStent)
    assert selection.GetActivePlotChartID() == chart.GetID()


def test_no_scene_is_saved_with_the_roomy_views_and_they_come_back(host, aStent, aScene, tmp_path):
    layout, ui = aScene.GetFirstNodeByClass("vtkMRMLLayoutNode"), aStent.ui
    for number in range(2):
        layout.SetViewArrangement(layout.SlicerLayoutFourUpView)
        ui.roomyViewsButton.checked = True
        roomy, path = layout.GetViewArrangement(), tmp_path / f"{number}.mrb"
        host.saveAndLoad(path)
        assert layout.GetViewArrangement() == roomy
        assert f'"{roomy}"' not in sceneText(path)
        aStent.exit()
        assert layout.GetViewArrangement() == layout.SlicerLayoutFourUpView
        aScene.WriteToMRB(str(path))
        assert "<Layout" in sceneText(path)  # of all other views it is
        aStent.enter()
        ui.roomyViewsButton.checked = False


def sceneText(path):
    with zipfile.ZipFile(path) as bundle:
        (name,) = (name for name in bundle.namelist() if name.endswith(".mrml"))
        return bundle.read(name).decode()


@pytest.fixture
def aSegmentation(host, aStent, aScene):
    """The panel, with the vessel and another segment in a segmentation."""
    node = aScene.AddNewNodeByClass("vtkMRMLSegmentationNode", "Vessels")
    node.CreateDefaultDisplayNodes()
    node.SetSourceRepresentationToClosedSurface()
    wall = aStent._parameterNode.vessel.GetPolyData()
    ids = [node.AddSegmentFromClosedSurfaceRepresentation(wall, name) for name in SEGMENTS]
    aStent.ui.vesselSelector.setCurrentNode(node)
    aStent.ui.segmentSelector.setCurrentSegmentID(ids[1])
    host.process()
    return aStent


def inThreeD(panel):
    """Which segments are seen in 3D."""
    vessel = panel._parameterNode.vessel
    ids = map(vessel.GetSegmentation().GetSegmentIdBySegmentName, SEGMENTS)
    isSeen = map(vessel.GetDisplayNode().GetSegmentVisibility3D, ids)
    return [name for name, seen in zip(SEGMENTS, isSeen, strict=True) if seen]


def test_a_plan_that_is_not_deployed_shows_the_segment(host, aSegmentation):
    ui = aSegmentation.ui
    deploy(host, aSegmentation)
    ui.plansCollapsibleButton.collapsed = False
    host.click(ui.duplicatePlanButton)
    assert inThreeD(aSegmentation) == ["bone", "lumen"]
    ui.planTable.selectRow(0)
    assert inThreeD(aSegmentation) == ["bone"]
    host.click(ui.removePlanButton)
    assert inThreeD(aSegmentation) == ["bone", "lumen"]


@pytest.mark.parametrize("when", ["live", "running", "saved"])
def test_without_stents_the_vessel_is_as_it_was(host, aStent, aScene, tmp_path, when):
    ui, vessel = aStent.ui, aStent._parameterNode.vessel
    host.click(ui.copyStentButton)
    aStent._parameterNode.stent.handle.SetNthControlPointPositionWorld(0, *theThroat())
    if when == "running":
        host.click(ui.deployButton)
        host.processUntil(lambda: aStent._parameterNode.outputVessel is not None)
    else:
        ui.autoUpdateCheckBox.checked = when == "live"
        deploy(host, aStent)
    if when == "saved":
        host.saveAndLoad(tmp_path / "scene.mrb")
        vessel = aStent._parameterNode.vessel
    host.click(ui.removeStentButton)
    assert aStent._parameterNode.outputVessel is not None
    host.click(ui.removeStentButton)
    settle(host, aStent)
    assert ui.statusLabel.text == "Add a stent, or switch one on."
    assert ui.lumenLabel.text == ui.certificateLabel.text == ui.warningLabel.text == ""
    assert vessel.GetDisplayNode().GetVisibility()
    names = [node.GetName() for node in slicer.util.getNodesByClass("vtkMRMLModelNode")]
    assert not [name for name in names if "tent" in name]
    charts = slicer.util.getNodesByClass("vtkMRMLPlotChartNode")
    assert not [chart for chart in charts if not chart.GetHideFromEditors()]
    for button in (ui.beforeButton, ui.showPlotButton, ui.showTableButton, ui.expansionSlider):
        assert not button.enabled
    host.click(ui.addStentButton)  # and all of it can be had again
    aStent._parameterNode.stent.handle.SetNthControlPointPositionWorld(0, *theThroat())
    settle(host, aStent)
    deploy(host, aStent)
    assert not vessel.GetDisplayNode().GetVisibility()
    assert "Minimum lumen" in ui.lumenLabel.text


def test_nobody_is_told_to_click_a_button_that_cannot_be_clicked(host, aStent):
    from PySide6.QtCore import Qt

    ui = aStent.ui
    deploy(host, aStent)
    ui.stentTable.item(0, 0).setCheckState(Qt.Unchecked)
    host.process()
    assert not ui.deployButton.enabled
    assert ui.statusLabel.text.splitlines() == [
        "Add a stent, or switch one on.",
        "Changed since this deployment.",
    ]


def test_nothing_can_be_canceled_once_the_last_stent_is_gone(host, aStent):
    aStent.ui.autoUpdateCheckBox.checked = True
    settle(host, aStent)
    host.click(aStent.ui.removeStentButton)
    host.processUntil(lambda: not aStent.session.isBusy)
    assert not aStent.ui.cancelButton.enabled
