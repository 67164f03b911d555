"""Scene to library: the only place where nodes become arrays, and where frames are settled.

Everything handed to the library is in world coordinates (RAS, mm), whatever transforms the nodes are under.
"""

import tempfile
from itertools import pairwise
from pathlib import Path

import numpy as np
import slicer
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkIdList, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkPolyData

from SDFStentLib.centerline import Centerline
from SDFStentLib.files import (
    VOXEL_ARRAY,
    add_arrays,
    half_voxel,
    inscribed_radius_from_polydata,
    lines_from_polydata,
    surface_from_polydata,
    triangulated_polydata,
)
from SDFStentLib.units import MILLIMETERS
from SDFStentLib.validation import InputError

from . import Outputs
from .Transforms import checkTransform, scaleToWorld, toWorld

FILE_UNITS = "SDFStent.FileUnits"
"""Attribute of a model in mm whose file is in another unit."""


def vesselPolyData(node, segmentID=""):
    """The vessel's wall in world coordinates: a copy, the node is not changed. Cells are as they are in the node.

    Raises `InputError` with a sentence that names the node.
    """
    if node is None:
        raise InputError(
            "Vessel: expected a model or a segmentation, got none; select one in Vessel."
        )
    checkTransform(node)
    if node.IsA("vtkMRMLSegmentationNode"):
        surface = _segmentSurface(node, segmentID)
    else:
        surface = toWorld(node, _modelSurface(node))
    if surface.GetNumberOfPolys() + surface.GetNumberOfStrips() == 0:
        raise InputError(
            f"Vessel {node.GetName()}: expected a surface of triangles, got none; select another node."
        )
    copy = vtkPolyData()
    copy.DeepCopy(surface)
    return copy


def halfVoxel(node, segmentID=""):
    """Half the side of a cube as large as a voxel in world coordinates, mm, of a vessel that was made of voxels; None of another one."""
    if node.IsA("vtkMRMLSegmentationNode"):
        kind = slicer.vtkSegmentationConverter.GetSegmentationBinaryLabelmapRepresentationName()
        segmentation = node.GetSegmentation()
        isOfVoxels = segmentation.GetSourceRepresentationName() == kind
        image = segmentation.GetSegment(segmentID).GetRepresentation(kind) if isOfVoxels else None
        half = None if image is None else half_voxel(image.GetSpacing())
    else:
        array = node.GetPolyData().GetFieldData().GetArray(VOXEL_ARRAY)
        half = None if array is None else half_voxel(vtk_to_numpy(array))
    scale = scaleToWorld(node)
    return None if half is None or scale is None else scale * half


def stentMesh(node):
    """A straight stent mesh of the user's as the library's `Surface`, in world coordinates; `InputError` with a sentence."""
    name = f"Stent mesh {node.GetName()}"
    polyData = node.GetPolyData()
    count = 0 if polyData is None else polyData.GetNumberOfPolys() + polyData.GetNumberOfStrips()
    if count == 0 or node.GetAttribute(Outputs.ATTRIBUTE) is not None:
        got = "a result of this module" if count else "none"
        raise InputError(
            f"{name}: expected a surface of your own, got {got}; select another model."
        )
    checkTransform(node)
    return surface_from_polydata(
        triangulated_polydata(toWorld(node, polyData), name).polydata, name
    )


def segmentOf(parameterNode):
    """Id of the segment that is the vessel; "" while the vessel is not a segmentation, whatever was chosen before."""
    vessel = parameterNode.vessel
    isSegmentation = vessel is not None and vessel.IsA("vtkMRMLSegmentationNode")
    return parameterNode.segmentID if isSegmentation else ""


def centerlineOf(node):
    """The library's centerline of a model, a curve, or a curve with its branches below it in the subject hierarchy."""
    return Centerline.from_lines(*centerlineLines(node))


