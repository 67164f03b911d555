"""The page's markup, made from the panel's arrangement so that it has the same order and words."""

from __future__ import annotations

from SDFStentLib.surface_formats import WHOLE_SUFFIXES

from .selectors import NEW, NodeComboBox, PlaceWidget, SegmentSelector
from .tables import Table
from .ui_file import Arranged, Placed
from .widgets import (
    Button,
    CheckBox,
    CollapsibleSection,
    ComboBox,
    Label,
    LineEdit,
    Number,
    ProgressBar,
    Separator,
    Widget,
)

NOT_IN_THE_PAGE = {
    "outputSelectorLabel": "results are saved from the page",
    "outputSelector": "results are saved from the page",
    "handleSelector": "every stent has a handle of its own",
    "roomyViewsButton": "the page has one view, and the plot beneath",
    "tilesLabel": "the tiles are shown below the view",
    "showPlotButton": "the plot is shown below the view",
    "showTableButton": "the table is shown below the view",
}
"""Parts of the panel that the page leaves out, and why."""

ASKS_FOR_FILE = {
    "loadPlanButton": (".json",),
    "loadPlansButton": (".json",),
    "deviceTableButton": (".json",),
    "loadProfileButton": (".csv",),
    "loadMeshButton": WHOLE_SUFFIXES,
}
"""Buttons that make the panel ask for a file, and the suffixes of these files."""

SAVES = {"savePlanButton": "plan"}
"""Buttons that save a file, which the browser keeps, and the kind of the file."""

WRITES_FILE = {
    "saveDeviceButton": ("stents.vtp", "application/xml"),
    "write0DButton": ("network.json", "application/json"),
}
"""Buttons that make the panel ask where to save a file; the name under which the browser keeps it,
and its media type."""

WRITES_FOLDER = {"comparePlansButton": "comparison.zip", "writeSegmentButton": "segment.zip"}
"""Buttons that make the panel ask for a folder; the name of the zip file with which the browser
keeps it."""


def value_of(widget: Widget) -> str:
    """Name of the state variable that the user edits in a widget."""
    return f"{widget.objectName}__v"


def markup(placed: Placed) -> str:
    """The Vue template of a widget and its content."""
    widget, name = placed.widget, placed.widget.objectName
    if name in NOT_IN_THE_PAGE:
        return ""
    inside = "" if placed.inside is None else _arranged(placed.inside)
    if isinstance(widget, CollapsibleSection):
        opened = f'@toggle="{name}__v = !$event.target.open"'
        return (
            f'<details v-show="{name}.visible" :open="!{name}__v" {opened} data-name="{name}">'
            f"<summary>{{{{ {name}.text }}}}</summary>{inside}</details>"
        )
    if inside:
        return f'<fieldset v-show="{name}.visible" :disabled="!{name}.enabled">{inside}</fieldset>'
    return _of(widget)


def _arranged(arranged: Arranged) -> str:
    if arranged.kind != "form":
        cells = "".join(_content(cell.content) for cell in arranged.cells)
        return f'<div class="{arranged.kind}">{cells}</div>'
    cells = "".join(
        f'<div class="cell" style="grid-row: {cell.row + 1}; grid-column: '
        f'{cell.column + 1} / span {cell.span}">{_content(cell.content)}</div>'
        for cell in arranged.cells
        if _content(cell.content)
    )
    return f'<div class="form">{cells}</div>'


def _content(content: Placed | Arranged) -> str:
    return _arranged(content) if isinstance(content, Arranged) else markup(content)


def _of(widget: Widget) -> str:
    """The Vue template of a single widget."""
    name, v = widget.objectName, value_of(widget)
    memo = (
        f"{name}, {v}" if widget.edited else name
    )  # rendered again only when one of these changes
    common = f'v-show="{name}.visible" v-memo="[{memo}]" :title="{name}.tip" data-name="{name}"'
    disabled = f':disabled="!{name}.enabled"'
    if isinstance(widget, Button):
        return f'<button type="button" {common} {disabled} @click="{_click(name)}">{{{{ {name}.text }}}}</button>'
    if isinstance(widget, CheckBox):
        return (
            f'<label class="check" {common} :class="{{off: !{name}.enabled}}">'
            f'<input type="checkbox" v-model="{v}" {disabled}>{{{{ {name}.text }}}}</label>'
        )
    if isinstance(widget, Number):
        return _number(widget, common, disabled)
    if isinstance(widget, LineEdit):
        return (
            f'<input type="text" v-model.lazy="{v}" {common} {disabled} :aria-label="{name}.tip">'
        )
    if isinstance(widget, Table):
        return _table(name)
    if isinstance(widget, ProgressBar):
        return f'<progress {common} :value="{name}.value" :max="{name}.max"></progress>'
    if isinstance(widget, PlaceWidget):
        return (
            f'<button type="button" {common} {disabled} :class="{{pressed: {v}}}" :aria-pressed="{v}" '
            f'@click="{v} = !{v}">{{{{ {v} ? "Click on the centerline" : "Place" }}}}</button>'
        )
    if isinstance(widget, (ComboBox, NodeComboBox, SegmentSelector)):
        return _choice(widget, common, disabled)
    if isinstance(widget, Separator):
        return "<hr>"
    if isinstance(widget, Label):
        return f'<div class="label" {common} :class="{{off: !{name}.enabled}}">{{{{ {name}.text }}}}</div>'
    return f"<div {common}></div>"


