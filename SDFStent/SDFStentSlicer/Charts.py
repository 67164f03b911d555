"""Diameters along a stent or a lesion: table and plot of a plan's results, and a plot to look at only."""

import numpy as np
import slicer
from slicer.i18n import tr as _
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonCore import vtkStringArray

from . import Display, Marks, Showing

TABLE_DECIMALS = 2
"""Decimals of mm in a table."""

TITLE_SIZE = 14
"""Points; less than Slicer's, for a sentence."""

OLD_OPACITY = 0.25


def fillTables(parameterNode, columns, description):
    """The table of diameters, for the plot and to be read: `columns` maps a title to (values, unit)."""
    for role, name, fill in (
        ("outputTable", _("Stent diameters"), _fillNumbers),
        ("outputTexts", _("Stent diameters to read"), _fillTexts),
    ):
        node = getattr(parameterNode, role)
        isNew = node is None
        if isNew:
            node = Display.addOutput(parameterNode, "vtkMRMLTableNode", name)
            setattr(parameterNode, role, node)
            node.SetUseColumnTitleAsColumnHeader(True)
            node.SetLocked(True)  # what somebody changes in it would be drawn as measured
        with slicer.util.NodeModify(node):  # a plot that is shown must not see it half filled
            fill(node, {title: values for title, (values, _unit) in columns.items()})
            for title, (_values, unit) in columns.items():
                node.SetColumnUnitLabel(title, unit)
                node.SetColumnTitle(title, title.removesuffix(f" ({unit})"))  # the view adds it
            node.SetDescription(description)
    if isNew and _isFree(_selection().GetActiveTableID()):
        Showing.activateTable(node)


def _fillNumbers(node, columns):
    _fillExactly(
        node, {title: np.round(values, TABLE_DECIMALS) for title, values in columns.items()}
    )


def _fillExactly(node, columns):
    node.RemoveAllColumns()
    for title, values in columns.items():
        column = numpy_to_vtk(values, deep=True)
        column.SetName(title)
        node.AddColumn(column)


def _fillTexts(node, columns):
    """Fill a table's texts; empty where nothing is known."""
    node.RemoveAllColumns()
    for title, values in columns.items():
        texts = vtkStringArray()
        texts.SetName(title)
        for value in np.round(values, TABLE_DECIMALS) + 0.0:  # no minus zero
            texts.InsertNextValue(f"{value:.{TABLE_DECIMALS}f}" if np.isfinite(value) else "")
        node.AddColumn(texts)


def showChart(parameterNode, x, series, top):
    """Show the plot chart over the table's column `x` from 0 to `top`: `series` maps a column to its color, the last is dashed."""
    chart, isNew = parameterNode.outputChart, parameterNode.outputChart is None
    if isNew:
        chart = _newChart(
            lambda *named: Display.addOutput(parameterNode, *named),
            _("Stent diameters chart"),
            _("From the proximal end (mm)"),
            series,
        )
        parameterNode.outputChart = chart
    _draw(chart, parameterNode.outputTable, x, series, top)
    if isNew:
        _offer(chart)
    return chart


def createChart(title, position, series):
    """Plot chart that is not saved, and before it in the list its parts.

    `position` is (label, values), `series` maps a label to (values, color); the last of them is dashed.
    """
    diameters = {label: values for label, (values, _color) in series.items()}
    table = _addMark("vtkMRMLTableNode", title)
    _fillExactly(table, {position[0]: position[1], **diameters})
    colors = {name: color for name, (_values, color) in series.items()}
    chart = _newChart(_addMark, title, position[0], colors)
    chart.SetTitle(title)
    _draw(chart, table, position[0], series, 1.1 * np.nanmax([*diameters.values()]))
    _offer(chart)
    return [table, *map(chart.GetNthPlotSeriesNode, range(len(series))), chart]


def fadeChart(chart, isOld):
    """Draw the lines of a chart weakly where they are of another plan, or of none."""
    for index in range(chart.GetNumberOfPlotSeriesNodes()):
        series = chart.GetNthPlotSeriesNode(index)
        if series is not None:
            series.SetOpacity(OLD_OPACITY if isOld else 1.0)


def _selection():
    return slicer.app.applicationLogic().GetSelectionNode()


def _isFree(shownID):
    """Whether a new plot or table may take the place of a node in the views: none is there, a mark, or that of another plan."""
    shown = slicer.mrmlScene.GetNodeByID(shownID or "")
    return shown is None or shown.GetHideFromEditors() or Display.resultsFolder(shown) != 0


def _offer(chart):
    """Show a new chart, unless the user looks at one of his own."""
    if _isFree(_selection().GetActivePlotChartID()):
        Showing.activateChart(chart)


def _addMark(className, name):
    return slicer.mrmlScene.AddNode(Marks.newNode(className, name))


def _newChart(add, name, along, series):
    """A chart with a line per series, none of which is drawn yet; `add(class name, name)` makes the nodes."""
    chart = add("vtkMRMLPlotChartNode", name)
    chart.SetXAxisTitle(along)
    chart.SetYAxisTitle(_("Diameter (mm)"))
    for column, color in series.items():
        node = add("vtkMRMLPlotSeriesNode", column)
        node.SetName(column)  # as the pointer tells it, also of the second plan
        node.SetPlotType(slicer.vtkMRMLPlotSeriesNode.PlotTypeScatter)
        node.SetMarkerStyle(slicer.vtkMRMLPlotSeriesNode.MarkerStyleNone)
        node.SetColor(*color)
        node.SetLineWidth(3)
        chart.AddAndObservePlotSeriesNodeID(node.GetID())
    node.SetLineStyle(node.LineStyleDash)  # seen over a line that agrees with it
    return chart


def _draw(chart, table, x, columns, top):
    """Columns over another, from 0 on. The title distinguishes the lines: a legend would lie over them."""
    chart.SetYAxisRangeAuto(False)
    chart.SetYAxisRange(0.0, top)
    chart.SetLegendVisibility(False)
    chart.SetTitleFontSize(TITLE_SIZE)
    for index, column in enumerate(columns):
        node = chart.GetNthPlotSeriesNode(index)
        if node is not None:
            with slicer.util.NodeModify(node):
                node.SetAndObserveTableNodeID(table.GetID())
                node.SetXColumnName(x)
                node.SetYColumnName(column)
