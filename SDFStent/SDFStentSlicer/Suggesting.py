"""Stents by the library's rule of sizing, and how sizes compare with the lesion of a stent."""

from dataclasses import replace

import slicer

from SDFStentLib.report import proposal_sentence
from SDFStentLib.treatment import SizingWishes, Vessel, stent_ratios, suggested
from SDFStentLib.validation import InputError
from SDFStentLib.vessel import lesions_within

from . import Conversion, Handles, Plans, Sizes
from .ParameterNode import stentOf
from .PlanFields import Placement
from .Portions import inPortions, untilDone
from .StentList import StentList

KEPT = ("keeps", "shape", "may_be_shortened")
"""What a stent that is sized anew has further on."""


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
        """The same in portions: a generator that yields None until it is done."""
        isThere = self.lesionOf(parameterNode) is lesion and Handles.isOwn(
            parameterNode.stent.handle
        )
        wishes = _wishesOf(parameterNode, parameterNode.stent if isThere else None)
        number = self._numberOf(parameterNode, lesion)
        centerline = yield from self._inputs.centerlineInPortions(parameterNode)
        found = self._inputs.lesions(parameterNode).found
        surface = (yield from self._inputs.vesselInPortions(parameterNode)).surface
        suggestion = yield from inPortions(
            lambda: Vessel(surface, centerline).compared(
                suggested(lesion, number, centerline, wishes), found
            )
        )
        values = Plans.valuesOf(suggestion.stent)
        del values["name"]
        values["placement"] = Placement.of(values["placement"])
        if isThere:
            self._resize(parameterNode, values)
        else:
            self.addStent(parameterNode, **values)
        handle = parameterNode.stent.handle
        handle.SetNthControlPointPositionWorld(0, *suggestion.stent.placement.point)
        cautions = [caution.sentence() for caution in suggestion.cautions()]
        parameterNode.status = "\n".join([proposal_sentence(suggestion), *cautions])
        self._proposal = parameterNode.status, _proposed(parameterNode)
        return suggestion

    def isProposal(self, parameterNode):
        """Whether what is said is a proposal, and the stent still as it was proposed."""
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

    def _resize(self, parameterNode, values):
        """Give the selected stent other values, and its handle the points that its placement needs then."""
        values = {key: values[key] for key in values if key not in KEPT}
        with slicer.util.NodeModify(parameterNode):
            StentList(parameterNode).change(placement=values["placement"])
            self.fitHandle(parameterNode)
            StentList(parameterNode).change(**values)

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
        if lying is None:
            return None
        planned, axis = lying
        for lesion in lesions_within(search.found, axis.points):
            return lesion, stent_ratios(planned, lesion)
        return None


def _proposed(parameterNode):
    """The stent of which something is said: its place, diameter and length."""
    stent = stentOf(parameterNode)
    return Conversion.changeStamp(stent.handle), stent.diameter, stent.length, stent.placement


def _wishesOf(parameterNode, stent):
    """What the parameters say of a suggestion, with the device of a stent, where there is one."""
    wishes = SizingWishes(parameterNode.suggestRatio, parameterNode.suggestMargin)
    if stent is None:
        return wishes
    device = Sizes.deviceOf(stent)
    isOwn = device is not None and not stent.deviceShortening
    own = stent.entry["foreshortening_fraction"] if isOwn else None
    return replace(wishes, device=device, foreshortening_fraction=own)
