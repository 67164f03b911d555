"""The panel, driven as a user does: clicks, sliders, points that move."""

import itertools

import numpy as np
import pytest
import slicer
from panel_helpers import clickSample, deploy, pointsOf, settle, theThroat


def test_a_disabled_deploy_button_says_what_is_missing(host, aPanel, aVessel):
    vessel, centerline = aVessel
    assert not aPanel.ui.deployButton.enabled
    assert "vessel" in aPanel.ui.deployButton.toolTip
    aPanel.ui.vesselSelector.setCurrentNode(vessel)
    assert "centerline" in aPanel.ui.deployButton.toolTip
    aPanel.ui.centerlineSelector.setCurrentNode(centerline)
    assert "stent" in aPanel.ui.deployButton.toolTip
    assert aPanel.ui.statusLabel.text == aPanel.ui.deployButton.toolTip
    host.click(aPanel.ui.addStentButton)
    assert aPanel.ui.deployButton.enabled


def test_every_control_has_a_tooltip(aPanel):
    from PySide6 import QtWidgets

    controls = (
        QtWidgets.QAbstractButton,
        QtWidgets.QComboBox,
        QtWidgets.QLineEdit,
        QtWidgets.QTableWidget,
    )
    custom = ("Selector", "Slider", "Widget", "ComboBox", "Button", "CheckBox", "Edit", "Table")
    for name, widget in vars(aPanel.ui).items():
        isControl = isinstance(widget, controls) or name.endswith(custom)
        if isControl and not name.endswith("CollapsibleButton"):
            assert widget.toolTip, name


def test_the_3d_view_shows_the_stented_vessel(host, aStent, thePictures):
    deploy(host, aStent)
    bounds = aStent._parameterNode.outputVessel.GetPolyData().GetBounds()
    aStent.ui.expansionSlider.value = 0
    before = imageOf(host.application.render(thePictures / "before.png", focus=bounds))
    aStent.ui.expansionSlider.value = 100
    after = imageOf(host.application.render(thePictures / "after.png", focus=bounds))
    aStent.ui.mapComboBox.currentIndex = 1
    host.process()
    colored = imageOf(host.application.render(thePictures / "displacement.png", focus=bounds))
    assert (before != before[:, :1]).mean() > 0.05  # something is drawn on the rows' background
    assert (before != after).mean() > 0.01
    assert (after != colored).mean() > 0.01


def imageOf(path):
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy

    reader = vtk.vtkPNGReader()
    reader.SetFileName(str(path))
    reader.Update()
    pixels = vtk_to_numpy(reader.GetOutput().GetPointData().GetScalars()).astype(int)
    width, height, _depth = reader.GetOutput().GetDimensions()
    return pixels.reshape(height, width, -1)


def test_sliders_and_parameters_are_bound_both_ways(aStent):
    parameters = aStent._parameterNode
    aStent.ui.diameterSlider.value = 7.5
    assert parameters.stent.diameter == parameters.stents[0].diameter == 7.5
    parameters.method.influenceDistance = 9.0
    assert aStent.ui.influenceDistanceSlider.value == 9.0
    aStent.ui.falloffComboBox.currentIndex = 2
    assert parameters.method.falloff == "cosine"
    aStent.ui.defaultsButton.click()
    assert parameters.method.falloff == "compact"
    assert aStent.ui.influenceDistanceSlider.value == 6.5


def test_the_table_adds_copies_moves_switches_and_removes(host, aStent):
    from PySide6.QtCore import Qt

    ui, parameters = aStent.ui, aStent._parameterNode
    host.click(ui.copyStentButton)
    host.click(ui.addStentButton)
    labels = lambda: [stent.label for stent in parameters.stents]  # noqa: E731
    assert labels() == ["Stent 1", "Stent 2", "Stent 3"]
    assert parameters.stents[1].diameter == 8.5
    assert parameters.stents[1].handle is not parameters.stents[0].handle
    host.click(ui.moveUpButton)
    assert labels() == ["Stent 1", "Stent 3", "Stent 2"]
    assert ui.stentTable.currentRow() == 1
    ui.stentTable.selectRow(0)
    assert parameters.selected == 0
    assert ui.nameEdit.text == "Stent 1"
    ui.stentTable.item(2, 0).setCheckState(Qt.Unchecked)
    assert [stent.enabled for stent in parameters.stents] == [True, True, False]
    handle = parameters.stent.handle
    host.click(ui.removeStentButton)
    assert labels() == ["Stent 3", "Stent 2"]
    assert handle.GetScene() is None


def test_dragging_the_handle_redeploys_and_ends_with_the_final_place(host, aStent):
    aStent.ui.autoUpdateCheckBox.checked = True
    settle(host, aStent)
    parameters, logic = aStent._parameterNode, aStent.logic
    centerline = logic._inputs.centerline(parameters)
    path = centerline.path_around(theThroat(), 12.0).points
    for point in path:
        parameters.stent.handle.SetNthControlPointPositionWorld(0, *point)
        host.process(0.01)
    settle(host, aStent)
    shown = pointsOf(parameters.outputVessel)
    # The full method came after the preview.
    assert "prescribed 8.5 mm" in aStent.ui.lumenLabel.text
    np.testing.assert_array_equal(shown, logic.deploy(parameters).points.astype(np.float32))


