"""The widgets of CTK and Slicer in Qt: values of the page that Qt shows and lets a user edit.

What they answer and emit is said once, in `SDFStentApp`. `check_panel.py` holds the panel against the real headers as well.
"""

from functools import partial
from types import SimpleNamespace

import slicer
from PySide6 import QtWidgets
from PySide6.QtCore import QSignalBlocker, QSize, Qt
from PySide6.QtWidgets import QSizePolicy
from vtkmodules.vtkCommonCore import vtkCommand

from SDFStentApp import selectors, widgets

from .qt_stand_in import wrapped


class Skin:
    """A widget of Qt that is one of the page's values as well: `_show` is called when that has changed."""

    def __init__(self, parent=None):
        QtWidgets.QWidget.__init__(self, parent)
        super().__init__()
        self._make()
        self.on_change = type(self)._show
        self._show()

    def _row(self, *parts):
        layout = QtWidgets.QHBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        for part in parts:
            layout.addWidget(part)

    def _make(self):
        """Make what it consists of."""

    def _show(self):
        """Show the value, without a signal."""


class Signal:
    """A signal by its name, `widget.signal.connect(function)`, as Slicer's own connectors write it."""

    def __set_name__(self, _owner, name):
        self._signature = f"{name}()"

    def __get__(self, widget, _owner):
        ways = (widget.connect, widget.disconnect)
        return SimpleNamespace(**{way.__name__: partial(way, self._signature) for way in ways})


class qMRMLWidget(Skin, widgets.Area, QtWidgets.QWidget):
    pass


class ctkCollapsibleButton(Skin, widgets.CollapsibleSection, QtWidgets.QWidget):
    def _make(self):
        self.setSizePolicy(QSizePolicy.Preferred, QSizePolicy.Preferred)
        self._header = QtWidgets.QToolButton(self)
        self._header.setToolButtonStyle(Qt.ToolButtonTextBesideIcon)
        self._header.setSizePolicy(QSizePolicy.Expanding, QSizePolicy.Fixed)
        self._header.clicked.connect(lambda: self.edit(not self.collapsed))
        self.setContentsMargins(0, self._header.sizeHint().height() + 2, 0, 0)
        self._hidden = []

    def sizeHint(self):
        return self._closedSize() if self.collapsed else super().sizeHint()

    def minimumSizeHint(self):
        return self._closedSize() if self.collapsed else super().minimumSizeHint()

    def _closedSize(self):
        return self._header.sizeHint() + QSize(0, self.collapsedHeight)

    def resizeEvent(self, event):
        self._header.setGeometry(0, 0, event.size().width(), self._header.sizeHint().height())

    def _show(self):
        self._header.setText(self.text)
        self._header.setArrowType(Qt.RightArrow if self.collapsed else Qt.DownArrow)
        if self.collapsed == bool(self._hidden):
            return
        if self.collapsed:
            children = self.findChildren(QtWidgets.QWidget, options=Qt.FindDirectChildrenOnly)
            self._hidden = [c for c in children if c is not self._header and not c.isHidden()]
        for child in self._hidden:  # what the panel has hidden itself stays hidden
            child.setVisible(not self.collapsed)
        if not self.collapsed:
            self._hidden = []
        self.updateGeometry()


class ctkSliderWidget(Skin, widgets.Number, QtWidgets.QWidget):
    valueChanged = Signal()

    def _make(self):
        self._slider = QtWidgets.QSlider(Qt.Horizontal, self)
        self._slider.setRange(0, 1000)
        self._spinBox = QtWidgets.QDoubleSpinBox(self)
        self._row(self._slider, self._spinBox)
        self._slider.valueChanged.connect(self._onSlider)
        self._spinBox.valueChanged.connect(self.edit)

    def checked_value(self, name, value):
        value = super().checked_value(name, value)
        return round(value, self.decimals) if name == "value" else value

    def _onSlider(self, position):
        if self._slider.hasFocus() or self._slider.isSliderDown():
            self.edit(self.minimum + (self.maximum - self.minimum) * position / 1000)

    def _show(self):
        span = self.maximum - self.minimum
        box, slider = self._spinBox, self._slider
        with QSignalBlocker(box):
            box.setDecimals(self.decimals)
            box.setRange(self.minimum, self.maximum)
            box.setSingleStep(self.singleStep)
            box.setSuffix(self.suffix)
            box.setValue(self.value)
        with QSignalBlocker(slider):
            slider.setValue(round(1000 * (self.value - self.minimum) / span) if span else 0)


