"""Alternatives in the panel: plans for one vessel beside each other, and the page that compares them."""

import json
from pathlib import Path

import numpy as np
import pytest
import slicer
import vtk
from panel_helpers import deploy, handleNames, offered, pointsOf, saveAsFile, settle, theThroat


@pytest.fixture
def aPlan(host, aStent):
    """The panel with one stent at the throat and the section Plans open."""
    aStent.ui.plansCollapsibleButton.collapsed = False
    aStent.parent.resize(460, 2000)
    host.process()
    return aStent


def names(panel):
    table = panel.ui.planTable
    return [table.item(row, 0).text() for row in range(table.rowCount)]


def rowOf(panel, row):
    return [panel.ui.planTable.item(row, column).text() for column in range(5)]


def rename(panel, row, name):
    """As the editor of the table does when it is closed."""
    panel.ui.planTable.item(row, 0).setText(name)


def isSeen(node):
    return bool(node.GetDisplayNode().GetVisibility())


def test_a_duplicate_is_a_whole_plan_of_its_own(host, aPlan):
    from SDFStentSlicer.Alternatives import COPIED

    ui, first = aPlan.ui, aPlan._parameterNode
    host.click(ui.copyStentButton)
    ui.waistSpinBox.value = 5.0
    ui.tissueGapSlider.value = 0.7
    ui.flowMeanSpinBox.value = 1.5
    first.deviceTable = "some.json"
    host.click(ui.duplicatePlanButton)
    second = aPlan._parameterNode
    assert second is not first
    assert names(aPlan) == ["Plan 1", "Plan 2"]
    assert ui.planTable.currentRow() == 1
    for name in COPIED:
        assert getattr(second, name) == getattr(first, name), name
    assert second.method.tissueGap == 0.7
    for one, other in zip(first.stents, second.stents, strict=True):
        assert one.draft.entry == other.draft.entry
        assert one.handle is not other.handle
        places = [node.GetNthControlPointPositionWorld(0) for node in (one.handle, other.handle)]
        np.testing.assert_array_equal(*places)
    ui.diameterSlider.value = 6.0
    place = tuple(first.stent.handle.GetNthControlPointPositionWorld(0))
    second.stent.handle.SetNthControlPointPositionWorld(0, 0.0, 0.0, 20.0)
    ui.planTable.selectRow(0)
    assert aPlan._parameterNode is first
    assert first.stents[1].diameter == ui.diameterSlider.value == 8.5
    assert tuple(first.stent.handle.GetNthControlPointPositionWorld(0)) == place


def test_a_duplicate_names_every_parameter_that_is_no_result(theModule):
    """A parameter that is added later is copied, or named here."""
    from SDFStentSlicer.Alternatives import COPIED
    from SDFStentSlicer.ParameterNode import SDFStentParameterNode

    own = {"selected", "expansion", "status"}
    results = {name for name in SDFStentParameterNode.allParameters if name.startswith("output")}
    results |= {"rightBranch", "lumenSummary", "certificateSummary", "warningSummary", "tiles"}
    results |= {"atHand"}
    assert {*COPIED} | own | results == set(SDFStentParameterNode.allParameters)


def test_switching_puts_stents_and_results_back(host, aPlan):
    ui, first, table = aPlan.ui, aPlan._parameterNode, aPlan.ui.planTable
    vessel = first.vessel
    deploy(host, aPlan)
    told, points = ui.lumenLabel.text, pointsOf(first.outputVessel)
    assert not isSeen(vessel)
    host.click(ui.duplicatePlanButton)
    second = aPlan._parameterNode
    assert isSeen(vessel)  # nothing is deployed yet in its place
    hidden = (first.outputVessel, first.outputStents, first.stent.handle)
    assert not any(isSeen(node) for node in hidden)
    assert ui.lumenLabel.text == ""
    ui.diameterSlider.value = 6.0
    deploy(host, aPlan)
    assert not isSeen(vessel)
    assert second.outputVessel is not first.outputVessel
    other = pointsOf(second.outputVessel)
    assert np.abs(points - other).max() > 0.5
    assert rowOf(aPlan, 0)[1] != rowOf(aPlan, 1)[1]

    table.selectRow(0)
    assert not aPlan.session.isBusy
    assert (ui.lumenLabel.text, ui.diameterSlider.value) == (told, 8.5)
    assert ui.lumenLabel.enabled
    np.testing.assert_array_equal(pointsOf(first.outputVessel), points)
    for one, isShown in ((first, True), (second, False)):
        nodes = (one.outputVessel, one.outputStents, one.outputCenterline, one.stent.handle)
        assert [isSeen(node) for node in nodes] == [isShown] * 4
    ui.expansionSlider.value = 0.0  # its steps are still there
    np.testing.assert_allclose(pointsOf(first.outputVessel), pointsOf(vessel), atol=1e-6)
    table.selectRow(1)
    np.testing.assert_array_equal(pointsOf(second.outputVessel), other)
    assert isSeen(second.outputVessel)


