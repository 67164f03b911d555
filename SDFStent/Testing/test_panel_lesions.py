"""The lesions of the vessel in the panel: found by themselves, gone to by a click, treated by Add."""

import time

import numpy as np
import pytest
import slicer
from panel_helpers import deploy, settle, suggest, theThroat
from PIL import Image
from PySide6 import QtGui


def found(host, panel):
    """Wait until the search has come to its end; the lesions."""
    host.processUntil(lambda: not panel.lesions.isBusy)
    return panel.lesions._search.found


def clickRow(host, table, row):
    from PySide6 import QtCore, QtTest

    place = table.visualItemRect(table.item(row, 0)).center()
    QtTest.QTest.mouseClick(table.viewport(), QtCore.Qt.LeftButton, QtCore.Qt.NoModifier, place)
    host.process()


def test_lesions_are_listed_before_any_stent_is_added(host, theInputs, thePictures):
    lesions = found(host, theInputs)
    table = theInputs.ui.lesionTable
    assert len(theInputs._parameterNode.stents) == 0
    assert table.visible
    assert table.rowCount == len(lesions) >= 1
    assert np.linalg.norm(np.subtract(lesions[0].point, theThroat())) < 1.5
    # The phantom was built with 40 % there.
    assert float(table.item(0, 1).text().split()[0]) == pytest.approx(40, abs=3)
    assert "against" in table.item(0, 0).toolTip()
    assert not theInputs.ui.lesionLabel.visible
    theInputs.parent.resize(460, 900)
    host.process()
    assert table.horizontalScrollBar().maximum() == 0
    host.grab(theInputs.parent, thePictures / "lesions.png")


def test_ends_to_which_no_line_leads_are_told_beside_the_lesions(host, aPanel, aVessel):
    from SDFStentSlicer import Conversion

    from SDFStentLib.files import polydata_from_lines

    vessel, centerline = aVessel
    points, lines, _radii = Conversion.centerlineLines(centerline)
    centerline.SetAndObservePolyData(polydata_from_lines(points, lines[:1]))
    aPanel.ui.vesselSelector.setCurrentNode(vessel)
    aPanel.ui.centerlineSelector.setCurrentNode(centerline)
    found(host, aPanel)
    assert "of the 3 ends of the surface no line" in aPanel.ui.lesionLabel.text


def test_a_centerline_of_the_other_frame_is_refused_with_its_name(host, aPanel, aVessel):
    """As of a model file that names no frame: half of it lies inside by chance."""
    from SDFStentSlicer import Conversion

    from SDFStentLib.files import polydata_from_lines

    vessel, centerline = aVessel
    points, lines, _radii = Conversion.centerlineLines(centerline)
    centerline.SetAndObservePolyData(polydata_from_lines(points * (-1, -1, 1), lines))
    aPanel.ui.vesselSelector.setCurrentNode(vessel)
    aPanel.ui.centerlineSelector.setCurrentNode(centerline)
    assert found(host, aPanel) == ()
    said = aPanel.ui.lesionLabel.text
    assert said.startswith(f"{centerline.GetName()}: expected it inside {vessel.GetName()}")
    assert "one is in RAS and the other in LPS" in said


def test_a_click_goes_to_the_lesion_in_slices_and_3d(host, theInputs, aScene):
    camera = aScene.AddNewNodeByClass("vtkMRMLCameraNode")
    sliceNode = aScene.AddNewNodeByClass("vtkMRMLSliceNode")
    sliceNode.SetFieldOfView(500.0, 250.0, 1.0)
    camera.SetPosition(300.0, 0.0, 0.0)
    camera.SetFocalPoint(0.0, 0.0, 0.0)
    lesion = found(host, theInputs)[0]
    clickRow(host, theInputs.ui.lesionTable, 0)
    np.testing.assert_allclose(camera.GetFocalPoint(), lesion.point, atol=1e-6)
    way = np.subtract(camera.GetPosition(), camera.GetFocalPoint())
    np.testing.assert_allclose(way / np.linalg.norm(way), [1, 0, 0], atol=1e-9)
    # All of it is seen, and it is a good part of the view, whose angle is from bottom to top.
    height = 2 * np.linalg.norm(way) * np.tan(np.radians(camera.GetViewAngle() / 2))
    assert height == pytest.approx(max(3 * lesion.length, 30.0))
    middle = [sliceNode.GetSliceToRAS().GetElement(row, 3) for row in range(3)]
    np.testing.assert_allclose(middle, lesion.point, atol=1e-6)
    assert sliceNode.GetFieldOfView() == pytest.approx(
        (2 * height, height, 1.0)
    )  # a stent is dragged there, too
    camera.SetFocalPoint(9.0, 9.0, 9.0)
    clickRow(host, theInputs.ui.lesionTable, 0)  # once more: back again
    np.testing.assert_allclose(camera.GetFocalPoint(), lesion.point, atol=1e-6)