class Selector(Skin):
    """A combo box over what a selector offers; `LABEL` is what the widget itself writes before it."""

    LABEL = ""
    _items = None

    def _make(self):
        self._box = QtWidgets.QComboBox(self)
        self._box.activated.connect(lambda index: self.edit(self._box.itemData(index)))
        label = wrapped(QtWidgets.QLabel)(self.LABEL, self)
        label.setVisible(bool(self.LABEL))
        self._row(label, self._box)
        self.layout().setStretch(1, 1)

    def _show(self):
        state = self.state()
        items = [(one["name"], one["id"]) for one in state["items"]]
        if state.get("none") is not None or not items:
            items.insert(0, (state.get("none") or "", ""))
        if state.get("add"):
            items.append((f"Create new {self.baseName or 'node'}", selectors.NEW))
        chosen = getattr(self, self.edited)
        if items != self._items:
            with QSignalBlocker(self._box):
                self._box.clear()
                for name, value in items:
                    self._box.addItem(name, value)
            self._items = items
        if self._box.currentData() != chosen:
            with QSignalBlocker(self._box):
                self._box.setCurrentIndex(self._box.findData(chosen))


class qMRMLNodeComboBox(Selector, selectors.NodeComboBox, QtWidgets.QWidget):
    currentNodeChanged = Signal()


class qMRMLSegmentSelectorWidget(Selector, selectors.SegmentSelector, QtWidgets.QWidget):
    LABEL = "Segment: "


class qSlicerMarkupsPlaceWidget(Skin, selectors.PlaceWidget, QtWidgets.QWidget):
    """Places by the application's own interaction; the placing itself is that of Slicer's own views."""

    def _make(self):
        self._button = QtWidgets.QPushButton("Place", self)
        self._button.setCheckable(True)
        self._button.toggled.connect(self._set)
        self._row(self._button)
        self._observed, self._wasPlacing = [], False

    def setMRMLScene(self, scene):
        for node, tag in self._observed:
            node.RemoveObserver(tag)
        nodes = (self._interaction, self._selection) if scene else ()
        self._observed = [
            (node, node.AddObserver(vtkCommand.ModifiedEvent, lambda *_: self._show()))
            for node in nodes
        ]

    @property
    def _interaction(self):
        return slicer.app.applicationLogic().GetInteractionNode()

    @property
    def _selection(self):
        return slicer.app.applicationLogic().GetSelectionNode()

    def setCurrentNode(self, node):
        self._node = node
        self._show()

    def _get(self):
        interaction, node = self._interaction, self._node
        isActive = node is not None and self._selection.GetActivePlaceNodeID() == node.GetID()
        return isActive and interaction.GetCurrentInteractionMode() == interaction.Place

    def _set(self, isPlacing):
        if self._node is None:
            return
        interaction, selection = self._interaction, self._selection
        if isPlacing:
            selection.SetReferenceActivePlaceNodeClassName(self._node.GetClassName())
            selection.SetActivePlaceNodeID(self._node.GetID())
        mode = interaction.Place if isPlacing else interaction.ViewTransform
        interaction.SetCurrentInteractionMode(mode)
        self._show()

    placeModeEnabled = property(lambda self: self._get(), lambda self, value: self._set(value))
    placeModePersistency = property(
        lambda self: bool(self._interaction.GetPlaceModePersistence()),
        lambda self, value: self._interaction.SetPlaceModePersistence(value),
    )

    def _show(self):
        isComplete = self._node is not None and self._node.GetControlPointPlacementComplete()
        isPlacing = self._get()
        with QSignalBlocker(self._button):
            self._button.setEnabled(self._node is not None and not isComplete)
            self._button.setChecked(isPlacing)
        if isPlacing != self._wasPlacing:
            self._wasPlacing = isPlacing
            self.emit("activeMarkupsPlaceModeChanged", isPlacing)


CTK = {one.__name__: one for one in (ctkCollapsibleButton, ctkSliderWidget)}
SLICER = {
    one.__name__: one
    for one in (
        qMRMLWidget,
        qMRMLNodeComboBox,
        qMRMLSegmentSelectorWidget,
        qSlicerMarkupsPlaceWidget,
    )
}