def test_plot_and_table_in_the_views_are_those_of_the_plan(host, aPlan):
    from SDFStentSlicer.Results import SERIES

    ui, first = aPlan.ui, aPlan._parameterNode
    deploy(host, aPlan)
    host.click(ui.duplicatePlanButton)
    deploy(host, aPlan)
    second = aPlan._parameterNode
    selection = slicer.app.applicationLogic().GetSelectionNode()
    assert selection.GetActivePlotChartID() == second.outputChart.GetID()  # whatever the layout
    assert selection.GetActiveTableID() == second.outputTexts.GetID()
    host.click(ui.showPlotButton)
    host.click(ui.showTableButton)
    for row, plan in ((0, first), (1, second)):
        ui.planTable.selectRow(row)
        assert selection.GetActivePlotChartID() == plan.outputChart.GetID()
        assert selection.GetActiveTableID() == plan.outputTexts.GetID()
        lines = (plan.outputChart.GetNthPlotSeriesNode(index) for index in range(3))
        assert [line.GetName() for line in lines] == list(SERIES)  # as a pointer tells them


def test_a_plan_without_a_result_has_the_plot_of_a_lesion_and_one_with_it_its_own(host, aPlan):
    ui, first = aPlan.ui, aPlan._parameterNode
    selection = slicer.app.applicationLogic().GetSelectionNode()
    deploy(host, aPlan)
    host.click(ui.duplicatePlanButton)
    host.processUntil(lambda: not aPlan.lesions.isBusy)
    assert aPlan._parameterNode.outputChart is None
    ui.lesionTable.selectRow(0)
    shown = slicer.mrmlScene.GetNodeByID(selection.GetActivePlotChartID())
    assert shown.GetTitle().startswith("Lesion 1:")
    ui.planTable.selectRow(0)
    assert aPlan._parameterNode is first
    assert selection.GetActivePlotChartID() == first.outputChart.GetID()


def test_the_plot_of_a_plan_that_is_not_shown_is_weak(host, aPlan):
    deploy(host, aPlan)
    line = aPlan._parameterNode.outputChart.GetNthPlotSeriesNode(0)
    assert line.GetOpacity() == 1.0
    host.click(aPlan.ui.duplicatePlanButton)  # which has no plot of its own yet
    assert line.GetOpacity() < 0.5
    aPlan.ui.planTable.selectRow(0)
    settle(host, aPlan)
    assert line.GetOpacity() == 1.0


def test_the_table_says_what_the_results_say(host, aPlan):
    """Against the library's result, counted here: the worst lesion left, branches covered, lumen, certificate."""
    deploy(host, aPlan)
    run = aPlan.logic.lastRun(aPlan._parameterNode)
    (treated,) = run.result.stents
    left = max(
        100 * (1 - one.after.minimum_diameter / one.after.reference_diameter) for one in run.lesions
    )
    covered = sum(branch.covered_share > 0 for branch in treated.branches)
    branches = f"{covered} of {len(treated.branches)} covered" if treated.branches else "none near"
    assert rowOf(aPlan, 0) == [
        "Plan 1",
        f"{treated.after.inscribed_diameter.min():.1f} mm",
        f"{left:.0f} %" if left >= 0.5 else "none",
        branches,
        "certified for meshing",
    ]
    aPlan.ui.diameterSlider.value = 8.0
    assert aPlan.ui.planTable.item(0, 1).toolTip().endswith("Changed since this deployment.")
    aPlan.logic.reset(aPlan._parameterNode)
    assert rowOf(aPlan, 0)[1:] == [""] * 4


