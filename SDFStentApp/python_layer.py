"""The parts of Slicer's Python layer that the module imports and `slicer-core` does not have."""

from __future__ import annotations

import sys
import types
from pathlib import Path
from typing import Any

import slicer

from . import module_base, parameter_node
from .ui_file import UiPanel


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
    install_packages()


def install_packages(*bases: type) -> None:
    """Install stand-ins for Slicer's own Python packages; `bases` are further base classes that an
    application has."""
    _add("slicer.i18n", tr=lambda text: text, translate=lambda _context, text: text)
    kinds = [one for name, one in vars(module_base).items() if name.startswith("Scripted")]
    classes = {one.__name__: one for one in (*kinds, *bases)}
    _add("slicer.ScriptedLoadableModule", __all__=list(classes), **classes)
    names = ("parameterNodeWrapper", "WithinRange")
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
