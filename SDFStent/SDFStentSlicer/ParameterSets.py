"""The parameter nodes of a scene, each a plan of its own."""

import slicer
from slicer.i18n import tr as _

from . import FormerScenes
from .ParameterNode import SDFStentParameterNode

FIRST_PLAN = "Plan 1"


class ParameterSets:
    """A part of `SDFStentLogic`: the same object for the same node of the scene, as long as that has its content."""

    def begin(self):
        """Start anew in a scene with imported content; plans that are singletons, as in former versions, are no longer."""
        self.forget()
        for node in self.getAllParameterNodes():
            if node.IsSingleton():
                self._takeOutOfSingletons(node)

    @staticmethod
    def _takeOutOfSingletons(node):
        """Put a node with another ID in a node's place: MRML takes the ID of a singleton for one, with or without its tag."""
        scene, copy = node.GetScene(), node.CreateNodeInstance()
        copy.UnRegister(None)
        copy.Copy(node)
        copy.SetSingletonTag(None)
        scene.RemoveNode(node)
        scene.AddNode(copy)

    def getParameterNode(self):
        """The parameters that the panel starts with."""
        return self.parameterSet(super().getParameterNode())

    def createParameterNode(self):
        """The node of the first plan in a scene."""
        node = super().createParameterNode()
        node.SetName(slicer.mrmlScene.GenerateUniqueName(_(FIRST_PLAN)))
        return node

    def parameterSet(self, node):
        """The parameters in a `vtkMRMLScriptedModuleNode`, always the same object for the same node."""
        wrapper = self._wrappers.get(node.GetID())
        if wrapper is None or wrapper.parameterNode is not node:
            FormerScenes.takeOver(node)
            wrapper = self._wrappers[node.GetID()] = SDFStentParameterNode(node)
        return wrapper

    def addParameterSet(self, name):
        """Add a plan to the scene, with inputs, stents and outputs of its own; returns its parameters."""
        node = slicer.mrmlScene.CreateNodeByClass("vtkMRMLScriptedModuleNode")
        node.UnRegister(None)
        node.SetName(slicer.mrmlScene.GenerateUniqueName(name))
        node.SetAttribute("ModuleName", self.moduleName)
        return self.parameterSet(slicer.mrmlScene.AddNode(node))