def test_a_plan_is_renamed_in_the_table(host, aPlan):
    host.click(aPlan.ui.duplicatePlanButton)
    rename(aPlan, 1, " One long stent ")
    assert aPlan._parameterNode.parameterNode.GetName() == "One long stent"
    assert names(aPlan) == ["Plan 1", "One long stent"]
    for wrong, said in (
        ("Plan 1", "Plan: expected a name of its own, another plan is called Plan 1, too"),
        ("  ", "Plan: expected a name, got none; type one."),
    ):
        rename(aPlan, 1, wrong)
        assert names(aPlan) == ["Plan 1", "One long stent"]
        assert aPlan.ui.statusLabel.text.startswith(said)


def test_a_result_that_is_the_vessel_of_another_plan_stays(host, aPlan, aScene):
    ui, first, logic = aPlan.ui, aPlan._parameterNode, aPlan.logic
    host.click(ui.duplicatePlanButton)
    deploy(host, aPlan)
    result = aPlan._parameterNode.outputVessel
    following = logic.addParameterSet("Following")
    following.vessel = result
    assert names(aPlan) == ["Plan 1", "Plan 2"]  # that one is for another vessel
    host.click(ui.removePlanButton)
    assert aPlan._parameterNode is first
    assert result.GetScene() is aScene


def test_a_plan_that_is_deleted_elsewhere_leaves_the_table(host, aPlan, aScene):
    """As by the selector on top of the panel, and takes its results and handles with it."""
    first, counts = aPlan._parameterNode, []
    deploy(host, aPlan)
    for _time in range(2):  # before the first one a lesion may have been plotted, or not yet
        host.click(aPlan.ui.duplicatePlanButton)
        deploy(host, aPlan)
        aScene.RemoveNode(aPlan._parameterNode.parameterNode)
        host.process()
        settle(host, aPlan)
        host.processUntil(lambda: not aPlan.ends.isBusy)
        assert aPlan._parameterNode is first
        assert names(aPlan) == ["Plan 1"]
        assert isSeen(first.outputVessel)
        counts.append(aScene.GetNumberOfNodes())
    assert counts[0] == counts[1]


def test_plan_files_become_plans(host, aPlan, tmp_path):
    ui, first = aPlan.ui, aPlan._parameterNode
    paths = [tmp_path / "short.json", tmp_path / "long.json"]
    for path, length in zip(paths, (10.0, 30.0), strict=True):
        ui.lengthSlider.value = length
        aPlan.logic.savePlan(path, first)
    ui.lengthSlider.value = 14.0
    host.files.append([str(path) for path in paths])
    host.click(ui.loadPlansButton)
    assert names(aPlan) == ["Plan 1", "short", "long"]
    assert aPlan._parameterNode.stent.length == 30.0
    plans = aPlan.logic.alternatives(first)
    assert [plan.stents[0].length for plan in plans] == [14.0, 10.0, 30.0]
    paths[0].write_text("{}", encoding="utf-8")
    host.files.append([str(paths[1]), str(paths[0])])
    host.click(ui.loadPlansButton)  # the second cannot be read
    assert names(aPlan) == ["Plan 1", "short", "long", "long 2"]
    assert "short.json" in ui.statusLabel.text
    host.files.append([])  # the dialog is closed
    host.click(ui.loadPlansButton)
    assert len(names(aPlan)) == 4


def test_a_plan_without_stents_is_where_the_first_file_goes(host, aPlan, tmp_path):
    path = tmp_path / "proposal.json"
    aPlan.logic.savePlan(path, aPlan._parameterNode)
    host.click(aPlan.ui.removeStentButton)
    host.files.append([str(path)])
    host.click(aPlan.ui.loadPlansButton)
    assert names(aPlan) == ["proposal"]
    assert len(aPlan._parameterNode.stents) == 1


