"""The page's markup, made from the panel's arrangement so that it has the same order and words."""

from __future__ import annotations

from html import escape

from SDFStentLib.surface_formats import WHOLE_SUFFIXES
from SDFStentLib.units import MILLIMETERS

from .selectors import NEW, NodeComboBox, PlaceWidget, SegmentSelector
from .tables import Table
from .ui_file import Arranged, Placed
from .view import SIDES
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
    "extractButton": "opens another module of Slicer",
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
        return saving(SAVES[name])
    if name in (*WRITES_FILE, *WRITES_FOLDER):
        return f"window.inOrder('gather', ['{name}'])"
    return f"window.inOrder('click', ['{name}'])"


def saving(kind: str) -> str:
    """The call that asks the server for a file, which the browser keeps once it is made; if that
    fails, the page says why."""
    return f"window.inOrder('save', ['{kind}'])"


KEEP = (
    "trigger('fetch').then(files => files.forEach(f => utils.download(f.name, f.content, f.type)))"
)
"""The script with which the browser keeps the files that were made for it."""


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


MESSAGE = (
    '<div class="message" v-show="message" role="alert" data-name="message">{{ message }}</div>'
)

PATHS = ("surfacePath", "centerlinePath", "chosenPath")
"""State variables that hold the path of a file."""


def _upload(variable: str) -> str:
    """The field for a file of the browser's own machine, beside the field for a path."""
    words = "A file of this computer; one can be dropped anywhere on the page, too"
    return f"""<input type="file" data-name="{variable}-upload" title="{words}" aria-label="A file of this computer" \
@change="window.send('{variable}', $event.target.files)">"""


def _units() -> str:
    return "".join(f"<option>{name}</option>" for name in MILLIMETERS)


OPENING = f"""
<details class="opening" :key="opened" :open="!opened" data-name="opening">
<summary>Open</summary>
<div class="row"><button type="button" @click="window.inOrder('demo')" data-name="demoButton">Synthetic patient</button></div>
<form class="form" @submit.prevent="window.inOrder('open', [surfacePath, centerlinePath, fileUnits])">
<label class="label" for="surfacePath">Surface:</label>
<input id="surfacePath" type="text" v-model.lazy="surfacePath" list="surfaces" placeholder="path of a surface, or of a plan">
<span></span>{_upload("surfacePath")}
<label class="label" for="centerlinePath">Centerline:</label>
<input id="centerlinePath" type="text" v-model.lazy="centerlinePath" list="centerlines" placeholder="path of its centerline">
<span></span>{_upload("centerlinePath")}
<label class="label" for="fileUnits">Unit:</label>
<select id="fileUnits" v-model="fileUnits" title="Of both files; a plan names its own.">{_units()}</select>
<span></span><button type="submit" data-name="openButton">Open</button>
</form>
<datalist id="surfaces"><option v-for="path in surfaceFiles" :value="path"></option></datalist>
<datalist id="centerlines"><option v-for="path in centerlineFiles" :value="path"></option></datalist>
</details>
"""

CHOOSER = f"""
<div class="chooser" v-if="chooser.button" role="dialog" :aria-label="chooser.text" data-name="chooser">
<form @submit.prevent="window.inOrder('choose', [chooser.button, chosenPath])">
<label class="label" for="chosenPath">{{{{ chooser.text }}}}</label>
<input id="chosenPath" type="text" v-model.lazy="chosenPath" list="choices" placeholder="path of the file">
{_upload("chosenPath")}
<datalist id="choices"><option v-for="path in chooser.files" :value="path"></option></datalist>
<button type="submit">OK</button>
<button type="button" @click="window.inOrder('choose', ['', ''])">Cancel</button>
</form></div>
"""

AT_HAND = """
<div class="hand" :class="[atHand.kind, { aside: pointed }]" v-show="atHand.lines.length" role="status" data-name="atHand">
<div v-for="line in atHand.lines">{{ line }}</div></div>
"""
"""The lines over the view. They move aside while the user points at the plot: the place marked in
the view may lie beneath them."""


KEYS = (
    ("Left, Right", "move the selected stent by 1 mm along the vessel, with Shift by 0.2"),
    ("Delete", "take the selected stent away"),
    ("Up, Down, Enter", "go through the rows of a table, and choose one"),
    ("Ctrl+Z, Ctrl+Y", "undo and redo"),
    ("Escape", "end placing, close a question"),
    ("?", "show these keys"),
)
"""Keys, and what they do."""

HELP = (
    '<dialog class="keys" data-name="keys" aria-label="Keys"><dl>'
    + "".join(f"<dt>{keys}</dt><dd>{words}</dd>" for keys, words in KEYS)
    + '</dl><form method="dialog"><button type="submit">Close</button></form></dialog>'
)
"""The dialog that shows the keys."""