def centerlineLines(node):
    """Points in world coordinates, lines of them and radii or None: what `Centerline.from_lines` makes a centerline of."""
    if node is None:
        raise InputError(
            "Centerline: expected a model or a markups curve, got none; select one in Vessel."
        )
    checkTransform(node)
    if node.IsA("vtkMRMLModelNode"):
        return _linesOfModel(node)
    pieces = [curvePoints(curve) for curve in [node, *_branchCurves(node)]]
    starts = np.cumsum([0] + [len(p) for p in pieces])
    lines = [np.arange(a, b) for a, b in pairwise(starts)]
    # A curve's measurement "Radius" may be shifted by one sample (VTK 9.3 and later): measured on the wall instead.
    return np.concatenate(pieces), lines, None


def hasLines(node):
    """Whether a centerline can be made of a node: of any curve, and of a model of lines."""
    if node is None or not node.IsA("vtkMRMLModelNode"):
        return node is not None
    surface = node.GetPolyData()
    return surface is not None and surface.GetNumberOfLines() > 0


def hasWall(node):
    """Whether a vessel can be made of a node: of any segmentation, and of a model of polygons."""
    if node is None or not node.IsA("vtkMRMLModelNode"):
        return node is not None
    surface = node.GetPolyData()
    return surface is not None and surface.GetNumberOfPolys() + surface.GetNumberOfStrips() > 0


def curvePoints(node):
    """The points of a markups curve (n, 3), at least two."""
    count = len(placedIndices(node))
    if count < 2:
        raise InputError(
            f"Curve {node.GetName()}: expected at least two points, got {count}; place more points."
        )
    if count == node.GetNumberOfControlPoints():
        points = vtk_to_numpy(node.GetCurvePointsWorld().GetData())
    else:
        points = vtk_to_numpy(toWorld(node, _placedCurve(node)).GetPoints().GetData())
    return np.array(points, dtype=np.float64)


def handlePoints(node, count, label):
    """The first `count` placed points of a stent's handle, (count, 3)."""
    if node is None:
        raise InputError(
            f"{label}: expected a handle, got none; choose a point list or press Add again."
        )
    checkTransform(node)
    placed = placedPoints(node)
    if len(placed) < count:
        words = "one point" if count == 1 else f"{count} points"
        raise InputError(
            f"{label}: expected {words} in {node.GetName()}, got {len(placed)}; place them in a view."
        )
    return np.array(placed[:count])


def placedPoints(node):
    """Positions of the markups' points that were put somewhere; one that follows the mouse was not."""
    return [node.GetNthControlPointPositionWorld(index) for index in placedIndices(node)]


def placedIndices(node):
    """Indices of these points among all control points, in order."""
    return [
        index
        for index in range(node.GetNumberOfControlPoints())
        if node.GetNthControlPointPositionStatus(index) == slicer.vtkMRMLMarkupsNode.PositionDefined
    ]


def _placedCurve(node):
    """The curve through the placed points alone, in the node's own frame; the node's runs on to the mouse."""
    copy = node.CreateNodeInstance()
    copy.UnRegister(None)
    copy.CopyContent(node)
    placed = placedIndices(node)
    for index in reversed(range(node.GetNumberOfControlPoints())):
        if index not in placed:
            copy.RemoveNthControlPoint(index)
    return copy.GetCurve()


def fileFrame(node):
    """RAS or LPS: the frame of the file that a model is kept in, as it was read or written; None where there is none."""
    storage = node.GetStorageNode() if node is not None and node.IsA("vtkMRMLModelNode") else None
    if storage is None or not storage.GetFileName():
        return None
    return storage.GetCoordinateSystemTypeAsString(storage.GetCoordinateSystem())


def fileUnits(node):
    """The unit of the file that a model is kept in; mm, as Slicer reads and writes, unless something else is said of it."""
    return node.GetAttribute(FILE_UNITS) or "mm"


def bringToMillimeters(node, units):
    """Scale a model that was read from a file in another unit; it stays one that is as in its file."""
    polyData, scale = vtkPolyData(), MILLIMETERS[units]
    polyData.ShallowCopy(node.GetPolyData())
    points = vtkPoints()
    stored = vtk_to_numpy(polyData.GetPoints().GetData()).astype(np.float64)
    points.SetData(numpy_to_vtk(scale * stored, deep=True))
    polyData.SetPoints(points)
    radius = inscribed_radius_from_polydata(polyData)
    if radius is not None:
        # The name that is looked for first.
        add_arrays(polyData, {"MaximumInscribedSphereRadius": scale * radius}, None)
    node.SetAndObservePolyData(polyData)
    node.SetAttribute(FILE_UNITS, units)
    takeAsInFile(node)


