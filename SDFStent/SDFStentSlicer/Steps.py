"""The headings of the panel: what is set in a part that is closed stands in its heading."""

from slicer.i18n import tr as _

from SDFStentLib.validation import one_line

from . import Sizes
from .ParameterNode import MethodParameters, methodOf, stentOf, stentsOf

LONGEST = 44
"""Characters of a heading: the panel is as wide as its widest one."""


class Steps:
    """Writes the headings, and closes the first step once it is known that vessel and centerline can be used."""

    def __init__(self, ui):
        self._ui, self._isDone = ui, False

    def closeFirst(self):
        """Vessel and centerline can be used: their step is done, until one of them is taken away."""
        if not self._isDone:
            self._isDone = self._ui.inputsCollapsibleButton.collapsed = True

    def show(self, parameterNode):
        """After parameters have changed."""
        vessel, centerline = parameterNode.vessel, parameterNode.centerline
        if self._isDone and (vessel is None or centerline is None):
            self._isDone = self._ui.inputsCollapsibleButton.collapsed = False
        names = [node.GetName() for node in (vessel, centerline) if node is not None]
        hasStents = len(stentsOf(parameterNode)) > 0
        stent = stentOf(parameterNode)
        details = Sizes.detailsOf(stent)
        for name, title, words in (
            ("inputs", _("Vessel"), ", ".join(names)),
            ("place", _("Place"), stent.placement.label() if hasStents else ""),
            ("device", _("Device"), _deviceWords(details)),
            ("shape", _("Shape"), "" if details.shape is None else _("as set")),
            ("advanced", _("Advanced"), "" if _isUsual(parameterNode) else _("changed")),
            ("flow", _("Flow"), _flowWords(parameterNode)),
        ):
            text = f"{title}: {one_line(words)}" if words else title
            getattr(self._ui, f"{name}CollapsibleButton").text = _cut(text)


def _deviceWords(details):
    name = details.device.name if details.device is not None else ""
    return ", ".join(filter(None, [name, _("on a balloon") if details.balloon is not None else ""]))


def _isUsual(parameterNode):
    method, usual = methodOf(parameterNode), MethodParameters()
    return all(
        getattr(method, name) == getattr(usual, name) for name in MethodParameters.allParameters
    )


def _flowWords(parameterNode):
    mean = parameterNode.flowMean
    return _("{mean:g} L/min").format(mean=mean) if mean > 0 else ""


def _cut(text):
    return text if len(text) <= LONGEST else text[: LONGEST - 1] + "\N{HORIZONTAL ELLIPSIS}"
