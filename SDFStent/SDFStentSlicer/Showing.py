"""Visibility of one thing in place of another, a node or of a segmentation one segment in 3D; plot and table in the views."""

import contextlib

import slicer

from . import Clock, Conversion

ONE_COLOR = "SDFStent.OneColor"
VESSEL_COLOR, VESSEL_OPACITY = (0.85, 0.81, 0.78), 0.35
"""Lesions, lines and handles lie inside: before stents as after."""
LINE_COLOR, LINE_WIDTH = (0.15, 0.35, 0.75), 3
"""The color of centerlines, and their width, pixels."""


@contextlib.contextmanager
def inOneFrame():
    """Draw what changes meanwhile at its end: where frames take long, views draw one at every single change."""
    views = slicer.app.applicationLogic()
    views.PauseRender()
    try:
        yield
    finally:
        views.ResumeRender()


class HeldFrame:
    """Frame held while things change: drawn once it is released, or when it was held for as long as a turn may take."""

    def __init__(self):
        self._isHeld = False
        self._timer = Clock.timer(self.release, round(1000 * Clock.longest()))

    def hold(self):
        """Hold the scene from now on."""
        if not self._isHeld:
            slicer.app.applicationLogic().PauseRender()
            self._timer.start()
        self._isHeld = True

    def release(self):
        """Draw it, if it was held."""
        self._timer.stop()
        if self._isHeld:
            slicer.app.applicationLogic().ResumeRender()
        self._isHeld = False


def threeDViews():
    """The 3D views of the application; none without a window."""
    manager = slicer.app.layoutManager()
    count = 0 if manager is None else manager.threeDViewCount
    return [manager.threeDWidget(number).threeDView() for number in range(count)]


def firstRenderer():
    """The renderer of the first 3D view; None without one."""
    views = threeDViews()
    return views[0].renderWindow().GetRenderers().GetFirstRenderer() if views else None


class QuickDrawing:
    """Draws walls that are seen through in any order while something moves.

    Depth peeling draws them up to four times: without a GPU a frame of 180,000 triangles takes 220 ms with it and 80 without.
    """

    def __init__(self):
        self._former = []

    def begin(self):
        """Begin to show from now on; the view nodes, which are the user's, stay as they are."""
        if self._former:
            return
        for view in threeDViews():
            renderer = view.renderWindow().GetRenderers().GetFirstRenderer()
            self._former.append(
                (view, renderer, renderer.GetUseDepthPeeling(), renderer.GetUseOIT())
            )
            renderer.SetUseDepthPeeling(False)
            renderer.SetUseOIT(False)

    def end(self):
        """Draw as before."""
        for view, renderer, usesPeeling, usesOIT in self._former:
            renderer.SetUseDepthPeeling(usesPeeling)
            renderer.SetUseOIT(usesOIT)
            view.scheduleRender()
        self._former = []


REPLACED = "SDFStent.Replaced"
"""Attribute of a node hidden because another one was chosen instead."""


def inOneColor(vessel, centerline):
    """Show models without the colors of the arrays that they happen to have, and a vessel that can be seen through.

    Once: who wants it otherwise changes it again. What was chosen by mistake keeps its own look.
    """
    for node, isSuch, show in (
        (vessel, Conversion.hasWall, _asVessel),
        (centerline, Conversion.hasLines, _asCenterline),
    ):
        display = node and node.GetDisplayNode()
        if display and isSuch(node) and not node.GetAttribute(ONE_COLOR):
            node.SetAttribute(ONE_COLOR, "1")
            with slicer.util.NodeModify(display):  # the views follow every change
                show(display)


def _asVessel(display):
    if display.IsA("vtkMRMLModelDisplayNode"):
        display.SetScalarVisibility(False)
        display.SetColor(*VESSEL_COLOR)
        display.SetVisibility2D(True)
        seeThrough(display)
    else:
        display.SetOpacity3D(VESSEL_OPACITY)


def _asCenterline(display):
    if display.IsA("vtkMRMLModelDisplayNode"):
        display.SetScalarVisibility(False)
        display.SetColor(*LINE_COLOR)
        display.SetLineWidth(LINE_WIDTH)


def seeThrough(display):
    """Show the wall of a vessel in front of its inside, and not the one behind: it is clearer, and drawn faster."""
    display.SetOpacity(VESSEL_OPACITY)
    display.SetBackfaceCulling(True)


