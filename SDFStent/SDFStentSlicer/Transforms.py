"""Transform of a node to world coordinates."""

import numpy as np
import slicer
from vtkmodules.vtkCommonMath import vtkMatrix4x4
from vtkmodules.vtkCommonTransforms import vtkGeneralTransform
from vtkmodules.vtkFiltersGeneral import vtkTransformPolyDataFilter

from SDFStentLib.validation import InputError


def checkTransform(node):
    """Refuse a transform that cannot be inverted; `InputError` with a sentence."""
    transform = node.GetParentTransformNode()
    if transform is None or not transform.IsTransformToWorldLinear():
        return
    matrix = vtkMatrix4x4()
    transform.GetMatrixTransformToWorld(matrix)
    if abs(matrix.Determinant()) < 1e-9:
        raise InputError(
            f"{node.GetName()}: expected a transform that can be inverted, got {transform.GetName()}, which flattens space; "
            "change or remove the transform."
        )


def toWorld(node, polyData):
    """The polydata of a node in world coordinates; itself without a transform."""
    transform = node.GetParentTransformNode()
    if transform is None:
        return polyData
    way = vtkGeneralTransform()
    slicer.vtkMRMLTransformNode.GetTransformBetweenNodes(transform, None, way)
    mover = vtkTransformPolyDataFilter()
    mover.SetTransform(way)
    mover.SetInputData(polyData)
    mover.Update()
    return mover.GetOutput()


def scaleToWorld(node):
    """The factor by which the transform of a node makes it larger; None for one that changes its form, so that no radius is known."""
    transform = node.GetParentTransformNode()
    if transform is None:
        return 1.0
    if not transform.IsTransformToWorldLinear():
        return None
    matrix = vtkMatrix4x4()
    transform.GetMatrixTransformToWorld(matrix)
    scales = np.linalg.svd(_array(matrix)[:3, :3], compute_uv=False)
    return float(scales[0]) if np.allclose(scales, scales[0], rtol=1e-3) else None


def matrixToWorld(node):
    """Matrix (4, 4) of a node to world coordinates; None for a transform that is not linear."""
    transform, matrix = node.GetParentTransformNode(), vtkMatrix4x4()
    if transform is not None:
        if not transform.IsTransformToWorldLinear():
            return None
        transform.GetMatrixTransformToWorld(matrix)
    return _array(matrix)


def _array(matrix):
    return np.array([[matrix.GetElement(row, column) for column in range(4)] for row in range(4)])
