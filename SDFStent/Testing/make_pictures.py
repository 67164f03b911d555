"""Makes the pictures of the user guide: drives the panel in the test host and draws the 3D view.

usage: make_pictures.py [FOLDER] [--moving]          default: docs/images; --moving: dragging.gif alone

A picture of a step shows the part of the panel that is meant, beside what the 3D view shows then. They are made by the test host;
pictures for the extension's index are to be taken in Slicer itself.
"""

import logging
import sys
from pathlib import Path

import numpy as np
import vtk
from panel_helpers import clickSample, settle, suggest, theThroat
from PySide6 import QtCore, QtGui, QtWidgets
from sdfstent_host import Host
from vtk.util.numpy_support import vtk_to_numpy

HERE = Path(__file__).resolve().parent
PANEL_WIDTH = 460
PANEL_HEIGHT = 1500
VIEW_SIZE = (700, 520)
PLOT_SIZE = (760, 420)
MOVING_SIZE = (560, 416)
MARGIN = 12
REST = 0.5
"""Rest of the view, s: the numbers of lesions follow it then."""
NESTED = {
    **dict.fromkeys(("place", "device", "shape", "advanced"), "stents"),
    **dict.fromkeys(("flow", "plans"), "results"),
    "segment": "outputs",
}
"""Sections within others."""
SECTIONS = ("inputs", "stents", "results", "outputs", *NESTED)


class Studio:
    """The host with a panel, and a folder for pictures."""

    def __init__(self, folder):
        self.folder = Path(folder)
        self.folder.mkdir(parents=True, exist_ok=True)
        self.host = Host.start()
        self.panel = self.host.openPanel(
            self.host.loadModule(HERE.parent / "SDFStent.py"),
            width=PANEL_WIDTH,
            height=PANEL_HEIGHT,
        )
        self.view = self.host.application.view
        self.view.window.SetSize(*VIEW_SIZE)

    def look(self, points, zoom=1.0):
        """Point the camera at a cloud of points."""
        low, high = np.min(points, axis=0), np.max(points, axis=0)
        self.view.look(np.stack([low, high], axis=1).ravel(), zoom=zoom)

    def take(self, name, *sections):
        """Save a picture: these sections of the panel (all others closed) at the left, the 3D view at the right."""
        self._open(sections)
        self.view.render()
        self.host.process(REST)
        self.host.processUntil(lambda: not self.panel.ends.isBusy)
        root = self.panel.ui.inputsCollapsibleButton.parentWidget()
        top, bottom = (
            self._ends(section, root)[end] for section, end in ((sections[0], 0), (sections[-1], 1))
        )
        area = QtCore.QRect(0, top, geometry(root).width(), bottom - top)
        self._save(name, root.grab(area).toImage(), self.image())

    def _ends(self, section, root):
        """Top and bottom of a section in the panel."""
        button = getattr(self.panel.ui, section + "CollapsibleButton")
        top = QtWidgets.QWidget.mapTo(button, root, QtCore.QPoint(0, 0)).y()
        return top, top + geometry(button).height()

    def image(self):
        """The 3D view."""
        self.view.render()
        grabber = vtk.vtkWindowToImageFilter()
        grabber.SetInput(self.view.window)
        grabber.ReadFrontBufferOff()
        grabber.Update()
        return qImage(grabber.GetOutput())

    def panelPicture(self, name):
        """The panel alone, as it is used."""
        self._open(("stents", "results"))
        self.panel.parent.resize(PANEL_WIDTH, self.panel.parent.sizeHint().height())
        self.host.process(0.05)
        self.host.grab(self.panel.parent, self.folder / name)
        self.panel.parent.resize(PANEL_WIDTH, PANEL_HEIGHT)

    def _open(self, sections):
        sections = {*sections, *(NESTED[name] for name in sections if name in NESTED)}
        for name in SECTIONS:
            button = getattr(self.panel.ui, name + "CollapsibleButton")
            if button.collapsed != (name not in sections):
                button.collapsed = name not in sections
        self.host.process()

    def _save(self, name, left, right):
        height = max(left.height(), right.height())
        picture = QtGui.QImage(
            left.width() + right.width() + MARGIN, height, QtGui.QImage.Format_RGB32
        )
        picture.fill(QtGui.QColor("white"))
        painter = QtGui.QPainter(picture)
        painter.drawImage(0, 0, left)
        painter.drawImage(left.width() + MARGIN, 0, right)
        painter.end()
        if not picture.save(str(self.folder / name)):
            raise OSError(f"Could not write {self.folder / name}")


