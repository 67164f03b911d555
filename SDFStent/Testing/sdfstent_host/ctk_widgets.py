"""Look-alikes of CTK widgets: their properties, slots and signals, plain Qt inside."""

from PySide6.QtCore import Property, QSize, Qt, Signal
from PySide6.QtWidgets import (
    QDoubleSpinBox,
    QHBoxLayout,
    QSizePolicy,
    QSlider,
    QToolButton,
    QWidget,
)

COLLAPSED_HEIGHT = 10
"""Of the frame below a closed section, as in CTK."""


class ctkCollapsibleButton(QWidget):
    contentsCollapsed = Signal(bool)

    def __init__(self, parent=None):
        super().__init__(parent)
        self.setSizePolicy(QSizePolicy.Preferred, QSizePolicy.Preferred)
        self._header = QToolButton(self)
        self._header.setToolButtonStyle(Qt.ToolButtonTextBesideIcon)
        self._header.setArrowType(Qt.DownArrow)
        self._header.setSizePolicy(QSizePolicy.Expanding, QSizePolicy.Fixed)
        self._header.clicked.connect(lambda: self._setCollapsed(not self._collapsed))
        self.setContentsMargins(0, self._header.sizeHint().height() + 2, 0, 0)
        self._collapsed, self._shown = False, []

    def sizeHint(self):
        return self._closedSize() if self._collapsed else super().sizeHint()

    def minimumSizeHint(self):
        return self._closedSize() if self._collapsed else super().minimumSizeHint()

    def _closedSize(self):
        return self._header.sizeHint() + QSize(0, COLLAPSED_HEIGHT)

    def resizeEvent(self, event):
        self._header.setGeometry(0, 0, event.size().width(), self._header.sizeHint().height())

    def _text(self):
        return self._header.text()

    def _setText(self, text):
        self._header.setText(text)

    def _isCollapsed(self):
        return self._collapsed

    def _setCollapsed(self, collapsed):
        self._collapsed = collapsed
        self._header.setArrowType(Qt.RightArrow if collapsed else Qt.DownArrow)
        if collapsed:  # said again once the children are there
            children = self.findChildren(QWidget, options=Qt.FindDirectChildrenOnly)
            self._shown += [c for c in children if c is not self._header and not c.isHidden()]
        for child in self._shown:  # what the panel has hidden itself stays hidden
            child.setVisible(not collapsed)
        if not collapsed:
            self._shown = []
        self.updateGeometry()
        self.contentsCollapsed.emit(collapsed)

    text = Property(str, _text, _setText)
    collapsed = Property(bool, _isCollapsed, _setCollapsed)


class ctkSliderWidget(QWidget):
    valueChanged = Signal(float)
    valueIsChanging = Signal(float)

    def __init__(self, parent=None):
        super().__init__(parent)
        layout = QHBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        self._slider = QSlider(Qt.Horizontal, self)
        self._slider.setRange(0, 1000)
        self._spinBox = QDoubleSpinBox(self)
        self._spinBox.setKeyboardTracking(False)
        layout.addWidget(self._slider)
        layout.addWidget(self._spinBox)
        self._tracking = True
        self._slider.valueChanged.connect(self._onSlider)
        self._spinBox.valueChanged.connect(self._onSpinBox)
        self._spinBox.setMaximum(100.0)

    def _onSlider(self, position):
        if self._slider.hasFocus() or self._slider.isSliderDown():
            self._setValue(self._minimum() + (self._maximum() - self._minimum()) * position / 1000)

    def _onSpinBox(self, value):
        self._placeSlider()
        self.valueChanged.emit(value)

    def _placeSlider(self):
        self._slider.blockSignals(True)
        span = self._maximum() - self._minimum()
        self._slider.setValue(round(1000 * (self._value() - self._minimum()) / span) if span else 0)
        self._slider.blockSignals(False)

    def _value(self):
        return self._spinBox.value()

    def _setValue(self, value):
        self._spinBox.setValue(value)

    def _minimum(self):
        return self._spinBox.minimum()

    def _setMinimum(self, value):
        self._spinBox.setMinimum(value)
        self._placeSlider()

    def _maximum(self):
        return self._spinBox.maximum()

    def _setMaximum(self, value):
        self._spinBox.setMaximum(value)
        self._placeSlider()

    def _singleStep(self):
        return self._spinBox.singleStep()

    def _setSingleStep(self, value):
        self._spinBox.setSingleStep(value)

    def _decimals(self):
        return self._spinBox.decimals()

    def _setDecimals(self, value):
        self._spinBox.setDecimals(value)

    def _suffix(self):
        return self._spinBox.suffix()

    def _setSuffix(self, value):
        self._spinBox.setSuffix(value)

    def _pageStep(self):
        return self._slider.pageStep()

    def _setPageStep(self, value):
        self._slider.setPageStep(max(1, round(value)))

    def _isTracking(self):
        return self._tracking

    def _setTracking(self, tracking):
        self._tracking = tracking

    decimals = Property(int, _decimals, _setDecimals)
    minimum = Property(float, _minimum, _setMinimum)
    maximum = Property(float, _maximum, _setMaximum)
    singleStep = Property(float, _singleStep, _setSingleStep)
    pageStep = Property(float, _pageStep, _setPageStep)
    suffix = Property(str, _suffix, _setSuffix)
    tracking = Property(bool, _isTracking, _setTracking)
    value = Property(float, _value, _setValue)


CTK_WIDGETS = {c.__name__: c for c in (ctkCollapsibleButton, ctkSliderWidget)}
