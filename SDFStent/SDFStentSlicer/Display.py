"""Library to scene: output nodes, made once and updated in place, and how they look."""

import math
from pathlib import Path

import numpy as np
import slicer
from slicer.i18n import tr as _
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkFiltersCore import vtkAppendPolyData, vtkAssignAttribute, vtkTubeFilter

from SDFStentLib.files import polydata_from_arrays, polydata_from_lines

from . import Outputs, Showing

STENT_COLOR = (0.72, 0.76, 0.80)
OUTPUT_ROLES = (
    "outputVessel",
    "outputCenterline",
    "outputStents",
    "outputTable",
    "outputTexts",
    "outputChart",
)
FOLDER_ATTRIBUTE = "SDFStent.Results"
TUBE_SIDES = 24
TUBE_SPACING = 1.5
TUBE_SHRINK = 0.97
"""Stents are drawn a little inside the wall that they touch, so that both can be seen."""

DRAWN_ATTRIBUTE = "SDFStent.DrawnAs"
STRUT_WIDTH = 3
"""Pixels."""

VIEW_LENGTHS, SMALLEST_VIEW = 3.0, 30.0
"""View of a lesion or a stent, in its lengths, and the least one, mm."""


def outputModel(parameterNode, role, name, color):
    """Model node of a role: the one in use if it was made for this, or a new one."""
    node = getattr(parameterNode, role)
    if not Outputs.isUsable(parameterNode, role, node):
        node = addOutput(parameterNode, "vtkMRMLModelNode", name)
        node.SetAttribute(Outputs.ATTRIBUTE, role)
        setattr(parameterNode, role, node)
    if node.GetDisplayNode() is None:
        node.CreateDefaultDisplayNodes()
        node.GetDisplayNode().SetColor(*color)
        node.GetDisplayNode().SetVisibility2D(False)
    return node


def addOutput(parameterNode, className, name):
    """Add a node to the folder of the parameter set's results, with the plan in its name where another one has that name."""
    scene = parameterNode.parameterNode.GetScene()
    if scene.GetFirstNodeByName(name) is not None:
        plan = parameterNode.parameterNode.GetName()
        name = scene.GenerateUniqueName(_("{name}, {plan}").format(name=name, plan=plan))
    node = scene.AddNewNodeByClass(className, name)
    hierarchy = slicer.vtkMRMLSubjectHierarchyNode.GetSubjectHierarchyNode(scene)
    hierarchy.CreateItem(_folder(hierarchy, parameterNode), node)
    return node


def _folder(hierarchy, parameterNode):
    """The subject hierarchy folder that holds another result of the parameter set, or a new one."""
    for role in OUTPUT_ROLES:
        node = getattr(parameterNode, role)
        if node is None or node.GetID() in Outputs.takenIDs(parameterNode, role):
            continue
        if folder := resultsFolder(node):
            return folder
    name = _folderName(parameterNode)
    folder = hierarchy.CreateFolderItem(hierarchy.GetSceneItemID(), name)
    hierarchy.SetItemAttribute(folder, FOLDER_ATTRIBUTE, name)
    return folder


def nameFolder(parameterNode):
    """Call the folder of the results as the plan is called now, unless the user has given it a name of its own."""
    node, name = parameterNode.outputVessel, _folderName(parameterNode)
    folder = 0 if node is None else resultsFolder(node)
    if not folder:
        return
    hierarchy = slicer.vtkMRMLSubjectHierarchyNode.GetSubjectHierarchyNode(node.GetScene())
    former = hierarchy.GetItemAttribute(folder, FOLDER_ATTRIBUTE)
    if former != name and hierarchy.GetItemName(folder) == former:
        hierarchy.SetItemName(folder, name)
        hierarchy.SetItemAttribute(folder, FOLDER_ATTRIBUTE, name)


def _folderName(parameterNode):
    return _("{name} results").format(name=parameterNode.parameterNode.GetName())


def resultsFolder(node):
    """The item of the folder of results that a node is in; 0 where it is in none."""
    hierarchy = slicer.vtkMRMLSubjectHierarchyNode.GetSubjectHierarchyNode(node.GetScene())
    item = hierarchy.GetItemByDataNode(node)
    folder = hierarchy.GetItemParent(item) if item else 0
    isOurs = folder and hierarchy.GetItemAttribute(folder, FOLDER_ATTRIBUTE)
    return folder if isOurs else 0


