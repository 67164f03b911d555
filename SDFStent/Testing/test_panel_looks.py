"""How the panel looks: in a narrow window, in any palette, while something runs."""

import slicer
from panel_helpers import deploy, settle


def test_the_progress_bar_is_there_while_a_deployment_runs(host, aStent):
    ui = aStent.ui
    aStent.parent.resize(520, 1300)  # Slicer's panel scrolls; this one would squeeze its sections
    host.process()
    assert not ui.progressBar.visible
    height = ui.statusLabel.parentWidget().height
    host.click(ui.deployButton)
    ui.deployButton.repaint()
    seen = []
    progress = aStent.session._run._onProgress
    aStent.session._run._onProgress = lambda fraction: (
        seen.append((ui.progressBar.visible, ui.statusLabel.parentWidget().height)),
        progress(fraction),
    )
    settle(host, aStent)
    assert {visible for visible, _height in seen} == {True}
    assert {seenHeight for _visible, seenHeight in seen} == {height}  # nothing jumps
    assert not ui.progressBar.visible


def test_a_preview_shows_no_progress_bar(host, aStent):
    from SDFStentSlicer import Clock

    aStent.ui.autoUpdateCheckBox.checked = True
    settle(host, aStent)
    session, seen = aStent.session, []
    # The full method says that it runs after a while, unless it is done before.
    session._settleTimer = Clock.timer(session._settle, 0)
    onStart = session._onStart
    session._onStart = lambda: (
        onStart(),
        seen.append((session.isPreview, aStent.ui.progressBar.visible)),
    )
    aStent.ui.diameterSlider.value = 8.0
    settle(host, aStent)
    assert seen == [(True, False), (False, True)]  # the preview, then the full method


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
    for section in ("advanced", "plans", "segment"):
        getattr(aStent.ui, section + "CollapsibleButton").collapsed = False
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


def test_labels_with_sentences_are_wrapped(aPanel):
    for name in ("statusLabel", "lumenLabel", "certificateLabel", "warningLabel", "researchLabel"):
        assert getattr(aPanel.ui, name).wordWrap, name


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


def test_the_stented_vessel_is_chosen_under_outputs(aPanel):
    assert aPanel.ui.outputSelector.parentWidget() is aPanel.ui.outputsCollapsibleButton


def test_names_with_control_characters_are_printable_in_the_panel(host, aStent):
    parameters = aStent._parameterNode
    parameters.stent.label = "a\nb\x1b\u202e"
    parameters.stent.handle.RemoveAllControlPoints()
    host.process()
    shown = r"a\nb\x1b\u202e"
    assert aStent.ui.stentTable.item(0, 0).text() == shown
    assert r"\x1b\u202e: place 1 point" in aStent.ui.statusLabel.text


def test_names_with_control_characters_are_printable_in_the_results(host, aStent):
    aStent._parameterNode.stent.label = "a\nb\x1b\u202e"
    aStent.ui.diameterSlider.value = 3.0
    deploy(host, aStent)
    shown = r"a\nb\x1b\u202e"
    assert aStent.ui.lumenLabel.text.startswith(f"{shown}, 3.0 mm\n")
    (line, *_others) = aStent.ui.warningLabel.text.splitlines()
    assert line.startswith(f"Warning: Stent 1 ({shown}): ")