def recorded_begins(aStent):
    """A list to which every deployment that begins from now on adds whether it is live."""
    begun = []
    begin = aStent.session._begin
    aStent.session._begin = lambda live, *rest: (begun.append(live), begin(live, *rest))
    return begun


def test_the_expansion_slider_goes_back_and_forth(host, aStent):
    deploy(host, aStent)
    parameters = aStent._parameterNode
    original = pointsOf(parameters.vessel)
    final = pointsOf(parameters.outputVessel)
    aStent.ui.expansionSlider.value = 80
    between = pointsOf(parameters.outputVessel)
    assert 0 < np.abs(between - original).max() < np.abs(final - original).max()
    host.click(aStent.ui.beforeButton)
    np.testing.assert_array_equal(
        slicer.util.arrayFromModelPoints(parameters.outputVessel), original
    )
    aStent.ui.expansionSlider.value = 100
    np.testing.assert_array_equal(slicer.util.arrayFromModelPoints(parameters.outputVessel), final)


def test_closing_the_scene_while_deploying_is_clean(host, aStent, aScene):
    aStent.session.start()
    aScene.Clear(0)
    settle(host, aStent)
    assert not aStent.ui.deployButton.enabled


def ownModules():
    import sys

    packages = ("SDFStent", "SDFStentLib", "SDFStentSlicer")
    return {name: one for name, one in sys.modules.items() if name.split(".")[0] in packages}


@pytest.fixture
def reloading():
    """Tests that follow go on with the classes that they have imported."""
    import sys

    entry, modules = slicer.modules.sdfstent, ownModules()
    yield
    for name in ownModules():
        del sys.modules[name]
    sys.modules.update(modules)
    slicer.modules.sdfstent = entry


def test_reload_reads_both_halves_again(reloading, host, aPanel):
    before = ownModules()
    aPanel.onReload()
    after = ownModules()
    for name in ("SDFStentLib.stent", "SDFStentSlicer.Logic"):
        assert after[name] is not before[name]


def test_sample_data_comes_without_network(host, aScene):
    for name in ("StenosedPulmonaryArtery", "AortaWithCoarctation"):
        vessel, centerline = clickSample(name)
        assert vessel.GetPolyData().GetNumberOfPolys() > 1000
        assert centerline.GetPolyData().GetPointData().HasArray("Radius")


def test_cancel_acts_while_measuring_and_nobody_waits(host, aStent, knownResults, aStepAtATime):
    import threading

    before = set(threading.enumerate())  # other tests of this process may have left some
    knownResults.clear()
    host.click(aStent.ui.deployButton)
    host.processUntil(lambda: aStent.ui.lumenLabel.text == "Not measured yet.")
    assert aStent.session.isRunning
    host.click(aStent.ui.cancelButton)
    assert not aStent.session.isBusy
    host.processUntil(lambda: before.issuperset(threading.enumerate()))
    assert aStent.ui.lumenLabel.text == "Not measured yet."
    deploy(host, aStent)
    assert "prescribed 8.5 mm" in aStent.ui.lumenLabel.text


def test_a_fast_drag_is_followed_while_it_lasts(host, aStent):
    from SDFStentSlicer import Clock

    aStent.ui.autoUpdateCheckBox.checked = True
    settle(host, aStent)
    begun, values = recorded_begins(aStent), itertools.cycle(np.linspace(6.0, 9.0, 60))

    def move():
        aStent.ui.diameterSlider.value = next(values)

    # As a hand is heard: by the event loop, which also tells of a rest.
    hand = Clock.timer(move, 4, isRepeated=True)
    hand.start()
    host.processUntil(lambda: len(begun) >= 3)  # a wait that every change restarts would leave none
    hand.stop()
    assert all(begun)  # previews only
    aStent.ui.diameterSlider.value = 9.0
    settle(host, aStent)
    assert "prescribed 9 mm" in aStent.ui.lumenLabel.text


def test_the_only_vessel_and_centerline_are_chosen_when_the_module_is_entered(
    host, aPanel, aVessel, aScene
):
    parameters, (vessel, centerline) = aPanel._parameterNode, aVessel
    assert parameters.vessel is None
    host.leave(aPanel)
    another = aScene.AddNewNodeByClass("vtkMRMLModelNode", "Another wall")
    another.SetAndObservePolyData(vessel.GetPolyData())
    host.enter(aPanel)
    assert aPanel._parameterNode.vessel is aPanel._parameterNode.centerline is None  # which one?
    host.leave(aPanel)
    aScene.RemoveNode(another)
    host.enter(aPanel)
    parameters = aPanel._parameterNode
    assert (parameters.vessel, parameters.centerline) == (vessel, centerline)
    parameters.vessel = None
    host.leave(aPanel)
    host.enter(aPanel)
    assert aPanel._parameterNode.vessel is None  # the user's choice, once there is one
