"""Nodes that a plan has made in the scene, and what goes with it when the plan or its results are removed."""

from typing import Any, NamedTuple

import slicer

from . import Conversion, Display, Handles, Outputs, Results, Showing

SEEN_ROLES = ("outputVessel", "outputCenterline", "outputStents")


class Leavings(NamedTuple):
    """Nodes that a plan has made in a scene, and the item of their folder, 0 without; and the vessel, or its segment, that it was for."""

    scene: Any
    nodes: list
    folder: int
    vessel: Any
    segment: str


class Removing:
    """A part of `SDFStentLogic`: removes plans and their results, but nothing that another plan uses."""

    def removePlan(self, parameterNode):
        """Remove a plan with its results and the handles that were made for it; what other plans use stays."""
        leavings = self.leavings(parameterNode)
        parameterNode.parameterNode.GetScene().RemoveNode(parameterNode.parameterNode)
        self.removeLeavings(leavings)

    def leavings(self, parameterNode):
        """The `Leavings` of a plan when its parameters are removed, for `removeLeavings` then."""
        scene = parameterNode.parameterNode.GetScene()
        vessel = (parameterNode.vessel, Conversion.segmentOf(parameterNode))
        return Leavings(scene, _ownNodes(parameterNode), _folderOf(parameterNode), *vessel)

    def removeLeavings(self, leavings):
        """Remove nodes of a plan that no other one uses; the vessel is seen again where it has no plan any more."""
        plans = [self.parameterSet(node) for node in self.getAllParameterNodes()]
        kept = [used for plan in plans for used in (*_ownNodes(plan), plan.vessel, plan.centerline)]
        for one in leavings.nodes:
            if one not in kept and one.GetScene() is not None:
                Handles.removeWhole(one)
        hierarchy = slicer.vtkMRMLSubjectHierarchyNode.GetSubjectHierarchyNode(leavings.scene)
        if leavings.folder and not hierarchy.GetNumberOfItemChildren(leavings.folder):
            hierarchy.RemoveItem(leavings.folder)
        shown = [(plan.vessel, Conversion.segmentOf(plan)) for plan in plans if plan.outputVessel]
        if leavings.vessel is not None and (leavings.vessel, leavings.segment) not in shown:
            Showing.setShown(leavings.vessel, True, leavings.segment)

    def removeResults(self, parameterNode):
        """Remove the results of a plan without stents: the vessel is seen as it is again."""
        leavings = self.leavings(parameterNode)
        self.forgetRun(parameterNode)
        with slicer.util.NodeModify(parameterNode):
            for role in Display.OUTPUT_ROLES:
                setattr(parameterNode, role, None)
            Results.clearNumbers(parameterNode)
        self.removeLeavings(leavings)
        self.showPlan(parameterNode)


def seenNodes(parameterNode):
    """Nodes of a plan that are seen in the views: results, and handles that were made for it."""
    results = [getattr(parameterNode, role) for role in SEEN_ROLES]
    handles = [stent.handle for stent in parameterNode.stents]
    made = [node for node in handles if node and node.GetAttribute(Handles.HANDLE_ATTRIBUTE)]
    return [node for node in (*results, *made) if node is not None]


def _ownNodes(parameterNode):
    """Nodes that a plan has made in the scene."""
    chart = parameterNode.outputChart
    count = 0 if chart is None else chart.GetNumberOfPlotSeriesNodes()
    found = [
        *seenNodes(parameterNode),
        parameterNode.outputTable,
        parameterNode.outputTexts,
        *(chart.GetNthPlotSeriesNode(index) for index in range(count)),
        chart,
    ]
    return [
        node
        for node in found
        if node is not None
        and not (node.IsA("vtkMRMLModelNode") and node.GetAttribute(Outputs.ATTRIBUTE) is None)
    ]


def _folderOf(parameterNode):
    """The item of the folder with the plan's results; 0 without one."""
    node = parameterNode.outputVessel
    return 0 if node is None else Display.resultsFolder(node)
