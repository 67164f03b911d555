"""What happens to the user's choices while the scene changes: imports, deleted nodes, several parameter sets."""

import numpy as np
import pytest
import slicer
import vtk
from panel_helpers import deploy, expanded, offered, pointsOf, settle, theThroat
from vtk.util.numpy_support import vtk_to_numpy


def chosen(parameters):
    """The names of the nodes that a user chose, and of the results."""
    roles = ("vessel", "centerline", "outputVessel", "outputStents", "outputCenterline")
    nodes = [getattr(parameters, role) for role in roles]
    return [node and node.GetName() for node in [*nodes, parameters.stent.handle]]


def models(scene, name):
    """How many models are called so, or so with a number."""
    nodes = slicer.util.getNodesByClass("vtkMRMLModelNode")
    return sum(node.GetName().split("_")[0] == name for node in nodes)


def addModel(scene, name):
    """A sphere that somebody else's module made."""
    sphere = vtk.vtkSphereSource()
    sphere.Update()
    node = scene.AddNewNodeByClass("vtkMRMLModelNode", name)
    node.SetAndObservePolyData(sphere.GetOutput())
    return node


@pytest.fixture
def aDeployment(host, aStent):
    """The panel after a deployment."""
    deploy(host, aStent)
    return aStent


@pytest.fixture
def aSavedScene(host, aScene, theModule, tmp_path):
    """A scene of another day, saved with the stents half expanded; its nodes have other IDs."""
    from SDFStentSlicer.SampleVessels import addSampleVessel

    for _ in range(6):
        aScene.AddNewNodeByClass("vtkMRMLModelNode", "Other")
    logic = theModule.python.SDFStentLogic()
    parameters = logic.getParameterNode()
    parameters.vessel, parameters.centerline = addSampleVessel(
        "branching_pulmonary_artery", "Saved"
    )
    logic.addStent(parameters, diameter=8.0, length=12.0)
    logic.deploy(parameters)
    parameters.expansion = 40.0
    path = tmp_path / "saved.mrb"
    assert aScene.WriteToMRB(str(path))
    host.newScene()
    return path


def test_loading_a_scene_keeps_what_was_chosen_in_it(host, aSavedScene, aPanel, aScene):
    host.newScene()
    assert aScene.ReadFromMRB(str(aSavedScene), True)
    host.process()
    parameters = aPanel._parameterNode
    assert chosen(parameters) == [
        "Saved",
        "Saved centerline",
        "Stented vessel",
        "Stents",
        "Stented centerline",
        "Stent 1",
    ]
    for name, node in (
        ("vesselSelector", parameters.vessel),
        ("centerlineSelector", parameters.centerline),
        ("handleSelector", parameters.stent.handle),
        ("outputSelector", parameters.outputVessel),
    ):
        assert getattr(aPanel.ui, name).currentNode() is node
    deploy(host, aPanel)
    assert models(aScene, "Stents") == models(aScene, "Stented vessel") == 1


def test_importing_into_a_scene_replaces_no_plan_and_makes_no_model_twice(
    host, aSavedScene, aDeployment, aScene
):
    aDeployment.ui.autoUpdateCheckBox.checked = True
    settle(host, aDeployment)
    before, shown = chosen(aDeployment._parameterNode), aDeployment._parameterNode.parameterNode
    assert aScene.ReadFromMRB(str(aSavedScene), False)
    settle(host, aDeployment)
    assert models(aScene, "Stents") == 2  # the scene's own and the imported one
    assert aDeployment._parameterNode.parameterNode is shown
    assert chosen(aDeployment._parameterNode) == before
    deploy(host, aDeployment)
    assert models(aScene, "Stents") == models(aScene, "Stented vessel") == 2
    assert vesselsOfPlans(aDeployment) == ["Artery", "Saved"]
    assert offered(aDeployment.ui.parameterSetSelector) == ["Plan 1", "Plan 1 (2)"]
    assert aScene.ReadFromMRB(str(aSavedScene), False)
    host.process()
    assert offered(aDeployment.ui.parameterSetSelector) == ["Plan 1", "Plan 1 (2)", "Plan 1 (3)"]


def seen(node):
    return bool(node.GetDisplayNode().GetVisibility())


def drawn(parameters):
    """What a plan has in the views."""
    roles = ("outputVessel", "outputStents", "outputCenterline")
    return [*(getattr(parameters, role) for role in roles), parameters.stent.handle]


