"""How the panel looks: in a narrow window, in any palette, while something runs."""

import re

import pytest
import slicer
from panel_helpers import deploy, settle


def bottomOf(widget, panel):
    """Where a widget ends, pixels below the top of the panel."""
    from PySide6 import QtCore

    return widget.mapTo(panel.parent, QtCore.QPoint(0, 0)).y() + widget.height


SHORTEST_PANEL = 390
"""Pixels that Slicer shows of a panel at 1280 x 800 with *Data Probe* open."""


def test_all_that_the_loop_needs_is_seen_without_scrolling(host, aStent, thePictures):
    from PySide6 import QtWidgets

    ui = aStent.ui
    host.processUntil(lambda: not aStent.lesions.isBusy)
    QtWidgets.QWidget.resize(aStent.parent, 440, 900)
    deploy(host, aStent)
    host.process()
    top = bottomOf(ui.tilesLabel, aStent) - ui.tilesLabel.height
    assert 0 <= top - bottomOf(ui.deployButton, aStent) <= 20  # the answer is beside its button
    host.click(ui.copyStentButton)
    host.process()
    needed = ("lesionTable", "stentTable", "addStentButton", "suggestButton", "diameterSlider")
    for name in (*needed, "lengthSlider", "deployButton", "statusLabel"):
        widget = getattr(ui, name)
        assert widget.isVisible(), name
        assert bottomOf(widget, aStent) <= SHORTEST_PANEL, name
    second = ui.stentTable.visualItemRect(ui.stentTable.item(1, 0))
    assert second.bottom() <= ui.stentTable.viewport().height()  # two rows without scrolling
    host.grab(aStent.parent, thePictures / "loop.png")


def test_nothing_moves_under_the_mouse_when_the_search_for_lesions_ends(host, aPanel, aVessel):
    ui = aPanel.ui
    ui.vesselSelector.setCurrentNode(aVessel[0])
    assert not ui.inputsCollapsibleButton.collapsed
    ui.centerlineSelector.setCurrentNode(aVessel[1])
    assert ui.inputsCollapsibleButton.collapsed  # by the choice itself
    host.processUntil(lambda: ui.lesionTable.visible)
    host.process()
    while_searching = [bottomOf(one, aPanel) for one in (ui.lesionTable, ui.addStentButton)]
    assert aPanel.lesions.isBusy
    host.processUntil(lambda: not aPanel.lesions.isBusy)
    host.process()
    assert while_searching == [bottomOf(one, aPanel) for one in (ui.lesionTable, ui.addStentButton)]


def test_a_closed_part_tells_what_is_set_in_it(host, aStent):
    ui = aStent.ui
    host.processUntil(lambda: not aStent.lesions.isBusy)
    assert ui.inputsCollapsibleButton.collapsed
    assert ui.inputsCollapsibleButton.text == "Vessel: Artery, Artery centerline"
    assert ui.deviceCollapsibleButton.text == "Device"
    device = ui.deviceComboBox.findText("begraft-besmooth-peripheral")
    host.choose(ui.deviceComboBox, device)
    assert ui.deviceCollapsibleButton.text == "Device: begraft-besmooth-peripheral"
    host.choose(ui.placementComboBox, 1)
    assert ui.placeCollapsibleButton.text == f"Place: {ui.placementComboBox.currentText}"
    ui.waistSpinBox.value = 5.0
    assert ui.shapeCollapsibleButton.text == "Shape: as set"
    ui.tissueGapSlider.value = 0.9
    assert ui.advancedCollapsibleButton.text == "Advanced: changed"
    ui.flowMeanSpinBox.value = 2.5
    assert ui.flowCollapsibleButton.text == "Flow: 2.5 L/min"
    aStent._parameterNode.flowMean = 5.1082  # as of a wave
    assert ui.flowCollapsibleButton.text == "Flow: 5.11 L/min"
    ui.centerlineSelector.setCurrentNode(None)
    assert not ui.inputsCollapsibleButton.collapsed