def test_plans_are_saved_with_the_scene(host, aPlan, aScene, tmp_path):
    deploy(host, aPlan)
    host.click(aPlan.ui.duplicatePlanButton)
    rename(aPlan, 1, "Smaller")
    aPlan.ui.diameterSlider.value = 6.5
    rows = [rowOf(aPlan, 0), rowOf(aPlan, 1)]
    path = tmp_path / "plans.mrb"
    assert aScene.WriteToMRB(str(path))
    host.newScene()
    assert names(aPlan) == ["Plan 1"]
    assert rowOf(aPlan, 0)[1:] == [""] * 4
    assert aScene.ReadFromMRB(str(path), True)
    host.process()
    assert [rowOf(aPlan, 0), rowOf(aPlan, 1)] == rows
    assert aPlan._parameterNode.parameterNode.GetName() == "Smaller"  # which was shown last
    assert aPlan.ui.planTable.currentRow() == 1
    aPlan.ui.planTable.selectRow(0)
    first = aPlan._parameterNode
    assert aPlan.ui.diameterSlider.value == 8.5
    assert isSeen(first.outputVessel)
    aPlan.ui.planTable.selectRow(1)
    assert aPlan.ui.diameterSlider.value == 6.5
    assert not isSeen(first.outputVessel)


# Comparing


@pytest.fixture
def twoPlans(host, aPlan):
    """Two plans, a wide stent and a narrow one; neither vessel nor centerline is in a file."""
    host.click(aPlan.ui.duplicatePlanButton)
    rename(aPlan, 1, "narrow: 6/5 mm")
    aPlan.ui.diameterSlider.value = 6.5
    slicer.util.openedUrls.clear()
    return aPlan


def compared(host, panel, folder):
    host.files.append(str(folder))
    host.click(panel.ui.comparePlansButton)
    host.processUntil(lambda: not panel.plans.comparing.isRunning)


def told(document):
    """What a comparison says, without when, where and how quickly it was made."""
    for one in document["alternatives"]:
        report = one["report"]
        for key in ("created", "timings", "inputs"):
            del report[key]
    return [(one["name"], one["certified"], one["report"]) for one in document["alternatives"]]


def test_the_page_is_that_of_sdfstent_compare(host, twoPlans, tmp_path):
    """What the shell makes of the folder's plans and inputs is the same, and the numbers are the panel's.

    Meanwhile the user goes on, and even closes the scene.
    """
    from SDFStentLib.plan import compare, load_plan
    from SDFStentLib.report import comparison_document, document_json

    ui = twoPlans.ui
    deploy(host, twoPlans)
    (treated,) = twoPlans.logic.lastRun(twoPlans._parameterNode).result.stents
    folder = tmp_path / "comparison"
    host.files.append(str(tmp_path))
    host.click(ui.comparePlansButton)
    ui.planTable.selectRow(0)
    host.newScene()
    host.processUntil(lambda: not twoPlans.plans.comparing.isRunning)
    (url,) = slicer.util.openedUrls
    assert Path(url.toLocalFile()) == folder / "comparison.html"
    assert "data:image/png" in (folder / "comparison.html").read_text(encoding="utf-8")
    ours = json.loads((folder / "comparison.json").read_text(encoding="utf-8"))
    names = [one["name"] for one in ours["alternatives"]]
    assert names == ["Plan 1", "narrow_ 6_5 mm"]
    plans = {name: load_plan(folder / f"{name}.json") for name in names}
    theirs = json.loads(document_json(comparison_document(compare(plans))))
    lumen = ours["alternatives"][1]["report"]["stents"][0]["diameters"]["minimum_lumen"]
    assert told(ours) == told(theirs)
    assert lumen["after_mm"] == pytest.approx(treated.after.minimum, abs=1e-9)


def test_files_that_are_there_are_named_and_not_written_again(aLogic, theParameters, tmp_path):
    for node in (theParameters.vessel, theParameters.centerline):
        saveAsFile(node, tmp_path / f"{node.GetName()}.vtp", "LPS")
    aLogic.duplicatePlan(theParameters)
    steps = aLogic.comparisonSteps(theParameters, tmp_path)
    next(steps)  # by now the inputs are in files
    assert list((tmp_path / "comparison").iterdir()) == []
    steps.close()
    assert not (tmp_path / "comparison").exists()


