"""Handles and results that go along when the transform of a centerline, or of a vessel without one, changes."""

import numpy as np
from slicer.i18n import tr as _
from vtkmodules.vtkCommonMath import vtkMatrix4x4

from . import Conversion, Handles, Plans
from .ParameterNode import stentsOf
from .Transforms import matrixToWorld

CARRIED_ROLES = ("outputVessel", "outputCenterline", "outputStents")
"""Results lie in world coordinates, below no transform."""


class Carrying:
    """Knows where centerlines and vessels were. What changes of their content, as where a transform is hardened, moves nothing."""

    def __init__(self):
        self._known = {}

    def follow(self, parameterNode, plans):
        """Move the handles and places of all `plans` along with the node that they belong to; `status` then tells what stayed behind.

        Returns whether it was elsewhere before.
        """
        node = parameterNode.centerline or parameterNode.vessel
        if node is None:
            return False
        content, matrix = Conversion.contentOf(node), matrixToWorld(node)
        former, self._known[node.GetID()] = self._known.get(node.GetID()), (content, matrix)
        if former is None or former[0] != content or _isSame(former[1], matrix):
            return False
        change = _change(former[1], matrix)
        for plan in plans:
            if node is (plan.centerline or plan.vessel):
                _carry(plan, change, node)
        return True


def _isSame(former, matrix):
    if former is None or matrix is None:
        return former is matrix
    return np.allclose(former, matrix, rtol=0, atol=1e-9)


def _change(former, matrix):
    """The transform (4, 4) from where a node was to where it is; None where one of both is not known, or flattens space."""
    if former is None or matrix is None or abs(np.linalg.det(former)) < 1e-9:
        return None
    return matrix @ np.linalg.inv(former)


def _carry(plan, change, node):
    left = []

    def moved(points):
        return points @ change[:3, :3].T + change[:3, 3]

    if change is not None:
        Plans.moveMarks(plan, moved)
    for handle in dict.fromkeys(stent.handle for stent in stentsOf(plan)):
        if handle is None or handle.GetParentTransformNode() is not None:
            continue  # it has gone along by itself, or not as it was meant to
        if change is None or not handle.GetAttribute(Handles.HANDLE_ATTRIBUTE):
            left.append(handle.GetName())
        else:
            points = np.array(Conversion.placedPoints(handle)).reshape(-1, 3)
            Handles.placeAt(handle, moved(points))
    results = [getattr(plan, role) for role in CARRIED_ROLES] if change is not None else []
    for result in filter(None, results):
        result.ApplyTransformMatrix(_vtk(change))
    if left:
        plan.status = _(
            "{name} was moved by its transform; where they were are still: {left}. Move them, or put them below that transform."
        ).format(name=node.GetName(), left=", ".join(left))


def _vtk(matrix):
    result = vtkMatrix4x4()
    result.DeepCopy(matrix.ravel().tolist())
    return result
