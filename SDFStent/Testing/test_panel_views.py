"""The section Working view: the 3D view as a C-arm, its angles in the corner, and an X-ray in it."""

import numpy as np
import pytest
import slicer
from panel_helpers import deploy, settle
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkRenderingAnnotation import vtkCornerAnnotation

from SDFStentLib.view import ArmView


@pytest.fixture(autouse=True)
def theWindow(host):
    slicer.app.showMainWindow(True)
    yield
    slicer.app.showMainWindow(False)


@pytest.fixture
def theSection(host, aStent):
    """The panel with a stent, its section of views open."""
    aStent.ui.viewsCollapsibleButton.collapsed = False
    seen(host, aStent)
    return aStent


def seen(host, panel):
    """Let it work out what is seen."""
    settle(host, panel)
    host.processUntil(lambda: not panel.sight.isBusy)


def camera():
    return slicer.util.getNodesByClass("vtkMRMLCameraNode")[0]


def direction():
    back = np.subtract(camera().GetPosition(), camera().GetFocalPoint())
    return back / np.linalg.norm(back)


def corner():
    view = slicer.app.layoutManager().threeDWidget(0).threeDView()
    return (view.cornerAnnotation().GetText(vtkCornerAnnotation.UpperRight) or "").split("\n")


def film():
    """The node of the X-ray that is seen, or None."""
    nodes = slicer.util.getNodesByClass("vtkMRMLModelNode")
    shown = [one for one in nodes if one.GetName() == "X-ray" and one.GetDisplayVisibility()]
    assert len(shown) < 2
    return shown[0] if shown else None


def gray():
    source = film().GetDisplayNode().GetTextureImageDataConnection().GetProducer()
    image = source.GetOutputDataObject(0)
    rows, columns = image.GetDimensions()[1::-1]
    return vtk_to_numpy(image.GetPointData().GetScalars())[:, 0].reshape(rows, columns)[::-1]


def turnTo(view):
    """As a hand turns the view."""
    from SDFStentSlicer import Camera

    Camera.turn(camera(), view.axes("RAS"))


def test_the_button_turns_the_view_to_where_the_stent_is_seen_best(host, theSection, thePictures):
    ui, node = theSection.ui, theSection._parameterNode
    host.click(ui.workingViewButton)
    seen(host, theSection)
    view = ArmView(node.get("views.lao"), node.get("views.cra"))
    assert (ui.laoSpinBox.value, ui.craSpinBox.value) == view
    assert direction() == pytest.approx(view.axes("RAS")[2], abs=1e-6)
    up = np.array(camera().GetViewUp())
    assert up @ view.axes("RAS")[1] == pytest.approx(1, abs=1e-6)
    stent = node.stent.handle.GetNthControlPointPositionWorld(0)
    assert np.linalg.norm(np.subtract(camera().GetFocalPoint(), stent)) < 3
    lines = corner()
    assert lines[0] == view.words
    assert lines[1].startswith("foreshortened ")
    assert float(lines[1].split()[1]) < 8
    assert lines[2] == "under other vessels 0 %"
    assert ui.viewLabel.text.startswith(f"View {view.words}: foreshortened ")
    first = direction()
    host.click(ui.secondViewButton)
    seen(host, theSection)
    assert abs(direction() @ first) <= 0.5 + 1e-6  # 60 degrees away
    host.application.render(thePictures / "second_view.png")


def test_angles_are_typed_undone_and_kept_in_the_plan(host, theSection, tmp_path):
    ui, node = theSection.ui, theSection._parameterNode
    before = direction()
    host.process(1.0)  # the plan as it is now is kept
    ui.laoSpinBox.value = 30.0
    host.process()
    assert direction() == pytest.approx(ArmView(30, 0).axes("RAS")[2], abs=1e-6)
    ui.craSpinBox.value = -20.0
    host.process(1.0)
    assert direction() == pytest.approx(ArmView(30, -20).axes("RAS")[2], abs=1e-6)
    assert corner()[0] == "LAO 30, CAU 20"
    theSection.logic.savePlan(str(tmp_path / "plan.json"), node)
    from SDFStentLib.plan import load_plan

    assert load_plan(tmp_path / "plan.json").views.view == (30, -20)
    host.click(ui.undoButton)
    host.process()
    assert node.get("views") is None
    assert (ui.laoSpinBox.value, ui.craSpinBox.value) == (0, 0)
    host.click(ui.redoButton)
    host.process()
    assert direction() == pytest.approx(ArmView(30, -20).axes("RAS")[2], abs=1e-6)
    assert before != pytest.approx(direction())


def test_a_hand_that_turns_the_view_reads_its_angles_and_changes_no_plan(host, theSection):
    turnTo(ArmView(-40, 10))
    assert corner() == ["RAO 40, CRA 10"]  # at once; the rest at rest
    seen(host, theSection)
    assert corner()[1].startswith("foreshortened ")
    assert theSection._parameterNode.get("views") is None


