"""The panel's `.ui` file: its widgets and their arrangement."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from . import widgets
from .selectors import NodeComboBox, PlaceWidget, SegmentSelector
from .tables import Table
from .widgets import Widget

CLASSES: dict[str, Callable[[str], Widget]] = {
    "QLabel": widgets.Label,
    "QPushButton": widgets.Button,
    "QToolButton": widgets.Button,
    "QCheckBox": widgets.CheckBox,
    "QComboBox": widgets.ComboBox,
    "QSpinBox": widgets.Number,
    "QDoubleSpinBox": widgets.Number,
    "ctkSliderWidget": partial(widgets.Number, has_slider=True),
    "QLineEdit": widgets.LineEdit,
    "QTableWidget": Table,
    "QProgressBar": widgets.ProgressBar,
    "QWidget": widgets.Area,
    "QFrame": widgets.Separator,
    "Line": widgets.Separator,
    "qMRMLWidget": widgets.Area,
    "ctkCollapsibleButton": widgets.CollapsibleSection,
    "qMRMLNodeComboBox": NodeComboBox,
    "qMRMLSegmentSelectorWidget": SegmentSelector,
    "qSlicerMarkupsPlaceWidget": PlaceWidget,
}
ARRANGEMENTS = {"QFormLayout": "form", "QHBoxLayout": "row", "QVBoxLayout": "column"}
ENDS_FIRST = ("minimum", "maximum")
"""Properties that are set before the others, since a number is kept within its ends."""


class Placed(NamedTuple):
    """A widget and its content, which is None if it has none."""

    widget: Widget
    inside: Arranged | None


class Arranged(NamedTuple):
    """Widgets and arrangements in order, as a `form`, in a `row` or in a `column`."""

    kind: str
    cells: tuple[PlacedCell, ...]


class PlacedCell(NamedTuple):
    """A cell of an arrangement; row and column matter only in a form."""

    content: Placed | Arranged
    row: int
    column: int
    span: int


class UiPanel:
    """The widgets of a `.ui` file by name, which are attributes, too, and their arrangement, which
    begins with `top`."""

    def __init__(self, path: Path) -> None:
        root = ElementTree.parse(path).getroot()
        self.widgets: dict[str, Widget] = {}
        top = root.find("widget")
        assert top is not None
        self.top = self._placed(top)
        connect(root, self.widgets.__getitem__)

    def _placed(self, element: ElementTree.Element) -> Placed:
        name, kind = element.get("name", ""), element.get("class", "")
        if kind not in CLASSES:
            raise LookupError(f"{name}: there is nothing in the page for a {kind}.")
        widget = CLASSES[kind](name)
        fill(widget, element)
        self.widgets[name] = widget
        setattr(self, name, widget)
        layout = element.find("layout")
        return Placed(widget, None if layout is None else self._arranged(layout))

    def _arranged(self, element: ElementTree.Element) -> Arranged:
        cells = []
        for item in element.findall("item"):
            inside = next((child for child in item if child.tag in ("widget", "layout")), None)
            if inside is None:
                continue  # a spacer
            content = self._placed(inside) if inside.tag == "widget" else self._arranged(inside)
            row, column, span = (
                int(item.get(key, default))
                for key, default in (("row", len(cells)), ("column", 0), ("colspan", 1))
            )
            cells.append(PlacedCell(content, row, column, span))
        return Arranged(ARRANGEMENTS[element.get("class", "")], tuple(cells))


def fill(widget: Widget, element: ElementTree.Element) -> None:
    """Give a widget its properties from the file."""
    values = {p.get("name", ""): _value(p) for p in element.findall("property")}
    widget.parameter = values.pop("SlicerParameterName", "")
    widget.plan = values.pop("plan", "")
    columns = [_text(column.find("property")) for column in element.findall("column")]
    if columns:
        values["columns"] = tuple(columns)
    for key in sorted(values, key=lambda key: key not in ENDS_FIRST):
        if isinstance(getattr(type(widget), key, None), widgets.ShownAttribute):
            setattr(widget, key, values[key])


def connect(root: ElementTree.Element, named: Callable[[str], Any]) -> None:
    """Make the connections between the widgets of a file."""
    for connection in root.findall("connections/connection"):
        part = {element.tag: element.text or "" for element in connection}
        slot = getattr(named(part["receiver"]), part["slot"].partition("(")[0])
        named(part["sender"]).connect(part["signal"], slot)


def _value(element: ElementTree.Element) -> Any:
    inside = element[0]
    text = inside.text or ""
    if inside.tag == "bool":
        return text == "true"
    if inside.tag in ("number", "double"):
        return float(text) if inside.tag == "double" else int(text)
    if inside.tag == "stringlist":
        return tuple(part.text or "" for part in inside)
    return text


def _text(element: ElementTree.Element | None) -> str:
    return "" if element is None else str(_value(element))
