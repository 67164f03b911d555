"""Results of a deployment in the scene: centerline, stents, table, plot, maps and the sentences of the panel."""

import json

import numpy as np
import slicer
from slicer.i18n import tr as _

from SDFStentLib.certificate import NOT_CERTIFIED
from SDFStentLib.lumen import displacements, face_stretches
from SDFStentLib.report import (
    WARNING,
    flow_moments,
    flow_section,
    measured_lines,
    measuring_lines,
    previewed_lines,
    previewed_sentences,
    previewed_tiles,
    residual_facts,
    result_tiles,
    stent_lines,
    stents_in,
    voxel_facts,
)
from SDFStentLib.validation import InputError, one_line

from . import Charts, Conversion, Display, Showing
from .ParameterNode import SurfaceMap

SERIES = {
    "Before (mm)": (0.85, 0.33, 0.25),
    "After (mm)": (0.10, 0.45, 0.75),
    "Prescribed (mm)": (0.3, 0.3, 0.3),
}
POSITION = "Position (mm)"


def tellMeasuring(parameterNode, run):
    """Show the lines of the selected stent before anything is measured."""
    with slicer.util.NodeModify(parameterNode):
        parameterNode.expansion = 100.0
        clearNumbers(parameterNode, _("Not measured yet."))
        chosen = run.drawn[selectedStent(parameterNode, run)]
        parameterNode.atHand = "\n".join(measuring_lines(chosen.placed))


def showEnd(parameterNode, run, lines):
    """Show the stents and the moved centerline, by its `lines`, after the last step."""
    showStents(parameterNode, run.end()[1], isWhole=True)
    if run.centerline is not None:
        node = Display.outputModel(
            parameterNode, "outputCenterline", _("Stented centerline"), Showing.LINE_COLOR
        )
        Display.showLines(node, run.centerline.points, lines)
    tellMeasuring(parameterNode, run)


def clearNumbers(parameterNode, text=""):
    """Take away what was measured; `text` stands in its place."""
    parameterNode.lumenSummary = text
    parameterNode.certificateSummary = parameterNode.warningSummary = parameterNode.tiles = ""
    parameterNode.rightBranch = parameterNode.atHand = ""


def clearCenterline(parameterNode):
    """Show no stented centerline: that of another vessel, or of stents that are not there, would be taken for this one's."""
    node = parameterNode.outputCenterline
    if node is not None:
        Display.showLines(node, (), ())


def showStents(parameterNode, stents, isWhole=False):
    """Show every `DrawnStent` in one model, as struts or as a tube; once they are deployed, `isWhole`, as the user's own mesh."""
    node = Display.outputModel(parameterNode, "outputStents", _("Stents"), Display.STENT_COLOR)
    mesh = _ownMesh(parameterNode) if isWhole else None
    Display.setDrawnAs(node, _wantedAs(parameterNode))
    if mesh is not None:
        Display.showMeshes(node, stents, mesh)
    elif parameterNode.showDevice:
        Display.showStruts(node, stents)
    else:
        Display.showTubes(node, [(one.axis, one.radius) for one in stents])
    node.GetDisplayNode().SetVisibility(parameterNode.showStents)


def _ownMesh(parameterNode):
    """The straight mesh of the user's own; None without one, or, with a sentence in `status`, for one that cannot be used."""
    if parameterNode.deviceMesh is None:
        return None
    try:
        return Conversion.stentMesh(parameterNode.deviceMesh)
    except InputError as error:
        parameterNode.status = str(error)
        return None


def _wantedAs(parameterNode):
    """Text that differs whenever the stents are to be drawn as something else."""
    return repr((parameterNode.showDevice, Conversion.changeStamp(parameterNode.deviceMesh)))


def followDevice(parameterNode, run):
    """Draw the stents anew, as they are shown, when they are wanted as something else: tubes, struts, or another mesh."""
    node = parameterNode.outputStents
    if node is not None and Display.drawnAs(node) != _wantedAs(parameterNode):
        _points, stents = run.at(parameterNode.expansion)
        isWhole = bool(run.recorded) and parameterNode.expansion >= 100
        showStents(parameterNode, stents, isWhole)


