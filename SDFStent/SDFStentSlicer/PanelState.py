"""State of the panel: enabled widgets, ends of sliders, headings, the status line, lines in the 3D views."""

import math
import textwrap

import slicer
from slicer.i18n import tr as _
from vtkmodules.vtkRenderingAnnotation import vtkCornerAnnotation

from SDFStentLib.certificate import (
    CERTIFIED,
    CERTIFIED_IN_PIECES,
    CERTIFIED_OPEN,
    NOT_CERTIFIED,
    NOT_READY,
)
from SDFStentLib.plan import value_at, value_in_use
from SDFStentLib.report import WARNING
from SDFStentLib.validation import one_line, printable

from . import Charts, Conversion, Flow, FormerScenes, Showing, Tiles
from .PanelParts import cut, tellOnce
from .ParameterNode import methodOf, stentOf, stentsOf
from .PlanFields import DEFAULTS, METHOD, METHOD_PARAMETERS, Placement

LONGEST = 44
"""Characters of a heading: the panel is as wide as its widest one."""


class Steps:
    """Writes the headings, and closes the first step at the choice that ends it.

    Not later: by then the mouse may be on its way to what lies below.
    """

    def __init__(self, ui):
        self._ui, self._isDone = ui, False

    def show(self, parameterNode):
        """Follow changes of parameters."""
        vessel, centerline = parameterNode.vessel, parameterNode.centerline
        isDone = Conversion.hasWall(vessel) and Conversion.hasLines(centerline)
        if isDone != self._isDone:
            self._isDone = self._ui.inputsCollapsibleButton.collapsed = isDone
        names = [] if vessel is centerline is None else [_nameOf(vessel), _nameOf(centerline)]
        hasStents = len(stentsOf(parameterNode)) > 0
        stent = stentOf(parameterNode)
        for name, title, words in (
            ("inputs", _("Vessel"), ", ".join(names)),
            ("place", _("Place"), stent.placement.label() if hasStents else ""),
            ("device", _("Device"), _deviceWords(stent)),
            ("shape", _("Shape"), "" if stent.draft.shape is None else _("as set")),
            ("advanced", _("Advanced"), "" if _isUsual(parameterNode) else _("changed")),
            ("flow", _("Flow"), _flowWords(parameterNode)),
        ):
            text = f"{title}: {one_line(words)}" if words else title
            getattr(self._ui, f"{name}CollapsibleButton").text = cut(text, LONGEST)


def _nameOf(node):
    return _("none") if node is None else node.GetName()


def _deviceWords(stent):
    name = "" if stent.device is None else stent.device["name"]
    return ", ".join(filter(None, [name, _("on a balloon") if stent.balloon is not None else ""]))


def _isUsual(parameterNode):
    return all(
        parameterNode.get(one.path) == value_at(DEFAULTS, one.path) for one in METHOD.values()
    )


def _flowWords(parameterNode):
    mean, inlets = parameterNode.flowMean, len(Flow.flowsIn(parameterNode))
    if not mean > 0:
        return ""
    at = _(" at {count} inlets").format(count=inlets) if inlets > 1 else ""
    return _("{mean:g} L/min").format(mean=round(mean, 2)) + at


SAID_MS = 10_000
"""The milliseconds for which the application's status bar shows what the panel says below *Deploy*."""

PENDING, GOOD, BAD = "pending", "good", "bad"
KINDS = {
    **dict.fromkeys((CERTIFIED, CERTIFIED_IN_PIECES, CERTIFIED_OPEN), GOOD),
    **dict.fromkeys((NOT_READY, NOT_CERTIFIED), BAD),
}
"""Kinds by the last line of what stands beside a stent, without a warning."""
COLORS = {PENDING: (0.85, 0.87, 0.90), GOOD: (0.62, 0.93, 0.66), BAD: (1.0, 0.72, 0.45)}
"""Colors on `BACKGROUND`, which lets them be read on any view. What a color says stands in one of the lines, too."""
BACKGROUND = (0.08, 0.10, 0.13)
"""Opaque background: letters of the view's axes would be read as some of the lines."""
LARGEST_FONT = 18
LONGEST_ROW = 52
"""Characters: a view of four on a small screen is as wide. A longer row is cut there, after all letters have shrunk for it."""


def _kindOf(lines, isCaution):
    """Kind of the lines: a warning prevails over the certificate, also while a hand still moves."""
    isWarned = isCaution or any(line.startswith(WARNING) for line in lines)
    return BAD if isWarned else KINDS.get(lines[-1], PENDING)