def marks(scene):
    """The numbers at the lesions, and the line along the selected one."""
    found = [
        [node for node in slicer.util.getNodesByClass(kind, scene) if node.GetHideFromEditors()]
        for kind in ("vtkMRMLMarkupsFiducialNode", "vtkMRMLMarkupsCurveNode")
    ]
    return [nodes[0] if nodes else None for nodes in found]


def orange(host, path):
    """How many pixels of the 3D view, kept as a picture, are of a selected lesion."""
    host.application.render(path)
    red, _green, blue = np.moveaxis(np.asarray(Image.open(path).convert("RGB"), dtype=int), 2, 0)
    return int(((red > blue + 110) & (red > 150)).sum())


def test_lesions_are_marked_in_the_view_and_the_selected_one_is_seen_through_the_vessel(
    host, theInputs, aScene, thePictures
):
    parameters, table = theInputs._parameterNode, theInputs.ui.lesionTable
    selection = slicer.app.applicationLogic().GetSelectionNode()
    placed = aScene.AddNewNodeByClass("vtkMRMLMarkupsLineNode").GetID()
    lesions = found(host, theInputs)
    numbers, extent = marks(aScene)
    texts = [
        numbers.GetNthControlPointLabel(n).strip()
        for n in range(numbers.GetNumberOfControlPoints())
    ]
    assert texts == [str(1 + n) for n in range(len(lesions))]
    for index, lesion in enumerate(lesions):  # beside the vessel, where no handle is
        apart = np.subtract(numbers.GetNthControlPointPositionWorld(index), lesion.point)
        assert 0.9 <= np.linalg.norm(apart) / lesion.reference_diameter <= 2.5
    assert extent is None
    host.application.view.look(parameters.vessel.GetPolyData().GetBounds())
    parameters.vessel.GetDisplayNode().SetOpacity(1.0)
    before = orange(host, thePictures / "lesions_marked.png")
    clickRow(host, table, 0)
    extent = marks(aScene)[1]
    ends = extent.GetCurvePointsWorld()
    ends = [ends.GetPoint(0), ends.GetPoint(ends.GetNumberOfPoints() - 1)]
    np.testing.assert_allclose(ends, lesions[0].line.points[[0, -1]], atol=1e-6)
    assert numbers.GetNthControlPointSelected(0)
    assert orange(host, thePictures / "lesion_selected.png") > before + 100
    for node in (numbers, extent):
        assert node.GetLocked()
        assert not node.GetSaveWithScene()
        assert not node.GetDisplayNode().GetSaveWithScene()
    assert selection.GetActivePlaceNodeID() == placed  # a click adds no lesion
    assert selection.GetActivePlaceNodeClassName() == "vtkMRMLMarkupsLineNode"
    theInputs.exit()
    assert marks(aScene) == [None, None]
    theInputs.enter()
    found(host, theInputs)
    assert marks(aScene)[0] is not None


