"""The Python layer of Slicer that slicer-core does not have: module base classes, `slicer.app`, `slicer.modules`, SampleData."""

import importlib
import sys
import types
import unittest
from pathlib import Path

import slicer
from PySide6 import QtWidgets
from vtkmodules.vtkRenderingAnnotation import vtkCornerAnnotation
from vtkmodules.vtkRenderingCore import vtkRenderer, vtkRenderWindow

from SDFStentApp import python_layer

from . import skins, ui_loader
from .qt_stand_in import ctkModule, qtModule, wrapped

PYTHON_LAYER = ("ScriptedLoadableModule", "i18n", "parameterNodeWrapper")


class ScriptedLoadableModule:
    def __init__(self, parent):
        self.parent = parent
        self.moduleName = type(self).__name__
        parent.title, parent.categories, parent.dependencies, parent.contributors = "", [], [], []
        parent.helpText = parent.acknowledgementText = ""

    def resourcePath(self, name):
        return str(Path(self.parent.path).parent / "Resources" / name)

    def getDefaultModuleDocumentationLink(self, docPage=None):
        return ""


class ScriptedLoadableModuleTest(unittest.TestCase):
    def delayDisplay(self, message, requestedDelay=None, msec=None):
        pass

    def runTest(self, **_):
        for name in (n for n in dir(self) if n.startswith("test")):
            self.setUp()
            getattr(self, name)()
            self.tearDown()


class Settings(dict):
    def value(self, key, default=None):
        return self.get(key, default)

    def setValue(self, key, value):
        self[key] = value


class App:
    """`slicer.app`: only what modules may reasonably ask for."""

    testingEnabled = staticmethod(lambda: True)

    def __init__(self, application):
        self._application, self._settings = application, Settings()
        self.startupFunctions, self.temporaryPath = [], application.folder.name
        self.hasStarted, self._layoutManager, self.window = False, None, None

    def connect(self, signature, function):
        if signature.startswith("startupCompleted") and not self.hasStarted:
            self.startupFunctions.append(function)

    def completeStartup(self):
        """All modules are there: say so, once."""
        if not self.hasStarted:
            slicer.modules.sampledata = types.SimpleNamespace(name="SampleData")
            self.hasStarted = True
            for function in self.startupFunctions:
                function()

    def applicationLogic(self):
        return self._application.applicationLogic

    def layoutManager(self):
        return self._layoutManager  # None, as with --no-main-window

    def showMainWindow(self, shown):
        """Have a layout manager, or none; `window` is the main window, if a test makes one."""
        if self._layoutManager is not None:
            self._layoutManager.close()
        self._layoutManager = LayoutManager(self._application) if shown else None

    def settings(self):
        return self._settings

    def moduleManager(self):
        return types.SimpleNamespace(connect=lambda *_: True, disconnect=lambda *_: True)

    def translate(self, context, text):
        return text

    def moduleDocumentationUrl(self, name):
        return ""

    userSettings = settings

    def processEvents(self, *_):
        QtWidgets.QApplication.processEvents()


class LayoutManager:
    """What the layout manager does to the 3D views."""

    def __init__(self, application):
        self._application, view = application, application.view
        self._widgets = [_threeDWidget(view.window)]
        view = self._widgets[0].threeDView()
        application.view.renderer.AddViewProp(view.cornerAnnotation())

    def close(self):
        """Draw no more what was in the corners of its views."""
        corner = self._widgets[0].threeDView().cornerAnnotation()
        self._application.view.renderer.RemoveViewProp(corner)

    @property
    def threeDViewCount(self):
        """As many as the layout has; a view is made when it is first shown, with nothing in its corners."""
        layout = self._application.scene.GetFirstNodeByClass("vtkMRMLLayoutNode")
        return 2 if layout.GetViewArrangement() == layout.SlicerLayoutDual3DView else 1

    def threeDWidget(self, number):
        while len(self._widgets) <= number:
            self._widgets.append(_threeDWidget(_emptyWindow()))
        return self._widgets[number]

    def resetThreeDViews(self):
        self._application.view.renderer.ResetCamera()


def _threeDWidget(window):
    corner = vtkCornerAnnotation()
    view = types.SimpleNamespace(
        cornerAnnotation=lambda: corner, scheduleRender=lambda: None, renderWindow=lambda: window
    )
    return types.SimpleNamespace(threeDView=lambda: view)


