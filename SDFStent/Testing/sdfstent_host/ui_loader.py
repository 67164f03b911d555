"""Load a .ui file as Slicer's `slicer.util.loadUI` does, with stand-ins for every widget that is not Qt's own."""

import tempfile
import xml.etree.ElementTree as ElementTree
from pathlib import Path

from PySide6 import QtCore, QtUiTools, QtWidgets

from .ctk_widgets import CTK_WIDGETS
from .qmrml_widgets import QMRML_WIDGETS
from .qt_stand_in import wrapped

# PySide6 may make a new wrapper for a widget nobody holds, and a plain one then.
_alive = []


class Loader(QtUiTools.QUiLoader):
    def createWidget(self, className, parent=None, name=""):
        cls = (
            CTK_WIDGETS.get(className)
            or QMRML_WIDGETS.get(className)
            or getattr(QtWidgets, className, None)
        )
        if cls is None:
            raise LookupError(f"No stand-in for the widget class {className} ({name}).")
        widget = wrapped(cls)(parent)
        widget.setObjectName(name)
        _alive.append(widget)
        return widget


def loadUI(path):
    """The panel's top widget. Connections of the file are made in Python, and are listed when they cannot be."""
    tree = ElementTree.parse(path)
    root = tree.getroot()
    connections = root.find("connections")
    if connections is not None:
        root.remove(connections)
    collapsed = _collapsedButtons(root)
    with tempfile.TemporaryDirectory() as folder:
        stripped = Path(folder) / "panel.ui"
        tree.write(stripped)
        file = QtCore.QFile(str(stripped))
        file.open(QtCore.QIODevice.ReadOnly)
        widget = Loader().load(file)
        file.close()
    for name in collapsed:  # the loader sets container properties before the children exist
        child(widget, name).setProperty("collapsed", True)
    for connection in connections if connections is not None else ():
        part = {element.tag: element.text for element in connection}
        sender, receiver = child(widget, part["sender"]), child(widget, part["receiver"])
        getattr(sender, part["signal"].partition("(")[0]).connect(
            getattr(receiver, part["slot"].partition("(")[0])
        )
    return widget


def child(widget, name):
    found = widget if widget.objectName == name else widget.findChild(QtCore.QObject, name)
    if found is None:
        raise LookupError(f"The panel has no widget called {name}.")
    return found


class ChildWidgets:
    """What `slicer.util.childWidgetVariables` returns: one attribute per named child."""

    def __init__(self, widget):
        for found in widget.findChildren(QtWidgets.QWidget):
            name = QtCore.QObject.property(found, "objectName")
            if name and not name.startswith("qt_"):
                setattr(self, name, found)


def _collapsedButtons(root):
    return [
        node.get("name")
        for node in root.iter("widget")
        for prop in node.findall("property")
        if prop.get("name") == "collapsed" and prop.findtext("bool") == "true"
    ]
