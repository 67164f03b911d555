from panel_helpers import deploy
from PySide6 import QtWidgets


def bottomOf(widget, panel):
    from PySide6 import QtCore

    return widget.mapTo(panel.parent, QtCore.QPoint(0, 0)).y(), widget.mapTo(
        panel.parent, QtCore.QPoint(0, 0)
    ).y() + widget.height


def test_pic(host, aStent):
    ui = aStent.ui
    host.processUntil(lambda: not aStent.lesions.isBusy)
    QtWidgets.QWidget.resize(aStent.parent, 440, 900)
    deploy(host, aStent)
    host.process()
    for n in (
        "inputsCollapsibleButton",
        "stentsCollapsibleButton",
        "lesionTable",
        "stentTable",
        "addStentButton",
        "diameterSlider",
        "lengthSlider",
        "placeCollapsibleButton",
        "deployButton",
        "statusLabel",
        "oldLabel",
        "tilesLabel",
        "detailsCollapsibleButton",
        "resultsCollapsibleButton",
        "advancedCollapsibleButton",
        "outputsCollapsibleButton",
    ):
        w = getattr(ui, n)
        print(n, bottomOf(w, aStent), w.isVisible())
    print(ui.tilesLabel.text)
    host.grab(aStent.parent, "/tmp/panel.png")
