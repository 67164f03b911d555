"""Output nodes of a parameter set: only those that were made for it."""

import slicer

ATTRIBUTE = "SDFStent.Output"
"""Attribute of every model that was made for results: its role."""


def isUsable(parameterNode, role, node):
    """Whether a node was made for results of this role, is no input of the parameter set, and no other set writes into
    it."""
    return (
        node is not None
        and node.GetAttribute(ATTRIBUTE) == role
        and node not in (parameterNode.vessel, parameterNode.centerline)
        and node.GetID() not in takenIDs(parameterNode, role)
    )


def takenIDs(parameterNode, role):
    """IDs of the nodes that other parameter sets in the scene write results of this role into."""
    own = parameterNode.parameterNode
    sets = slicer.util.getNodesByClass("vtkMRMLScriptedModuleNode", own.GetScene())
    return [
        nodeID
        for node in sets
        if node is not own
        for name in map(node.GetNthNodeReferenceRole, range(node.GetNumberOfNodeReferenceRoles()))
        if name.split(".")[0] == role and (nodeID := node.GetNodeReferenceID(name))
    ]
