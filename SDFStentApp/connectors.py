"""Connectors, which show the value of a parameter in a widget of the page and return it, as
Slicer's own do."""

from __future__ import annotations

import typing
from collections.abc import Callable
from typing import Any


class Connector:
    """Connects a widget with a value; `signal` is what the widget emits when the
    user changes it."""

    signal = attribute = ""

    def __init__(self, widget: Any, field: Any) -> None:
        self.widget, self.field = widget, field
        self._callback: Callable[[], None] | None = None

    def onChanged(self, callback: Callable[[], None] | None) -> None:
        """Call this function when the user changes the value; with None call nothing any more."""
        if self._callback is None and callback is not None:
            self.widget.connect(f"{self.signal}()", self._emit)
        elif callback is None:
            self.widget.disconnect(f"{self.signal}()", self._emit)
        self._callback = callback

    def _emit(self) -> None:
        if self._callback is not None:
            self._callback()

    def read(self) -> Any:
        """The value that the widget shows."""
        return getattr(self.widget, self.attribute)

    def write(self, value: Any) -> None:
        """Let the widget show a value."""
        setattr(self.widget, self.attribute, value)


class CheckBoxConnector(Connector):
    signal, attribute = "toggled", "checked"


class NumberConnector(Connector):
    signal, attribute = "valueChanged", "value"

    def __init__(self, widget: Any, field: Any) -> None:
        super().__init__(widget, field)
        ends = next(one for one in field.validators if hasattr(one, "maximum"))
        widget.minimum, widget.maximum = ends.minimum, ends.maximum

    def read(self) -> Any:
        return self.field.type(self.widget.value)


class ComboBoxConnector(Connector):
    signal = "currentIndexChanged"

    def __init__(self, widget: Any, field: Any) -> None:
        super().__init__(widget, field)
        choices = [one.choices for one in field.validators if hasattr(one, "choices")]
        self.values = list(choices[0] if choices else field.type)
        widget.clear()
        for value in self.values:
            widget.addItem(value.label() if hasattr(value, "label") else str(value))

    def read(self) -> Any:
        return self.values[self.widget.currentIndex]

    def write(self, value: Any) -> None:
        self.widget.currentIndex = self.values.index(value)


class TextConnector(Connector):
    signal, attribute = "textChanged", "text"

    def write(self, value: Any) -> None:
        if self.read() != value:  # else the cursor would jump
            super().write(value)


class LabelConnector(TextConnector):
    def onChanged(self, callback: Callable[[], None] | None) -> None:
        """Do nothing: the user cannot change a label."""


class NodeConnector(Connector):
    signal = "currentNodeChanged"

    def __init__(self, widget: Any, field: Any) -> None:
        super().__init__(widget, field)
        types = typing.get_args(field.type) or (field.type,)
        widget.nodeTypes = tuple(one.__name__ for one in types if one is not type(None))

    def read(self) -> Any:
        return self.widget.currentNode()

    def write(self, value: Any) -> None:
        self.widget.setCurrentNode(value)


CONNECTORS = {
    "CheckBox": CheckBoxConnector,
    "SpinBox": NumberConnector,
    "DoubleSpinBox": NumberConnector,
    "Number": NumberConnector,
    "ComboBox": ComboBoxConnector,
    "LineEdit": TextConnector,
    "Label": LabelConnector,
    "NodeComboBox": NodeConnector,
}


def connector(widget: Any, field: Any) -> Connector:
    """The connector for a widget, of the page or of Qt, and a field of a parameter node."""
    for one in type(widget).__mro__:
        kind = CONNECTORS.get(one.__name__.removeprefix("Q"))
        if kind is not None:
            return kind(widget, field)
    raise RuntimeError(f"{widget.objectName}: there is no connector to {field.name}.")
