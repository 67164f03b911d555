"""The panel's widgets as values: their state is sent to the page, and what the user does there
comes back as their signals.

They answer as the widgets of Qt, CTK and Slicer do in the few words that the panel uses, so that
its code runs unchanged.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from SDFStentLib.validation import InputError


def shown(default: Any, signal: str = "") -> Any:
    """An attribute that the page shows; if `signal` is named, it is emitted with
    every new value."""
    return ShownAttribute(default, signal)


class ShownAttribute:
    def __init__(self, default: Any, signal: str) -> None:
        self.default, self.signal = default, signal

    def __set_name__(self, _owner: type, name: str) -> None:
        self.name = name

    def __get__(self, widget: Widget | None, _owner: type) -> Any:
        return self if widget is None else widget.shown.get(self.name, self.default)

    def __set__(self, widget: Widget, value: Any) -> None:
        value = widget.checked_value(self.name, value)
        if value == self.__get__(widget, type(widget)):
            return
        widget.shown[self.name] = value
        widget.tell()
        if self.signal:
            widget.emit(self.signal, value)


class Widget:
    """A widget with a name. `on_change(widget)` is called whenever it looks different."""

    edited = ""
    """The attribute that a user changes in the page."""

    visible = shown(True)
    enabled = shown(True)
    toolTip = shown("")
    text = shown("")
    wordWrap = shown(False)

    def __init__(self, name: str = "", parameter: str = "") -> None:
        self.objectName, self.parameter, self.plan = name, parameter, ""
        self.shown: dict[str, Any] = {}
        self.on_change: Callable[[Widget], None] | None = None
        self._slots: dict[str, list[tuple[Callable[..., Any], int | None]]] = {}
        self._is_blocked = False
        self.shortcuts: list[Any] = []

    def connect(self, signature: str, function: Callable[..., Any]) -> bool:
        """Call a function on a signal, with as many values as the signature names, as PythonQt
        does."""
        name, _, rest = signature.partition("(")
        arguments = rest.rstrip(")").strip()
        count = len(arguments.split(",")) if arguments else 0
        self._slots.setdefault(name, []).append((function, count))
        return True

    def disconnect(self, signature: str, function: Callable[..., Any]) -> bool:
        """Call a function no more on a signal."""
        slots = self._slots.get(signature.partition("(")[0], [])
        kept = [slot for slot in slots if slot[0] != function]
        isThere = len(kept) < len(slots)
        slots[:] = kept
        return isThere

    def emit(self, signal: str, *values: Any) -> None:
        """Call the functions connected to a signal."""
        if not self._is_blocked:
            for function, count in list(self._slots.get(signal, ())):
                function(*values[:count])

    def blockSignals(self, block: bool) -> bool:
        """Block the signals, or unblock them; returns whether they were blocked."""
        before, self._is_blocked = self._is_blocked, block
        return before

    def tell(self) -> None:
        """Tell the page that the widget looks different."""
        if self.on_change is not None:
            self.on_change(self)

    def checked_value(self, _name: str, value: Any) -> Any:
        """The value as this widget takes it."""
        return value

    def property(self, name: str) -> Any:
        """Property from the `.ui` file that is no attribute of the widget."""
        return {"SlicerParameterName": self.parameter, "plan": self.plan}.get(name)

    def setMRMLScene(self, scene: Any) -> None:
        """Emit the scene for the connected selectors; other widgets do not use it."""
        self.emit("mrmlSceneChanged", scene)

    def state(self) -> dict[str, Any]:
        """The state that the page needs, without the attribute `edited`."""
        values = {"visible": self.visible, "enabled": self.enabled}
        return {**values, "tip": self.toolTip, "text": self.text}

    def edit(self, value: Any) -> None:
        """Take a value that the user has set in the page, which may be anything."""


class Button(Widget):
    """A button to click."""

    def click(self) -> None:
        """Press the button, as the user does; a disabled one cannot be pressed."""
        if self.enabled:
            self.emit("clicked", False)


class CheckBox(Widget):
    """A box that is checked or not."""

    edited = "checked"
    checked = shown(False, "toggled")

    def checked_value(self, name: str, value: Any) -> Any:
        return bool(value) if name == "checked" else value

    def edit(self, value: Any) -> None:
        if isinstance(value, bool) and self.enabled:
            self.checked = value


class Number(Widget):
    """A number within its ends: a spin box, or with `has_slider` a slider with a spin box."""

    edited = "value"
    minimum, maximum = shown(0.0), shown(99.99)
    singleStep, pageStep = shown(1.0), shown(10.0)
    decimals, suffix, specialValueText = shown(2), shown(""), shown("")
    keyboardTracking, tracking = shown(True), shown(True)
    value = shown(0.0, "valueChanged")

    def __init__(self, name: str = "", parameter: str = "", has_slider: bool = False) -> None:
        super().__init__(name, parameter)
        self.has_slider = has_slider

    def checked_value(self, name: str, value: Any) -> Any:
        if name == "value":
            return min(max(float(value), self.minimum), self.maximum)
        return value

    def tell(self) -> None:
        super().tell()
        if not self.minimum <= self.value <= self.maximum:
            self.value = self.value  # its ends have moved

    def state(self) -> dict[str, Any]:
        ends = {"min": self.minimum, "max": self.maximum, "step": self.singleStep}
        words = {"suffix": self.suffix, "special": self.specialValueText}
        return {**super().state(), **ends, **words, "decimals": self.decimals}

    def edit(self, value: Any) -> None:
        self.tell()  # the page shows the present value again after text, or a number beyond the ends
        isNumber = isinstance(value, (int, float)) and not isinstance(value, bool)
        if not (isNumber and value == value and self.enabled):
            return
        if not self.minimum <= value <= self.maximum:
            raise InputError(
                f"Expected {self.minimum:g} to {self.maximum:g}{self.suffix}, got {value:g}; "
                f"it stays {self.value:g}{self.suffix}."
            )
        self.value = value


class LineEdit(Widget):
    """A field for a line of text."""

    edited = "text"
    text = shown("", "textChanged")
    readOnly = False

    def edit(self, value: Any) -> None:
        if isinstance(value, str) and self.enabled:
            self.text = value


class ComboBox(Widget):
    """A choice of one of several texts."""

    edited = "currentIndex"
    currentIndex = shown(-1, "currentIndexChanged")
    items = shown(())

    @property
    def count(self) -> int:
        return len(self.items)

    @property
    def currentText(self) -> str:
        return self.items[self.currentIndex] if 0 <= self.currentIndex < self.count else ""

    def addItem(self, text: str, _data: Any = None) -> None:
        """Append a text; the first text is chosen."""
        self.items = (*self.items, text)
        if self.currentIndex < 0:
            self.currentIndex = 0

    def itemText(self, index: int) -> str:
        return self.items[index]

    def findText(self, text: str) -> int:
        """Index of a text, or -1."""
        return self.items.index(text) if text in self.items else -1

    def removeItem(self, index: int) -> None:
        self.items = (*self.items[:index], *self.items[index + 1 :])
        self.currentIndex = min(self.currentIndex, self.count - 1)

    def clear(self) -> None:
        self.items = ()
        self.currentIndex = -1

    def state(self) -> dict[str, Any]:
        return {**super().state(), "items": list(self.items)}

    def edit(self, value: Any) -> None:
        if type(value) is int and 0 <= value < self.count and self.enabled:
            self.currentIndex = value
            self.emit("activated", value)


class ProgressBar(Widget):
    """A bar that shows the progress of something."""

    value, maximum = shown(0), shown(100)

    def state(self) -> dict[str, Any]:
        value = self.value if self.visible else 0  # nobody sees it: nothing to send
        return {**super().state(), "value": value, "max": self.maximum}


class CollapsibleSection(Widget):
    """A section of the panel that can be closed."""

    edited = "collapsed"
    collapsed = shown(False, "contentsCollapsed")
    collapsedHeight = shown(10)

    def edit(self, value: Any) -> None:
        if isinstance(value, bool):
            self.collapsed = value


class Area(Widget):
    """A widget that holds others."""


class Label(Widget):
    """A text to read."""


class Separator(Widget):
    """A line between widgets."""