def _inRows(text):
    """Lines, long ones in several rows."""
    rows = [textwrap.wrap(line, LONGEST_ROW, subsequent_indent="  ") for line in text.split("\n")]
    return "\n".join(row for line in rows for row in line)


class AtHand:
    """Shows lines in all 3D views. `text` is what is shown, `kind` one of `COLORS`; `angles` is from where one looks."""

    def __init__(self):
        self.text, self.kind, self.angles = "", PENDING, ""

    def showAngles(self, text):
        """Show from where one looks, line by line, in another corner."""
        self.angles = text
        self.write()

    def show(self, text, instead="", isCaution=False):
        """Show lines; `instead` of the last what else is to be known of them, where something is.

        `isCaution` says whether any of the panel's tiles is one: both have the same color then.
        """
        lines = text.split("\n")
        if text and instead:
            lines[-1] = instead
        self.text, self.kind = "\n".join(lines), PENDING if instead else _kindOf(lines, isCaution)
        self.write()

    def write(self):
        """Write the lines into the views that do not show them yet, as those of another layout."""
        rows = _inRows(self.text)
        for view in Showing.threeDViews():
            corner = view.cornerAnnotation()
            font, color = corner.GetTextProperty(), COLORS[self.kind]
            texts = {
                vtkCornerAnnotation.UpperLeft: rows,
                vtkCornerAnnotation.UpperRight: self.angles,
            }
            isShown = all((corner.GetText(at) or "") == text for at, text in texts.items())
            if isShown and (not any(texts.values()) or font.GetColor() == color):
                continue
            corner.SetMaximumFontSize(LARGEST_FONT)
            for at, text in texts.items():
                corner.SetText(at, text)
            font.SetColor(*color)
            font.BoldOn()  # thin letters are hard to read from where an operator stands
            font.ShadowOff()
            font.SetBackgroundColor(*BACKGROUND)
            font.SetBackgroundOpacity(1.0 if self.text or self.angles else 0.0)
            view.scheduleRender()


METHOD_SLIDERS = {
    f"{field}Slider": field
    for field, (name, one) in METHOD_PARAMETERS.items()
    if one.unit and not one.is_optional
}
"""Sliders of the lengths of the method, by widget."""