SAID = '<div class="said" v-show="said" role="status" data-name="said">{{ said }}</div>'
"""The latest message, over the view, where it is seen whatever part of the panel is shown."""


def bar() -> str:
    """The buttons of the view."""
    sides = "".join(
        f'<button type="button" title="View from {side.lower()}" aria-label="View from {side.lower()}" '
        f"""data-name="from{side}" @click="trigger('look_from', ['{side}'])">{side[0]}</button>"""
        for side in SIDES
    )
    return f"""<div class="bar" role="toolbar" aria-label="View">
<button type="button" title="See the whole vessel" @click="trigger('fit')" data-name="fitButton">Fit</button>{sides}
<button type="button" title="Keep what the view shows as a picture" @click="trigger('picture')" data-name="pictureButton">\
Save picture</button>
<button type="button" title="Keys" aria-label="Keys" onclick="document.querySelector('.keys').showModal()" data-name="keysButton">?</button>
</div>"""


SPLIT = """
<div class="split" role="separator" tabindex="0" aria-orientation="vertical" aria-label="Width of the panel" aria-valuemin="300"
aria-valuemax="900" aria-valuenow="446" data-name="split" @pointerdown="$event.target.setPointerCapture($event.pointerId)"
@pointermove="$event.buttons && window.split($event.clientX)" @dblclick="window.split(446)"
@keydown.left.stop.prevent="window.split('-')" @keydown.right.stop.prevent="window.split('+')"></div>
"""

DIAMETERS = """
<div class="results"><div class="tiles" v-memo="[tiles]" data-name="tiles" role="region" aria-label="Result" tabindex="0">
<component v-for="t in tiles" :is="t.is_caution ? 'button' : 'div'" class="tile" :class="{caution: t.is_caution}" @click="t.is_caution && window.unfold('detailsCollapsibleButton')">
<span>{{ t.name }}</span> <strong>{{ t.value }}</strong> <span>{{ t.beneath }}</span></component></div>
<div v-memo="[plot, table, pointed]">
<p class="suffix" v-show="!plot.lines.length">Diameters along a lesion or a stent.</p>
<figure v-show="plot.lines.length"><h2>{{ plot.title }}</h2><svg :viewBox="'0 0 ' + plot.width + ' ' + plot.height" preserveAspectRatio="xMinYMid" role="img" :aria-label="plot.title"
@pointermove="pointed = window.nearest($event, plot.values)" @pointerdown="pointed = window.nearest($event, plot.values)" @pointerleave="pointed = window.nowhere()">
<line v-if="pointed" class="pointed" :x1="pointed.at" :x2="pointed.at" y1="0" :y2="plot.height - 34"></line>
<g class="grid"><line v-for="t in plot.up" x1="44" :x2="plot.width - 12" :y1="t.at" :y2="t.at"></line></g>
<g class="ticks"><text v-for="t in plot.up" x="38" :y="t.at + 4" text-anchor="end">{{ t.text }}</text>
<text v-for="t in plot.across" :x="t.at" :y="plot.height - 18" text-anchor="middle">{{ t.text }}</text>
<text :x="plot.width / 2" :y="plot.height - 3" text-anchor="middle">{{ plot.words[0] }}</text>
<text :transform="'translate(11 ' + plot.height / 2 + ') rotate(-90)'" text-anchor="middle">{{ plot.words[1] }}</text></g>
<path v-for="l in plot.lines" :d="l.path" :stroke="l.color" :opacity="l.opacity" :stroke-dasharray="l.dash ? '7 5' : null"></path>
</svg><p class="suffix" data-name="pointed">{{ pointed ? pointed.text : '' }}</p></figure>
<details v-show="table.rows.length"><summary>{{ table.title || 'Table' }}</summary><div class="table" role="region" aria-label="Diameters" tabindex="0"><table>
<thead><tr><th v-for="c in table.columns">{{ c }}</th></tr></thead>
<tbody><tr v-for="row in table.rows"><td v-for="v in row">{{ v }}</td></tr></tbody></table></div></details>
</div></div>
"""

GONE = """
<div class="gone" role="alert">The connection is lost, or this page was opened in another window.
It goes on by itself as soon as it can.
<button type="button" onclick="location.reload()">Go on now</button>
If that does not help, sdfstent app has ended: start it again and use the address that it prints.</div>
"""


def saving_row() -> str:
    """The buttons that let the browser keep results."""
    buttons = "".join(
        f'<button type="button" :disabled="!canSave || isSaving" data-name="save-{kind}" @click="{escape(saving(kind))}">{text}</button>'
        for kind, text in (("surface", "Save surface..."), ("report", "Save report..."))
    )
    return (
        f'<div class="row">{buttons}<span v-show="isSaving" class="suffix">Working...</span></div>'
    )