def showLines(node, points, lines):
    """Put poly-lines into a model node, in place."""
    _replaceContent(node, polydata_from_lines(points, lines) if len(lines) else vtkPolyData())
    node.GetDisplayNode().SetLineWidth(Showing.LINE_WIDTH)


def showTubes(node, axes):
    """Put one open tube per (stent axis, largest radius) into a model node, in place."""
    appended = vtkAppendPolyData()
    for axis, radius in axes:
        spine = axis.line.resampled(TUBE_SPACING).points
        line = polydata_from_lines(spine, [np.arange(len(spine))])
        tube = vtkTubeFilter()
        if axis.profile is not None:
            widths = axis.profile.at(np.linspace(0, 1, len(spine))) / axis.profile.widest
            shares = numpy_to_vtk(TUBE_SHRINK * radius * widths, deep=True)
            shares.SetName("TubeRadius")
            line.GetPointData().SetScalars(shares)
            tube.SetVaryRadiusToVaryRadiusByAbsoluteScalar()
        tube.SetInputData(line)
        tube.SetRadius(TUBE_SHRINK * radius)
        tube.SetNumberOfSides(TUBE_SIDES)
        tube.CappingOff()
        appended.AddInputConnection(tube.GetOutputPort())
    if axes:
        appended.Update()
    _replaceContent(node, appended.GetOutput() if axes else vtkPolyData())
    display = node.GetDisplayNode()
    display.SetRepresentation(slicer.vtkMRMLDisplayNode.SurfaceRepresentation)
    display.SetEdgeVisibility(True)
    display.SetEdgeColor(0.25, 0.3, 0.35)


def showStruts(node, stents):
    """Put the rings and struts of every `DrawnStent` into a model node, in place, as wide as it is now."""
    points, lines, first = [], [], 0
    for one in stents:
        lattice = one.placed.lattice(one.radius)
        points.append(lattice.points)
        lines += list(lattice.lines + first)
        first += len(lattice.points)
    _replaceContent(
        node, polydata_from_lines(np.concatenate(points), lines) if stents else vtkPolyData()
    )
    node.GetDisplayNode().SetLineWidth(STRUT_WIDTH)
    _hideEdges(node)


def showMeshes(node, stents, mesh):
    """Put a straight mesh of the user's own into a model node, once for every `DrawnStent`, where it lies."""
    points = [one.placed.laid(mesh.points) for one in stents]
    triangles = [mesh.triangles + number * len(mesh.points) for number in range(len(stents))]
    _replaceContent(node, polydata_from_arrays(np.concatenate(points), np.concatenate(triangles)))
    _hideEdges(node)


def _hideEdges(node):
    display = node.GetDisplayNode()
    display.SetRepresentation(slicer.vtkMRMLDisplayNode.SurfaceRepresentation)
    display.SetEdgeVisibility(False)


def addMesh(parameterNode, path, surface):
    """Add a model node of a surface that was read from a file, hidden: it lies where no vessel is."""
    scene = parameterNode.parameterNode.GetScene()
    name = scene.GenerateUniqueName(Path(path).stem)
    node = scene.AddNewNodeByClass("vtkMRMLModelNode", name)
    node.SetAndObservePolyData(polydata_from_arrays(surface.points, surface.triangles))
    node.CreateDefaultDisplayNodes()
    node.GetDisplayNode().SetVisibility(False)
    return node


def drawnAs(node):
    """Name of what a model of stents was asked to show them as."""
    return node.GetAttribute(DRAWN_ATTRIBUTE) or ""


def setDrawnAs(node, asked):
    """Remember that."""
    node.SetAttribute(DRAWN_ATTRIBUTE, asked)


def _replaceContent(node, polyData):
    if node.GetPolyData() is None:
        node.SetAndObservePolyData(polyData)
    else:
        node.GetPolyData().ShallowCopy(polyData)
        node.GetPolyData().Modified()