def _click(name: str) -> str:
    if name in ASKS_FOR_FILE:
        return f"window.inOrder('ask', ['{name}'])"
    if name in SAVES:
        return f"window.inOrder('save', ['{SAVES[name]}'])"
    if name in (*WRITES_FILE, *WRITES_FOLDER):
        return f"window.inOrder('gather', ['{name}'])"
    return f"window.inOrder('click', ['{name}'])"


def _number(widget: Number, common: str, disabled: str) -> str:
    name, v = widget.objectName, value_of(widget)
    slider = (
        f'<input type="range" v-model.number="{v}" :step="{name}.step" '
        f':min="Math.ceil({name}.min / {name}.step - 1e-9) * {name}.step" :max="{name}.max" {disabled} '
        f':aria-label="{name}.tip">'
        if widget.has_slider
        else ""
    )
    again = f"$event.target.value = {v}.toFixed({name}.decimals)"  # what was taken of it
    box = (
        f'<input type="number" :value="{v}.toFixed({name}.decimals)" :step="{name}.step" '
        f':min="{name}.min" :max="{name}.max" {disabled} :aria-label="{name}.tip" {COMMA}'
        f"""@change="window.inOrder('edit', ['{name}', $event.target.valueAsNumber]).then(() => {again})">"""
    )
    special = (
        f'<span class="special" v-if="{v} &lt;= {name}.min">({{{{ {name}.special }}}})</span>'
        if widget.specialValueText
        else ""
    )
    suffix = f'<span class="suffix">{{{{ {name}.suffix }}}}</span>' if widget.suffix else ""
    return f'<span class="number" {common}>{slider}{box}{suffix}{special}</span>'


def _choice(widget: Widget, common: str, disabled: str) -> str:
    name, v = widget.objectName, value_of(widget)
    named = f':aria-label="{name}.tip"'
    if isinstance(widget, ComboBox):
        options = f'<option v-for="(text, i) in {name}.items" :value="i">{{{{ text }}}}</option>'
        return f'<select v-model.number="{v}" {common} {disabled} {named}>{options}</select>'
    options = f'<option v-for="one in {name}.items" :value="one.id">{{{{ one.name }}}}</option>'
    if isinstance(widget, SegmentSelector):
        select = f'<select v-model="{v}" :title="{name}.tip" {disabled}>{options}</select>'
        return f'<label class="row" {common}>Segment: {select}</label>'
    options = (
        f'<option v-if="{name}.none !== null" value="">{{{{ {name}.none }}}}</option>'
        f'{options}<option v-if="{name}.add" value="{NEW}">New points</option>'
    )
    return f'<select v-model="{v}" {common} {disabled} {named}>{options}</select>'


ROW_KEYS = " ".join(
    f'@keydown.{key}.prevent="$event.currentTarget.{to}ElementSibling?.focus()"'
    for key, to in (("up", "previous"), ("down", "next"))
)
"""Moves the focus from row to row of a table with the keys."""


COMMA = "@keydown.,.prevent=\"window.document.execCommand('insertText', false, '.')\" "
"""Lets a comma stand for a decimal point in a number, whatever the language of the browser."""


def _hovered(name: str) -> str:
    """The attributes of a row of lesions that let the view mark the lesion under the mouse; "" for
    other tables."""
    if name != "lesionTable":
        return ""
    hovered = "trigger('hover', ['{name}', {row}])".format
    enter, leave = hovered(name=name, row="r"), hovered(name=name, row="-1")
    return f'@pointerenter="{enter}" @pointerleave="{leave}" '


def _table(name: str) -> str:
    click = f"window.inOrder('edit', ['{name}', [r, c]])"
    tick = f"window.inOrder('edit', ['{name}', [r, c, $event.target.checked]])"
    typed = f"name !== null && window.inOrder('edit', ['{name}', [r, c, name]])"
    rename = f"item.edit && (name => {typed})(window.prompt({name}.columns[c], item.text))"
    return (
        f'<div class="table" v-show="{name}.visible" v-memo="[{name}]" data-name="{name}" '
        # One without rows is scrolled by its own keys on a narrow screen, others by those of a row.
        f':tabindex="{name}.rows.length ? null : 0"><table :title="{name}.tip">'
        f'<thead><tr><th v-for="text in {name}.columns">{{{{ text }}}}</th></tr></thead><tbody>'
        f'<tr v-for="(row, r) in {name}.rows" :class="{{selected: r === {name}.selected}}" {_hovered(name)}'
        f':aria-selected="r === {name}.selected" tabindex="0" '
        f'@keydown.enter.self="{click.replace("[r, c]", "[r, 0]")}" {ROW_KEYS}>'
        f'<td v-for="(item, c) in row" :title="item.tip" @click="{click}" @dblclick="{rename}">'
        f'<input v-if="item.check === true || item.check === false" type="checkbox" '
        f':checked="item.check" :aria-label="item.text" @click.stop @change="{tick}">{{{{ item.text }}}}</td></tr>'
        "</tbody></table></div>"
    )


PATHS = ("surfacePath", "centerlinePath", "chosenPath")
"""State variables that hold the path of a file."""
