"""Binds widgets to the plan: one whose property `plan` is a path, such as "stents.selected.diameter", shows the value there and sets it.

A number behind which " %" or " L/min" stands is shown so, and is a fraction or mL/s in the plan; one with a special text for its least
value stands for none there. This is the same in Qt and in the page.
"""

from SDFStentLib.stent import KEPT

from . import Sizes
from .ParameterNode import stentOf
from .PlanFields import (
    CHOICE_LABELS,
    KEPT_LABELS,
    METHOD_PARAMETERS,
    PATHS,
    RANGES,
    UNITS,
    Placement,
)

SELECTED = "stents.selected."
IN_USE = {
    f"{SELECTED}length": Sizes.lengthOf,
    f"{SELECTED}foreshortening_fraction": lambda stent: Sizes.foreshorteningOf(stent) / 100,
}
"""What is shown in place of a value that a device may have of its own."""

WITH_IT = {f"{SELECTED}foreshortening_fraction": {f"{SELECTED}device_shortening": False}}
"""What else is set where a value is."""

CHOICES = {
    f"settings.{name}": [(key, CHOICE_LABELS[name].get(key, key)) for key in one.names]
    for name, one in METHOD_PARAMETERS.values()
    if one.names
}
CHOICES[f"{SELECTED}placement"] = [(kind.place, kind.label()) for kind in Placement]
CHOICES[f"{SELECTED}keeps"] = [(key, KEPT_LABELS[key]) for key in KEPT]
"""By path the values that can be chosen, and their texts."""


class Binder:
    """Binds the widgets of `ui` to the plan of one parameter node after another; `show` is to be called whenever that has changed."""

    def __init__(self, ui):
        self._parameterNode, self._isShowing = None, False
        widgets = [one for one in vars(ui).values() if hasattr(one, "property")]
        paths = [(one.property("plan"), one) for one in widgets]
        self._bound = {path: boundTo(widget, path) for path, widget in paths if path}
        for path, bound in self._bound.items():
            bound.widget.connect(bound.signal, lambda _value, path=path: self._onChanged(path))

    def show(self, parameterNode):
        """Show the plan of a parameter node, or with None of none: what is changed then is set nowhere."""
        self._parameterNode = parameterNode
        if parameterNode is None:
            return
        wasShowing, self._isShowing = self._isShowing, True
        try:
            for path, bound in self._bound.items():
                inUse = IN_USE.get(path)
                value = inUse(stentOf(parameterNode)) if inUse else parameterNode.get(path)
                bound.write(value)
        finally:
            self._isShowing = wasShowing

    def _onChanged(self, path):
        if self._isShowing or self._parameterNode is None:
            return
        values = {path: self._bound[path].read(), **WITH_IT.get(path, {})}
        part = path.rpartition(".")[0]
        if self._parameterNode.get(part) is None:  # made now: all that is shown of it belongs to it
            beside = [one for one in self._bound if one.startswith(f"{part}.")]
            values |= {one: self._bound[one].read() for one in beside}
        self._parameterNode.change(values)


class OfNumber:
    """A number with its unit; its least value stands for none where that has a text of its own."""

    signal = "valueChanged(double)"

    def __init__(self, widget, path):
        self.widget = widget
        self._fromPlan, self._toPlan = UNITS.get(widget.suffix, (float, float))
        self._hasNone = bool(getattr(widget, "specialValueText", ""))
        limits = RANGES.get(PATHS.get(path))
        if limits is not None:
            widget.minimum, widget.maximum = limits.low, limits.high
        self._first = widget.minimum if self._hasNone else widget.value

    def read(self):
        """The value for the plan."""
        isNone = self._hasNone and self.widget.value <= self.widget.minimum
        return None if isNone else self._toPlan(self.widget.value)

    def write(self, value):
        """Show a value of the plan; for none what the form begins with, and not what was there of another stent or patient."""
        self.widget.value = self._first if value is None else self._fromPlan(value)


class OfChoice:
    """One of several texts."""

    signal = "currentIndexChanged(int)"

    def __init__(self, widget, path):
        self.widget, self._values = widget, []
        widget.clear()
        for value, text in CHOICES[path]:
            self._values.append(value)
            widget.addItem(text)

    def read(self):
        """The value for the plan."""
        return self._values[self.widget.currentIndex]

    def write(self, value):
        """Show a value of the plan; a place by its kind."""
        if isinstance(value, dict):
            value = Placement.of(value).place
        self.widget.currentIndex = self._values.index(value)


class OfSwitch:
    """A box that is checked or not."""

    signal = "toggled(bool)"

    def __init__(self, widget, _path):
        self.widget = widget

    def read(self):
        """The value for the plan."""
        return bool(self.widget.checked)

    def write(self, value):
        """Show a value of the plan."""
        self.widget.checked = bool(value)


class OfText(OfSwitch):
    """A line of text."""

    signal = "textChanged(QString)"

    def read(self):
        """The value for the plan."""
        return str(self.widget.text)

    def write(self, value):
        """Show a value of the plan, where it is another: else the cursor would jump."""
        if self.widget.text != value:
            self.widget.text = value


class OfNode(OfSwitch):
    """A node of the scene."""

    signal = "currentNodeChanged(vtkMRMLNode*)"

    def read(self):
        """The node."""
        return self.widget.currentNode()

    def write(self, value):
        """Show a node, or none."""
        self.widget.setCurrentNode(value)


KINDS = {
    "setCurrentNode": OfNode,
    "currentIndex": OfChoice,
    "checked": OfSwitch,
    "value": OfNumber,
    "text": OfText,
}
"""By what only such widgets have, of those that are still left."""


def boundTo(widget, path):
    """A widget bound to a path."""
    return next(kind for name, kind in KINDS.items() if hasattr(widget, name))(widget, path)
