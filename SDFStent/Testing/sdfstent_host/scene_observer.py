"""How a widget of qMRML hears of its scene: the events and priorities of Slicer's scene model."""

import vtk
from PySide6.QtWidgets import QComboBox, QHBoxLayout, QLabel, QWidget

from .qt_stand_in import wrapped

EVENTS = {
    "NodeAddedEvent": 10.0,
    "NodeAboutToBeRemovedEvent": -10.0,
    "NodeRemovedEvent": 10.0,
    "EndCloseEvent": 0.0,
    "EndImportEvent": 0.0,
}


class SceneObserver:
    """Calls `callback(event, node)` on every change of the scene's content, and lets go of the scene again."""

    def __init__(self, callback):
        self._callback, self._scene, self._tags = callback, None, []

    def observe(self, scene):
        for tag in self._tags:
            self._scene.RemoveObserver(tag)
        self._scene = scene
        self._tags = [self._add(name) for name in EVENTS] if scene else []

    def _add(self, name):
        @vtk.calldata_type(vtk.VTK_OBJECT)
        def heard(_scene, _event, node=None):
            self._callback(name, node)

        return self._scene.AddObserver(getattr(self._scene, name), heard, EVENTS[name])


class SceneSelector(QWidget):
    """A combo box over the content of a scene, which says `_onScene(event, node)` when that changes."""

    LABEL = ""
    """What the widget itself writes before its box."""

    def __init__(self, parent=None):
        super().__init__(parent)
        self._box = QComboBox(self)
        layout = QHBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        if self.LABEL:
            layout.addWidget(wrapped(QLabel)(self.LABEL, self))
        layout.addWidget(self._box, 1)
        self._scene = None
        self._observer = SceneObserver(self._onScene)
        self.destroyed.connect(lambda *_, observer=self._observer: observer.observe(None))

    def mrmlScene(self):
        return self._scene

    def setMRMLScene(self, scene):
        self._scene = scene
        self._observer.observe(scene)

    def _show(self, labels, index):
        """Fill the box without a signal."""
        self._box.blockSignals(True)
        self._box.clear()
        self._box.addItems(labels)
        self._box.setCurrentIndex(index)
        self._box.blockSignals(False)


def neighbor(items, item):
    """What a combo box shows when the row that it shows is taken out: the next row, or else the one before; None when alone."""
    index = items.index(item)
    others = items[:index] + items[index + 1 :]
    return others[min(index, len(others) - 1)] if others else None
