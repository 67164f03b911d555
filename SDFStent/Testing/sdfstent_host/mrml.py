"""A real MRML scene with its logics, as the application would bring it up (no Qt)."""

from pathlib import Path

import numpy as np
import slicer
import vtk
from vtkmodules.util.misc import calldata_type
from vtkmodules.util.vtkConstants import VTK_OBJECT

from SDFStentApp import application


class ErrorLog:
    """Everything that VTK and MRML would write to the console since `clear`."""

    def __init__(self):
        self._window = vtk.vtkStringOutputWindow()
        vtk.vtkLogger.SetStderrVerbosity(vtk.vtkLogger.VERBOSITY_OFF)
        vtk.vtkOutputWindow.SetInstance(self._window)
        self._start = 0

    def clear(self):
        self._start = len(self._window.GetOutput())

    def text(self):
        return self._window.GetOutput()[self._start :]


class Application(application.MrmlApplication):
    """The application's scene and logics, with files, layouts, an error log and a view."""

    def __init__(self):
        self.errorLog = ErrorLog()
        super().__init__()
        self._io = self._makeDataIO()
        self.layoutLogic = slicer.vtkMRMLLayoutLogic()  # makes the views of a layout
        self.layoutLogic.SetMRMLApplicationLogic(self.applicationLogic)
        self.layoutLogic.SetMRMLScene(self.scene)
        # Takes the nodes that show and store a node out of the scene with it.
        self.dataLogic = slicer.vtkSlicerDataModuleLogic()
        self.dataLogic.SetMRMLScene(self.scene)
        self.scene.AddObserver(self.scene.NodeAboutToBeRemovedEvent, self._onRemoving)
        slicer.mrmlScene = self.scene
        self.view = View(
            self
        )  # before any content: the legend's manager draws only legends that it saw being added

    @calldata_type(VTK_OBJECT)
    def _onRemoving(self, scene, _event, node):
        """As `qSlicerSubjectHierarchyPluginLogic` does, which complains of a node that is in no scene any more."""
        if not scene.IsClosing():
            slicer.vtkMRMLSubjectHierarchyNode.GetSubjectHierarchyNode(node.GetScene())

    def render(self, path, size=(900, 675), *, focus=None):
        """The 3D view drawn by the real displayable managers into a PNG file; `focus` is a box to look at."""
        self.view.window.SetSize(*size)
        self.view.render(focus)
        self.view.save(path)
        return Path(path)

    def _makeDataIO(self):
        # Reading .mrb files goes through the data manager, which wants a cache folder.
        remote = slicer.vtkMRMLRemoteIOLogic()
        remote.SetMRMLScene(self.scene)
        remote.SetMRMLApplicationLogic(self.applicationLogic)
        cache = Path(self.folder.name) / "cache"
        cache.mkdir()
        (cache / ".slicer-cache").touch()  # the cache manager warns about a folder without it
        remote.GetCacheManager().SetRemoteCacheDirectory(str(cache))
        manager = slicer.vtkDataIOManagerLogic()
        manager.SetMRMLScene(self.scene)
        manager.SetMRMLApplicationLogic(self.applicationLogic)
        manager.SetAndObserveDataIOManager(remote.GetDataIOManager())
        remote.AddDataIOToScene()
        return remote, manager


class View(application.ThreeDView):
    """The 3D view, with a mouse of its own and pictures of it."""

    def __init__(self, application, size=(900, 675)):
        super().__init__(application, vtk.vtkRenderWindowInteractor())
        self.window.SetSize(*size)

    def look(self, bounds, direction=(0.0, -1.0, 0.15), up=(0.0, 0.0, 1.0), zoom=1.4):
        """Point the camera at a box, along `direction`."""
        camera = self.renderer.GetActiveCamera()
        center = [(bounds[i] + bounds[i + 1]) / 2 for i in (0, 2, 4)]
        camera.SetFocalPoint(center)
        camera.SetPosition([c - 100 * d for c, d in zip(center, direction, strict=True)])
        camera.SetViewUp(up)
        self.renderer.ResetCamera(bounds)
        camera.Zoom(zoom)
        self.renderer.ResetCameraClippingRange()

    def pixel(self, point):
        """Where a point in space is seen, in pixels from the lower left corner."""
        self.renderer.SetWorldPoint(*point, 1.0)
        self.renderer.WorldToDisplay()
        return np.array(self.renderer.GetDisplayPoint()[:2])

    def mouse(self, event, pixel):
        """An event of the mouse at a pixel: `MouseMove`, `LeftButtonPress`, `LeftButtonRelease`."""
        self.interactor.SetEventInformation(*(round(float(side)) for side in pixel))
        self.interactor.InvokeEvent(f"{event}Event")

    def drag(self, pixels, onMove=lambda: None):
        """Press at the first pixel, move over the others and let go; the real widgets of markups hear of it, snapping included."""
        self.window.Render()  # what is picked is what is seen
        self.mouse("MouseMove", pixels[0])
        self.mouse("LeftButtonPress", pixels[0])
        for pixel in pixels[1:]:
            self.mouse("MouseMove", pixel)
            onMove()
        self.mouse("LeftButtonRelease", pixels[-1])

    def render(self, focus=None):
        self.node.SetBoxVisible(False)
        self.node.SetAxisLabelsVisible(False)
        if focus is not None:
            self.look(focus)
        self.window.Render()

    def save(self, path):
        grabber = vtk.vtkWindowToImageFilter()
        grabber.SetInput(self.window)
        grabber.ReadFrontBufferOff()
        writer = vtk.vtkPNGWriter()
        writer.SetFileName(str(path))
        writer.SetInputConnection(grabber.GetOutputPort())
        writer.Write()


class PlotView:
    """The lines of a plot chart, drawn again at every change of the chart as Slicer's plot view does."""

    def __init__(self, chart):
        self._chart = chart
        self._tag = chart.AddObserver(chart.PlotModifiedEvent, lambda *_: self.draw())
        self.drawn = 0
        self.draw()

    def draw(self):
        self.drawn += 1
        for index in range(self._chart.GetNumberOfPlotSeriesNodes()):
            series = self._chart.GetNthPlotSeriesNode(index)
            line = vtk.vtkPlotLine()
            line.SetInputData(
                series.GetTableNode().GetTable(), series.GetXColumnName(), series.GetYColumnName()
            )
            line.Update()

    def close(self):
        self._chart.RemoveObserver(self._tag)
