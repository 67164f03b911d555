"""What is seen while something is dragged."""

import itertools
import re
import threading
import time

import numpy as np
import pytest
import vtk
from panel_helpers import deploy, pointsOf, settle, theThroat
from vtkmodules.util.numpy_support import vtk_to_numpy


def shown(parameters):
    return pointsOf(parameters.outputVessel)


def previewed(logic, parameters):
    """Run a preview to its end; returns the points that it shows."""
    for _fraction in logic.steps(parameters, live=True):
        pass
    return shown(parameters)


def test_the_preview_is_the_library_s(aLogic, theParameters):
    from SDFStentSlicer import Plans

    from SDFStentLib.treatment import Preview

    points = previewed(aLogic, theParameters)
    surface = aLogic._inputs.vessel(theParameters).surface
    preview = Preview(surface, aLogic.centerlineOf(theParameters))
    seen = preview.of(Plans.plannedOf(theParameters), Plans.settingsOf(theParameters, live=True))
    expected = surface.points.copy()
    expected[seen.indices] = seen.coordinates
    np.testing.assert_array_equal(points, expected.astype(np.float32))
    assert len(seen.indices) > 100


def test_the_first_preview_waits_for_the_vessel_in_portions(aLogic, theParameters, monkeypatch):
    from SDFStentSlicer import Inputs

    made, isAtIt = Inputs.vessel_of, threading.Event()

    def slow(*args, **how):
        isAtIt.set()
        time.sleep(0.3)
        isAtIt.clear()
        return made(*args, **how)

    monkeypatch.setattr(Inputs, "vessel_of", slow)
    assert any(isAtIt.is_set() for _fraction in aLogic.steps(theParameters, live=True))


def test_inputs_are_converted_once_for_all_who_wait_for_them(aLogic, theParameters, monkeypatch):
    from SDFStentSlicer import Conversion, Inputs

    theParameters.vessel.GetMesh().Modified()  # it is converted anew
    made = []
    for module, name in (
        (Conversion, "vesselPolyData"),
        (Inputs, "LineEnds"),
        (Inputs, "vessel_of"),
    ):
        former = getattr(module, name)
        monkeypatch.setattr(
            module, name, lambda *a, _f=former, _n=name, **k: made.append(_n) or _f(*a, **k)
        )
    waiting = [aLogic._inputs.patientInPortions(theParameters) for _ in range(3)]
    next(waiting[2])
    waiting.pop().close()  # whoever goes takes nothing away
    found = {}
    # Ends: with the calculation, in turns.
    while len(found) < len(waiting):
        for number in {0, 1}.difference(found):
            try:
                next(waiting[number])
            except StopIteration as end:
                found[number] = end.value
    assert made == ["vesselPolyData", "LineEnds", "vessel_of"]
    assert found[0] is found[1] is aLogic._inputs.patient(theParameters)


def test_the_wall_is_not_indexed_on_the_application_s_thread(aLogic, theParameters, monkeypatch):
    from SDFStentSlicer import Inputs

    made, where = Inputs.LineEnds, []

    def noted(surface):
        where.append(threading.current_thread())
        return made(surface)

    monkeypatch.setattr(Inputs, "LineEnds", noted)
    theParameters.centerline.GetMesh().Modified()  # it is converted anew
    aLogic.centerlineOf(theParameters)
    assert where
    assert threading.main_thread() not in where


def test_the_minimum_lumen_is_told_while_dragging_and_marked(host, aStent, theModule, monkeypatch):
    from SDFStentSlicer import Results

    told = []
    showPreviewed = Results.showPreviewed
    monkeypatch.setattr(
        Results,
        "showPreviewed",
        lambda parameterNode, *values: (
            showPreviewed(parameterNode, *values),
            told.append(aStent.ui.lumenLabel.text),
        ),
    )
    aStent.ui.autoUpdateCheckBox.checked = True
    settle(host, aStent)
    aStent.ui.diameterSlider.value = 9.0
    settle(host, aStent)
    assert len(told) >= 1
    assert "(preview)" in told[-1]
    preview = float(re.search(r"about (\S+) mm", told[-1]).group(1))
    run = aStent.logic.lastRun(aStent._parameterNode)
    assert preview == pytest.approx(run.result.stents[0].after.minimum, rel=0.03)
    assert "preview" not in aStent.ui.lumenLabel.text  # the full method came after it


