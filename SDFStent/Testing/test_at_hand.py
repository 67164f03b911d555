"""The few lines over the 3D view that follow the hand."""

import numpy as np
import pytest
import slicer
from panel_helpers import deploy, settle
from vtkmodules.vtkRenderingAnnotation import vtkCornerAnnotation


@pytest.fixture(autouse=True)
def theWindow(host):
    slicer.app.showMainWindow(True)
    yield
    slicer.app.showMainWindow(False)


def lengthOf(points):
    return np.linalg.norm(np.diff(points, axis=0), axis=1).sum()


def corner():
    """What the view tells, line by line, and the annotation that does."""
    view = slicer.app.layoutManager().threeDWidget(0).threeDView()
    annotation = view.cornerAnnotation()
    return (annotation.GetText(vtkCornerAnnotation.UpperLeft) or "").split("\n"), annotation


def test_the_view_tells_of_the_stent_while_it_is_dragged_and_when_it_is_measured(
    host, aStent, thePictures
):
    ui, seen = aStent.ui, []
    show = aStent._state.atHand.show
    aStent._state.atHand.show = lambda *told: (show(*told), seen.append(corner()[0]))
    ui.autoUpdateCheckBox.checked = True
    host.processUntil(lambda: not aStent.lesions.isBusy)
    settle(host, aStent)
    seen.clear()
    ui.diameterSlider.value = 8.0
    settle(host, aStent)
    previews = [lines for lines in seen if lines[-1] == "preview"]
    assert previews
    lines, annotation = corner()
    run = aStent.logic.lastRun(aStent._parameterNode)
    treated, lesion = run.result.stents[0], run.lesions[0]
    before = lesion.before
    for told in previews:
        assert told[1].startswith(f"narrowest {before.minimum_diameter:.1f} -> about ")
        assert told[2].startswith(f"stenosis {before.percent_diameter:.0f} % -> ")
    assert lines[0] == f"8.0 x {lengthOf(treated.axis.points):.1f} mm"
    assert lines[1] == f"narrowest {treated.before.minimum:.1f} -> {treated.after.minimum:.1f} mm"
    assert lines[2].startswith(f"stenosis {lesion.before.percent_diameter:.0f} % -> ")
    assert lines[-1] == "certified for meshing"
    assert len(lines) <= 6
    assert annotation.GetTextProperty().GetBackgroundOpacity() == 1.0  # no letters of axes within
    good = annotation.GetTextProperty().GetColor()
    host.application.render(thePictures / "at_hand.png")

    ui.autoUpdateCheckBox.checked = False
    ui.diameterSlider.value = 9.0
    host.process()
    lines, annotation = corner()
    assert lines[-1] == "changed since; not deployed yet"
    assert annotation.GetTextProperty().GetColor() != good
    aStent.logic.reset(aStent._parameterNode)
    assert corner()[0] == [""]
    aStent.exit()
    assert corner()[0] == [""]


def test_a_stent_beside_its_lesion_still_tells_of_it(host, aStent):
    host.processUntil(lambda: not aStent.lesions.isBusy)
    aStent.ui.autoUpdateCheckBox.checked = True
    settle(host, aStent)
    aStent._moveStent(20.0)
    host.processUntil(lambda: corner()[0][-1] == "preview")
    assert corner()[0][2] == "no lesion covered"
    aStent.ui.autoUpdateCheckBox.checked = False
    deploy(host, aStent)
    (lesion,) = aStent.logic.lastRun(aStent._parameterNode).lesions
    assert lesion.stents == ()
    told = f"no lesion covered; lesion 1: {lesion.after.percent_diameter:.0f} % left"
    assert told in corner()[0]


def test_branches_are_told_where_a_dragged_stent_covers_others_than_before(host, aStent):
    aStent.ui.autoUpdateCheckBox.checked = True
    settle(host, aStent)
    assert "branches: 1 covered" in corner()[0]
    aStent._moveStent(6.0)
    host.processUntil(lambda: corner()[0][-1] == "preview")
    assert "branches: 1 -> about 0 covered" in corner()[0]
    settle(host, aStent)
    run = aStent.logic.lastRun(aStent._parameterNode)
    assert all(one.is_free for one in run.result.stents[0].branches)


def test_flow_has_a_line_of_its_own(host, aStent):
    aStent.ui.flowMeanSpinBox.value = 3.0
    deploy(host, aStent)
    (line,) = [line for line in corner()[0] if line.startswith(("flow", "drop"))]
    moment = aStent.logic.lastRun(aStent._parameterNode).flow.after["mean"]
    assert line.endswith(f"-> {moment.drops[0].recovered.value:.1f} mmHg")
