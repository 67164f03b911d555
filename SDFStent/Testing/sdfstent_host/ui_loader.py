"""Loads a .ui file as Slicer's `slicer.util.loadUI` does, with skins for every widget that is not Qt's own."""

import xml.etree.ElementTree as ElementTree
from functools import cache

from PySide6 import QtCore, QtUiTools, QtWidgets

from SDFStentApp.ui_file import connect, fill

from . import skins
from .qt_stand_in import wrapped

# Keeps the widgets: for one that nobody holds, PySide6 may make a new wrapper, which then is of a plain class.
_alive = []


class Loader(QtUiTools.QUiLoader):
    def createWidget(self, className, parent=None, name=""):
        cls = {**skins.CTK, **skins.SLICER}.get(className) or getattr(QtWidgets, className)
        widget = wrapped(cls)(parent)
        widget.setObjectName(name)
        _alive.append(widget)
        return widget


@cache
def parsed(path):
    """A .ui file as parsed, and without its connections for Qt's loader. It is kept, since every test has a panel of
    its own."""
    root = ElementTree.parse(path).getroot()
    root.remove(connections := root.find("connections"))
    given = ElementTree.tostring(root)
    root.append(connections)
    return root, given


def loadUI(path):
    """The panel's top widget. Properties and connections of skins, which Qt's loader does not know, are
    set afterward."""
    root, given = parsed(path)
    buffer = QtCore.QBuffer()
    buffer.setData(given)
    widget = Loader().load(buffer)

    def named(name):
        return widget if widget.objectName == name else widget.findChild(QtCore.QObject, name)

    for element in root.iter("widget"):
        if isinstance(found := named(element.get("name")), skins.Skin):
            fill(found, element)
    connect(root, named)
    return widget


class ChildWidgets:
    """The result of `slicer.util.childWidgetVariables`: one attribute per named child."""

    def __init__(self, widget):
        for found in widget.findChildren(QtWidgets.QWidget):
            name = QtCore.QObject.property(found, "objectName")
            if name and not name.startswith("qt_"):
                setattr(self, name, found)
