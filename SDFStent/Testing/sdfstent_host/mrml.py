"""A real MRML scene with its logics, as the application would bring it up (no Qt)."""

import tempfile
from pathlib import Path

import slicer
import vtk

LOGIC_CLASSES = {
    "Units": "vtkSlicerUnitsLogic",
    "SubjectHierarchy": "vtkSlicerSubjectHierarchyModuleLogic",
    "Models": "vtkSlicerModelsLogic",
    "Markups": "vtkSlicerMarkupsLogic",
    "Segmentations": "vtkSlicerSegmentationsModuleLogic",
    "Transforms": "vtkSlicerTransformLogic",
    "Tables": "vtkSlicerTablesLogic",
    "Plots": "vtkSlicerPlotsLogic",
    "Colors": "vtkSlicerColorLogic",
}
DISPLAYABLE_MANAGERS = (
    "vtkMRMLCameraDisplayableManager",
    "vtkMRMLViewDisplayableManager",
    "vtkMRMLModelDisplayableManager",
    "vtkMRMLMarkupsDisplayableManager",
    "vtkMRMLColorLegendDisplayableManager",
)

IN_SUBJECT_HIERARCHY = (
    slicer.vtkMRMLModelNode,
    slicer.vtkMRMLMarkupsNode,
    slicer.vtkMRMLSegmentationNode,
    slicer.vtkMRMLTransformNode,
    slicer.vtkMRMLTableNode,
    slicer.vtkMRMLPlotChartNode,
    slicer.vtkMRMLPlotSeriesNode,
)


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


class Application:
    """Scene, application logic and module logics. Keep it alive as long as the scene is used."""

    def __init__(self):
        self.errorLog = ErrorLog()
        self.folder = tempfile.TemporaryDirectory(prefix="host-")
        self.scene = slicer.vtkMRMLScene()
        self.applicationLogic = slicer.vtkSlicerApplicationLogic()
        self._makeColorFolder()
        self.applicationLogic.SetMRMLScene(self.scene)
        self.logics = {name: self._addLogic(name, cls) for name, cls in LOGIC_CLASSES.items()}
        self.logics["Colors"].AddDefaultColorNodes()
        self._io = self._makeDataIO()
        self.layoutLogic = slicer.vtkMRMLLayoutLogic()  # makes the views of a layout
        self.layoutLogic.SetMRMLApplicationLogic(self.applicationLogic)
        self.layoutLogic.SetMRMLScene(self.scene)
        self.scene.AddObserver(self.scene.NodeAddedEvent, self._addToSubjectHierarchy)
        self.scene.AddObserver(
            self.scene.NodeAboutToBeRemovedEvent, self._removeFromSubjectHierarchy
        )
        slicer.mrmlScene = self.scene
        self.view = View(
            self
        )  # before any content: the legend's manager draws only legends that it saw being added

    def render(self, path, size=(900, 675), *, focus=None):
        """The 3D view drawn by the real displayable managers into a PNG file; `focus` is a box to look at."""
        self.view.window.SetSize(*size)
        self.view.render(focus)
        self.view.save(path)
        return Path(path)

    def _addLogic(self, name, className):
        logic = getattr(slicer, className)()
        logic.SetMRMLApplicationLogic(self.applicationLogic)
        logic.SetMRMLScene(self.scene)
        self.applicationLogic.SetModuleLogic(name, logic)
        return logic

    @vtk.calldata_type(vtk.VTK_OBJECT)
    def _addToSubjectHierarchy(self, _scene, _event, node):
        # The application's plugins do this for every node that a user may see.
        if isinstance(node, IN_SUBJECT_HIERARCHY) and not self.scene.IsImporting():
            hierarchy = slicer.vtkMRMLSubjectHierarchyNode.GetSubjectHierarchyNode(self.scene)
            hierarchy.CreateItem(hierarchy.GetSceneItemID(), node)

    @vtk.calldata_type(vtk.VTK_OBJECT)
    def _removeFromSubjectHierarchy(self, _scene, _event, node):
        if isinstance(node, IN_SUBJECT_HIERARCHY) and not self.scene.IsClosing():
            hierarchy = slicer.vtkMRMLSubjectHierarchyNode.GetSubjectHierarchyNode(self.scene)
            item = hierarchy.GetItemByDataNode(node)
            if item:
                hierarchy.RemoveItem(item, False, False)

    def _makeColorFolder(self):
        # The color logic logs an error unless this folder exists; slicer-core ships no color files.
        (Path(self.folder.name) / "share" / "ColorFiles").mkdir(parents=True)
        self.applicationLogic.SetHomeDirectory(self.folder.name)
        self.applicationLogic.SetShareDirectory("share")

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


class View:
    """An off-screen 3D view that shows the scene through the real displayable managers."""

    def __init__(self, application, size=(900, 675)):
        self.node = _viewNode(application.scene)
        self.renderer = vtk.vtkRenderer()
        self.window = vtk.vtkRenderWindow()
        self.window.SetOffScreenRendering(True)
        self.window.SetMultiSamples(0)
        self.window.SetSize(*size)
        self.window.AddRenderer(self.renderer)
        interactor = vtk.vtkRenderWindowInteractor()
        interactor.SetRenderWindow(self.window)
        factory = slicer.vtkMRMLThreeDViewDisplayableManagerFactory.GetInstance()
        factory.SetMRMLApplicationLogic(application.applicationLogic)
        for name in DISPLAYABLE_MANAGERS:
            if not factory.IsDisplayableManagerRegistered(name):
                factory.RegisterDisplayableManager(name)
        self._interactor = interactor
        self.group = slicer.vtkMRMLDisplayableManagerGroup()
        self.group.Initialize(factory, self.renderer)
        self.group.SetMRMLDisplayableNode(self.node)

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


def _viewNode(scene):
    node = slicer.vtkMRMLViewNode()
    node.SetName("View1")
    node.SetLayoutName("1")
    node.SetSingletonTag("1")  # stays when the scene is closed
    return scene.AddNode(node)