def test_the_full_method_takes_no_preview_back_before_it_has_ended(host, aStent, monkeypatch):
    from SDFStentSlicer.SurfaceOutput import SurfaceOutput

    parameters = aStent._parameterNode
    native = pointsOf(parameters.vessel)
    moved, showChanged = [], SurfaceOutput.showChanged

    def recorded(self, *values):
        showChanged(self, *values)
        moved.append(np.abs(shown(parameters) - native).max())

    monkeypatch.setattr(SurfaceOutput, "showChanged", recorded)
    aStent.ui.autoUpdateCheckBox.checked = True
    settle(host, aStent)
    assert "prescribed" in aStent.ui.lumenLabel.text
    assert len(moved) == 2  # the preview, and the end of the full method
    assert moved[1] == pytest.approx(moved[0], abs=0.3)
    aStent.ui.diameterSlider.value = 9.5
    aStent.ui.autoUpdateCheckBox.checked = False
    moved.clear()
    aStent.session.start()  # of another plan than the one that is shown
    settle(host, aStent)
    assert len(moved) > 2
    assert moved[0] < 0.5 * moved[-1]  # it is seen from the beginning


def test_the_full_method_begins_unseen_before_a_hand_is_taken_to_have_stopped(
    host, aStent, monkeypatch
):
    from SDFStentSlicer import Clock

    ui, session = aStent.ui, aStent.session
    steps, begun, isHeld = aStent.logic.steps, [], False

    def held(*arguments, live, **more):
        begun.append("preview" if live else "full")
        for step in steps(*arguments, live=live, **more):
            yield step
            while isHeld and not live:  # Ends: when the test has looked.
                yield step

    monkeypatch.setattr(aStent.logic, "steps", held)
    ui.autoUpdateCheckBox.checked = True
    settle(host, aStent)
    told, onStart = [], session._onStart
    session._onStart = lambda: (onStart(), told.append(session.isPreview))
    session._settleTimer = Clock.timer(session._settle, 3_600_000)
    isHeld, begun = True, []
    for count, diameter in enumerate((9.0, 9.5), 1):
        ui.diameterSlider.value = diameter
        host.processUntil(lambda count=count: begun.count("full") == count)
        assert session._settleTimer.isActive()
        assert session.isRunning
        assert session.isPreview
        assert "(preview)" in ui.lumenLabel.text
        assert ui.deployButton.enabled
        assert not ui.progressBar.visible
    isHeld = False
    settle(host, aStent)
    assert told == [True]  # from the full method to the first preview: nothing flickers in between
    assert "prescribed 9.5 mm" in ui.lumenLabel.text
    assert not session.isPreview


def letGoAt(handle, place):
    """The mouse moves a handle and lets it go before anything could be shown."""
    handle.SetNthControlPointPositionWorld(0, *place)
    handle.InvokeEvent(handle.PointEndInteractionEvent)