class PanelState:
    """Brings the widgets into line with the parameters, the logic and the session."""

    def __init__(self, ui, logic, session, size):
        self.ui = ui
        self._logic, self._session, self._size = logic, session, size
        self.atHand, self.steps, self._told = AtHand(), Steps(ui), ("", "")
        self._tiles, self._toldOf = Tiles.TilesLabel(ui.tilesLabel), (None,)
        self._usualReach = {name: getattr(ui, name).maximum for name in METHOD_SLIDERS}

    def show(self, parameterNode):
        """Follow changes of parameters."""
        hasStents = len(stentsOf(parameterNode)) > 0
        self.ui.placeWidget.setCurrentNode(stentOf(parameterNode).handle if hasStents else None)
        self.steps.show(parameterNode)
        self._reach(parameterNode)
        self.enable(parameterNode)
        self._logic.updateDisplay(parameterNode)

    def _reach(self, parameterNode):
        """Set the ends of sliders, for this vessel or as designed, and beyond where the value is."""
        stent, method = stentOf(parameterNode), methodOf(parameterNode)
        diameter, length = self._logic.sizeLimits(parameterNode)
        _letReach(self.ui.diameterSlider, diameter, stent.diameter)
        _letReach(self.ui.lengthSlider, length, stent.draft.length)
        _letReach(
            self.ui.balloonSlider,
            self.ui.diameterSlider.maximum,
            value_in_use(stent.draft, "balloon.diameter"),
        )
        for name, parameter in METHOD_SLIDERS.items():
            _letReach(getattr(self.ui, name), self._usualReach[name], getattr(method, parameter))

    def enable(self, parameterNode, standing=None):
        """Enable the widgets that can be used now; `standing` is that of the parameter node, where it was just asked for."""
        if parameterNode is None:
            return
        running, count = self._session.isRunning, len(stentsOf(parameterNode))
        standing, hasSteps = (
            standing or self._logic.standing(parameterNode),
            self._logic.hasSteps(parameterNode),
        )
        missing, isDeploying = standing.missing, running and not self._session.isPreview
        self.ui.deployButton.enabled = not missing and not isDeploying
        self.ui.deployButton.toolTip = missing or _(
            "Expand the stents and show the stented vessel."
        )
        self.ui.cancelButton.enabled = self._session.mayBeCancelled
        self.ui.progressBar.visible = isDeploying
        self.ui.beforeButton.enabled = self.ui.expansionSlider.enabled = hasSteps and not running
        isBefore = hasSteps and not running and parameterNode.expansion <= 0
        self.ui.beforeButton.text = _("After") if isBefore else _("Before")
        self.ui.stentEditor.enabled = self.ui.stentDetails.enabled = count > 0
        stent = stentOf(parameterNode)
        self.ui.wholeCurveCheckBox.visible = stent.placement == Placement.ALONG_CURVE
        device, isByDevice = stent.device, stent.deviceShortening
        self.ui.lengthSlider.enabled = stent.draft.has_free_length
        isKnown = device is not None or stent.placement == Placement.AGAIN
        isAsked = stent.draft.asks_for_shortening
        self.ui.foreshorteningSlider.enabled = isAsked or not (isKnown and isByDevice)
        self.ui.addStentButton.enabled = (
            parameterNode.vessel is not None or parameterNode.centerline is not None
        )
        self.ui.extractButton.enabled = parameterNode.vessel is not None
        for name in ("copyStentButton", "removeStentButton", "zoomButton"):
            getattr(self.ui, name).enabled = count > 0
        self.ui.moveUpButton.enabled = parameterNode.selected > 0
        self.ui.moveDownButton.enabled = 0 <= parameterNode.selected < count - 1
        self.ui.savePlanButton.enabled = not missing
        self.ui.showPlotButton.enabled = parameterNode.outputChart is not None
        self.ui.showTableButton.enabled = parameterNode.outputTable is not None
        self.ui.warningLabel.visible = bool(parameterNode.warningSummary)
        self._tell(parameterNode, standing, isBefore)

    def _tell(self, parameterNode, standing, isBefore):
        """The line below Deploy; results that no longer belong to the plan are said to be old, unless they are renewed anyway."""
        isRenewed = self._session.isRenewing(standing)
        isOld = not isRenewed and self._logic.hasChanged(parameterNode, standing)
        tiles = Tiles.tilesOf(parameterNode)
        hasResult = bool(parameterNode.lumenSummary)
        self._tiles.show(tiles, parameterNode.lumenSummary)
        self.ui.tilesLabel.visible = hasResult
        self.ui.detailsCollapsibleButton.visible = hasResult
        # In words: gray text is hardly legible in a dark style.
        self.ui.oldLabel.visible = isOld and hasResult
        changed = (
            _("Changed since this deployment.")
            if standing.missing
            else _("Changed since this deployment; click Deploy.")
        )
        if parameterNode.outputChart is not None:
            isTold = bool(parameterNode.certificateSummary)
            Charts.fadeChart(parameterNode.outputChart, isOld or not isTold)
        instead = _("seen before the stents") if isBefore else ""
        instead = _("changed since; not deployed yet") if isOld else instead
        self.atHand.show(parameterNode.atHand, instead, any(one.is_caution for one in tiles))
        told = standing.missing, parameterNode.status
        of = parameterNode, standing.signature, Flow.toldFlow(parameterNode)
        isAsBefore = told[1] == self._told[1] and parameterNode is self._toldOf[0]
        if (
            told[1]
            and isAsBefore
            and of != self._toldOf
            and not self._logic.isProposal(parameterNode)
        ):
            parameterNode.status = ""  # was said of the plan as it was; this has come here again
            return
        self._toldOf = of
        for sentence, former in zip(told, self._told, strict=True):
            if sentence != former:  # who asked from a section far below sees it, too
                slicer.util.showStatusMessage(sentence.rpartition("\n")[2], SAID_MS)
        self._told = told
        former = FormerScenes.toldOf(parameterNode)
        sentences = [standing.missing, former, parameterNode.status, changed if isOld else ""]
        self.ui.statusLabel.text = printable("\n".join(filter(None, sentences)))
        self.ui.statusLabel.visible = bool(self.ui.statusLabel.text)
        tellOnce(self.ui)
        self._size.fit()


def _letReach(slider, usual, value):
    """End a slider at `usual`, or behind a value beyond; the value had been cut to the former end."""
    wasBlocked = slider.blockSignals(True)
    slider.maximum = max(usual, math.ceil(value))
    slider.value = value
    slider.blockSignals(wasBlocked)