def test_the_progress_bar_is_there_while_a_deployment_runs(host, aStent, aStepAtATime):
    ui = aStent.ui
    aStent.parent.resize(520, 1300)  # Slicer's panel scrolls; this one would squeeze its sections
    # What is found in the meantime would be shown, and laid out.
    host.processUntil(lambda: not (aStent.lesions.isBusy or aStent.recoil.isBusy))
    settle(host, aStent)
    host.process()
    assert not ui.progressBar.visible
    bottom = bottomOf(ui.deployButton, aStent)
    host.click(ui.deployButton)
    ui.deployButton.repaint()
    seen = []
    progress = aStent.session._run._onProgress
    aStent.session._run._onProgress = lambda fraction: (
        seen.append((ui.progressBar.visible, bottomOf(ui.deployButton, aStent))),
        progress(fraction),
    )
    settle(host, aStent)
    assert {visible for visible, _bottom in seen} == {True}
    assert {seenBottom for _visible, seenBottom in seen} == {bottom}  # nothing jumps
    assert not ui.progressBar.visible


def pressDelete(host, widget):
    from PySide6 import QtCore, QtTest

    widget.setFocus()
    QtTest.QTest.keyClick(widget, QtCore.Qt.Key_Delete)
    host.process()


def test_the_delete_key_removes_the_selected_stent_in_the_table_only(host, aStent):
    parameters = aStent._parameterNode
    host.click(aStent.ui.copyStentButton)
    aStent.parent.activateWindow()
    host.process()
    pressDelete(host, aStent.ui.nameEdit)
    assert len(parameters.stents) == 2
    pressDelete(host, aStent.ui.stentTable)
    assert [stent.label for stent in parameters.stents] == ["Stent 1"]
    for _ in range(2):  # the second finds nothing to remove
        pressDelete(host, aStent.ui.stentTable)
    assert len(parameters.stents) == 0


WIDTH_IN_THE_HOST = 420
"""The real application's fonts make the panel a tenth wider than the host's; it has 460 pixels there."""


def neededWidth(panel):
    from PySide6 import QtWidgets

    margins = panel.layout.contentsMargins()
    needed = QtWidgets.QWidget.minimumSizeHint(panel.parent).width()
    return needed - margins.left() - margins.right()


def test_the_panel_fits_into_a_narrow_window(host, aStent):
    parameters = aStent._parameterNode
    long = "4D cardiac CT with contrast agent, reconstruction 3, left pulmonary artery, smoothed"
    for node in (parameters.vessel, parameters.stent.handle, parameters.parameterNode):
        node.SetName(long)
    aStent.ui.nameEdit.text = long
    aStent.ui.diameterSlider.value = 2.0  # with a warning
    deploy(host, aStent)
    openSections(aStent)
    device = aStent.ui.deviceComboBox.findText("begraft-besmooth-peripheral")
    host.choose(aStent.ui.deviceComboBox, device)
    aStent.ui.deviceShorteningCheckBox.checked = False
    aStent.ui.balloonCheckBox.checked = True
    host.processUntil(lambda: not aStent.recoil.isBusy)
    aStent.ui.waistSpinBox.value, aStent.ui.proximalEndSpinBox.value = 1.5, 10.0
    host.click(aStent.ui.duplicatePlanButton)
    deploy(host, aStent)
    host.choose(aStent.ui.placementComboBox, 4)
    host.process()
    assert neededWidth(aStent) <= WIDTH_IN_THE_HOST


def test_the_table_needs_no_scrolling_sideways_in_a_narrow_panel(host, aStent):
    aStent.parent.resize(460, 1000)
    for placement in range(5):
        host.choose(aStent.ui.placementComboBox, placement)
        assert aStent.ui.stentTable.horizontalScrollBar().maximum() == 0


def openSections(panel):
    for name, widget in vars(panel.ui).items():
        if name.endswith("CollapsibleButton"):
            widget.collapsed = False


def test_nothing_that_happens_changes_the_width_of_the_panel(host, aStent, tmp_path):
    ui, parameters = aStent.ui, aStent._parameterNode
    openSections(aStent)
    settle(host, aStent)
    host.widths(aStent).clear()
    deploy(host, aStent)
    ui.autoUpdateCheckBox.checked = True
    for diameter in (2.0, 59.0, 8.0):  # with warnings, refused
        ui.diameterSlider.value = diameter
        settle(host, aStent)
    for placement in (3, 4):
        host.choose(ui.placementComboBox, placement)
        settle(host, aStent)
    for name in (parameters.vessel, parameters.parameterNode, parameters.stent.handle):
        name.SetName("4D cardiac CT with contrast agent, reconstruction 3, left pulmonary artery")
    host.click(ui.duplicatePlanButton)
    settle(host, aStent)
    host.files.append(str(tmp_path))
    host.click(ui.comparePlansButton)
    host.processUntil(lambda: not aStent.plans.comparing.isRunning)
    assert len(host.widths(aStent)) == 1


