"""How a widget shows and returns the value of a parameter; one class per pair that Slicer itself supports."""

import typing

from PySide6 import QtWidgets

from . import ctk_widgets, qmrml_widgets


class Connector:
    """Widget on one side, a value on the other; `signal` names what the widget emits when the user changes it."""

    signal = ""

    def __init__(self, widget, field):
        self.widget, self.field, self._callback = widget, field, None

    def onChanged(self, callback):
        signal = getattr(self.widget, self.signal)
        if self._callback is not None:
            signal.disconnect(self._emit)
        self._callback = callback
        if callback is not None:
            signal.connect(self._emit)

    def _emit(self, *_):
        if self._callback is not None:
            self._callback()


class CheckBox(Connector):
    signal = "toggled"

    def read(self):
        return self.widget.checked

    def write(self, value):
        self.widget.checked = value


class Number(Connector):
    signal = "valueChanged"

    def __init__(self, widget, field):
        super().__init__(widget, field)
        bounds = [v for v in field.validators if hasattr(v, "minimum") and hasattr(v, "maximum")]
        if not bounds:
            raise RuntimeError(f"{widget.objectName}: a slider needs a parameter with a range")
        widget.minimum, widget.maximum = bounds[0].minimum, bounds[0].maximum

    def read(self):
        return self.field.type(self.widget.value)

    def write(self, value):
        self.widget.value = value


class ComboBox(Connector):
    signal = "currentIndexChanged"

    def __init__(self, widget, field):
        super().__init__(widget, field)
        choices = [v.choices for v in field.validators if hasattr(v, "choices")]
        self.values = list(choices[0] if choices else field.type)
        widget.clear()
        for value in self.values:
            widget.addItem(
                value.label() if hasattr(value, "label") else getattr(value, "name", str(value))
            )

    def read(self):
        return self.values[self.widget.currentIndex]

    def write(self, value):
        self.widget.currentIndex = self.values.index(value)


class Text(Connector):
    signal = "textChanged"

    def read(self):
        return self.widget.text

    def write(self, value):
        if self.widget.text != value:
            self.widget.text = value


class Label(Text):
    def onChanged(self, callback):
        """A label is only written."""


class NodeComboBox(Connector):
    signal = "currentNodeChanged"

    def __init__(self, widget, field):
        super().__init__(widget, field)
        types = typing.get_args(field.type) or (field.type,)
        widget.nodeTypes = [t.__name__ for t in types if t is not type(None)]

    def read(self):
        return self.widget.currentNode()

    def write(self, value):
        self.widget.setCurrentNode(value)


CONNECTORS = (
    (QtWidgets.QCheckBox, CheckBox),
    (QtWidgets.QSpinBox, Number),
    (QtWidgets.QDoubleSpinBox, Number),
    (ctk_widgets.ctkSliderWidget, Number),
    (QtWidgets.QComboBox, ComboBox),
    (QtWidgets.QLineEdit, Text),
    (QtWidgets.QLabel, Label),
    (qmrml_widgets.qMRMLNodeComboBox, NodeComboBox),
)


def connector(widget, field):
    """The connector for a widget; raises for a pair that Slicer does not support either."""
    for widgetClass, connectorClass in CONNECTORS:
        if isinstance(widget, widgetClass):
            return connectorClass(widget, field)
    raise RuntimeError(
        f"Unable to find a GUI connector for {type(widget).__name__} {widget.objectName} and {field.name}"
    )