def test_what_a_hand_lets_go_of_is_deployed_in_full_at_once(host, aStent, monkeypatch):
    """And seen as soon as a preview would be."""
    parameters, begun, drawn = aStent._parameterNode, [], []
    handle, steps = parameters.stent.handle, aStent.logic.steps
    aStent.ui.autoUpdateCheckBox.checked = True
    settle(host, aStent)

    def noted(*arguments, live, **more):
        begun.append("preview" if live else "full")
        for step in steps(*arguments, live=live, **more):
            tube = parameters.outputStents.GetPolyData()
            drawn.append((shown(parameters), tube.GetBounds(), parameters.certificateSummary))
            yield step

    monkeypatch.setattr(aStent.logic, "steps", noted)
    tree = aStent.logic.centerlineOf(parameters)
    chain = tree.ancestry(tree.project(theThroat()).index)
    letGoAt(handle, tree.points[chain][tree.arc_length[chain] < tree.arc_length[chain[-1]] - 4][-1])
    settle(host, aStent)
    assert begun == ["full"]
    assert "prescribed 8.5 mm" in aStent.ui.lumenLabel.text
    # Three pictures: as it was, grown, and finished; never the vessel without its stent.
    native = pointsOf(parameters.vessel)
    states = [one for one, _tube, _told in drawn]
    changes = [
        (first, second)
        for first, second in itertools.pairwise(states)
        if not np.array_equal(first, second)
    ]
    assert len(changes) == 2
    assert min(np.abs(one - native).max() for pair in changes for one in pair) > 0.5
    (former, grown), (_grown, finished) = changes
    away = [np.linalg.norm(finished - one) for one in (former, grown)]
    assert away[1] < 0.3 * min(away[0], np.linalg.norm(finished - native))
    first = next(n for n, one in enumerate(states) if np.array_equal(one, grown))
    assert drawn[first][1] == drawn[-1][1] != drawn[0][1]  # the stent as well


def test_the_view_is_drawn_while_what_a_hand_let_go_of_takes_long_to_grow(
    host, aStent, monkeypatch
):
    parameters, session, isHeld = aStent._parameterNode, aStent.session, True
    steps = aStent.logic.steps
    aStent.ui.autoUpdateCheckBox.checked = True
    settle(host, aStent)

    def slow(*arguments, **more):
        while isHeld:  # Ends: when the test has looked.
            yield 0.0
        yield from steps(*arguments, **more)

    monkeypatch.setattr(aStent.logic, "steps", slow)
    with host.drawing(0.001) as frames:
        letGoAt(parameters.stent.handle, theThroat() + np.array([0.3, 0, 0]))
        count = frames.count
        host.application.view.group.InvokeEvent(vtk.vtkCommand.UpdateEvent)
        host.processUntil(lambda: not session._settleTimer.isActive())
        host.processUntil(lambda: frames.count > count, 20)
    assert session.isRunning
    isHeld = False
    settle(host, aStent)
    assert "prescribed 8.5 mm" in aStent.ui.lumenLabel.text


def test_a_place_that_is_refused_is_shown_as_it_was_when_a_hand_lets_go(host, aStent):
    parameters = aStent._parameterNode
    aStent.ui.autoUpdateCheckBox.checked = True
    settle(host, aStent)
    letGoAt(parameters.stent.handle, theThroat() + np.array([0, 3.8, 0]))
    settle(host, aStent)
    assert "in the lumen" in aStent.ui.statusLabel.text
    np.testing.assert_array_equal(shown(parameters), pointsOf(parameters.vessel))
    assert aStent._state.atHand.text == ""


def test_nothing_is_deployed_when_a_hand_lets_go_without_live(host, aStent):
    letGoAt(aStent._parameterNode.stent.handle, theThroat() + np.array([0.2, 0, 0]))
    settle(host, aStent)
    assert aStent._parameterNode.outputVessel is None


