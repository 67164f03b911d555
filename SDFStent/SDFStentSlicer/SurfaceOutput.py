"""Stented vessel in the scene, which follows every step, and the plan that it is of."""

import numpy as np
from slicer.i18n import tr as _
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkPolyData

from . import Conversion, Display, Results, Showing
from .Marks import createOutline, removeMark
from .PointNormals import PointNormals, withNormals

VESSEL_COLOR = (0.88, 0.47, 0.42)


class SurfaceOutput:
    """A model node whose points follow the deployment: same polydata, same point array, one `Modified` per change."""

    def __init__(self, node, polyData, corners=None):
        """Show `polyData` (which becomes the node's own) unless the node already shows the same mesh."""
        self.node, self.template, self.vessel = node, None, None
        withNormals(polyData)
        self._polyData, self._normals = polyData, PointNormals(polyData, corners)
        self._normals.update()  # without them it is black until something changes
        node.SetAndObservePolyData(polyData)
        self._changed = None
        self._outline = None

    @property
    def isValid(self):
        """False when the node was deleted or given another mesh by somebody else."""
        return self.node.GetScene() is not None and self.node.GetPolyData() is self._polyData

    def show(self, points, indices=None, coordinates=None):
        """Set all points, then some of them; as `showChanged`."""
        own = vtk_to_numpy(self.template.GetPoints().GetData())
        points = np.array(points, dtype=own.dtype)
        if indices is not None:
            points[indices] = coordinates
        changed = np.flatnonzero((points != own).any(axis=1))
        self.showChanged(changed, points[changed])

    def showChanged(self, indices, coordinates):
        """Set some points, all others as they are in the template, and the normals; observers hear of it once.

        Touches what is not shown already.
        """
        own = vtk_to_numpy(self.template.GetPoints().GetData())
        array = vtk_to_numpy(self._polyData.GetPoints().GetData())
        if self._changed is None:
            array[:] = own
        else:
            array[self._changed] = own[self._changed]
        array[indices] = coordinates
        self._normals.update(None if self._changed is None else (self._changed, indices))
        self._changed = indices
        self._tell()

    def _tell(self):
        self._polyData.GetPoints().GetData().Modified()
        self._polyData.Modified()

    def hideOutline(self):
        """Show the outline of the vessel as it was in the slice views: that of the output would be cut anew at every change."""
        display = self.node.GetDisplayNode()
        if display is not None and display.GetVisibility() and display.GetVisibility2D():
            with Showing.inOneFrame():
                self._outline = createOutline(_("Vessel before treatment"), self.template)
                display.SetVisibility2D(False)

    def showOutline(self):
        """Bring the outline back, if it was taken away."""
        display = self.node.GetDisplayNode()
        if self._outline is not None:
            with Showing.inOneFrame():
                if display is not None:
                    display.SetVisibility2D(True)
                removeMark(self._outline)
        self._outline = None


def outputSurface(parameterNode, vessel, former):
    """The output of a parameter node, showing the mesh of a `Vessel`; the `former` one while the mesh stays the same."""
    shown, template = parameterNode.outputVessel, vessel.polyData
    node = Display.outputModel(parameterNode, "outputVessel", _("Stented vessel"), VESSEL_COLOR)
    if node is not shown:
        Showing.seeThrough(node.GetDisplayNode())
        node.GetDisplayNode().SetVisibility2D(True)
    isOther = former is not None and former.vessel is not parameterNode.vessel
    if node is not shown or isOther:
        Showing.setShown(parameterNode.vessel, False, Conversion.segmentOf(parameterNode))
    if former is not None:
        if former.node is node and former.template is template and former.isValid:
            return former
        former.showOutline()
    copy = vtkPolyData()
    copy.DeepCopy(template)
    surface = SurfaceOutput(node, copy, vessel.corners)
    surface.template, surface.vessel = template, parameterNode.vessel
    return surface


class ShownResult:
    """The last deployment or preview of one parameter set as the scene shows it.

    `run` is the `Stenting` or the `PreviewRun` of it, None before the first; `signature` that of the plan and inputs it is of.
    """

    def __init__(self, parameterNode):
        self.parameterNode = parameterNode
        self.run = self.signature = self._surface = None

    def surface(self, vessel):
        """The output that shows the mesh of a `Vessel`."""
        self._surface = outputSurface(self.parameterNode, vessel, self._surface)
        return self._surface

    def isPreviewOf(self, signature):
        """Whether the preview of the plan and inputs with a signature is shown."""
        return self.run is not None and not self.run.recorded and self.signature == signature

    @property
    def hasSteps(self):
        """Whether the steps of a deployment are kept."""
        isRecorded = self.run is not None and bool(self.run.recorded)
        return isRecorded and self.parameterNode.outputVessel is not None

    def step(self, percent):
        """Show the run at a percentage of its steps."""
        if self.run is None or self._surface is None or not self._surface.isValid:
            return
        points, tubes = self.run.end() if percent >= 100 else self.run.at(percent)
        self._surface.show(points)
        Results.showStents(self.parameterNode, tubes, percent >= 100 and bool(self.run.recorded))

    def outline(self):
        """Show the outline in the slice views again: nothing more is coming for now."""
        if self._surface is not None:
            self._surface.showOutline()