@pytest.mark.parametrize("isEntered", [True, False])
def test_of_an_imported_plan_nothing_lies_on_the_one_that_is_shown(
    host, aSavedScene, aDeployment, aScene, isEntered
):
    before = aDeployment.logic.getAllParameterNodes()
    if not isEntered:
        host.leave(aDeployment)
    assert aScene.ReadFromMRB(str(aSavedScene), False)
    host.process()
    nodes = sorted(aDeployment.logic.getAllParameterNodes(), key=before.__contains__)
    came, shown = map(aDeployment.logic.parameterSet, nodes)
    assert came.vessel is not shown.vessel
    assert not any(map(seen, [*drawn(came), came.vessel, came.centerline]))
    assert all(map(seen, [*drawn(shown), shown.centerline]))
    if not isEntered:
        host.enter(aDeployment)
    aDeployment._switchTo(came)
    host.process()
    assert all(map(seen, [*drawn(came), came.centerline]))
    assert not any(map(seen, [*drawn(shown), shown.vessel, shown.centerline]))
    aDeployment._switchTo(shown)
    host.process()
    assert all(map(seen, [*drawn(shown), shown.centerline]))


def test_of_two_imported_plans_one_is_seen_when_the_module_is_opened(
    host, aSavedScene, aScene, theModule
):
    for _time in range(2):
        assert aScene.ReadFromMRB(str(aSavedScene), False)
    host.process()
    panel = host.openPanel(theModule)
    plans = map(panel.logic.parameterSet, panel.logic.getAllParameterNodes())
    seenOf = {one is panel._parameterNode: list(map(seen, drawn(one))) for one in plans}
    assert seenOf == {True: 4 * [True], False: 4 * [False]}
    host.closePanel(panel)


def vesselsOfPlans(panel):
    """The vessels of the plans that the panel offers, in order; "" for none."""
    selector, vessels = panel.ui.parameterSetSelector, []
    for node in selector.nodes():
        selector.setCurrentNode(node)
        vessel = panel._parameterNode.vessel
        vessels.append(vessel.GetName() if vessel else "")
    return vessels


def openSample(host, panel):
    """Choose the sample vessel in the panel and add a stent at its throat."""
    from SDFStentSlicer.SampleVessels import addSampleVessel

    parameters = panel._parameterNode
    parameters.vessel, parameters.centerline = addSampleVessel(
        "branching_pulmonary_artery", "Artery"
    )
    host.click(panel.ui.addStentButton)
    parameters.stent.handle.SetNthControlPointPositionWorld(0, *theThroat())
    parameters.stent.diameter, parameters.stent.length = 8.5, 14.0


@pytest.mark.parametrize("isEntered", [pytest.param(True, marks=pytest.mark.bench), False])
def test_the_panel_works_on_in_a_scene_that_was_closed(host, aStent, tmp_path, aScene, isEntered):
    deploy(host, aStent)
    path = tmp_path / "scene.mrb"
    for turn in range(2):  # closed; saved before, closed and loaded
        if not isEntered:
            host.leave(aStent)
        host.newScene()
        if turn:
            assert aScene.ReadFromMRB(str(path), True)
        host.enter(aStent)
        assert vesselsOfPlans(aStent) == (["Artery"] if turn else [""])
        assert aStent.ui.parameterSetSelector.currentNode() is aStent._parameterNode.parameterNode
        if not turn:
            openSample(host, aStent)
        aStent.ui.plansCollapsibleButton.collapsed = False
        for diameter in (8.0, 9.0):
            aStent.ui.autoUpdateCheckBox.checked = True
            aStent.ui.diameterSlider.value = diameter
            settle(host, aStent)
            assert f"prescribed {diameter:g} mm" in aStent.ui.lumenLabel.text
        assert host.errors() == []
        if not turn:
            assert aScene.WriteToMRB(str(path))


def test_plans_of_former_versions_are_taken_over_by_a_module_that_is_opened_later(
    theModule, aScene
):
    former = slicer.vtkMRMLScriptedModuleNode()
    former.SetSingletonTag("SDFStent")
    former.SetAttribute("ModuleName", "SDFStent")
    former.SetName("Former plan")
    aScene.AddNode(former)
    logic = theModule.python.SDFStentLogic()
    node = logic.getParameterNode().parameterNode
    assert node.GetName() == "Former plan"
    assert not node.IsSingleton()
    assert logic.getAllParameterNodes() == [node]


