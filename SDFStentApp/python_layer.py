"""The parts of Slicer's Python layer and of Qt that the module imports and `slicer-core` does not
have."""

from __future__ import annotations

import asyncio
import contextlib
import sys
import types
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import slicer
from vtkmodules.util import numpy_support

from . import module_base, parameter_node, tables
from .ui_file import UiPanel


class AsyncTimer:
    """A timer of the module's `Clock`, run by asyncio's event loop; a repeated timer lets all other
    work have its turn."""

    WAIT_S = 0.001
    """Waiting for threads is short: they advance anyway, and best beside the drawing of a frame."""

    TURN_S = (0.002, 0.002)

    def __init__(self, call: Callable[[], Any], milliseconds: float, isRepeated: bool) -> None:
        self._call, self._seconds, self._isRepeated = call, milliseconds / 1000, isRepeated
        self._waiting: asyncio.TimerHandle | None = None

    def start(self) -> None:
        """Begin to wait, or begin anew."""
        self.stop()
        self._waiting = asyncio.get_running_loop().call_later(self._seconds, self._run)

    def stop(self) -> None:
        """Cancel the call that is still to come."""
        if self._waiting is not None:
            self._waiting.cancel()
        self._waiting = None

    def isActive(self) -> bool:
        """Whether a call is still to come."""
        return self._waiting is not None

    def _run(self) -> None:
        self._waiting = None
        if self._isRepeated:
            self.start()  # first: the call may stop it
        self._call()


class FileDialog:
    """Stand-in for Qt's questions for a file: the page has asked before, and `answering` sets the
    answer."""

    _answer = ""

    @classmethod
    @contextlib.contextmanager
    def answering(cls, path: Path) -> Iterator[None]:
        """Within the block every question for a file or a folder is answered with this path."""
        cls._answer = str(path)
        try:
            yield
        finally:
            cls._answer = ""

    @classmethod
    def getOpenFileName(cls, *_question: Any) -> str:
        return cls._answer

    @classmethod
    def getOpenFileNames(cls, *_question: Any) -> list[str]:
        return [cls._answer] if cls._answer else []

    getSaveFileName = getExistingDirectory = getOpenFileName


WITH_CHILDREN, EVERYWHERE = 3, 2
"""The places where a key works: in its widget, or in all widgets."""


class Shortcut:
    """A key of the panel, which belongs to a widget; the page looks through the `shortcuts` of its
    widgets when a key is pressed."""

    def __init__(self, key: str, widget: Any) -> None:
        self.key, self._widget = key, widget
        self._isEnabled, self._context = True, WITH_CHILDREN
        self._functions: list[Callable[[], Any]] = []
        widget.shortcuts.append(self)

    def setContext(self, context: int) -> None:
        self._context = context

    def setEnabled(self, isEnabled: bool) -> None:
        self._isEnabled = isEnabled

    def connect(self, _signature: str, function: Callable[[], Any]) -> None:
        self._functions.append(function)

    def press(self, name: Any) -> None:
        """Call the functions of the key, which was pressed in a widget of this name."""
        isMeant = self._context == EVERYWHERE or name == self._widget.objectName
        if self._isEnabled and isMeant:
            for function in self._functions:
                function()


class Vtk(types.ModuleType):
    """VTK under its old name, from which functions of `slicer.util` import: all of it takes 50 MB
    more than the modules that are loaded anyway."""

    def __getattr__(self, name: str) -> Any:
        for key, module in list(sys.modules.items()):
            if key.startswith("vtkmodules.vtk") and hasattr(module, name):
                return getattr(module, name)
        raise AttributeError(f"VTK has no {name} in the modules that are loaded.")


def install(application: Any) -> None:
    """Put all stand-ins where the module looks for them. Call it once, before the module is
    imported."""
    slicer.mrmlScene = application.scene
    slicer.app = types.SimpleNamespace(
        applicationLogic=lambda: application.applicationLogic,
        layoutManager=lambda: None,  # the page lays out its one view itself
    )
    slicer.modules = types.SimpleNamespace()
    slicer.util.loadUI = _loaded
    slicer.util.childWidgetVariables = lambda top: top.panel
    if "vtk" not in sys.modules:
        sys.modules["vtk"] = sys.modules["vtk.util"] = vtk = Vtk("vtk")
        vtk.util, vtk.numpy_support = vtk, numpy_support
        sys.modules["vtk.util.numpy_support"] = numpy_support
    install_packages()
    _add(
        "qt",
        QTableWidgetItem=tables.TableItem,
        QHeaderView=types.SimpleNamespace(ResizeToContents=3, Stretch=1),
        QFileDialog=FileDialog,
        QShortcut=Shortcut,
        QUrl=types.SimpleNamespace(fromLocalFile=lambda path: path),
        QDesktopServices=types.SimpleNamespace(openUrl=lambda _path: None),  # the browser's
        QKeySequence=lambda key: key,
        QCoreApplication=types.SimpleNamespace(sendPostedEvents=lambda _receiver, _kind: None),
        QEvent=types.SimpleNamespace(LayoutRequest=76),
        Qt=types.SimpleNamespace(
            Checked=tables.CHECKED,
            Unchecked=tables.UNCHECKED,
            ItemIsSelectable=1,
            ItemIsEditable=tables.CAN_BE_EDITED,
            ItemIsUserCheckable=tables.CAN_BE_CHECKED,
            ItemIsEnabled=32,
            WidgetWithChildrenShortcut=WITH_CHILDREN,
            ApplicationShortcut=EVERYWHERE,
        ),
    )


def install_packages(*bases: type) -> None:
    """Install stand-ins for Slicer's own Python packages; `bases` are further base classes that an
    application has."""
    _add("slicer.i18n", tr=lambda text: text, translate=lambda _context, text: text)
    kinds = [one for name, one in vars(module_base).items() if name.startswith("Scripted")]
    classes = {one.__name__: one for one in (*kinds, *bases)}
    _add("slicer.ScriptedLoadableModule", __all__=list(classes), **classes)
    names = ("parameterNodeWrapper", "parameterPack", "WithinRange", "Choice")
    _add("slicer.parameterNodeWrapper", **{n: getattr(parameter_node, n) for n in names})


def _add(name: str, **contents: Any) -> None:
    module = types.ModuleType(name)
    vars(module).update(contents)
    sys.modules[name] = module
    if name.startswith("slicer."):
        setattr(slicer, name.partition(".")[2], module)


def _loaded(path: str) -> Any:
    """The top widget of a `.ui` file, as `slicer.util.loadUI` returns it."""
    panel = UiPanel(Path(path))
    top = panel.top.widget
    top.panel = panel  # type: ignore[attr-defined]
    # The browser gives the page its size.
    layout = types.SimpleNamespace(
        heightForWidth=lambda _width: 0,
        minimumSize=lambda: types.SimpleNamespace(width=lambda: 0),
    )
    top.layout = lambda: layout  # type: ignore[attr-defined]
    top.width = top.minimumWidth = 0  # type: ignore[attr-defined]
    return top
