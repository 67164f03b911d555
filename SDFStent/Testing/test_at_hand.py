"""The few lines over the 3D view that follow the hand."""

import json

import numpy as np
import pytest
import slicer
from panel_helpers import deploy, settle
from vtkmodules.vtkRenderingAnnotation import vtkCornerAnnotation

from SDFStentLib.treatment.placing import uncovered_length


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
    assert lines[0] == f"8.0 x {lengthOf(treated.axis.points):.1f} mm (14 mm as packed)"
    assert ui.lengthSlider.value == 14.0
    assert lines[1] == f"narrowest {treated.before.minimum:.1f} -> {treated.after.minimum:.1f} mm"
    assert lines[2].startswith(f"stenosis {lesion.before.percent_diameter:.0f} % -> ")
    assert lines[-1] == "certified for meshing"
    left = uncovered_length(lesion.before, [treated.axis.line])
    assert left > 0.5
    assert lines[-2] == f"warning: lesion 1 uncovered over {left:.1f} mm"
    assert aStent._state.atHand.kind == "bad"
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


def test_lines_have_the_color_of_the_tiles(host, aStent):
    """A lesion that is left alone is no warning of the treatment, but its tile is one, and the lines beside it were green."""
    host.processUntil(lambda: not aStent.lesions.isBusy)
    aStent.ui.diameterSlider.value, aStent.ui.lengthSlider.value = 7.0, 10.0
    seen = set()
    for step in (0.0, 12.0, 4.0):
        aStent._moveStent(step)
        deploy(host, aStent)
        tiles = json.loads(aStent._parameterNode.tiles)
        isCaution = any(tile[-1] for tile in tiles)
        assert (aStent._state.atHand.kind == "bad") == isCaution
        seen.add((isCaution, isWarned(aStent)))
    assert (True, False) in seen


def test_no_line_is_wider_than_a_view_of_four(aStent):
    """In the application it was cut at the edge: "narrowed 2.4 -> 1.9 mm," and nothing of two more."""
    line = "warning: side branch of 2.1 mm with 3 outlets at 21 mm narrowed 2.4 -> 1.9 mm, 2 more"
    aStent._state.atHand.show(f"6.6 x 30.6 mm\n{line}\ncertified for meshing")
    rows, _annotation = corner()
    assert max(map(len, rows)) <= 52
    assert " ".join(row.strip() for row in rows[1:-1]) == line
    assert rows[0] == "6.6 x 30.6 mm"
    assert aStent._state.atHand.text.split("\n")[1] == line  # the page has its own rows


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


def isWarned(panel):
    return bool(panel._parameterNode.warningSummary)


@pytest.mark.parametrize("diameter", [3.0, 4.0, 6.9, 8.5, 10.5])
@pytest.mark.parametrize("length", [5.0, 20.0])
def test_lines_are_green_only_where_the_panel_warns_of_nothing(host, aStent, diameter, length):
    aStent.ui.diameterSlider.value, aStent.ui.lengthSlider.value = diameter, length
    deploy(host, aStent)
    lines, annotation = corner()
    warned = [line for line in lines if line.startswith("warning: ")]
    assert len(warned) == isWarned(aStent)
    kinds = {"good": (0.62, 0.93, 0.66), "bad": (1.0, 0.72, 0.45)}
    wanted = "bad" if warned else "good"
    assert aStent._state.atHand.kind == wanted
    assert annotation.GetTextProperty().GetColor() == pytest.approx(kinds[wanted])
    count = aStent._parameterNode.warningSummary.count("Warning: ")
    assert f", {count - 1} more" in warned[0] if count > 1 else "more" not in "".join(warned)
    assert lines[-1] == "certified for meshing"


def test_the_gravest_warning_of_all_stents_is_told_of_any(host, aStent):
    host.click(aStent.ui.copyStentButton)
    aStent.ui.diameterSlider.value = 4.0  # hangs free
    deploy(host, aStent)
    for row in (0, 1):
        aStent.ui.stentTable.selectRow(row)
        host.process()
        (line,) = [line for line in corner()[0] if line.startswith("warning")]
        assert line.startswith("warning: hangs free over ")
        assert aStent._state.atHand.kind == "bad"


def test_a_warning_of_the_vessel_is_one(host, aStent):
    run = None
    deploy(host, aStent)
    run = aStent.logic.lastRun(aStent._parameterNode)
    run.remark = "Artery is 0.12 mm long, unusual for a vessel."
    from SDFStentSlicer import Results

    Results.showMeasured(aStent._parameterNode, run)
    host.process()
    assert aStent._state.atHand.kind == "bad"


def test_a_hand_that_goes_on_is_warned_already(host, aStent):
    host.processUntil(lambda: not aStent.lesions.isBusy)
    aStent.ui.autoUpdateCheckBox.checked = True
    settle(host, aStent)
    aStent.ui.diameterSlider.value = 11.0
    host.processUntil(lambda: corner()[0][-1] == "preview")
    (line,) = [line for line in corner()[0] if line.startswith("warning")]
    assert line.startswith("warning: overdilated 1.")
    assert aStent._state.atHand.kind == "bad"


def test_what_matters_for_safety_gives_way_to_no_flow(host, aStent):
    aStent.ui.flowMeanSpinBox.value, aStent.ui.lengthSlider.value = 3.0, 20.0
    aStent.ui.diameterSlider.value = 6.0
    deploy(host, aStent)
    lines = corner()[0]
    treated = aStent.logic.lastRun(aStent._parameterNode).result.stents[0]
    found = treated.apposition
    told = f"off the wall over {found.free_length:.0f} of {found.length:.0f} mm"
    assert (told in lines) == (found.free_length > 0)
    assert found.free_length > 0
    assert any(line.startswith(("flow", "drop")) for line in lines)
