"""Binds widgets to the plan: one whose property `plan` is a path, such as "stents.selected.diameter", shows the value there and sets it.

One whose property `SlicerParameterName` is that of another parameter of the node, such as "autoUpdate", shows and sets that. Slicer 5.10.0
leaves an observer on the node at every `disconnectGui`, which crashes once nobody holds the parameter node: it is not asked.
A number behind which " %" or " L/min" stands is shown so, and is a fraction or mL/s in the plan; one with a special text for its least
value stands for none there. This is the same in Qt and in the page.
"""

from slicer.i18n import tr as _

from SDFStentLib.plan import parameter_at

from .ParameterNode import SELECTED, SurfaceMap
from .PlanFields import (
    CHOICE_LABELS,
    KEPT_LABELS,
    METHOD_PARAMETERS,
    PATHS,
    RANGES,
    UNITS,
    Placement,
)

FLAT = 0.35
"""Height of the caps called flat, relative to their radius."""

CHOICES = {
    f"settings.{name}": [(key, CHOICE_LABELS[name].get(key, key)) for key in one.names]
    for name, one in METHOD_PARAMETERS.values()
    if one.names
}
CHOICES[f"{SELECTED}placement"] = [(kind.place, kind.label()) for kind in Placement]
CHOICES[f"{SELECTED}keeps"] = [
    (key, KEPT_LABELS[key]) for key in parameter_at("stents.keeps").names
]
CHOICES["map"] = [(one, one.label()) for one in SurfaceMap]
CHOICES[f"{SELECTED}shape.cap_height"] = [(1.0, _("Round")), (FLAT, _("Flat"))]
"""The values by path that can be chosen, and their texts."""

OTHERS = {f"{SELECTED}shape.cap_height": _("{value:g} of the radius high")}
"""The text by path of any other value, as a plan may have it."""


class Binder:
    """Binds the widgets of `ui` to the plan of one parameter node after another; `show` is to be called whenever that has changed."""

    def __init__(self, ui, attempt):
        """`attempt(action)` does what is asked for and says why when it cannot be done."""
        self._parameterNode, self._isShowing, self._attempt = None, False, attempt
        widgets = [one for one in vars(ui).values() if hasattr(one, "property")]
        names = "plan", "SlicerParameterName"
        paths = [(one.property(name), one) for name in names for one in widgets]
        self._bound = {path: boundTo(widget, path) for path, widget in paths if path}
        for path, bound in self._bound.items():
            if bound.signal:
                bound.widget.connect(bound.signal, lambda _value, path=path: self._onChanged(path))

    def show(self, parameterNode):
        """Show the plan of a parameter node; with None, show none and set nothing."""
        self._parameterNode = parameterNode
        if parameterNode is None:
            return
        wasShowing, self._isShowing = self._isShowing, True
        try:
            for path, bound in self._bound.items():
                bound.write(parameterNode.shown(path))
        finally:
            self._isShowing = wasShowing

    def _onChanged(self, path):
        if self._isShowing or self._parameterNode is None:
            return
        part = path.rpartition(".")[0]
        if part and self._parameterNode.shown(part) is None:
            # It is made now: all that is shown of it belongs to it.
            beside = [one for one in self._bound if one.startswith(f"{part}.")]
            self._parameterNode.change({one: self._bound[one].read() for one in beside})
        else:
            value = self._bound[path].read()
            self._attempt(lambda: self._parameterNode.put(path, value))


class OfNumber:
    """A number with its unit; its least value stands for none where that has a text of its own."""

    signal = "valueChanged(double)"

    def __init__(self, widget, path):
        self.widget = widget
        unit = widget.suffix if "." in path else ""  # other parameters are as shown
        self._fromPlan, self._toPlan = UNITS.get(unit, (float, float))
        self._hasNone = bool(getattr(widget, "specialValueText", ""))
        limits = RANGES.get(PATHS.get(path, path))
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
    """A choice of one of several texts."""

    signal = "currentIndexChanged(int)"

    def __init__(self, widget, path):
        self.widget, self._values, self._other = widget, [], OTHERS.get(path)
        widget.clear()
        for value, text in CHOICES[path]:
            self._values.append(value)
            widget.addItem(text)
        self._count = len(self._values)

    def read(self):
        """The value for the plan."""
        return self._values[self.widget.currentIndex]

    def write(self, value):
        """Show a value of the plan; a place by its kind."""
        if isinstance(value, dict):
            value = Placement.of(value).place
        if self._other is not None and value != self._values[-1]:
            self._leaveOther(value)
        self.widget.currentIndex = self._values.index(value)

    def _leaveOther(self, value):
        """Offer this value, where it is none to choose from, in place of another such one."""
        if len(self._values) > self._count:
            self._values.pop()
            self.widget.removeItem(self._count)
        if value not in self._values:
            self._values.append(value)
            self.widget.addItem(self._other.format(value=value))


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


class OfLabel(OfText):
    """A text that the user does not change."""

    signal = ""


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
    "readOnly": OfText,
    "text": OfLabel,
}
"""Kinds of bound widgets, by a property that no widget of the kinds below has."""


def boundTo(widget, path):
    """A widget bound to a path."""
    return next(kind for name, kind in KINDS.items() if hasattr(widget, name))(widget, path)
