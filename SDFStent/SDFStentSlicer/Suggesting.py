"""Stents by the library's rule of sizing, and how sizes compare with the lesion of a stent."""

import slicer

from SDFStentLib.plan import Draft, Row, wishes_of
from SDFStentLib.report import proposal_sentence
from SDFStentLib.validation import InputError

from . import Conversion, Handles
from .ParameterNode import stentOf
from .Portions import inPortions, untilDone
from .StentList import StentList

KEPT = ("name", "keeps", "shape", "may_be_shortened", "redilation")
"""Values of its entry that a stent keeps when it is sized anew."""


class Suggesting:
    """A part of `SDFStentLogic`. `self._inputs` are the logic's `Inputs`."""

    _proposal = None

    def suggestStent(self, parameterNode, lesion):
        """Size a stent for a lesion by the library's rule and place it there; what it says of that is in `status` afterward.

        The selected stent where that covers the lesion by a handle of ours, with its device and shape, and else a new one. Returns
        the library's `Suggestion`.
        """
        return untilDone(self.suggestionInPortions(parameterNode, lesion))

    def suggestionInPortions(self, parameterNode, lesion):
        """Suggestion in portions: a generator that yields None until it is done."""
        isThere = self.lesionOf(parameterNode) is lesion and Handles.isOwn(
            parameterNode.stent.handle
        )
        draft = parameterNode.stent.draft if isThere else Draft({})
        wishes = wishes_of(draft, parameterNode.suggestRatio, parameterNode.suggestMargin)
        number = self._numberOf(parameterNode, lesion)
        search = self._inputs.lesions(parameterNode)
        suggestion = yield from inPortions(lambda: search.vessel.suggestion(number, wishes))
        row = Row(suggestion.stent)
        if isThere:
            self._resize(parameterNode, row)
        else:
            self.addRow(parameterNode, row)
        cautions = [caution.sentence() for caution in suggestion.cautions()]
        parameterNode.status = "\n".join([proposal_sentence(suggestion), *cautions])
        self._proposal = parameterNode.status, _proposed(parameterNode)
        return suggestion

    def isProposal(self, parameterNode):
        """Whether the words are a proposal, and the stent still as proposed."""
        return self._proposal == (parameterNode.status, _proposed(parameterNode))

    def _numberOf(self, parameterNode, lesion):
        """The number of a lesion among those of the vessel, from 1."""
        found = self._inputs.lesions(parameterNode).found or ()
        for number, one in enumerate(found, start=1):
            if one is lesion:
                return number
        raise InputError(
            "lesion: expected one that was found in this vessel, got another; look for them again."
        )

    def _resize(self, parameterNode, row):
        """Give the selected stent other values, and its handle the point of its placement then."""
        values = {key: value for key, value in row.entry.items() if key not in KEPT}
        with slicer.util.NodeModify(parameterNode):
            StentList(parameterNode).change(placement=values["placement"])
            self.fitHandle(parameterNode)
            StentList(parameterNode).change(**values)
        parameterNode.stent.handle.SetNthControlPointPositionWorld(0, *row.points[0])

    def lesionOf(self, parameterNode):
        """The tightest lesion that the selected stent covers; None without one, or before they were looked for."""
        known = self.ratios(parameterNode)
        return None if known is None else known[0]

    def ratios(self, parameterNode):
        """The selected stent's lesion, as of `lesionOf`, and its `SizeRatios` to it; None without one."""
        search = self.lesionSearch(parameterNode)
        if search is None or not search.found:
            return None
        lying = self.lying(parameterNode, self._inputs.centerline(parameterNode))
        return lying and search.vessel.ratios(lying)


def _proposed(parameterNode):
    """The stent of which something is said: its place, diameter and length."""
    stent = stentOf(parameterNode)
    return Conversion.changeStamp(stent.handle), stent.diameter, stent.length, stent.placement