def showPreviewed(parameterNode, run, numbers, lesions):
    """The `numbers` of a preview, as such, and the ratios to the `lesions` of the vessel, as far as these are known."""
    sentences = [
        "\n".join([_title(one.stent), *previewed_sentences(one, its, lesions)])
        for one, its in zip(run.state.stents, numbers, strict=True)
    ]
    with slicer.util.NodeModify(parameterNode):
        clearNumbers(parameterNode, "\n\n".join(sentences))
        parameterNode.tiles = json.dumps(previewed_tiles(numbers))
        if run.state.stents:
            number = selectedStent(parameterNode, run)
            lines = previewed_lines(run.state.stents[number], numbers[number], lesions)
            parameterNode.atHand = "\n".join(lines)


def showMeasured(parameterNode, run):
    """The numbers: sentences, table and plot."""
    with slicer.util.NodeModify(parameterNode):
        showProfile(parameterNode, run)
        showSummary(parameterNode, run)
        parameterNode.certificateSummary = (
            run.result.certificate.sentence()
            if run.result.certificate
            else f"Surface {NOT_CERTIFIED}."
        )
        told = filter(None, (run.remark, *(caution.sentence() for caution in _cautions(run))))
        parameterNode.warningSummary = "\n".join(
            _("Warning: {sentence}").format(sentence=one_line(sentence)) for sentence in told
        )


def _cautions(run):
    """Cautions on the stents and on their sizes."""
    told = [*run.result.warnings, *run.case.size_cautions(run.label)]
    return [one for one in told if one.kind != "switched-off"]  # the table says so


def showSummary(parameterNode, run):
    """Show the sentences on every stent, and on the flow where that is known."""
    summaries = [stentSummary(treated, run.lesions) for treated in run.result.stents]
    left = run.case.residual
    headline = [] if left is None else [str(residual_facts(left).named("words"))]
    told = [*headline, *summaries, *_flowParagraphs(run), *_rangeSentences(run)]
    parameterNode.lumenSummary = "\n\n".join(told)
    showAtHand(parameterNode, run)
    tiles = result_tiles(
        run.result.stents,
        run.lesions,
        run.result.certificate,
        _cautions(run),
        _flowOf(run),
        run.voxels,
    )
    parameterNode.tiles = json.dumps(tiles)


def _flowOf(run):
    return None if run.flow is None else flow_section(run.flow)


def showAtHand(parameterNode, run):
    """The few lines beside the selected stent."""
    stents = run.result.stents
    chosen = stents[selectedStent(parameterNode, run)]
    lines = measured_lines(
        chosen, stents, run.lesions, run.result.certificate, _cautions(run), _flowOf(run)
    )
    if run.remark and not any(line.startswith(WARNING) for line in lines):
        lines.insert(-1, _("{warning}the vessel, see Details").format(warning=WARNING))
    parameterNode.atHand = "\n".join(lines)


def _flowParagraphs(run):
    """Paragraphs on pressures and flows, with notes; or the reason for none."""
    if run.flow is None:
        return [run.flowRemark] if run.flowRemark else []
    section = flow_section(run.flow)
    told = [
        "\n".join([f"{at}:", *(f"{one.label} {one.change}" for one in facts)])
        for at, facts in flow_moments(section, stents_in(section))
    ]
    return [*told, *section["notes"]]


def _rangeSentences(run):
    """Sentences on the range by half a voxel; or the reason for none."""
    if run.voxels is None:
        return [run.voxelRemark] if run.voxelRemark else []
    return voxel_facts(run.voxels).sentences


def showRange(parameterNode, run):
    """The numbers with the range by half a voxel, where it is known."""
    with slicer.util.NodeModify(parameterNode):
        showSummary(parameterNode, run)