def test_only_the_wall_before_a_stent_hides_it_and_half_so(host, aStent):
    deploy(host, aStent)
    for node in (aStent._parameterNode.vessel, aStent._parameterNode.outputVessel):
        display = node.GetDisplayNode()
        assert display.GetOpacity() < 0.5
        assert display.GetBackfaceCulling()


def test_folding_a_section_keeps_the_width_of_the_panel(host, aStent):
    host.widths(aStent).clear()
    for name, widget in vars(aStent.ui).items():
        if name.endswith("CollapsibleButton"):
            for isCollapsed in (not widget.collapsed, widget.collapsed):
                widget.collapsed = isCollapsed
                host.process()
    assert len(host.widths(aStent)) == 1


def test_no_color_is_set_by_hand_in_the_panel():
    from pathlib import Path

    text = (Path(__file__).parents[1] / "Resources" / "UI" / "SDFStent.ui").read_text("utf-8")
    assert "color" not in text.replace("Color the stented vessel", "").lower()
    assert "styleSheet" not in text


def test_the_color_legend_keeps_the_colors_of_the_application(host, aStent):
    aStent.ui.mapComboBox.currentIndex = 1
    deploy(host, aStent)
    legend = slicer.vtkSlicerColorLogic.GetColorLegendDisplayNode(
        aStent._parameterNode.outputVessel
    )
    usual = slicer.vtkMRMLColorLegendDisplayNode()
    for ours, theirs in (
        (legend.GetTitleTextProperty(), usual.GetTitleTextProperty()),
        (legend.GetLabelTextProperty(), usual.GetLabelTextProperty()),
    ):
        assert ours.GetColor() == theirs.GetColor()
        assert ours.GetShadow() == theirs.GetShadow()


def test_no_line_of_the_results_is_cut(host, aStent):
    from PySide6 import QtWidgets

    ui, area = aStent.ui, QtWidgets.QScrollArea()
    openSections(aStent)
    deploy(host, aStent)  # there are details only of a result
    aStent.parent.setParent(None)
    area.setWidgetResizable(True)  # as Slicer's module panel
    area.setWidget(aStent.parent)
    area.resize(480, 800)
    area.show()
    results = [ui.lumenLabel, ui.warningLabel, ui.certificateLabel]
    labels = [*results, ui.tilesLabel, ui.oldLabel, ui.deviceLabel]
    for count in (1, 40, 150, 400):
        for own in labels:
            for label in labels:
                label.visible = True
                label.text = "word " * (count if label is own else 60)
            # A busy machine lays out later; what is cut stays so and ends the wait.
            host.processUntil(
                lambda: all(one.height >= one.heightForWidth(one.width) for one in labels), 60.0
            )
    area.takeWidget()


def test_no_panel_is_measured_once_it_is_gone(host, aScene, theModule, monkeypatch):
    """The application may end right after the module has been chosen, before its event loop has turned."""
    from SDFStentSlicer.PanelParts import PanelSize

    fitted = []
    monkeypatch.setattr(PanelSize, "_fit", lambda _self: fitted.append(True))
    panel = host.openPanel(theModule)
    assert fitted
    panel.ui.stentsCollapsibleButton.collapsed = not panel.ui.stentsCollapsibleButton.collapsed
    fitted.clear()
    panel.cleanup()
    host.process()
    assert fitted == []
    host.closePanel(panel)


