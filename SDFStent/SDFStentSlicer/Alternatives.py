"""Alternatives: several plans for one vessel, each a parameter set with stents, method and results of its own."""

from pathlib import Path

import slicer
from slicer.i18n import tr as _

from SDFStentLib.validation import InputError

from . import (
    Charts,
    Comparing,
    Conversion,
    Dependencies,
    Display,
    Handles,
    Showing,
)
from .Exporting import inNewFolder
from .Leavings import seenNodes
from .Portions import untilDone
from .StentList import StentList

COPIED = (
    "vessel",
    "segmentID",
    "centerline",
    "deviceTable",
    "suggestRatio",
    "suggestMargin",
    "map",
    "showStents",
    "showDevice",
    "showXray",
    "deviceMesh",
    "autoUpdate",
    "segmentEnds",
    "closeBranches",
    "plan",
)
"""Attributes that a copy of a plan takes over, besides copies of its handles; its results it has to make."""

HIDDEN_ATTRIBUTE = "SDFStent.HiddenWithPlan"
SHOWN_ATTRIBUTE = "SDFStent.ShownWithPlan"
LAST_ATTRIBUTE = "SDFStent.ShownLast"


class Alternatives:
    """A part of `SDFStentLogic`: the plans for a vessel beside each other.

    Which there are only the scene knows, so that it saves them, brings them back and forgets them like all else.
    """

    def alternatives(self, parameterNode):
        """Plans for the vessel of a parameter node, itself among them, in the order in which they were made."""
        vessel = parameterNode.vessel
        if vessel is None:
            return [parameterNode]
        segment = Conversion.segmentOf(parameterNode)
        sets = [self.parameterSet(node) for node in self.getAllParameterNodes()]
        return [
            one for one in sets if one.vessel is vessel and Conversion.segmentOf(one) == segment
        ]

    def duplicatePlan(self, parameterNode):
        """Duplicate a plan with its stents and their handles; returns the parameters of the copy."""
        copy = self.addParameterSet(self._freePlanName(parameterNode))
        with slicer.util.NodeModify(copy):
            for name in COPIED:
                setattr(copy, name, getattr(parameterNode, name))
            StentList(copy).replace(_withOwnHandles(parameterNode), parameterNode.selected)
        return copy

    def loadPlans(self, paths, parameterNode):
        """Add a plan per plan document, called as its file; the first one takes the place of a plan without stents.

        Returns the parameters of the last one. What cannot be read is refused before anything is kept of it.
        """
        last = parameterNode
        for path in paths:
            last = self._loadInto(path, parameterNode)
        return last

    def _loadInto(self, path, parameterNode):
        isEmpty = not parameterNode.stents
        plan = parameterNode if isEmpty else self.addParameterSet(Path(path).stem)
        try:
            if not isEmpty:
                for name in ("vessel", "segmentID", "centerline", "autoUpdate"):
                    setattr(plan, name, getattr(parameterNode, name))
            self.loadPlan(path, plan)
        except Exception:
            if not isEmpty:
                slicer.mrmlScene.RemoveNode(plan.parameterNode)
            raise
        plan.parameterNode.SetName(self._freePlanName(plan, Path(path).stem))
        return plan

    def renamePlan(self, parameterNode, name):
        """Call a plan otherwise; `InputError` for no name, or that of another plan for the vessel."""
        name = name.strip()
        if not name:
            raise InputError(_("Plan: expected a name, got none; type one."))
        if name in self._namesBeside(parameterNode):
            raise InputError(
                _(
                    "Plan: expected a name of its own, another plan is called {name}, too; choose another one."
                ).format(name=name)
            )
        parameterNode.parameterNode.SetName(name)
        Display.nameFolder(parameterNode)

    def markShown(self, parameterNode):
        """Let the scene remember which plan is shown; none with None."""
        shown = None if parameterNode is None else parameterNode.parameterNode
        for node in self.getAllParameterNodes():
            if (node is shown) != (node.GetAttribute(LAST_ATTRIBUTE) is not None):
                node.SetAttribute(LAST_ATTRIBUTE, "1" if node is shown else None)

    def markedPlan(self):
        """The node of the plan that was shown last, as the scene remembers it; None where it does not."""
        nodes = self.getAllParameterNodes()
        return next((node for node in nodes if node.GetAttribute(LAST_ATTRIBUTE)), None)

    def planAfterImport(self, shown, before):
        """The node of the plan to show after an import, of that shown and those there before; None for none.

        A plan for which nothing was chosen yet, as the panel makes one for an empty scene, is removed where another can be shown.
        """
        nodes = self.getAllParameterNodes()
        if shown in nodes and not self._isBlank(shown):
            return shown
        came = [node for node in nodes if node not in before]
        full = [node for node in came if not self._isBlank(node)]
        marked = self.markedPlan()
        kept = marked if marked in full else next(iter(full), shown)
        if kept in nodes:
            for node in {shown, *came}.intersection(nodes) - {kept, *full}:
                slicer.mrmlScene.RemoveNode(node)
        return kept

    def nameApart(self, before):
        """Give plans that an import has brought names of their own, of the plans there `before` and one another."""
        nodes = self.getAllParameterNodes()
        for node in nodes:
            others = [other.GetName() for other in nodes if other is not node]
            if node not in before and node.GetName() in others:
                node.SetName(Handles.freeName(node.GetScene(), node.GetName()))

    def _isBlank(self, node):
        plan = self.parameterSet(node)
        return plan.vessel is None and plan.centerline is None and not len(plan.stents)

    def showPlan(self, parameterNode):
        """Show the nodes of a plan, and hide those of other plans only, of whatever vessel: the mouse takes the node it lies on.

        Another vessel and its lines are hidden, too, where this plan has its own.
        Only what was hidden in this way is shown again: who hides a result himself finds it hidden.
        """
        sets = [self.parameterSet(node) for node in self.getAllParameterNodes()]
        others = [one for one in sets if one is not parameterNode]
        own = seenNodes(parameterNode)
        for node in (node for other in others for node in seenNodes(other)):
            if node not in own:
                Showing.changeOver(node, HIDDEN_ATTRIBUTE, False)
        for node in own:
            Showing.changeBack(node, HIDDEN_ATTRIBUTE, True)
        beside = [one for one in self.alternatives(parameterNode) if one is not parameterNode]
        _showVessel(parameterNode, any(other.outputVessel is not None for other in beside))
        chosen = parameterNode.vessel, parameterNode.centerline
        for other in others:
            Showing.inPlaceOf((other.vessel, other.centerline), chosen)
            Showing.followPlan(other, parameterNode)
            if other.outputChart is not None:
                Charts.fadeChart(other.outputChart, True)

    def compare(self, parameterNode, folder):
        """Carry out all plans for the vessel and write them side by side into a new folder in `folder`.

        Returns the path of the page, that of `sdfstent compare`. Errors are those of a deployment.
        """
        return untilDone(self.comparisonSteps(parameterNode, folder))

    def comparisonSteps(self, parameterNode, folder):
        """Comparison in portions: an iterator over the fraction done, which returns the path."""
        plans = {}
        for one in self.alternatives(parameterNode):
            name = one.parameterNode.GetName()
            if missing := Dependencies.missing(one):
                raise InputError(f"{name}: {missing}")
            if name in plans:
                raise InputError(
                    _(
                        "Compare: expected plans of different names, two are called {name}; rename one."
                    ).format(name=name)
                )
            plans[name] = one
        return inNewFolder(folder, "comparison", lambda new: Comparing.steps(plans, new))

    def _namesBeside(self, parameterNode):
        beside = [one for one in self.alternatives(parameterNode) if one is not parameterNode]
        return {one.parameterNode.GetName() for one in beside}

    def _freePlanName(self, parameterNode, wanted=""):
        """Wanted name, or the plan's, with a number behind it while another plan has it."""
        names = self._namesBeside(parameterNode)
        if wanted and wanted not in names:
            return wanted
        names.add(parameterNode.parameterNode.GetName())
        stem = wanted or _("Plan")
        number = 2
        # Ends: there are finitely many names.
        while f"{stem} {number}" in names:
            number += 1
        return f"{stem} {number}"


def _withOwnHandles(parameterNode):
    """The stents of a plan as dictionaries, with copies of their handles."""
    stents, copies = StentList(parameterNode).values(), {None: None}
    for values in stents:
        handle = values["handle"]
        if handle not in copies:  # one that dilates another again has the same
            copies[handle] = Handles.copyHandle(handle, values["name"])
        values["handle"] = copies[handle]
    return stents


def _showVessel(parameterNode, othersDeployed):
    """The vessel itself while a plan has no result in its place, as others have."""
    vessel, segment = parameterNode.vessel, Conversion.segmentOf(parameterNode)
    if vessel is None:
        return
    if parameterNode.outputVessel is not None:
        Showing.changeBack(vessel, SHOWN_ATTRIBUTE, False, segment)
    elif othersDeployed:
        Showing.changeOver(vessel, SHOWN_ATTRIBUTE, True, segment)
