"""The look of a page: the panel on one side, the view and the diameters on the other."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from trame.ui.html import DivLayout
from trame.widgets import client, html, rca

from . import template
from .charts import plot_of, table_of
from .chunks import LARGEST_UPLOAD
from .files import CENTERLINES, PLANS, SURFACES
from .view import NAME

TITLE = "SDF Stent"
STYLE = Path(__file__).with_name("page.css")
FOLLOW_THEME = """const isDark = window.matchMedia('(prefers-color-scheme: dark)');
const tell = () => trigger('theme', [isDark.matches ? 'dark' : 'light']);
isDark.addEventListener('change', tell); tell();"""
"""Sets the background of the view by the browser's light or dark theme, now and when
that changes."""

IN_ORDER = """window.inOrder = async (name, args) => {
  const {state, trigger} = window.trame;
  for (let turn = 0; state.dirtyKeys.size && turn < 1000; turn += 1) {
    await state.flush();
    if (state.dirtyKeys.size) await new window.Promise(done => window.setTimeout(done, 5));
  }
  return trigger(name, args);
};"""
"""Calls the page after all earlier edits were sent: while a call is under way trame's client sends
further calls, but no edits.

Names of the browser are reached through `window`: expressions of a Vue template see few of them,
and not `Promise`.
"""

NAMED = """const {document} = window, screen = document.querySelector('.screen');
const name = () => screen.querySelectorAll('img:not([alt])').forEach(one => { one.alt = 'Vessel and stents'; });
new window.MutationObserver(name).observe(screen, {childList: true, subtree: true}); name();
document.querySelector('meta[name=viewport]').content = 'width=device-width, initial-scale=1';"""
"""Adds what trame leaves out for users who cannot see a page, or need it larger."""

POINT = """let pointed = -1, told = -1, isTelling = false;
const point = async station => {
  pointed = station;
  if (isTelling) return;
  isTelling = true;
  try { while (told !== pointed) await window.trame.trigger('point', [told = pointed]); } finally { isTelling = false; }
};
window.nearest = (event, values) => {
  const seen = event.currentTarget.getScreenCTM().inverse();
  const {x} = new window.DOMPoint(event.clientX, event.clientY).matrixTransform(seen);
  const away = values.map(one => Math.abs(one.at - x)), station = away.indexOf(Math.min(...away));
  point(station);
  return values[station];
};
window.nowhere = () => { point(-1); return null; };"""
"""Finds the values of a plot that are nearest to the pointer, and lets the view mark their place,
one call after another."""

SEND = """window.send = (variable, files) => Array.from(files).forEach(async file => {
  const {state, trigger} = window.trame, isLarge = file.size > MOST;
  state.set('message', `Sending ${file.name}...`);
  trigger('upload', [variable, file.name, isLarge ? null : await file.arrayBuffer().catch(() => null)]);
});
const withFiles = take => event => {
  if (!event.dataTransfer.types.includes('Files')) return;
  event.preventDefault();
  take(event);
};
window.addEventListener('dragover', withFiles(() => {}));
window.addEventListener('drop', withFiles(event => {
  const field = event.target.closest('[type=file]');
  const other = window.trame.state.get('chooser').button ? 'chosenPath' : '';
  if (!other) document.querySelector('[data-name=opening]').open = true;
  window.send(field ? field.dataset.name.split('-')[0] : other, event.dataTransfer.files);
}));""".replace("MOST", str(LARGEST_UPLOAD))
"""Sends files of the browser's own machine, chosen or dropped. Of a file that is too large only the
name is sent."""

SPLIT = """window.split = to => {
  const [page, panel, split] = ['.page', '.panel', '.split'].map(one => document.querySelector(one));
  const steps = {'-': -20, '+': 20}, told = to in steps ? panel.offsetWidth + steps[to] : to;
  const most = Math.max(300, Math.min(900, window.innerWidth - 400)), width = Math.round(Math.min(Math.max(told, 300), most));
  page.style.setProperty('--panel', `${width}px`);
  split.setAttribute('aria-valuenow', width);
  window.localStorage.setItem('panel', width);
};
if (window.localStorage.getItem('panel')) window.split(window.localStorage.getItem('panel'));"""
"""Sets the width of the panel, or changes it by a step, such that both sides stay usable. A page
that is loaded again keeps it."""

UNFOLD = """window.unfold = name => {
  const part = document.querySelector(`[data-name=${name}]`);
  for (let one = part; one; one = one.parentElement.closest('details')) one.open = true;
  part.scrollIntoView({block: 'nearest'});
};"""
"""Unfolds a part of the panel and scrolls to it."""

KEYS = """const named = {Escape: 'Esc', ArrowLeft: 'Left', ArrowRight: 'Right', Delete: 'Del'};
const buttons = {z: 'undoButton', y: 'redoButton'};
window.addEventListener('keydown', event => {
  const {target} = event, isTyped = target.matches('input:not([type=checkbox]), select');
  const button = (event.ctrlKey || event.metaKey) && buttons[event.key];
  const key = named[event.key], widget = target.closest('[data-name]');
  const keys = document.querySelector('.keys');
  if (keys.open) return;
  if (event.key === '?' && !isTyped) return keys.showModal();
  if (isTyped && key !== 'Esc' || !key && !button) return;
  if (button || key.length > 3) event.preventDefault();
  if (button) return window.inOrder('click', [button]);
  const name = widget ? widget.dataset.name : key === 'Del' ? '' : 'stentTable';
  window.inOrder('key', [name, (event.shiftKey ? 'Shift+' : '') + key]);
});"""
"""Passes keys to the panel's table of stents, also when no widget or the view has the focus; keys
typed into a field stay there."""

GO_ON = """window.setInterval(async () => {
  if (!document.querySelector('.gone') || !document.hasFocus() || window.performance.now() < 10000) return;
  const answer = await window.fetch(window.location.href).catch(() => null);
  if (answer && answer.ok) window.location.reload();
}, 2000);"""
"""Loads a page whose connection is lost again as soon as the server answers: only in the window
with the focus, since the page may be open in another one. A page that fails at once is not
loaded again and again."""

TRIGGERS = (
    *("click", "edit", "hover", "key", "ask", "choose", "open", "upload", "demo"),
    *("save", "picture", "point", "gather", "fetch"),
)
"""Methods of the page that the browser calls."""

EVENT_EVERY_MS = 20
"""Shortest time between two events of the mouse."""


def build(page: Any) -> None:
    """Make the markup of a page and its state variables."""
    server = page.server
    _begin(page)
    for name in TRIGGERS:
        server.trigger(name)(getattr(page, name))
    server.trigger("theme")(page.view.paint)
    server.trigger("fit")(page.view.look_at_all)
    server.trigger("look_from")(page.view.look_from)
    panel = template.markup(page.panel.top)
    with DivLayout(server) as layout:
        layout.root.classes = "page"
        client.Style(STYLE.read_text(encoding="utf-8"))
        client.ClientTriggers(
            mounted=FOLLOW_THEME + IN_ORDER + NAMED + POINT + SEND + SPLIT + UNFOLD + KEYS + GO_ON
        )
        client.ClientStateChange(value="made", change=template.KEEP)
        html.Div(
            f"<h1>{TITLE}</h1>{template.MESSAGE}{template.OPENING}{template.CHOOSER}{panel}"
            f"{template.saving_row()}",
            classes="panel",
            raw_attrs=['role="main"'],
        )
        html.Div(template.SPLIT, raw_attrs=['role="region" aria-label="Panel and view"'])
        with html.Div(classes="stage", raw_attrs=['role="region" aria-label="View and diameters"']):
            with html.Div(classes=("{ screen: true, placing: isPlacing }",)):
                rca.RemoteControlledArea(
                    name=NAME,
                    display="image",
                    send_mouse_move=True,
                    event_throttle_ms=(str(EVENT_EVERY_MS),),
                )
                html.Div(
                    template.AT_HAND + template.bar() + template.SAID + template.HELP,
                    classes="over",
                )
            html.Div(template.DIAMETERS)


def _begin(page: Any) -> None:
    state = page.server.state
    state.trame__title = TITLE
    state.trame__template_error = template.GONE
    state.message, state.isPlacing, state.isSaving, state.canSave = "", False, False, False
    state.said = ""
    state.surfacePath = state.centerlinePath = state.chosenPath = ""
    state.fileUnits = page.opening.get("units", "mm")
    state.chooser, state.opened, state.made = {}, 0, 0
    state.surfaceFiles = page.folders.listing((*SURFACES, *PLANS))
    state.centerlineFiles = page.folders.listing(CENTERLINES)
    state.plot, state.table = plot_of(None), table_of(None)
    state.atHand = {"lines": [], "kind": ""}
    state.tiles = []
    state.pointed = None
    state.client_only("pointed")