def geometry(widget):
    """The stand-ins offer it as a property, plain Qt as a method; this works for both."""
    return QtWidgets.QWidget.geometry(widget)


def qImage(imageData):
    width, height, _depth = imageData.GetDimensions()
    pixels = vtk_to_numpy(imageData.GetPointData().GetScalars()).reshape(height, width, 3)[::-1]
    pixels = np.ascontiguousarray(pixels)
    return QtGui.QImage(pixels.data, width, height, 3 * width, QtGui.QImage.Format_RGB888).copy()


def plotPicture(chart, path):
    """The plot chart of the results, drawn with the classes that Slicer's plot view uses."""
    view = vtk.vtkContextView()
    view.GetRenderWindow().SetOffScreenRendering(True)
    view.GetRenderWindow().SetSize(*PLOT_SIZE)
    view.GetRenderer().SetBackground(1, 1, 1)
    drawn = vtk.vtkChartXY()
    drawn.SetShowLegend(chart.GetLegendVisibility())
    drawn.SetTitle(chart.GetTitle())
    drawn.GetTitleProperties().SetFontSize(chart.GetTitleFontSize())
    if not chart.GetYAxisRangeAuto():
        drawn.GetAxis(vtk.vtkAxis.LEFT).SetBehavior(vtk.vtkAxis.FIXED)
        drawn.GetAxis(vtk.vtkAxis.LEFT).SetRange(*chart.GetYAxisRange())
    drawn.GetAxis(vtk.vtkAxis.BOTTOM).SetTitle(chart.GetXAxisTitle())
    drawn.GetAxis(vtk.vtkAxis.LEFT).SetTitle(chart.GetYAxisTitle())
    view.GetScene().AddItem(drawn)
    for index in range(chart.GetNumberOfPlotSeriesNodes()):
        series = chart.GetNthPlotSeriesNode(index)
        line = drawn.AddPlot(vtk.vtkChart.LINE)
        table = series.GetTableNode().GetTable()
        line.SetInputData(table, series.GetXColumnName(), series.GetYColumnName())
        line.SetLabel(series.GetName())
        line.SetColorF(*series.GetColor())
        line.SetWidth(3)
        line.GetPen().SetLineType(series.GetLineStyle())  # the same numbers in both
    view.GetRenderWindow().Render()
    grabber = vtk.vtkWindowToImageFilter()
    grabber.SetInput(view.GetRenderWindow())
    grabber.Update()
    qImage(grabber.GetOutput()).save(str(path))