def test_two_centerlines_of_one_name_are_not_taken_for_one(aLogic, theParameters, aScene, tmp_path):
    line = theParameters.centerline
    other = aScene.AddNewNodeByClass("vtkMRMLModelNode", line.GetName())
    moved = vtk.vtkPolyData()
    moved.DeepCopy(line.GetPolyData())
    other.SetAndObservePolyData(moved)
    slicer.util.arrayFromModelPoints(other)[:, 0] += 0.25
    aLogic.duplicatePlan(theParameters).centerline = other
    with pytest.raises(ValueError, match="expected plans with one centerline"):
        aLogic.compare(theParameters, tmp_path)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["comparison", "Comparison", "plan 1"])
def test_names_of_which_one_file_would_overwrite_another_are_refused(
    aLogic, theParameters, tmp_path, name
):
    aLogic.duplicatePlan(theParameters).parameterNode.SetName(name)
    with pytest.raises(ValueError, match="expected plans of different names"):
        next(aLogic.comparisonSteps(theParameters, tmp_path))
    assert list(tmp_path.iterdir()) == []


def test_what_cannot_be_compared_is_a_sentence_and_leaves_no_folder(host, twoPlans, tmp_path):
    ui, second = twoPlans.ui, twoPlans._parameterNode
    host.files.append("")  # the dialog is closed
    host.click(ui.comparePlansButton)
    assert not twoPlans.plans.comparing.isRunning
    second.stent.handle.RemoveAllControlPoints()
    compared(host, twoPlans, tmp_path)
    assert "\nnarrow: 6/5 mm: Stent 1: place 1 point(s)" in ui.statusLabel.text
    second.stent.handle.AddControlPointWorld(*theThroat())
    second.parameterNode.SetName("Plan 1")
    compared(host, twoPlans, tmp_path)
    assert "two are called Plan 1; rename one." in ui.statusLabel.text
    second.parameterNode.SetName("narrow")
    compared(host, twoPlans, tmp_path / "missing")
    assert "missing" in ui.statusLabel.text
    assert list(tmp_path.iterdir()) == []
    assert slicer.util.openedUrls == []
    assert ui.comparePlansButton.text == "Compare..."


def test_a_comparison_that_is_stopped_leaves_nothing(host, twoPlans, tmp_path, aStepAtATime):
    import threading

    ui, before = twoPlans.ui, set(threading.enumerate())
    host.files.append(str(tmp_path))
    host.click(ui.comparePlansButton)
    assert ui.comparePlansButton.text.startswith("Stop, ")
    host.click(ui.comparePlansButton)
    assert not twoPlans.plans.comparing.isRunning
    assert ui.comparePlansButton.text == "Compare..."
    host.processUntil(lambda: before.issuperset(threading.enumerate()))
    assert list(tmp_path.iterdir()) == []
    assert slicer.util.openedUrls == []


def test_handles_of_further_plans_are_counted(host, aStent, aScene):
    ui = aStent.ui
    ui.plansCollapsibleButton.collapsed = False
    for _ in range(3):
        host.click(ui.duplicatePlanButton)
    host.click(ui.copyStentButton)
    assert handleNames(aScene) == [
        "Stent 1",
        "Stent 1 (2)",
        "Stent 1 (3)",
        "Stent 1 (4)",
        "Stent 2",
    ]


def test_results_are_not_offered_as_inputs(host, aStent, aScene):
    ui, vessel = aStent.ui, aStent._parameterNode.vessel
    before = {name: offered(getattr(ui, name)) for name in ("vesselSelector", "centerlineSelector")}
    deploy(host, aStent)
    for name, nodes in before.items():
        assert offered(getattr(ui, name)) == nodes
    assert aStent._parameterNode.vessel is vessel
    results = {"Stented vessel", "Stents", "Stented centerline"}
    assert results <= {node.GetName() for node in slicer.util.getNodesByClass("vtkMRMLModelNode")}
    assert not results & set(offered(ui.deviceMeshSelector))
    aStent._parameterNode.vessel = aStent._parameterNode.outputVessel  # as former versions let one
    host.process()
    assert ui.vesselSelector.currentNode() is aStent._parameterNode.outputVessel