def test_add_with_a_lesion_selected_places_a_stent_there_that_opens_it(host, theInputs):
    from SDFStentSlicer.Handles import middlePoint

    lesion = found(host, theInputs)[0]
    clickRow(host, theInputs.ui.lesionTable, 0)
    host.click(theInputs.ui.addStentButton)
    stent = theInputs._parameterNode.stent
    assert stent.diameter == pytest.approx(lesion.reference_diameter, abs=0.06)
    assert lesion.length <= 0.9 * stent.length < lesion.length + 0.9
    deploy(host, theInputs)
    run = theInputs.logic.lastRun(theInputs._parameterNode)
    assert run.lesions[0].stents == (1,)
    assert run.lesions[0].before is lesion
    assert abs(run.lesions[0].after.percent_diameter) < 10
    assert "Lesion 1, diameter stenosis: 4" in theInputs.ui.lumenLabel.text
    assert "against healthy vessel" in theInputs.ui.lumenLabel.text
    assert theInputs.lesions.selected is None
    host.click(theInputs.ui.addStentButton)  # nothing selected: at the middle as ever
    parameters = theInputs._parameterNode
    place = parameters.stent.handle.GetNthControlPointPositionWorld(0)
    centerline = theInputs.logic.centerlineOf(parameters)
    np.testing.assert_allclose(place, middlePoint(centerline), atol=1e-4)
    assert parameters.stent.length == 20.0


def test_the_line_of_a_lesion_makes_way_for_its_stent(host, theInputs, aScene):
    found(host, theInputs)
    clickRow(host, theInputs.ui.lesionTable, 0)
    assert marks(aScene)[1] is not None
    suggest(host, theInputs)
    numbers, line = marks(aScene)
    assert line is None
    assert numbers.GetNthControlPointSelected(0)
    clickRow(host, theInputs.ui.lesionTable, 0)  # as it is asked for
    assert marks(aScene)[1] is not None


def test_a_lesion_is_plotted_until_there_is_a_result(host, theInputs, aScene):
    lesions, ui = found(host, theInputs), theInputs.ui
    selection = slicer.app.applicationLogic().GetSelectionNode()

    def shown():
        return aScene.GetNodeByID(selection.GetActivePlotChartID())

    def drawn(index):
        series = shown().GetNthPlotSeriesNode(index)
        table = slicer.util.arrayFromTableColumn
        names = series.GetXColumnName(), series.GetYColumnName()
        return [table(series.GetTableNode(), name) for name in names]

    for row, lesion in enumerate(lesions):
        assert row or shown().GetTitle().startswith("Lesion 1:")  # before any click
        clickRow(host, ui.lesionTable, row)
        assert shown().GetTitle().startswith(f"Lesion {row + 1}:")
        along, before = drawn(0)
        # Two diameters of healthy vessel on both sides, as far as it goes on.
        reach = 2 * lesion.reference_diameter
        assert lesion.start - reach - 0.1 <= along[0] < lesion.start
        assert lesion.end < along[-1] <= lesion.end + reach + 0.1
        assert along[-1] == pytest.approx(lesion.end + reach, abs=0.1)
        assert (np.diff(along) > 0).all()
        within = (along > lesion.start - 1e-6) & (along < lesion.end + 1e-6)
        np.testing.assert_array_equal(before[within], lesion.diameters)
        np.testing.assert_array_equal(drawn(1)[1][within], lesion.healthy)
        assert np.isnan(drawn(1)[1][~within]).all()
        plotted = theInputs.lesions.plotted
        radii = theInputs.logic.centerlineOf(theInputs._parameterNode)
        places = [radii.project(point) for point in plotted.points]
        known = np.array([2 * place.inscribed_radius for place in places])
        np.testing.assert_allclose(before[~within], known[~within], rtol=0.06)
        assert not shown().GetSaveWithScene()
        assert shown().GetYAxisRange()[1] > max(np.nanmax(before), lesion.healthy.max())
    assert len(slicer.util.getNodesByClass("vtkMRMLPlotChartNode")) == 1
    clickRow(host, ui.lesionTable, 0)
    host.click(ui.addStentButton)
    deploy(host, theInputs)
    assert shown() is theInputs._parameterNode.outputChart
    clickRow(host, ui.lesionTable, 0)
    assert shown() is theInputs._parameterNode.outputChart


