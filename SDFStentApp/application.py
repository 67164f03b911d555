"""A MRML scene with its logics, set up as Slicer does it, without Qt."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import slicer
from vtkmodules.util.misc import calldata_type
from vtkmodules.util.vtkConstants import VTK_OBJECT
from vtkmodules.vtkRenderingCore import vtkInteractorStyle3D, vtkRenderer, vtkRenderWindow

DISPLAYABLE_MANAGERS = (
    "vtkMRMLCameraDisplayableManager",
    "vtkMRMLViewDisplayableManager",
    "vtkMRMLModelDisplayableManager",
    "vtkMRMLMarkupsDisplayableManager",
    "vtkMRMLColorLegendDisplayableManager",
    "vtkMRMLOrientationMarkerDisplayableManager",
    "vtkMRMLRulerDisplayableManager",
)

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
IN_SUBJECT_HIERARCHY = (
    slicer.vtkMRMLModelNode,
    slicer.vtkMRMLMarkupsNode,
    slicer.vtkMRMLSegmentationNode,
    slicer.vtkMRMLTransformNode,
    slicer.vtkMRMLTableNode,
    slicer.vtkMRMLPlotChartNode,
    slicer.vtkMRMLPlotSeriesNode,
)


class MrmlApplication:
    """The scene, the application logic and the module logics. Keep it alive as long as the scene is
    used."""

    def __init__(self) -> None:
        self.folder = tempfile.TemporaryDirectory(prefix="sdfstent-")
        self.scene = slicer.vtkMRMLScene()
        self.applicationLogic = slicer.vtkSlicerApplicationLogic()
        self._make_color_folder()
        self.applicationLogic.SetMRMLScene(self.scene)
        self.logics = {name: self._add_logic(name, cls) for name, cls in LOGIC_CLASSES.items()}
        self.logics["Colors"].AddDefaultColorNodes()
        for event, method in (
            (self.scene.NodeAddedEvent, self._add_to_subject_hierarchy),
            (self.scene.NodeAboutToBeRemovedEvent, self._remove_from_subject_hierarchy),
        ):
            self.scene.AddObserver(event, method)

    def _add_logic(self, name: str, className: str) -> Any:
        logic = getattr(slicer, className)()
        logic.SetMRMLApplicationLogic(self.applicationLogic)
        logic.SetMRMLScene(self.scene)
        self.applicationLogic.SetModuleLogic(name, logic)
        return logic

    @calldata_type(VTK_OBJECT)
    def _add_to_subject_hierarchy(self, _scene: Any, _event: str, node: Any) -> None:
        # The application's plugins do this for every node that a user may see.
        isMeant = isinstance(node, IN_SUBJECT_HIERARCHY) and not node.GetHideFromEditors()
        if isMeant and not self.scene.IsImporting():
            hierarchy = slicer.vtkMRMLSubjectHierarchyNode.GetSubjectHierarchyNode(self.scene)
            hierarchy.CreateItem(hierarchy.GetSceneItemID(), node)

    @calldata_type(VTK_OBJECT)
    def _remove_from_subject_hierarchy(self, _scene: Any, _event: str, node: Any) -> None:
        if isinstance(node, IN_SUBJECT_HIERARCHY) and not self.scene.IsClosing():
            hierarchy = slicer.vtkMRMLSubjectHierarchyNode.GetSubjectHierarchyNode(self.scene)
            item = hierarchy.GetItemByDataNode(node)
            if item:
                hierarchy.RemoveItem(item, False, False)

    def _make_color_folder(self) -> None:
        # The color logic logs an error unless this folder exists; slicer-core ships no color files.
        (Path(self.folder.name) / "share" / "ColorFiles").mkdir(parents=True)
        self.applicationLogic.SetHomeDirectory(self.folder.name)
        self.applicationLogic.SetShareDirectory("share")


class ThreeDView:
    """A view that Slicer's own displayable managers draw off screen, and that receives the mouse
    through an interactor."""

    def __init__(self, application: MrmlApplication, interactor: Any) -> None:
        self.node = slicer.vtkMRMLViewNode()
        self.node.SetName("View1")
        self.node.SetLayoutName("1")
        self.node.SetSingletonTag("1")  # stays when the scene is closed
        self.node = application.scene.AddNode(self.node)
        self.renderer, self.window = vtkRenderer(), vtkRenderWindow()
        self.window.SetOffScreenRendering(True)
        self.window.SetMultiSamples(0)
        self.window.SetSize(800, 600)
        self.window.AddRenderer(self.renderer)
        self.interactor = interactor
        interactor.SetRenderWindow(self.window)
        factory = slicer.vtkMRMLThreeDViewDisplayableManagerFactory.GetInstance()
        factory.SetMRMLApplicationLogic(application.applicationLogic)
        for name in DISPLAYABLE_MANAGERS:
            if not factory.IsDisplayableManagerRegistered(name):
                factory.RegisterDisplayableManager(name)
        self.group = slicer.vtkMRMLDisplayableManagerGroup()
        self.group.Initialize(factory, self.renderer)
        self.group.SetMRMLDisplayableNode(self.node)
        self._style = slicer.vtkMRMLThreeDViewInteractorStyle()
        self._style.SetDisplayableManagers(self.group)
        self._style.SetInteractor(interactor)
        interactor.SetInteractorStyle(vtkInteractorStyle3D())
