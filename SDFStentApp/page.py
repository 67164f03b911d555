"""A page: the module's panel with a scene of its own, shown by trame."""

from __future__ import annotations

import asyncio
import json
import os
import shutil
import tempfile
from collections.abc import Callable, Coroutine
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
import slicer
from trame_rca.encoders import RcaImageEncoder
from trame_server.utils.namespace import Translator

from SDFStentLib.files import write_bytes

from . import python_layer
from .application import MrmlApplication
from .charts import opacity_of, plot_of, table_of
from .desktop import AsyncTimer, PageDesktop
from .exports import NAMES, exported, zipped_folder
from .files import (
    PLANS,
    SCANS,
    Folders,
    Opened,
    Uploads,
    ends_in,
    has_lines,
    open_plan,
    open_vessel,
    save_model,
)
from .kept import PLAN
from .scans import Scans
from .selectors import PlaceWidget
from .sight import build
from .tables import Table
from .template import ASKS_FOR_FILE, PATHS, WRITES_FILE, WRITES_FOLDER, value_of
from .view import PageView
from .widgets import Button

EDIT_EVERY_S, LOOK_AGAIN_S = 0.03, 0.005
SHOW_EVERY_S = 0.05
"""Shortest time between two updates of the widgets in the browser; the result of a click is sent at
once."""

LATEST_EDIT_S = 0.5
"""Longest delay with which a dragged value is taken, however slowly its effect is drawn."""


class Kept(NamedTuple):
    """A file that the browser keeps."""

    name: str
    type: str
    content: bytes


def at_hand_of(widget: Any) -> dict[str, Any]:
    """The few lines of text over the view, from where one looks, and the kind of the first."""
    shown = widget._state.atHand
    rows = {"lines": shown.text, "angles": shown.angles}
    return {name: text.split("\n") if text else [] for name, text in rows.items()} | {
        "kind": shown.kind
    }


def tiles_of(parameters: Any) -> list[dict[str, Any]]:
    """The tiles that show the result at a glance."""
    from SDFStentSlicer.Tiles import tilesOf

    return [tile._asdict() for tile in tilesOf(parameters)]


class Plain(Translator):
    """A translator that leaves the names of state variables as they are; trame's own looks at all
    names whenever a value is set."""

    def reverse_translate_dict(self, key_dict: dict[str, Any]) -> dict[str, Any]:
        return key_dict