def test_the_search_never_holds_the_application_for_long(host, aPanel, aVessel, known_lesions):
    from SDFStentSlicer import Clock, Portions

    known_lesions.clear()
    ticks = []
    tick = Portions.SteppedRun._tick

    def timed(run):
        start = time.thread_time()  # a busy machine makes no tick longer by this clock
        tick(run)
        ticks.append(time.thread_time() - start)

    run = aPanel.lesions._run
    run._timer = Clock.timer(lambda: timed(run), 0, isRepeated=True)
    vessel, centerline = aVessel
    aPanel.ui.vesselSelector.setCurrentNode(vessel)
    aPanel.ui.centerlineSelector.setCurrentNode(centerline)
    host.processUntil(lambda: aPanel.ui.lesionTable.visible)
    assert told(aPanel) == "Looking for lesions..."
    aPanel.ui.lesionTable.selectRow(0)
    assert not aPanel.ui.lesionTable.selectedItems()
    found(host, aPanel)
    assert ticks  # of a small vessel the search may be done in one turn
    assert np.median(ticks) < 0.05


def told(panel):
    """What stands in place of lesions."""
    (row,) = range(panel.ui.lesionTable.rowCount)
    return panel.ui.lesionTable.item(row, 0).text()


def hoverOver(host, panel, row):
    from PySide6 import QtCore, QtTest

    table = panel.ui.lesionTable
    place = table.visualItemRect(table.item(row, 1)).center()
    QtTest.QTest.mouseMove(table.viewport(), place)
    QtCore.QCoreApplication.sendEvent(
        table.viewport(),
        QtGui.QMouseEvent(
            QtCore.QEvent.MouseMove,
            QtCore.QPointF(place),
            table.viewport().mapToGlobal(QtCore.QPointF(place)),
            QtCore.Qt.NoButton,
            QtCore.Qt.NoButton,
            QtCore.Qt.NoModifier,
        ),
    )
    host.process()


def test_a_lesion_is_marked_while_the_mouse_is_on_its_row(host, theInputs, aScene):
    found(host, theInputs)
    camera = aScene.AddNewNodeByClass("vtkMRMLCameraNode")
    before = camera.GetFocalPoint()
    theInputs.ui.lesionTable.underMouse = lambda: True
    hoverOver(host, theInputs, 0)
    assert marks(aScene)[1] is not None
    assert camera.GetFocalPoint() == before
    assert theInputs.lesions.selected is None
    theInputs.ui.lesionTable.underMouse = lambda: False
    host.process(0.4)
    assert marks(aScene)[1] is None
    clickRow(host, theInputs.ui.lesionTable, 0)
    hoverOver(host, theInputs, 0)
    host.process(0.4)
    assert marks(aScene)[1] is not None


def test_a_click_on_a_lesion_is_drawn_once(host, theInputs, aScene):
    """A tree of 180,000 triangles took 3 s to answer: views draw a frame at every change, and a click is heard twice."""
    found(host, theInputs)
    show, order = theInputs.logic.showLesion, []
    theInputs.logic.showLesion = lambda lesion: (
        time.sleep(0.05),
        show(lesion),
        order.append("whole"),
    )
    with host.drawing(0.05) as frames:
        frames.onFrame = lambda: order.append("frame")
        host.process(0.2)
        order.clear()
        theInputs.ui.lesionTable.selectRow(0)
        host.process(0.2)
    assert order[0] == "whole"
    assert "frame" in order


def test_what_is_marked_already_is_not_marked_anew(host, theInputs, aScene):
    found(host, theInputs)
    theInputs.ui.lesionTable.selectRow(0)
    line = marks(aScene)[1]
    theInputs.lesions._clicked(0, 0)
    hoverOver(host, theInputs, 0)
    assert marks(aScene)[1] is line
    theInputs.lesions.hideLine()
    theInputs.lesions._clicked(0, 0)
    assert marks(aScene)[1] is not None


