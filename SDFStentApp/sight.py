"""The look of a page: the panel on one side, the view and the diameters on the other."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from trame.ui.html import DivLayout
from trame.widgets import client, html, rca

from SDFStentLib.units import MILLIMETERS

from . import template
from .charts import plot_of, table_of
from .chunks import LARGEST_UPLOAD
from .files import CENTERLINES, PLANS, SCANS, SURFACES
from .view import NAME, SIDES

TITLE = "SDF Stent"
HERE = Path(__file__).parent
TRIGGERS = (
    *("click", "edit", "hover", "key", "ask", "choose", "open", "upload", "demo", "stop"),
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
        client.Style(_read("page.css"))
        client.Script(_read("page.js"))
        client.ClientTriggers(mounted="window.begin()")
        client.ClientStateChange(value="made", change="window.keep()")
        html.Div(
            f"<h1>{TITLE}</h1>{_read('markup/opening.html')}{panel}{_read('markup/saving.html')}",
            classes="panel",
            raw_attrs=['role="main"'],
        )
        html.Div(
            _read("markup/split.html"), raw_attrs=['role="region" aria-label="Panel and view"']
        )
        with html.Div(classes="stage", raw_attrs=['role="region" aria-label="View and diameters"']):
            with html.Div(classes=("{ screen: true, placing: isPlacing }",)):
                rca.RemoteControlledArea(
                    name=NAME,
                    display="image",
                    send_mouse_move=True,
                    event_throttle_ms=(str(EVENT_EVERY_MS),),
                )
                html.Div(_read("markup/over.html"), classes="over")
            html.Div(_read("markup/results.html"))


def _read(name: str) -> str:
    """Text of a file for the browser."""
    return (HERE / name).read_text(encoding="utf-8")


def _begin(page: Any) -> None:
    state = page.server.state
    state.trame__title = TITLE
    state.trame__template_error = _read("markup/gone.html")
    state.message, state.isPlacing, state.isSaving, state.canSave = "", False, False, False
    state.said = ""
    state.units, state.sides, state.largestUpload = [*MILLIMETERS], [*SIDES], LARGEST_UPLOAD
    state.surfacePath = state.centerlinePath = state.chosenPath = ""
    state.fileUnits = page.opening.get("units", "mm")
    state.chooser, state.opened, state.made = {}, 0, 0
    state.preparing, state.segments, state.segment = "", [], 0
    state.surfaceFiles = page.folders.listing((*SURFACES, *PLANS, *SCANS))
    state.centerlineFiles = page.folders.listing(CENTERLINES)
    state.plot, state.table = plot_of(None), table_of(None)
    state.atHand = {"lines": [], "angles": [], "kind": ""}
    state.tiles = []
    state.pointed = None
    state.client_only("pointed")