def takeAsInFile(node):
    """Mark a model as in its file, though Slicer's reader did not read it."""
    storage = node.GetStorageNode()
    path = storage.GetFileName()
    with tempfile.TemporaryDirectory(prefix="sdfstent-") as folder:
        storage.SetFileName(str(Path(folder) / "model.vtp"))
        storage.WriteData(node)  # from now on it counts as unchanged
    storage.SetFileName(path)


def inputStamp(parameterNode):
    """A value that changes whenever the vessel or the centerline does."""
    vessel, centerline = map(changeStamp, (parameterNode.vessel, parameterNode.centerline))
    return vessel, segmentOf(parameterNode), centerline


def changeStamp(node):
    """A value that changes whenever the node's content or its transform does; None for no node."""
    if node is None:
        return None
    transform = node.GetParentTransformNode()
    stamps = [node.GetID(), contentOf(node)]
    # Ends: MRML refuses a transform that is its own parent, however far above.
    while transform is not None:
        stamps += [transform.GetID(), transform.GetTransformToWorldMTime()]
        transform = transform.GetParentTransformNode()
    return tuple(stamps)


def contentOf(node):
    """A value that changes whenever the node's content does, wherever its transform brings that."""
    if node.IsA("vtkMRMLMarkupsNode"):  # moving a point does not touch the node's modification time
        return tuple(node.GetNthControlPointPosition(i) for i in placedIndices(node))
    if node.IsA("vtkMRMLSegmentationNode"):
        segmentation = node.GetSegmentation()
        return max(
            [segmentation.GetMTime()]
            + [_segmentTime(segmentation, i) for i in segmentation.GetSegmentIDs()]
        )
    return node.GetMesh().GetMTime() if node.GetMesh() is not None else 0


def _segmentTime(segmentation, segmentID):
    name = segmentation.GetSourceRepresentationName()
    representation = segmentation.GetSegment(segmentID).GetRepresentation(name)
    return representation.GetMTime() if representation is not None else 0


def _modelSurface(node):
    surface = node.GetPolyData()
    if surface is None or surface.GetNumberOfPoints() == 0:
        raise InputError(
            f"Vessel {node.GetName()}: expected a surface, got an empty model; select another node."
        )
    return surface


def _segmentSurface(node, segmentID):
    segmentation = node.GetSegmentation()
    if segmentation.GetNumberOfSegments() == 0:
        raise InputError(
            f"Vessel {node.GetName()}: expected a segment, the segmentation has none; select another node."
        )
    if segmentation.GetSegment(segmentID or "") is None:
        raise InputError(
            f"Vessel {node.GetName()}: expected a segment, got none; select one in Vessel."
        )
    surface = vtkPolyData()
    # The logic converts a copy of the segment where it has no surface yet, and applies the node's transform.
    slicer.vtkSlicerSegmentationsModuleLogic.GetSegmentClosedSurfaceRepresentation(
        node, segmentID, surface
    )
    return surface


def _linesOfModel(node):
    if not hasLines(node):
        raise InputError(
            f"Centerline {node.GetName()}: expected a model of lines, got none; select a centerline model."
        )
    surface, scale = toWorld(node, node.GetPolyData()), scaleToWorld(node)
    points, lines = lines_from_polydata(surface, f"Centerline {node.GetName()}")
    radius = None if scale is None else inscribed_radius_from_polydata(surface)
    return points, lines, None if radius is None else scale * radius


def _branchCurves(node):
    """Curves below this one in the subject hierarchy, as Extract Centerline leaves them."""
    hierarchy = slicer.vtkMRMLSubjectHierarchyNode.GetSubjectHierarchyNode(node.GetScene())
    item = hierarchy.GetItemByDataNode(node)
    if not item:
        return []
    children = vtkIdList()
    hierarchy.GetItemChildren(item, children, True)
    nodes = [hierarchy.GetItemDataNode(children.GetId(i)) for i in range(children.GetNumberOfIds())]
    return [n for n in nodes if n is not None and n.IsA("vtkMRMLMarkupsCurveNode")]