def showFlow(parameterNode, run, formerRemark):
    """The numbers with another flow than before, or in `status`, too, why it is not known, as the `formerRemark` was."""
    right = None if run.flow is None else run.flow.right_place
    with slicer.util.NodeModify(parameterNode):
        if run.flowRemark or parameterNode.status == formerRemark:
            parameterNode.status = run.flowRemark
        parameterNode.rightBranch = "" if right is None else json.dumps(right)
        showSummary(parameterNode, run)


def stentSummary(treated, lesions):
    """Sentences on one stent, a line per quantity, with true arrows."""
    told = stent_lines(treated, lesions)
    return "\n".join(
        [_title(treated.stent), *(line.replace("->", "\N{RIGHTWARDS ARROW}") for line in told)]
    )


def _title(stent):
    return _("{name}, {diameter:.1f} mm").format(name=one_line(stent.name), diameter=stent.diameter)


def followSelection(parameterNode, run):
    """Let table and plot show the selected stent, where both are there; makes no nodes."""
    if run.result is None or None in (parameterNode.outputTable, parameterNode.outputChart):
        return
    if selectedStent(parameterNode, run) != run.shownStent:
        showProfile(parameterNode, run)
        showAtHand(parameterNode, run)


def selectedStent(parameterNode, run):
    """Number of the selected stent among the deployed ones: that with its handle, or in its place; else the first."""
    handle, index = parameterNode.stent.handle, parameterNode.selected
    place = (index, handle.GetID() if handle is not None else None)
    ranks = [(p == place, p[1] == place[1], p[0] == index) for p in run.places]
    number = ranks.index(max(ranks))
    # Ends: with the list. A stent that is dilated again is there twice, and shown as it is in the end.
    while run.places[number + 1 : number + 2] == [run.places[number]]:
        number += 1
    return number


def _plotTitle(treated, number):
    """Title of a stent's plot: its name, and its number when the name is not its own."""
    names = [one_line(stent.stent.name) for stent in treated]
    if names[number] and names.count(names[number]) == 1:
        return names[number]
    rows = [stent.row for stent in treated]
    return _("{name} (stent {row} of {count})").format(
        name=names[number] or _("Stent"), row=rows[number], count=max(rows)
    )


def showProfile(parameterNode, run):
    """Show table and plot of the selected stent, or of the first when that one was not deployed."""
    treated, number = run.result.stents, selectedStent(parameterNode, run)
    run.shownStent = number
    chosen, title = treated[number], _plotTitle(treated, number)
    before, after = chosen.around_before, chosen.around_after
    inStent = (before.arc_length >= 0) & (before.arc_length <= chosen.before.arc_length[-1])
    columns = {
        POSITION: before.arc_length,
        "Before (mm)": before.inscribed_diameter,
        "After (mm)": after.inscribed_diameter,
        "Prescribed (mm)": np.where(
            inStent,
            chosen.prescribed(before.arc_length),
            np.nan,
        ),
        "Equivalent before (mm)": before.equivalent_diameter,
        "Equivalent after (mm)": after.equivalent_diameter,
    }
    Charts.fillTables(
        parameterNode,
        {name: (values, "mm") for name, values in columns.items()},
        _("Diameters along {label}, proximal to distal").format(label=title),
    )
    largest = max(np.nanmax(columns[name], initial=0.0) for name in SERIES)
    chart = Charts.showChart(parameterNode, POSITION, SERIES, top=1.1 * largest)
    chart.SetTitle(_("{label}: red before, blue after, dashed prescribed").format(label=title))


def mapOf(run, chosen):
    """Values of a surface map and whether they belong to the cells."""
    if chosen == SurfaceMap.DISPLACEMENT:
        return displacements(run.surface.points, run.points), False
    return run.surface.to_given(face_stretches(run.surface, run.points).area), True


def showMap(parameterNode, run):
    """The map that the parameters name, or none."""
    node, chosen = parameterNode.outputVessel, parameterNode.map
    if node is None or node.GetDisplayNode() is None:
        return
    if chosen == SurfaceMap.NONE:
        Display.showMap(node, "", None, False, "")
    else:
        values, onCells = mapOf(run, chosen)
        Display.showMap(node, chosen.value, values, onCells, chosen.label())
    run.shownMap = chosen
