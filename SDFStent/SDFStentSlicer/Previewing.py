"""Previews of stents while they are dragged: the library's preview, off the application's thread, and its display."""

import threading
import time
from typing import Any, NamedTuple

import numpy as np
import slicer
from slicer.i18n import tr as _

from SDFStentLib.beside import ProcessEnded
from SDFStentLib.validation import DeploymentError, InputError

from . import Calculating, Dependencies, Plans, Results
from .Portions import inPortions, working
from .Stenting import DrawnStent, lying

NUMBERS_EVERY_S = 0.15
"""Previews are measured no more often: a number that changes faster is not read."""


class Previewing:
    """Shows what the library's preview says of a plan, and about its numbers."""

    def __init__(self):
        self._measuredAt = 0.0

    def steps(self, shown, signature, vessel, inputs, search):
        """Preview the plan on the `PreviewedVessel` of the logic's `Inputs` and show it; an iterator as `SDFStentLogic.steps`.

        `search` is the `LesionSearch` of the vessel, or None. Where the library refuses the plan, or the centerline, the vessel is shown
        without stents, and said to be.
        """
        parameterNode, surface = shown.parameterNode, shown.surface(vessel)
        surface.hideOutline()  # until nothing more is coming
        try:
            preview = yield from working(inputs.previewInPortions(parameterNode))
            case = Plans.caseOf(parameterNode, preview.vessel, live=True)
            yield from working(inputs.placedInPortions(parameterNode, case))
            found = () if search is None else search.found or ()
            places = Dependencies.places(parameterNode)
            run = yield from working(preview.portions(case, places, found))
            run.follow(shown.run)
        except (InputError, DeploymentError):
            show(shown, surface, PreviewRun.withoutStents(vessel.surface), signature)
            with slicer.util.NodeModify(parameterNode):
                parameterNode.expansion = 0.0
                Results.clearNumbers(parameterNode, _("Shown: the vessel before treatment."))
            Results.clearCenterline(parameterNode)
            raise
        show(shown, surface, run, signature)
        parameterNode.expansion = 100.0
        yield 1.0
        yield from self._numbers(parameterNode, run, search)

    def _numbers(self, parameterNode, run, search):
        """Show about its numbers, unless that was done just now; numbers of the full method are replaced at once."""
        now, isTold = time.perf_counter(), not parameterNode.certificateSummary
        if isTold and now - self._measuredAt < NUMBERS_EVERY_S:
            return
        found = () if search is None else search.found or ()
        numbers = yield from working(run.numbers(found))
        self._measuredAt = now
        Results.showPreviewed(parameterNode, run, numbers, found)
        yield 1.0


def show(shown, surface, run, signature):
    """Show a `PreviewRun` of the plan and inputs with a signature."""
    surface.showChanged(run.state.indices, run.state.coordinates)
    shown.run, shown.signature = run, signature
    Results.showStents(shown.parameterNode, run.tubes())
    Results.showMap(shown.parameterNode, run)


class PreviewedVessel:
    """A vessel on which plans are tried out, in a process beside the application where there is one. No nodes in here.

    What is made for it once is made once, whoever waits for it.
    """

    def __init__(self, vessel):
        """A preview of the library's `Vessel`."""
        self.vessel, self._lock = vessel, threading.Lock()

    def portions(self, case, places, lesions=()):
        """Preview the library's `Case` in this vessel; yields portions until it is done, then returns its `PreviewRun`.

        `lesions` are those for the numbers.
        """
        surface, process = self.vessel.surface, Calculating.processes.previewing
        try:
            if process is not None:
                process.preview(case, lesions)
                asked = Calculating.Asked(process)
                state = yield from asked.answer()
                return PreviewRun(surface, state, places, asked)
        except ProcessEnded:
            pass
        return (yield from self._inTurn(lambda: PreviewRun(surface, case.previewed(), places)))

    def prepared(self):
        """Prepare the first preview, wherever it will be; yields None until it is done."""
        process = Calculating.processes.previewing
        try:
            if process is not None:
                process.prepare(self.vessel)
                return
        except ProcessEnded:
            pass
        yield from self._inTurn(self.vessel.preview.prepare)

    def _inTurn(self, function):
        """Run a function after those before it; not at all when nobody waits for it any more."""
        isWanted = [True]

        def run():
            with self._lock:
                return function() if isWanted[0] else None

        try:
            return (yield from inPortions(run))
        finally:
            isWanted[0] = False


class _State(NamedTuple):
    """The state of a vessel, as the library's `PreviewState` has it."""

    indices: Any
    coordinates: Any
    stents: Any


class PreviewRun:
    """Run of a preview, in the words of `Stenting`; it has no steps to go back to."""

    recorded = measured = ()
    result = lesions = centerline = None

    def __init__(self, surface, state, places, asked=None):
        """`asked` is what was asked of a process that has made the state, and will tell its numbers."""
        self.surface, self.state, self.places = surface, state, list(places)
        self._asked = asked
        self.shownMap = self.shownStent = None

    @classmethod
    def withoutStents(cls, surface):
        """The vessel as it was."""
        nothing = np.empty(0, dtype=np.int64), np.empty((0, 3)), ()
        return cls(surface, _State(*nothing), ())

    @classmethod
    def grown(cls, run, state):
        """Run with the wall that the only stent of a `Stenting` has grown, by its library's `TreatmentState`."""
        moved = state.deployment
        return cls(
            run.surface, _State(moved.indices, moved.coordinates, (state.placed,)), run.places
        )

    def follow(self, earlier):
        """Keep what the last deployment in this vessel measured: the `earlier` run is it, or has kept it."""
        if earlier is not None and earlier.surface is self.surface:
            self.measured = earlier.measured

    @property
    def points(self):
        """Points of the vessel."""
        points = self.surface.points.copy()
        points[self.state.indices] = self.state.coordinates
        return points

    def numbers(self, lesions):
        """Measure every stent and the lesions after treatment; yields portions until it is done, then returns a list."""
        asked, self._asked = self._asked, None  # it tells them once
        try:
            if asked is not None:
                numbers = yield from asked.answer()
                return self.state.with_covered(numbers, self.measured)
        except ProcessEnded:
            pass
        return (yield from inPortions(lambda: self.state.numbers(lesions, self.measured)))

    def tubes(self):
        """Stents as `DrawnStent`s."""
        return lying({one.number: DrawnStent.whole(one) for one in self.state.stents})

    def at(self, percent):
        """The points before or after the stents, and the stents that are there."""
        return self.end() if percent > 0 else (self.surface.points, [])

    def end(self):
        """The points after the stents, and every stent as a `DrawnStent`."""
        return self.points, self.tubes()