def _emptyWindow():
    window = vtkRenderWindow()
    window.AddRenderer(vtkRenderer())
    return window


class SampleDataLogic:
    """`SampleData.SampleDataLogic`: lists of sources by category. Slicer's own downloads make nothing of custom downloaders either."""

    sources = {}

    @classmethod
    def registerCustomSampleDataSource(cls, category="Custom", **told):
        source = types.SimpleNamespace(category=category, **told)
        if str(source) not in map(str, cls.sampleDataSourcesByCategory(category)):
            cls.sources.setdefault(category, []).append(source)

    @classmethod
    def sampleDataSourcesByCategory(cls, category=None):
        return cls.sources if category is None else cls.sources.get(category, [])


def install(application, files, checkout=None):
    """Put the stand-ins where modules look for them. `files` are what file dialogs answer with, in order.

    With a Slicer `checkout` its own `ScriptedLoadableModule`, `i18n` and `parameterNodeWrapper` are used.
    """
    qt, ctk, sampleData = qtModule(), ctkModule(), types.ModuleType("SampleData")
    sampleData.SampleDataLogic = SampleDataLogic
    for stand_in in (qt, ctk, sampleData):
        sys.modules[stand_in.__name__] = stand_in
    slicer.app, slicer.selfTests = App(application), {}
    slicer.modules = types.SimpleNamespace()
    for name, logic in application.logics.items():
        module = types.SimpleNamespace(logic=lambda logic=logic: logic, name=name)
        setattr(slicer.modules, name.lower(), module)
    for name, cls in skins.SLICER.items():
        setattr(slicer, name, wrapped(cls))
    names = ("getOpenFileName", "getOpenFileNames", "getSaveFileName", "getExistingDirectory")
    answer = staticmethod(lambda *_: files.pop(0))
    qt.QFileDialog = type("QFileDialog", (), dict.fromkeys(names, answer))
    slicer.util.openedUrls = []
    qt.QDesktopServices = types.SimpleNamespace(openUrl=slicer.util.openedUrls.append)
    _patchUtil()
    if checkout is None:
        python_layer.install_packages(ScriptedLoadableModule, ScriptedLoadableModuleTest)
    else:
        _installPythonLayerOf(Path(checkout), ctk)


def _installPythonLayerOf(checkout, ctk):
    """Slicer's own Python packages, from its sources, on the stand-ins for its widgets."""

    def anyWidget(name):
        return type(name, (), {})

    type(ctk).__getattr__ = _orElse(type(ctk).__getattr__, anyWidget)
    for name in ("qMRMLRangeWidget", "qMRMLSliderWidget", "qMRMLSpinBox", "qSlicerWidget"):
        setattr(slicer, name, anyWidget(name))
    slicer.__path__.append(str(checkout / "Base" / "Python" / "slicer"))
    for name in PYTHON_LAYER:
        setattr(slicer, name, importlib.import_module(f"slicer.{name}"))


def _orElse(function, fallback):
    def lookUp(self, name):
        try:
            return function(self, name)
        except AttributeError:
            if name.startswith("__"):
                raise
            setattr(self, name, fallback(name))
            return getattr(self, name)

    return lookUp


def _module(name):
    """A module that is there, as `slicer.modules` has it."""
    found = getattr(slicer.modules, name.lower(), None)
    if found is None:
        raise RuntimeError(f"Could not find module with name '{name}'")
    return found


def _patchUtil():
    util = slicer.util
    util.loadUI, util.childWidgetVariables = ui_loader.loadUI, ui_loader.ChildWidgets
    util.modulePath = lambda name: getattr(slicer.modules, name.lower()).path
    util.settingsValue = lambda key, default, converter=None: default
    util.shownErrors, util.shownMessages, util.selectedModules = [], [], []
    util.mainWindow = lambda: slicer.app.window
    util.selectModule = lambda name: util.selectedModules.append(_module(name).name)
    util.getModuleWidget = lambda name: _module(name).widget
    util.errorDisplay = lambda text, *_, **__: util.shownErrors.append(text)
    util.showStatusMessage = lambda text, *_: util.shownMessages.append(text)