def showMap(node, name, values, onCells, title):
    """Color a model by an array, with a legend; `name` "" takes both away."""
    display = node.GetDisplayNode()
    legend = slicer.vtkSlicerColorLogic.GetColorLegendDisplayNode(node)
    if not name:
        display.SetScalarVisibility(False)
        if legend is not None:
            legend.SetVisibility(False)
        return
    setArray(node, name, values, onCells)
    place = vtkAssignAttribute.CELL_DATA if onCells else vtkAssignAttribute.POINT_DATA
    display.SetActiveScalar(name, place)
    display.SetAndObserveColorNodeID(_mapColors(node.GetScene()).GetID())
    display.SetScalarRangeFlag(slicer.vtkMRMLDisplayNode.UseManualScalarRange)
    finite = values[np.isfinite(values)]
    low, high = (float(finite.min()), float(finite.max())) if len(finite) else (0.0, 1.0)
    display.SetScalarRange(low, max(high, low + 1e-6))
    display.SetScalarVisibility(True)
    if legend is None:
        legend = slicer.vtkSlicerColorLogic.AddDefaultColorLegendDisplayNode(node)
        # The colors stay Slicer's: white with a shadow can be read on any background.
        for text in (legend.GetTitleTextProperty(), legend.GetLabelTextProperty()):
            text.SetFontSize(10)
        legend.SetSize(0.1, 0.3)
        legend.SetPosition(0.97, 0.05)
        for view in slicer.util.getNodesByClass("vtkMRMLViewNode"):
            legend.AddViewNodeID(view.GetID())  # slices are too small for its digits
    legend.SetAndObserveColorNodeID(display.GetColorNodeID())
    legend.SetTitleText(title)
    legend.SetLabelFormat("%.2f")
    legend.SetVisibility(True)


def setArray(node, name, values, onCells):
    """Write a point or cell array of a model in place, or add it."""
    data = node.GetPolyData().GetCellData() if onCells else node.GetPolyData().GetPointData()
    array = data.GetArray(name)
    if array is not None and array.GetNumberOfTuples() == len(values):
        vtk_to_numpy(array)[:] = values
        array.Modified()
    else:
        array = numpy_to_vtk(np.asarray(values, dtype=np.float32), deep=True)
        array.SetName(name)
        data.AddArray(array)
    node.GetPolyData().Modified()


def _mapColors(scene):
    """A color node of ours, saved with the scene: white over yellow and red to dark red."""
    node = scene.GetFirstNode("SDFStent map", "vtkMRMLProceduralColorNode")
    if node is None:
        node = scene.AddNewNodeByClass("vtkMRMLProceduralColorNode", "SDFStent map")
        transfer = node.GetColorTransferFunction()
        for at, color in (
            (0.0, (0.97, 0.95, 0.92)),
            (0.35, (0.99, 0.80, 0.36)),
            (0.7, (0.85, 0.23, 0.16)),
            (1.0, (0.40, 0.0, 0.15)),
        ):
            transfer.AddRGBPoint(255 * at, *color)
    return node


def showPlace(point, size):
    """Center all views on a point in world coordinates, so near that `size` mm fill a view's height."""
    slices = slicer.vtkMRMLSliceNode
    slices.JumpAllSlices(slicer.mrmlScene, *point, slices.CenteredJumpSlice)
    for node in slicer.util.getNodesByClass("vtkMRMLSliceNode"):
        width, height, thickness = node.GetFieldOfView()
        node.SetFieldOfView(size * width / height, size, thickness)
    for camera in slicer.util.getNodesByClass("vtkMRMLCameraNode"):
        _look(camera, point, size)


def bringIntoView(polyData):
    """Let those 3D views look at a surface that have its middle out of view."""
    low, high = np.reshape(polyData.GetBounds(), (3, 2)).T
    middle = (low + high) / 2
    for camera in slicer.util.getNodesByClass("vtkMRMLCameraNode"):
        ahead = np.subtract(camera.GetFocalPoint(), camera.GetPosition())
        toward = middle - camera.GetPosition()
        along = ahead @ toward / np.linalg.norm(ahead)
        aside = math.sqrt(max(toward @ toward - along**2, 0.0))
        if aside >= along * math.tan(math.radians(camera.GetViewAngle()) / 2):
            _look(camera, middle, float(np.linalg.norm(high - low)))


def _look(camera, point, size):
    back = np.subtract(camera.GetPosition(), camera.GetFocalPoint())
    distance = size / 2 / math.tan(math.radians(camera.GetViewAngle()) / 2)
    with slicer.util.NodeModify(camera):
        camera.SetPosition(*(point + distance * back / np.linalg.norm(back)))
        camera.SetFocalPoint(*point)
        camera.SetParallelScale(size / 2)
    camera.ResetClippingRange()


def sizeRound(length):
    """Length to be seen of a lesion or a stent and of what lies beside it, mm."""
    return max(VIEW_LENGTHS * length, SMALLEST_VIEW)