def movingPicture(studio):
    """A stent dragged by the mouse through the narrowing, let go at its middle: a GIF for README."""
    from PIL import Image

    host, panel, view, frames = studio.host, studio.panel, studio.view, []

    def shot(milliseconds):
        image = studio.image()
        pixels = np.frombuffer(image.constBits(), np.uint8).reshape(image.height(), -1)
        picture = Image.fromarray(pixels[:, : 3 * image.width()].reshape(*pixels.shape[:1], -1, 3))
        frames.append((picture.resize(MOVING_SIZE, Image.LANCZOS), milliseconds))

    def moved():
        host.process(0.3)
        shot(110)

    host.click(panel.ui.addStentButton)
    panel.ui.diameterSlider.value, panel.ui.lengthSlider.value = 7.0, 14.0
    settle(host, panel)
    tree = panel.logic.centerlineOf(panel._parameterNode)
    way = tree.path_around(theThroat(), 34.0).points
    there = np.linspace(0, len(way) - 1, 22).astype(int)
    panel._parameterNode.stent.handle.SetNthControlPointPositionWorld(0, *way[0])
    settle(host, panel)
    back = there[::-1][1 : len(there) // 2 + 1]
    view.drag([view.pixel(way[index]) for index in (*there, *back)], moved)
    settle(host, panel)
    shot(2500)
    first, times = frames[0][0], [time for _picture, time in frames]
    colors = Image.new("RGB", (MOVING_SIZE[0], 2 * MOVING_SIZE[1]))
    colors.paste(first, (0, 0))
    colors.paste(frames[-1][0], (0, MOVING_SIZE[1]))
    palette = colors.quantize(96)
    shown = [picture.quantize(palette=palette, dither=0) for picture, _time in frames]
    path = studio.folder / "dragging.gif"
    shown[0].save(path, save_all=True, append_images=shown[1:], duration=times, loop=0)


def opened(folder):
    """A studio with the sample vessel, seen as a whole."""
    studio = Studio(folder)
    import slicer

    slicer.app.showMainWindow(True)  # the view tells what follows the hand
    vessel, centerline = clickSample("StenosedPulmonaryArtery")
    everything = vtk_to_numpy(vessel.GetPolyData().GetPoints().GetData())
    studio.panel.ui.vesselSelector.setCurrentNode(vessel)
    studio.panel.ui.centerlineSelector.setCurrentNode(centerline)
    studio.host.processUntil(lambda: not studio.panel.lesions.isBusy)
    studio.look(everything, zoom=1.25)
    return studio


def closed(studio):
    studio.host.closePanel(studio.panel)
    if studio.host.errors():
        raise RuntimeError("Something was logged while the pictures were made.")


def main(folder):
    studio = opened(folder)
    host, panel, ui = studio.host, studio.panel, studio.panel.ui
    studio.take("tutorial-1-inputs.png", "inputs")

    ui.stentsCollapsibleButton.collapsed = False
    ui.lesionTable.selectRow(0)
    host.click(ui.addStentButton)
    ui.diameterSlider.value, ui.lengthSlider.value = 7.0, 14.0
    settle(host, panel)
    studio.take("tutorial-2-stent.png", "stents")

    host.click(ui.deployButton)
    settle(host, panel)
    studio.take("tutorial-4-results.png", "stents", "results")
    studio.panelPicture("panel.png")
    plotPicture(panel._parameterNode.outputChart, studio.folder / "tutorial-5-plot.png")
    ui.mapComboBox.currentIndex = 1
    host.process()
    studio.take("tutorial-6-map.png", "results")

    ui.mapComboBox.currentIndex = 0
    host.click(ui.copyStentButton)
    near = panel.logic._inputs.centerline(panel._parameterNode)
    second = near.path_around(theThroat(), 30.0).points[-1]
    panel._parameterNode.stent.handle.SetNthControlPointPositionWorld(0, *second)
    ui.diameterSlider.value, ui.lengthSlider.value = 7.0, 12.0
    host.click(ui.deployButton)
    settle(host, panel)
    studio.take("tutorial-7-two-stents.png", "stents", "results")
    host.click(ui.removeStentButton)
    ui.stentsCollapsibleButton.collapsed = False
    ui.lesionTable.selectRow(0)
    suggest(host, panel)
    ui.waistSpinBox.value = 5.5
    ui.proximalEndSpinBox.value = 8.0
    ui.flowMeanSpinBox.value = 2.5
    host.processUntil(lambda: not panel.recoil.isBusy)
    settle(host, panel)  # the results are told for the flow; until then nothing can be deployed
    host.click(ui.deployButton)
    settle(host, panel)
    studio.take("reference-device-shape.png", "device", "shape")
    studio.take("reference-advanced.png", "advanced")
    ui.plansCollapsibleButton.collapsed = False
    host.click(ui.duplicatePlanButton)
    ui.balloonSlider.value = 6.5
    ui.planTable.item(1, 0).setText("smaller balloon")
    host.click(ui.deployButton)
    settle(host, panel)
    studio.take("reference-plans.png", "plans")
    closed(studio)


if __name__ == "__main__":
    logging.basicConfig()  # the host logs what goes wrong, and hides it from the console
    words = [word for word in sys.argv[1:] if word != "--moving"]
    where = words[0] if words else HERE.parents[1] / "docs" / "images"
    if "--moving" in sys.argv:
        studio = opened(where)
        movingPicture(studio)
        closed(studio)
    else:
        main(where)