class Page:
    """The content and the behavior of one page. `opening` is what it begins with, from the command
    line."""

    def __init__(self, server: Any, opening: dict[str, Any]) -> None:
        self.server, self.opening = server, opening
        self.application = MrmlApplication()
        python_layer.install(self.application)
        self.view = PageView(self.application, self._on_click)
        self.workshop = tempfile.TemporaryDirectory(prefix="sdfstent-")
        self.home = Path(opening.get("kept") or self.workshop.name)
        self.uploads = Uploads(self.home / "uploads")
        self.folders = Folders([*opening["folders"], self.uploads.folder])
        self._scan: Path | None = None
        self.scans = Scans(
            self.home, self._on_share, self._on_segments, self._on_prepared, self._tell
        )
        self._unseen = [str(self.uploads.folder), str(self.home)]
        self._forget: asyncio.TimerHandle | None = None
        slicer.util.showStatusMessage = self.tell
        self.widget = _panel(opening["module"])
        self.panel = self.widget.ui
        self._dirty: dict[str, Any] = {}
        self._flushed_at = 0.0
        self._edits: dict[Any, Any] = {}
        self._edited_at = -1
        self._shown_results: tuple[Any, ...] = ()
        self._pointed = -1
        self._kept: list[Kept] = []
        self._tasks: set[asyncio.Task[None]] = set()

    @property
    def parameters(self) -> Any:
        """The module's parameter node."""
        return self.widget._parameterNode

    # What the page shows

    def build(self) -> None:
        """Make the markup, and let state and widgets follow each other."""
        build(self)
        for widget in self.panel.widgets.values():
            self._show(widget)
            widget.on_change = self._changed
            if widget.edited:
                self._follow(widget)
        self.widget.vessel.making.onMade = self._made
        for place in self._places():
            place.connect("activeMarkupsPlaceModeChanged(bool)", self._on_placing)

    def _follow(self, widget: Any) -> None:
        name = value_of(widget)

        def edited(**state: Any) -> None:
            if state[name] != getattr(widget, widget.edited):
                self._edit_soon(widget, state[name])

        self.server.state.change(name)(edited)

    def _edit_soon(self, widget: Any, value: Any) -> None:
        """Take the latest value once the effect of the one before is seen, since a mouse is faster
        than that."""
        if not self._edits:
            loop = asyncio.get_running_loop()
            loop.call_later(EDIT_EVERY_S, self._edit_when_seen, loop.time() + LATEST_EDIT_S)
        self._edits.pop(widget, None)  # in the order in which they were touched last
        self._edits[widget] = value

    def _edit_when_seen(self, latest: float) -> None:
        loop = asyncio.get_running_loop()
        if self._edits and self._isAhead and loop.time() < latest:
            loop.call_later(LOOK_AGAIN_S, self._edit_when_seen, latest)
        else:
            self.take_edits()

    @property
    def _isAhead(self) -> bool:
        """Whether the effect of the value taken last has not been seen yet."""
        session, isSeen = self.widget.session, self.view.frames != self._edited_at
        return self.view.isBehind or (session.isRunning and session.isPreview and not isSeen)

    def take_edits(self) -> None:
        """Take the values set in the page until now: once per frame, before it is drawn, so that
        the next preview runs beside the drawing."""
        self._edited_at = self.view.frames
        edits, self._edits = self._edits, {}
        for widget, value in edits.items():
            self.attempt(partial(widget.edit, value))

    def _changed(self, widget: Any) -> None:
        """Send the state of a widget once all changes of this moment are made, but
        not too often."""
        if not self._dirty:
            loop = asyncio.get_running_loop()
            loop.call_at(max(self._flushed_at + SHOW_EVERY_S, loop.time()), self._flush)
        self._dirty[widget.objectName] = widget

    def _flush(self) -> None:
        changed, self._dirty = self._dirty, {}
        self._flushed_at = asyncio.get_running_loop().time()
        with self.server.state:
            for widget in changed.values():
                self._show(widget)
            self._show_results()

    def _show(self, widget: Any) -> None:
        state = self.server.state
        shown = widget.state()
        state[widget.objectName] = {**shown, "text": self._seen(shown["text"])}
        if widget.edited and widget not in self._edits:  # the browser knows better
            state[value_of(widget)] = getattr(widget, widget.edited)

    def _show_results(self) -> None:
        """Send the table and the plot, if they have changed, and whether there is something to
        save."""
        parameters = self.parameters
        chart, table = parameters.outputChart or self.widget.lesions.chart, parameters.outputTable
        drawn = chart and (chart.GetID(), chart.GetTitle(), opacity_of(chart))
        stamp = (drawn, table and table.GetTable().GetMTime())
        state = self.server.state
        state.canSave = self.panel.savePlanButton.enabled
        state.atHand = at_hand_of(self.widget)
        state.tiles = tiles_of(self.parameters)
        if stamp != self._shown_results:
            self._shown_results = stamp
            state.plot, state.table = plot_of(chart), table_of(table)
            self.point(self._pointed)

    def say(self, sentence: str) -> None:
        """Show a sentence above the panel; "" takes it away."""
        with self.server.state:
            self.server.state.message = self._seen(sentence)

    def tell(self, sentence: str, milliseconds: int) -> None:
        """Show a sentence over the view for some time, as in Slicer's status bar; ""
        takes it away."""
        if self._forget is not None:
            self._forget.cancel()
            self._forget = None
        with self.server.state:
            self.server.state.said = self._seen(sentence)
        if sentence:
            loop = asyncio.get_running_loop()
            self._forget = loop.call_later(milliseconds / 1000, self.tell, "", 0)

    def _seen(self, text: str) -> str:
        """A text without our folders: the files that the browser has sent or receives have the same
        names there."""
        for folder in self._unseen:
            text = text.replace(f"{folder}{os.sep}", "")
        return text

    def attempt(self, action: Callable[[], Any]) -> Any:
        """Do what the user asks for; if that fails, say why in the page."""
        self.say("")
        return self._tried(action)

    def _tried(self, action: Callable[[], Any]) -> Any:
        try:
            return action()
        except Exception as error:
            self._tell(error)
            return None

    def _tell(self, error: Exception) -> None:
        """Log an error and show its sentence; the page goes on, whatever it is."""
        self.widget.logic.log(error)
        self.say(self.widget.logic.sentence(error))

    # What the user does

    def click(self, name: str) -> None:
        """Press a button of the panel, after taking all values set before."""
        self.take_edits()
        widget = self.panel.widgets.get(name)
        if isinstance(widget, Button):
            self.attempt(widget.click)
            self._flush()

    def edit(self, name: str, value: Any) -> None:
        """Change a widget without a state variable for the change."""
        self.take_edits()
        widget = self.panel.widgets.get(name)
        if widget is not None:
            self.attempt(lambda: widget.edit(value))
            self._flush()

    def hover(self, name: str, row: Any) -> None:
        """Tell a table that the mouse is on a row, or with -1 on none."""
        widget = self.panel.widgets.get(name)
        if isinstance(widget, Table) and type(row) is int:
            self._tried(partial(widget.hover, row))  # what is said stays: nothing was asked for

    def key(self, name: str, key: str) -> None:
        """Press a key, in Qt's name for it, in a widget."""
        if key == "Esc" and self.server.state.chooser:
            self.choose("", "")
            return
        self.take_edits()
        for widget in self.panel.widgets.values():
            for shortcut in widget.shortcuts:
                if shortcut.key == key:
                    self.attempt(partial(shortcut.press, name))
        self._flush()

    def ask(self, name: str) -> None:
        """Ask for the file that a button of the panel needs, before the button is pressed."""
        if name in ASKS_FOR_FILE and self.panel.widgets[name].enabled:
            files = self.folders.listing(ASKS_FOR_FILE[name])
            text = self.panel.widgets[name].toolTip
            with self.server.state as state:
                state.chosenPath = ""
                state.chooser = {"button": name, "text": text, "files": files}

    def choose(self, name: str, path: str) -> None:
        """Press the button with the file that the user has chosen; without a name the user has
        chosen none."""

        self.take_edits()

        def press() -> None:
            with PageDesktop.answering(self.folders.existing(path)):
                self.panel.widgets[name].click()

        with self.server.state as state:
            state.chooser = {}
        if name in ASKS_FOR_FILE:
            self.attempt(press)

    def upload(self, variable: str, name: str, content: bytes) -> None:
        """Keep a file of the browser, and enter its path where the page asks for one; without a
        variable, where it belongs by its content."""

        def keep() -> None:
            path = self.uploads.kept(name, content)
            field = variable or ("centerlinePath" if has_lines(path) else "surfacePath")
            with self.server.state as state:
                state[field] = str(path)

        if variable in ("", *PATHS):
            self.attempt(keep)

    def open(self, surface: str, centerline: str, units: str, segment: int = -1) -> None:
        """Open a vessel, or in place of the surface a plan or a segmentation, from files that may
        be opened; a plan names its own unit. `segment` is the number of one of several."""

        def load() -> None:
            isNamed = surface == str(self._scan)  # as at the start, from wherever it is
            wall = Path(surface) if isNamed else self.folders.existing(surface)
            line = self.folders.existing(centerline) if centerline else None
            self._open(wall, line, units, self.folders, segment)

        if surface:
            self.attempt(load)
        else:
            self.say("Open: expected the path of a surface, got none; type or choose one.")

    def _open(
        self,
        wall: Path,
        line: Path | None,
        units: str,
        folders: Folders | None,
        segment: int = -1,
    ) -> None:
        """Open files; those that a plan names have to be in the folders, where there are some."""
        self.stop()
        if ends_in(wall, SCANS):
            isChosen = wall == self._scan and type(segment) is int
            if not isChosen:
                self._on_segments([])
            self._scan = wall
            self.scans.prepare(wall, segment if isChosen else -1)
            return
        self._scan = None
        self._on_segments([])
        scene = self.application.scene
        if wall.suffix.lower() in PLANS:
            self._opened(open_plan(scene, wall, folders))
        else:
            self._opened(open_vessel(scene, wall, line, units))

    def stop(self) -> None:
        """Make no vessel of a segmentation."""
        self.scans.stop()

    def _on_share(self, share: float | None) -> None:
        with self.server.state as state:
            state.preparing = "" if share is None else f"Surface and centerline, {share:.0%}"

    def _on_segments(self, segments: list[str]) -> None:
        with self.server.state as state:
            state.segments, state.segment = segments, 0
        if segments:
            self.say(f"Segment: choose one of {len(segments)}, then Open.")

    def _on_prepared(self, surface: Path, centerline: Path, said: str) -> None:
        def load() -> None:
            opened = open_vessel(self.application.scene, surface, centerline, "mm")
            self._opened(opened._replace(warnings="\n".join(filter(None, (said, opened.warnings)))))

        self.attempt(load)

    def open_named(self) -> None:
        """Open the files named at the start of the server, which may be anywhere."""

        def load() -> None:
            opening, kept = self.opening, self.home / PLAN
            given = kept if kept.is_file() else opening.get("input")  # a kept one goes on
            if given:
                line = opening.get("centerline")
                self._open(Path(given), line and Path(line), opening["units"], None)
            if self._scan is not None:
                with self.server.state as state:
                    state.surfacePath = str(self._scan)  # where one of several is to be chosen

        self.attempt(load)
        if self.opening.get("demo") and self.parameters.vessel is None:
            self.demo()
        if self.opening.get("kept"):
            self.widget.sections[0].onKept = self._keep

    def _keep(self, document: str) -> None:
        """Keep a plan on disk, so that the user can go on with it later."""
        if json.loads(document)["inputs"].get("surface"):
            self.home.mkdir(parents=True, exist_ok=True, mode=0o700)
            write_bytes(self.home / PLAN, document.encode())

    def demo(self) -> None:
        """Open the library's synthetic patient, from files of this page's own."""

        def load() -> None:
            from SDFStentSlicer.SampleVessels import addSampleVessel

            nodes = addSampleVessel("branching_pulmonary_artery", "Synthetic artery")
            for node, name in zip(nodes, ("surface", "centerline"), strict=True):
                self.home.mkdir(parents=True, exist_ok=True, mode=0o700)
                save_model(node, self.home / f"{name}.vtp")
            self._opened(Opened(*nodes))

        self.attempt(load)

    def _opened(self, opened: Any) -> None:
        parameters = self.parameters
        self.take_edits()  # they were made before
        self._close()
        parameters.vessel, parameters.centerline = opened.vessel, opened.centerline
        if opened.plan is not None:
            self.widget.logic.loadPlan(opened.plan, parameters)
        self.view.look_at_all()
        with self.server.state as state:
            state.opened += 1
        self.say(opened.warnings)

    def _made(self, former: Any) -> None:
        """Give a newly made centerline a file, as an opened one has."""
        line = self.parameters.centerline
        self.home.mkdir(parents=True, exist_ok=True, mode=0o700)
        save_model(line, self.home / f"{line.GetID()}.vtp")
        self.widget.sections[0].join(former)

    def _close(self) -> None:
        """Remove the former vessel from the scene, with its stents, its patient's flow and results."""
        from SDFStentSlicer.Display import OUTPUT_ROLES

        parameters, logic = self.parameters, self.widget.logic
        self.widget.onCancel()
        for other in logic.alternatives(parameters):
            if other is not parameters:
                logic.removePlan(other)
        if parameters.outputVessel is not None:
            logic.reset(parameters)
        # Ends, since every turn takes one away.
        while len(parameters.stents):
            logic.removeStent(parameters)
        parameters.change({"flow": None})
        for role in ("vessel", "centerline", *OUTPUT_ROLES):
            node = getattr(parameters, role)
            if node is not None:
                self.application.scene.RemoveNode(node)

    def save(self, kind: str) -> None:
        """Make a file for the browser to keep; if that fails, the page says why."""
        if kind in NAMES and not self.server.state.isSaving:
            self.take_edits()
            self.say("")
            with self.server.state as state:
                state.isSaving = True
            self._later(self._saved(kind))

    async def _saved(self, kind: str) -> Kept:
        try:
            path = Path(self.workshop.name) / "plan.json"
            self.widget.logic.savePlan(path, self.parameters)
            content = await asyncio.to_thread(exported, kind, path)
        finally:
            with self.server.state as state:
                state.isSaving = False
        return Kept(*NAMES[kind], content)

    def point(self, station: Any) -> None:
        """Mark the diameter of the vessel at a station of the plot in the view; without a valid
        number mark nothing."""
        self._pointed = station if type(station) is int else -1
        centers, diameters = self._plotted()
        isThere = 0 <= self._pointed < len(centers)
        center = centers[self._pointed] if isThere else None
        diameter = diameters[self._pointed] if isThere else np.nan
        self.view.mark(center if np.isfinite(diameter) else None, diameter)

    def _plotted(self) -> tuple[Any, Any]:
        """The points at the stations of the plot (k, 3) and the diameters of the vessel there (k,),
        mm."""
        run, lesion = self.widget.logic.lastRun(self.parameters), self.widget.lesions.plotted
        if self.parameters.outputChart is None and lesion is not None:
            return lesion.points, lesion.diameters
        if run is None or run.result is None:
            return (), ()
        profile = run.result.stents[run.shownStent or 0].around_after
        return profile.centers, profile.inscribed_diameter

    def picture(self) -> None:
        """Make a picture of the view for the browser to keep."""
        self._later(self._drawn())

    async def _drawn(self) -> Kept:
        encode, quality = RcaImageEncoder.PNG.encode, 100
        content, _about, _time = await asyncio.to_thread(encode, *self.view.picture(), quality)
        return Kept("view.png", "image/png", content)

    def gather(self, name: str) -> None:
        """Give the browser the file that a button of the panel writes; if the button writes a
        folder, a second click stops it."""
        if name not in {*WRITES_FILE, *WRITES_FOLDER} or not self.panel.widgets[name].enabled:
            return
        writer = self._writers().get(name)
        if writer is not None and writer.isRunning:
            self.click(name)
            return
        folder = Path(tempfile.mkdtemp(dir=self.workshop.name))
        self._unseen.append(str(folder))
        answer = folder / WRITES_FILE[name][0] if writer is None else folder
        with PageDesktop.answering(answer):
            self.click(name)
        self._later(self._gathered(name, writer, folder))

    def _writers(self) -> dict[str, Any]:
        """The writers of folders, which take a while, by their buttons."""
        return {
            "comparePlansButton": self.widget.plans.comparing,
            "writeSegmentButton": self.widget.sections[-1].writing,
        }

    async def _gathered(self, name: str, writer: Any, folder: Path) -> Kept | None:
        """The file to keep; None if nothing was written, for which the panel gives the reason."""
        try:
            if writer is None:
                file, media_type = WRITES_FILE[name]
                path = folder / file
                return Kept(file, media_type, path.read_bytes()) if path.exists() else None
            # Ends with the writing that the click has begun, or with a second click.
            while writer.isRunning:
                await asyncio.sleep(0.1)
            content = await asyncio.to_thread(zipped_folder, folder)
            return content and Kept(WRITES_FOLDER[name], "application/zip", content)
        finally:
            shutil.rmtree(folder, ignore_errors=True)

    def _later(self, making: Coroutine[Any, Any, Kept | None]) -> None:
        """Make a file while the page goes on: one call of the browser delays all later ones."""

        async def make() -> None:
            try:
                file = await making
            except Exception as error:
                self._tell(error)
                return
            if file is not None:
                self._kept.append(file)
                with self.server.state as state:
                    state.made += 1  # the browser comes for it

        task = asyncio.ensure_future(make())
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    def fetch(self) -> list[dict[str, Any]]:
        """Files that were made and not fetched yet."""
        kept, self._kept = self._kept, []
        return [file._asdict() for file in kept]

    def _places(self) -> list[PlaceWidget]:
        widgets = self.panel.widgets.values()
        return [one for one in widgets if isinstance(one, PlaceWidget)]

    def _on_placing(self, isPlacing: bool) -> None:
        with self.server.state as state:
            state.isPlacing = isPlacing

    def _on_click(self, x: float, y: float) -> bool:
        """Put the next point on the centerline where the user clicks, while placing is on."""
        self.take_edits()
        place = next((one for one in self._places() if one.placeModeEnabled), None)
        if place is not None:
            self.attempt(lambda: self._put(place, x, y))
        return place is not None

    def _put(self, place: PlaceWidget, x: float, y: float) -> None:
        from SDFStentSlicer import Conversion

        points, _lines, _radii = Conversion.centerlineLines(self.parameters.centerline)
        place.currentNode().AddControlPointWorld(*self.view.nearest(points, x, y))


def _panel(folder: Path) -> Any:
    """The module's own panel, set up and entered. Its folder is already on Python's path."""
    from SDFStentSlicer import Clock, Desktop
    from SDFStentSlicer.Widget import SDFStentWidget

    Clock.use(AsyncTimer)
    Desktop.use(PageDesktop)
    slicer.util.modulePath = lambda _name: str(folder / "SDFStent.py")
    layout = SimpleNamespace(addWidget=lambda _widget: None)
    widget = SDFStentWidget(SimpleNamespace(layout=lambda: layout, isEntered=True))
    widget.setup()
    widget.enter()
    return widget
