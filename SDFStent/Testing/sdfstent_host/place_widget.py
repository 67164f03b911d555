"""A look-alike of the widget that starts the placing of markups; the placing itself is that of Slicer's own views."""

import slicer
from PySide6.QtCore import Property, Signal
from PySide6.QtWidgets import QHBoxLayout, QPushButton, QWidget
from vtkmodules.vtkCommonCore import vtkCommand


class qSlicerMarkupsPlaceWidget(QWidget):
    activeMarkupsPlaceModeChanged = Signal(bool)

    def __init__(self, parent=None):
        super().__init__(parent)
        layout = QHBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        self._button = QPushButton("Place", self)
        self._button.setCheckable(True)
        self._button.toggled.connect(self._setPlaceModeEnabled)
        layout.addWidget(self._button)
        self._node, self._scene, self._flags = None, None, {}
        self._observed, self._wasPlacing = [], False
        self.destroyed.connect(lambda *_, observed=self._observed: _release(observed))

    def mrmlScene(self):
        return self._scene

    def setMRMLScene(self, scene):
        self._scene = scene
        _release(self._observed)
        for node in (self._interaction(), self._selection()) if scene else ():
            tag = node.AddObserver(vtkCommand.ModifiedEvent, lambda *_: self._update())
            self._observed.append((node, tag))

    def _interaction(self):
        return slicer.app.applicationLogic().GetInteractionNode()

    def _selection(self):
        return slicer.app.applicationLogic().GetSelectionNode()

    def currentNode(self):
        return self._node

    def setCurrentNode(self, node):
        self._node = node
        self._update()

    def _isPlaceModeEnabled(self):
        interaction, node = self._interaction(), self._node
        isActive = node is not None and self._selection().GetActivePlaceNodeID() == node.GetID()
        return isActive and interaction.GetCurrentInteractionMode() == interaction.Place

    def _setPlaceModeEnabled(self, enabled):
        if self._node is None:
            return
        interaction, selection = self._interaction(), self._selection()
        if enabled:
            selection.SetReferenceActivePlaceNodeClassName(self._node.GetClassName())
            selection.SetActivePlaceNodeID(self._node.GetID())
        mode = interaction.Place if enabled else interaction.ViewTransform
        interaction.SetCurrentInteractionMode(mode)
        self._update()

    def setPlaceModeEnabled(self, enabled):
        self._setPlaceModeEnabled(enabled)

    def _isPersistent(self):
        return bool(self._interaction().GetPlaceModePersistence())

    def _setPersistent(self, isPersistent):
        self._interaction().SetPlaceModePersistence(isPersistent)

    def _update(self):
        isComplete = self._node is not None and self._node.GetControlPointPlacementComplete()
        self._button.setEnabled(self._node is not None and not isComplete)
        isPlacing = self._isPlaceModeEnabled()
        self._button.blockSignals(True)
        self._button.setChecked(isPlacing)
        self._button.blockSignals(False)
        if isPlacing != self._wasPlacing:
            self._wasPlacing = isPlacing
            self.activeMarkupsPlaceModeChanged.emit(isPlacing)

    def _flag(name):
        return Property(
            bool,
            lambda self: self._flags.get(name, True),
            lambda self, v: self._flags.update({name: v}),
        )

    placeModeEnabled = Property(bool, _isPlaceModeEnabled, _setPlaceModeEnabled)
    placeModePersistency = Property(bool, _isPersistent, _setPersistent)
    buttonsVisible = _flag("buttonsVisible")
    deleteAllControlPointsOptionVisible = _flag("deleteAllControlPointsOptionVisible")


def _release(observed):
    for node, tag in observed:
        node.RemoveObserver(tag)
    observed.clear()
