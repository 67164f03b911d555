"""What a deployment leaves in the scene: centerline, stents, table, plot, maps and the sentences of the panel."""

import numpy as np
import slicer
from slicer.i18n import tr as _

from . import Display
from .ParameterNode import SurfaceMap
from .Stenting import summary

SERIES = {
    "Before (mm)": (0.85, 0.33, 0.25),
    "After (mm)": (0.10, 0.45, 0.75),
    "Prescribed (mm)": (0.45, 0.45, 0.45),
}
POSITION = "Position (mm)"


def showEnd(parameterNode, run):
    """After the last step: the stents and the moved centerline."""
    showStents(parameterNode, run.end()[1])
    if run.centerline is not None:
        node = Display.outputModel(
            parameterNode, "outputCenterline", _("Stented centerline"), Display.CENTERLINE_COLOR
        )
        lines = [run.centerline.ancestry(leaf) for leaf in run.centerline.leaves]
        Display.showLines(node, run.centerline.points, lines)
    with slicer.util.NodeModify(parameterNode):
        parameterNode.expansion = 100.0
        parameterNode.lumenSummary = parameterNode.certificateSummary = ""


def showStents(parameterNode, tubes):
    """The stents as a model of tubes."""
    node = Display.outputModel(parameterNode, "outputStents", _("Stents"), Display.STENT_COLOR)
    Display.showTubes(node, tubes)
    node.GetDisplayNode().SetVisibility(parameterNode.showStents)


def showMeasured(parameterNode, run):
    """The numbers: sentences, table and plot."""
    with slicer.util.NodeModify(parameterNode):
        showProfile(parameterNode, run)
        parameterNode.lumenSummary = "\n".join(summary(treated) for treated in run.result.stents)
        parameterNode.certificateSummary = (
            run.result.certificate.sentence() if run.result.certificate else _("Not certified.")
        )
        parameterNode.status = "\n".join(run.result.warnings)


def showProfile(parameterNode, run):
    """Table and plot of the selected stent, or of the first when that one is switched off."""
    treated = run.result.stents
    labels = [stent.planned.name for stent in treated]
    selected = parameterNode.stent.label
    chosen = treated[labels.index(selected) if selected in labels else 0]
    before, after = chosen.before, chosen.after
    columns = {
        POSITION: before.arc_length,
        "Before (mm)": before.inscribed_diameter,
        "After (mm)": after.inscribed_diameter,
        "Prescribed (mm)": np.full(len(before.arc_length), chosen.planned.stent.diameter),
        "Equivalent before (mm)": before.equivalent_diameter,
        "Equivalent after (mm)": after.equivalent_diameter,
    }
    table = Display.fillTable(
        parameterNode, {title: (values, "mm") for title, values in columns.items()}
    )
    table.SetDescription(
        _("Diameters along {label}, proximal to distal").format(label=chosen.planned.name)
    )
    Display.showChart(parameterNode, POSITION, SERIES)


def showMap(parameterNode, run):
    """The map that the parameters name, or none."""
    node, chosen = parameterNode.outputVessel, parameterNode.map
    if node is None or node.GetDisplayNode() is None:
        return
    if chosen == SurfaceMap.NONE:
        Display.showMap(node, "", None, False, "")
    else:
        values, onCells = run.map(chosen.value)
        Display.showMap(node, chosen.value, values, onCells, chosen.label())
    run.shownMap = chosen
