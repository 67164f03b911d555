"""Plot and table of the results in the views of the application."""

import slicer


def showPlot(parameterNode):
    """Show the chart in a layout that has a plot, and the 3D view as before."""
    _change(slicer.modules.plots.logic().GetLayoutWithPlot, "SlicerLayoutConventionalPlotView")
    slicer.modules.plots.logic().ShowChartInLayout(parameterNode.outputChart)


def showTable(parameterNode):
    """Show the table in a layout that has one, and the 3D view as before."""
    _change(slicer.modules.tables.logic().GetLayoutWithTable, "SlicerLayoutFourUpTableView")
    selection = slicer.app.applicationLogic().GetSelectionNode()
    selection.SetActiveTableID(parameterNode.outputTable.GetID())
    slicer.app.applicationLogic().PropagateTableSelection()


def _change(layoutFor, with3D):
    """Change to the layout that Slicer would take for the present one, or to another one where that would take the 3D view away."""
    node = slicer.mrmlScene.GetFirstNodeByClass("vtkMRMLLayoutNode")
    if node is None:
        return
    current = node.GetViewArrangement()
    wanted = layoutFor(current)
    if _has3D(node, current) and not _has3D(node, wanted):
        wanted = getattr(node, with3D)
    node.SetViewArrangement(wanted)


def _has3D(node, layout):
    return '"vtkMRMLViewNode"' in node.GetLayoutDescription(layout)


def followPlan(left, shown):
    """Where plot or table of the plan that is left are in a view, show those of the other plan, as far as it has them."""
    application = slicer.app.applicationLogic()
    selection = application.GetSelectionNode()
    table, chart = left.outputTable, left.outputChart
    if None not in (table, shown.outputTable) and selection.GetActiveTableID() == table.GetID():
        selection.SetActiveTableID(shown.outputTable.GetID())
        application.PropagateTableSelection()
    if None not in (chart, shown.outputChart) and selection.GetActivePlotChartID() == chart.GetID():
        selection.SetActivePlotChartID(shown.outputChart.GetID())
        application.PropagatePlotChartSelection()