def luminance(color):
    """Of a color by its hexadecimal digits, as WCAG 2.1 has it."""
    parts = [int(color[1 + 2 * i : 3 + 2 * i], 16) / 255 for i in range(3)]
    linear = [p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(one, other):
    dark, light = sorted(map(luminance, (one, other)))
    return (light + 0.05) / (dark + 0.05)


@pytest.mark.parametrize("window", ["#efefef", "#323232", "#1e1e1e"])
def test_a_warning_fits_the_style(host, aStent, window, thePictures):
    from PySide6 import QtGui, QtWidgets

    palette = QtGui.QPalette(QtGui.QColor(window))
    QtWidgets.QWidget.setPalette(aStent.parent, palette)
    deploy(host, aStent)
    ((ground, ink),) = set(
        re.findall(r"background-color: (#\w+); color: (#\w+)", aStent.ui.tilesLabel.text)
    )
    assert contrast(ground, ink) > 4.5
    assert contrast(ground, window) < 1.6  # no lamp in a dark room
    for lightness in ("#323232", "#efefef"):  # chosen while they are shown
        QtWidgets.QWidget.setPalette(aStent.parent, QtGui.QPalette(QtGui.QColor(lightness)))
        host.process()
        (ground,) = set(re.findall(r"background-color: (#\w+)", aStent.ui.tilesLabel.text))
        assert contrast(ground, lightness) < 1.6
    QtWidgets.QWidget.setPalette(aStent.parent, palette)
    host.grab(aStent.parent, thePictures / f"tiles_{window[1:]}.png")


def test_a_closed_section_is_as_high_as_its_header(host, aStent):
    host.process()
    for name, section in vars(aStent.ui).items():
        if name.endswith("CollapsibleButton") and section.collapsed and section.isVisible():
            assert section.height == section._header.height(), name


def test_the_certificate_comes_last_and_small(host, aStent):
    deploy(host, aStent)
    text = aStent.ui.tilesLabel.text
    sizes = re.findall(r"font-size: (\w+); font-weight: 600", text)
    assert sizes == [*(len(sizes) - 1) * ["large"], "small"]
    assert text.rindex("certified for meshing") > text.rindex("font-weight")


class Part:
    """A widget of the main window, as `slicer.util.findChildren` looks at it."""

    def __init__(self, name, *children, height=0):
        self.name, self.height, self.collapsed = name, height, False
        self.children = lambda: list(children)
        self._filters = []

    def installEventFilter(self, watch):
        self._filters.append(watch)

    def removeEventFilter(self, watch):
        self._filters.remove(watch)

    def resize(self, height):
        """Be so high, as by the user."""
        from PySide6 import QtCore, QtGui

        self.height = height
        for watch in self._filters:
            watch.eventFilter(self, QtGui.QResizeEvent(QtCore.QSize(9, 9), QtCore.QSize(9, 9)))


@pytest.fixture
def aMainWindow():
    """One of 800 pixels, with *Data Probe* open."""
    probe = Part("DataProbeCollapsibleWidget")
    slicer.app.window = Part("qSlicerMainWindow", Part("PanelDockWidget", probe), height=800)
    slicer.app.showMainWindow(True)
    yield slicer.app.window, probe
    slicer.app.showMainWindow(False)
    slicer.app.window = None


PROBE = 125
"""Pixels that *Data Probe* takes of a panel."""


def test_in_a_low_window_data_probe_makes_room_for_all_tiles(host, aStent, aMainWindow):
    from PySide6 import QtWidgets

    window, probe = aMainWindow
    host.leave(aStent)
    host.enter(aStent)
    assert probe.collapsed
    host.processUntil(lambda: not aStent.lesions.isBusy)
    aStent.ui.flowMeanSpinBox.value = 3.0  # with it there are three rows
    QtWidgets.QWidget.resize(aStent.parent, 440, 900)
    deploy(host, aStent)
    host.process()
    assert bottomOf(aStent.ui.tilesLabel, aStent) <= SHORTEST_PANEL + PROBE
    host.leave(aStent)
    assert not probe.collapsed
    host.enter(aStent)
    probe.collapsed = False  # by the user, who has it
    host.leave(aStent)
    assert not probe.collapsed
    window.height = 1080  # there is room for both
    host.enter(aStent)
    assert not probe.collapsed


def test_data_probe_that_was_folded_stays_so(host, aPanel, aMainWindow):
    _window, probe = aMainWindow
    probe.collapsed = True
    host.leave(aPanel)
    host.enter(aPanel)
    host.leave(aPanel)
    assert probe.collapsed


def test_data_probe_follows_a_window_that_becomes_lower_and_higher(host, aPanel, aMainWindow):
    window, probe = aMainWindow
    window.height = 1080
    host.leave(aPanel)
    host.enter(aPanel)
    assert not probe.collapsed
    window.resize(800)
    assert probe.collapsed
    probe.collapsed = False  # by the user, who has it
    window.resize(780)
    assert not probe.collapsed
    window.resize(1080)
    window.resize(800)
    assert probe.collapsed
    window.resize(1080)
    assert not probe.collapsed
    host.leave(aPanel)
    window.resize(800)
    assert not probe.collapsed