def test_a_lesion_that_nobody_named_is_called_by_side_and_generation(host, theInputs):
    from dataclasses import replace

    from SDFStentSlicer.LesionTable import _texts

    from SDFStentLib.report import lesion_facts

    (lesion,) = found(host, theInputs)
    side = theInputs.lesions._search.sideOf(lesion)
    assert lesion.branch_name == f"{side} pulmonary artery"  # as the vessel's faces call it
    assert _texts(lesion_facts(1, lesion), side)[0] == "1 left pulmonary artery"
    nameless = replace(lesion, branch_name="branch of 5.7 mm from 75 mm on (3 outlets)")
    nameless = replace(nameless, generation=3)
    assert _texts(lesion_facts(2, nameless), side)[0] == "2 left, generation 3"
    nameless = replace(lesion, branch_name="main branch of 6.4 mm (35 outlets)", generation=1)
    assert _texts(lesion_facts(1, nameless), side)[0] == "1 left main branch"


@pytest.mark.parametrize("turned", [1.0, -1.0], ids=["as it is", "mirrored"])
def test_a_side_is_that_of_the_lung_whatever_leaves_before(turned):
    """A patient's trunk gives off a twig far to the left before it parts into the two lungs."""
    from SDFStentSlicer.Lesions import _Sides

    from SDFStentLib.centerline import Centerline

    trunk = [(-20, 0, 0), (-16, 10, 0), (-12, 20, 0), (-4, 40, 0)]
    left = [(-10, 44, 0), (-30, 50, 0), (-40, 60, 10)]
    right = [(10, 44, 0), (40, 50, 0), (60, 50, 10), (70, 50, 20)]
    further, twig = [(45, 60, -10), (50, 70, -10)], [(-22, 30, 0), (-26, 36, 0)]
    points = np.array([*trunk, *left, *right, *further, *twig], dtype=float)
    points[:, 0] *= turned
    parent = [-1, 0, 1, 2, 3, 4, 5, 3, 7, 8, 9, 8, 11, 1, 13]
    sides = _Sides(Centerline(points, np.ones(len(points)), np.array(parent)))
    names = ["left", "right"][:: int(turned)]
    assert [sides.of(points[at]) for at in (0, 2, 3)] == ["", "", ""]
    assert {sides.of(points[at]) for at in (4, 5, 6, 13, 14)} == {names[0]}
    assert {sides.of(points[at]) for at in (7, 8, 10, 11, 12)} == {names[1]}
    alone = _Sides(Centerline(points[:4], np.ones(4), np.array([-1, 0, 1, 2])))
    assert alone.of(points[2]) == ""


def test_a_lesion_is_not_plotted_over_a_result_that_came_meanwhile(host, aStent, monkeypatch):
    lesions, selection = aStent.lesions, slicer.app.applicationLogic().GetSelectionNode()
    host.processUntil(lambda: not lesions.isBusy)
    search, isHeld = lesions._search, True
    around = search.around

    def held(lesion):
        while isHeld:  # Ends: when the test has its result.
            yield None
        return (yield from around(lesion))

    monkeypatch.setattr(search, "around", held)
    lesions._plot(0)
    host.click(aStent.ui.deployButton)
    host.processUntil(lambda: aStent._parameterNode.outputChart is not None)
    isHeld = False
    settle(host, aStent)
    assert selection.GetActivePlotChartID() == aStent._parameterNode.outputChart.GetID()


@pytest.mark.parametrize(("height", "rows"), [(500, 2), (900, None), (1600, 11)])
def test_as_many_lesions_are_seen_as_the_window_has_room_for(host, theInputs, height, rows):
    from PySide6 import QtWidgets

    lesions = found(host, theInputs)
    area = QtWidgets.QScrollArea()  # as `qSlicerModulePanel` has one
    area.setWidgetResizable(True)
    area.setWidget(theInputs.parent)
    area.resize(480, height)
    area.show()
    host.process()
    table = theInputs.ui.lesionTable
    theInputs.lesions._show("", lesions * 11)
    host.process()
    seen = (table.viewport().height()) // table.rowHeight(0)
    assert seen == rows or (rows is None and 2 <= seen <= 11)
    # What has to be seen below still is, or nothing is left that could be taken.
    panel = theInputs.parent
    assert seen == 2 or QtWidgets.QWidget.height(panel) <= area.viewport().height()
    theInputs.lesions._show("", lesions)
    host.process()
    assert (table.viewport().height()) // table.rowHeight(0) == 2
    area.takeWidget()
    area.close()