def test_an_x_ray_lies_before_all_and_shows_what_is_there(host, theSection, thePictures):
    ui = theSection.ui
    deploy(host, theSection)
    host.click(ui.workingViewButton)
    seen(host, theSection)
    host.application.render(thePictures / "before_x_ray.png")
    assert film() is None
    ui.xrayCheckBox.checked = True
    seen(host, theSection)
    with_stent = gray().copy()
    assert with_stent.shape == (512, 512)
    assert corner()[-1].startswith("X-ray, bar ")
    display = film().GetDisplayNode()
    (viewID,) = map(display.GetNthViewNodeID, range(display.GetNumberOfViewNodeIDs()))
    assert host.scene.GetNodeByID(viewID).GetLayoutName() == camera().GetLayoutName()
    picture = host.application.render(thePictures / "x_ray.png")
    assert picture.exists()
    ui.expansionSlider.value = 0.0
    assert film() is None  # at once
    seen(host, theSection)
    assert (gray() != with_stent).sum() > 1000
    ui.xrayCheckBox.checked = False
    host.process()
    assert film() is None


def test_an_x_ray_of_a_former_plan_says_so(host, theSection):
    deploy(host, theSection)
    theSection.ui.xrayCheckBox.checked = True
    theSection.ui.diameterSlider.value = 9.5
    seen(host, theSection)
    assert corner()[-1] == "before the last change"
    deploy(host, theSection)
    seen(host, theSection)
    assert corner()[-1].startswith("X-ray, bar ")


def test_no_x_ray_stays_that_is_of_something_else(host, theSection):
    ui = theSection.ui
    ui.xrayCheckBox.checked = True
    seen(host, theSection)
    assert film() is not None
    turnTo(ArmView(20, 20))
    assert film() is None
    seen(host, theSection)
    assert film() is not None
    ui.diameterSlider.value = 9.5
    assert film() is None
    seen(host, theSection)
    assert film() is not None
    ui.autoUpdateCheckBox.checked = True
    deploy(host, theSection)
    seen(host, theSection)
    assert theSection.sight.isXrayShown
    host.leave(theSection)
    assert film() is None
    assert corner() == [""]
    host.enter(theSection)
    seen(host, theSection)
    assert film() is not None
    theSection.ui.vesselSelector.setCurrentNode(None)
    host.process()
    assert film() is None


def test_without_anything_to_look_at_a_sentence_says_so(host, aPanel):
    aPanel.ui.viewsCollapsibleButton.collapsed = False
    seen(host, aPanel)
    host.click(aPanel.ui.workingViewButton)
    host.processUntil(lambda: not aPanel.sight.isBusy)
    assert "choose both in Vessel" in aPanel._parameterNode.status


def test_a_film_covers_the_same_of_the_view_at_any_distance(host, theSection):
    """As seen by the camera its edges lie where those of the picture at the isocenter do."""
    theSection.ui.xrayCheckBox.checked = True
    host.click(theSection.ui.workingViewButton)
    seen(host, theSection)
    for distance in (1.0, 2.0):
        place = np.array(camera().GetFocalPoint())
        away = np.array(camera().GetPosition()) - place
        camera().SetPosition(*(place + distance * away))
        corners = np.array(slicer.util.arrayFromModelPoints(film()))
        position = np.array(camera().GetPosition())
        rays = corners - position
        depth = (place - position) @ direction()
        at_isocenter = position + rays * (depth / (rays @ direction()))[:, None]
        side = np.linalg.norm(at_isocenter[1] - at_isocenter[0])
        assert side == pytest.approx(theSection.sight._film._film.side, rel=1e-6)
        assert at_isocenter.mean(axis=0) == pytest.approx(place, abs=1e-6)


def test_the_film_is_nobodys_input_and_in_no_file(host, theSection, tmp_path):
    theSection.ui.xrayCheckBox.checked = True
    seen(host, theSection)
    node = film()
    assert node.GetHideFromEditors()
    assert not node.GetSaveWithScene()
    assert not node.GetDisplayNode().GetSaveWithScene()
    host.newScene()
    assert slicer.util.getNodesByClass("vtkMRMLModelNode") == []


def test_the_pointed_lesion_is_looked_at_where_there_is_no_stent(host, theInputs):
    theInputs.ui.viewsCollapsibleButton.collapsed = False
    seen(host, theInputs)
    host.click(theInputs.ui.workingViewButton)
    seen(host, theInputs)
    (lesion,) = theInputs.lesions._search.found
    away = np.subtract(camera().GetFocalPoint(), lesion.point)
    assert np.linalg.norm(away) < lesion.length
    assert "stenosis " in theInputs.ui.viewLabel.text