@pytest.mark.parametrize("spoil", ["outside", "too wide"])
def test_where_no_stent_can_be_the_vessel_is_shown_as_it_was_and_said_to_be(host, aStent, spoil):
    parameters, handle = aStent._parameterNode, aStent._parameterNode.stent.handle
    before = pointsOf(parameters.vessel)
    aStent.ui.autoUpdateCheckBox.checked = True
    settle(host, aStent)
    assert np.abs(shown(parameters) - before).max() > 0.5
    assert parameters.outputStents.GetPolyData().GetNumberOfPoints() > 0
    if spoil == "too wide":
        parameters.stent.diameter = 59.0
    else:  # across the plane of the vessel
        handle.SetNthControlPointPositionWorld(0, *(theThroat() + np.array([0, 3.8, 0])))
    settle(host, aStent)
    told = {"outside": "in the lumen", "too wide": "at most 4 times"}
    assert told[spoil] in aStent.ui.statusLabel.text
    assert "Changed since" not in aStent.ui.statusLabel.text  # what is shown is of this plan
    np.testing.assert_array_equal(shown(parameters), before)
    assert parameters.outputStents.GetPolyData().GetNumberOfPoints() == 0
    assert aStent.ui.lumenLabel.text == "Shown: the vessel before treatment."
    assert aStent.ui.lumenLabel.enabled
    assert aStent.ui.certificateLabel.text == ""
    assert not aStent.ui.expansionSlider.enabled
    handle.SetNthControlPointPositionWorld(0, *theThroat())
    aStent.ui.diameterSlider.value = 8.5
    settle(host, aStent)
    assert "prescribed" in aStent.ui.lumenLabel.text
    assert aStent.ui.statusLabel.text == ""


def test_normals_computed_where_points_changed_are_those_computed_everywhere(aVessel, monkeypatch):
    from SDFStentSlicer import PointNormals
    from vtk.util.numpy_support import vtk_to_numpy

    surface = vtk.vtkPolyData()
    surface.DeepCopy(aVessel[0].GetPolyData())
    PointNormals.withNormals(surface)
    assert PointNormals.cornersOf(surface) is None  # faster as a whole
    monkeypatch.setattr(PointNormals, "LOCAL_FROM", 0)
    normals = PointNormals.PointNormals(surface, PointNormals.cornersOf(surface))
    normals.update()
    points = vtk_to_numpy(surface.GetPoints().GetData())
    indices = np.flatnonzero(np.linalg.norm(points - theThroat(), axis=1) < 6)
    points[indices] += 0.3 * np.sin(points[indices])
    surface.GetPoints().GetData().Modified()
    normals.update((indices[:10], indices))
    local = vtk_to_numpy(surface.GetPointData().GetNormals()).copy()
    normals.update()
    everywhere = vtk_to_numpy(surface.GetPointData().GetNormals())
    np.testing.assert_array_equal(local[indices], everywhere[indices])
    assert (local == everywhere).all(axis=1).mean() > 0.9  # all but the rim
    nothing = np.empty(0, dtype=np.int64)
    normals.update((nothing, nothing))  # a stent narrower than the lumen moves nothing
    np.testing.assert_array_equal(everywhere, vtk_to_numpy(surface.GetPointData().GetNormals()))


def test_the_output_is_lit_before_anything_changes(aLogic, theParameters):
    from SDFStentSlicer.SurfaceOutput import outputSurface

    made = outputSurface(theParameters, aLogic._inputs.vessel(theParameters), None)
    normals = vtk_to_numpy(made.node.GetPolyData().GetPointData().GetNormals())
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, rtol=1e-3)


def test_views_follow_a_vessel_that_is_chosen_once(aVessel):
    from SDFStentSlicer import Showing

    changes = []
    display = aVessel[0].GetDisplayNode()
    display.SetVisibility2D(False)
    display.AddObserver(vtk.vtkCommand.ModifiedEvent, lambda *_: changes.append(1))
    aVessel[0].RemoveAttribute(Showing.ONE_COLOR)
    Showing.inOneColor(*aVessel)
    assert display.GetBackfaceCulling()
    assert len(changes) == 1


def test_the_numbers_of_another_vessel_go_at_once(host, aStent):
    from SDFStentSlicer.SampleVessels import addSampleVessel

    panel = aStent
    deploy(host, panel)
    assert panel._parameterNode.tiles
    other = addSampleVessel("branching_pulmonary_artery", "Other")[0]
    panel.ui.autoUpdateCheckBox.checked = True
    settle(host, panel)
    panel.ui.vesselSelector.setCurrentNode(other)
    steps = panel.logic.steps(panel._parameterNode, live=True)
    next(steps)
    assert panel._parameterNode.tiles == panel._parameterNode.atHand == ""
    steps.close()
    settle(host, panel)
    assert panel._parameterNode.tiles