def isShown(node, segmentID=""):
    """Whether a node can be seen; None for one that nothing shows, and for a segment that is gone."""
    display = node.GetDisplayNode()
    if display is None or not _hasSegment(node, segmentID):
        return None
    return bool(display.GetSegmentVisibility3D(segmentID) if segmentID else display.GetVisibility())


def setShown(node, isVisible, segmentID=""):
    """Show a node, or hide it. The outline of a segment stays in the slice views, and so do the other segments."""
    if isShown(node, segmentID) == (not isVisible):
        display = node.GetDisplayNode()
        if segmentID:
            display.SetSegmentVisibility3D(segmentID, isVisible)
        else:
            display.SetVisibility(isVisible)


def changeOver(node, attribute, isVisible, segmentID=""):
    """Show or hide a node that was not, and remember that."""
    if isShown(node, segmentID) == (not isVisible):
        setShown(node, isVisible, segmentID)
        node.SetAttribute(attribute + segmentID, "1")


def changeBack(node, attribute, isVisible, segmentID=""):
    """Show or hide a node again of which the opposite was remembered."""
    if node.GetAttribute(attribute + segmentID):
        node.RemoveAttribute(attribute + segmentID)
        setShown(node, isVisible, segmentID)


def inPlaceOf(formers, chosen):
    """Show the nodes that were chosen instead of others, and hide those, if they are models, until they are chosen again."""
    for former, node in zip(formers, chosen, strict=True):
        if node is None or node is former:
            continue
        isLeft = former is not None and former.GetScene() is not None and former not in chosen
        if isLeft and former.IsA("vtkMRMLModelNode"):
            changeOver(former, REPLACED, False)
        changeBack(node, REPLACED, True)


def _hasSegment(node, segmentID):
    return not segmentID or node.GetSegmentation().GetSegment(segmentID) is not None


def showPlot(parameterNode):
    """Show the chart in a layout that has a plot, and the 3D view as before."""
    logic = slicer.modules.plots.logic()
    _change("Plot", logic.GetLayoutWithPlot, "SlicerLayoutConventionalPlotView")
    activateChart(parameterNode.outputChart)


def showTable(parameterNode):
    """Show the table in a layout that has one, and the 3D view as before."""
    logic = slicer.modules.tables.logic()
    _change("Table", logic.GetLayoutWithTable, "SlicerLayoutFourUpTableView")
    activateTable(readTable(parameterNode))


def readTable(parameterNode):
    """The table of diameters to be read; that of numbers in a scene of a former version, None without."""
    return parameterNode.outputTexts or parameterNode.outputTable


def _change(kind, layoutFor, with3D):
    """Change to the layout that Slicer would take for the present one, or to another one where that would take the 3D view away."""
    node = slicer.mrmlScene.GetFirstNodeByClass("vtkMRMLLayoutNode")
    if node is None:
        return
    current = node.GetViewArrangement()
    if _has(node, current, kind):  # one that Slicer does not know may have it, too
        return
    wanted = layoutFor(current)
    if _has(node, current, "") and not _has(node, wanted, ""):
        wanted = getattr(node, with3D)
    node.SetViewArrangement(wanted)


def hasPlot(node):
    """Whether the present layout of a layout node has a view for plots."""
    return _has(node, node.GetViewArrangement(), "Plot")


def _has(node, layout, kind):
    """Whether a layout has a view for plots or tables, or with "" one in 3D."""
    return f'"vtkMRML{kind}ViewNode"' in node.GetLayoutDescription(layout)


def activateChart(chart):
    """Show a chart in the views for plots, if any."""
    application = slicer.app.applicationLogic()
    application.GetSelectionNode().SetActivePlotChartID(chart.GetID())
    application.PropagatePlotChartSelection()


def activateTable(table):
    """Show a table in the views for tables, if any."""
    application = slicer.app.applicationLogic()
    application.GetSelectionNode().SetActiveTableID(table.GetID())
    application.PropagateTableSelection()


def followPlan(left, shown):
    """Show plot or table of another plan, as far as it has them, where those of the plan that is left are in a view."""
    selection = slicer.app.applicationLogic().GetSelectionNode()
    (table, other), chart = map(readTable, (left, shown)), left.outputChart
    if None not in (table, other) and selection.GetActiveTableID() == table.GetID():
        activateTable(other)
    active = slicer.mrmlScene.GetNodeByID(selection.GetActivePlotChartID() or "")
    isFree = active is None or active is chart  # that of a lesion goes with the plan that is left
    if shown.outputChart is not None and isFree:
        activateChart(shown.outputChart)