def test_plans_of_former_versions_replace_none_and_one_another_neither(
    host, aSavedScene, aPanel, aScene, tmp_path
):
    """They were singletons, which MRML overwrites by those of a file."""
    host.leave(aPanel)
    host.newScene()
    assert aScene.ReadFromMRB(str(aSavedScene), True)
    (plan,) = aPanel.logic.getAllParameterNodes()
    former = aScene.CreateNodeByClass("vtkMRMLScriptedModuleNode")
    former.UnRegister(None)
    former.Copy(plan)
    former.SetSingletonTag("SDFStent")
    aScene.RemoveNode(plan)
    aScene.AddNode(former)
    path = tmp_path / "former.mrb"
    assert aScene.WriteToMRB(str(path))
    host.newScene()
    host.enter(aPanel)
    openSample(host, aPanel)
    for number in (1, 2):
        assert aScene.ReadFromMRB(str(path), False)
        host.process()
        assert vesselsOfPlans(aPanel) == ["Artery", *number * ["Saved"]]
    assert not any(node.GetSingletonTag() for node in aPanel.logic.getAllParameterNodes())
    host.newScene()
    assert vesselsOfPlans(aPanel) == [""]


def test_a_deleted_node_is_not_replaced_by_its_neighbor(host, aDeployment, aScene):
    addModel(aScene, "Somebody else's")
    for role in ("outputVessel", "centerline", "vessel"):
        aScene.RemoveNode(getattr(aDeployment._parameterNode, role))
        host.process()
        assert getattr(aDeployment._parameterNode, role) is None


def test_the_output_selector_offers_only_outputs_that_nobody_else_uses(host, aDeployment, aScene):
    addModel(aScene, "Somebody else's")
    first, ui = aDeployment._parameterNode, aDeployment.ui
    assert offered(ui.outputSelector) == ["Stented vessel"]
    ui.parameterSetSelector.addNode()
    assert offered(ui.outputSelector) == []
    ui.parameterSetSelector.setCurrentNode(first.parameterNode)
    assert offered(ui.outputSelector) == ["Stented vessel"]
    assert ui.outputSelector.currentNode() is first.outputVessel
    assert first.outputVessel is not None


def test_nothing_is_written_into_a_model_that_is_no_output_of_the_set(
    aLogic, theParameters, aScene
):
    first = expanded(aLogic, theParameters).astype(np.float32)
    own, vessel = theParameters.outputVessel, theParameters.vessel
    second = aLogic.addParameterSet("Second")
    second.vessel, second.centerline = vessel, theParameters.centerline
    aLogic.addStent(second, diameter=9.0, length=10.0, handle=theParameters.stents[0].handle)
    native = pointsOf(vessel)
    for wrong in (own, vessel, theParameters.outputStents, addModel(aScene, "Else")):
        before = pointsOf(wrong)
        second.outputVessel = wrong
        aLogic.deploy(second)
        assert second.outputVessel is not wrong
        np.testing.assert_array_equal(slicer.util.arrayFromModelPoints(wrong), before)
    np.testing.assert_array_equal(slicer.util.arrayFromModelPoints(own), first)
    np.testing.assert_array_equal(slicer.util.arrayFromModelPoints(vessel), native)


# Segments


def addSegmentation(scene, name, count=2):
    """A segmentation of spheres that grow by 1 mm from segment to segment."""
    node = scene.AddNewNodeByClass("vtkMRMLSegmentationNode", name)
    node.SetSourceRepresentationToClosedSurface()
    for number in range(count):
        sphere = vtk.vtkSphereSource()
        sphere.SetRadius(5.0 + number)
        sphere.Update()
        node.AddSegmentFromClosedSurfaceRepresentation(
            sphere.GetOutput(), f"{name} {number}", [1, 0, 0], f"{name}{number}"
        )
    return node


# Arrays


def test_a_line_among_the_triangles_leaves_their_arrays_alone(aLogic, theParameters):
    surface = vtk.vtkPolyData()
    surface.DeepCopy(theParameters.vessel.GetPolyData())
    count = surface.GetNumberOfPolys()
    surface.SetLines(vtk.vtkCellArray())
    surface.GetLines().InsertNextCell(2, [0, 1])
    faceID = vtk.vtkIntArray()
    faceID.SetName("ModelFaceID")
    for value in [-7, *(1 + np.arange(count) % 5)]:  # lines come before polygons
        faceID.InsertNextValue(int(value))
    surface.GetCellData().AddArray(faceID)
    theParameters.vessel.SetAndObservePolyData(surface)
    expanded(aLogic, theParameters)
    shown = theParameters.outputVessel.GetPolyData()
    assert shown.GetNumberOfCells() == count
    np.testing.assert_array_equal(
        vtk_to_numpy(shown.GetCellData().GetArray("ModelFaceID")), 1 + np.arange(count) % 5
    )
