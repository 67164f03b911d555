"""Long work in small portions on the application's own thread, and long calculations on other threads."""

import threading
import time

import slicer

from . import Clock

ELSEWHERE = object()
"""Portion of a calculation in another process: the turn ends, since waiting longer does not bring it on."""

LONGEST_FRAME_S = 0.5
FORGOTTEN_S = 1.0
"""Half-life of the time that the application was seen to need: not every turn has a frame before it."""


class _Application:
    """The time that the application needs between the turns of all runs, mostly to draw a frame."""

    def __init__(self):
        self._worked = self._needed = self._seenAt = 0.0

    def clock(self):
        """Seconds on a clock that stands still while a run has its turn."""
        return time.perf_counter() - self._worked

    def needed(self, seconds):
        """Note that the application was away for this time, and return the longest time that it has needed lately."""
        now = time.perf_counter()
        left = 0.5 ** ((now - self._seenAt) / FORGOTTEN_S)
        self._needed, self._seenAt = max(min(seconds, LONGEST_FRAME_S), left * self._needed), now
        return self._needed

    def tookTurn(self, seconds):
        """Note that a run had a turn of this time."""
        self._worked += seconds


_application = _Application()


class SteppedRun:
    """Advances an iterator by a timer, for a limited time per tick, so that the application stays responsive.

    If frames take long to draw, as in software, a tick may take longer; nothing is drawn in the middle of it. A tick of
    a run whose progress is seen is long after a single slow frame; that of another run is only as long as the
    application has just needed.

    `onProgress(value)` gets the latest value once per tick; `onDone(error)` is called once per run: with None at the
    end, with the exception when one was raised. `cancel()` ends a run at once without calling `onDone`.

    One object serves one run after another, as a `Clock` timer does.
    """

    def __init__(self, onProgress, onDone):
        self._onProgress, self._onDone = onProgress, onDone
        self._iterator, self._leftAt, self._isSeen = None, 0.0, False
        self._timer = Clock.timer(self._tick, 0, isRepeated=True)

    def start(self, iterator, isSeen=False):
        """Begin a run; another one must not be under way."""
        self._iterator, self._leftAt = iterator, _application.clock()
        self._isSeen = isSeen
        self._timer.start()

    def advance(self):
        """Take a turn now, since a frame may be drawn before the timer's first tick."""
        self._tick()

    @property
    def isRunning(self):
        """Whether a run is under way."""
        return self._iterator is not None

    def cancel(self):
        """Stop the run; the iterator's `finally` blocks run now."""
        self._timer.stop()
        iterator, self._iterator = self._iterator, None
        if iterator is not None:
            iterator.close()

    def _tick(self):
        if self._iterator is None:
            return
        start, views = time.perf_counter(), slicer.app.applicationLogic()
        views.PauseRender()  # otherwise they would draw a due frame in the middle of a change
        try:
            away = _application.clock() - self._leftAt
            needed = _application.needed(away)
            self._advance(start + Clock.turn(needed if self._isSeen else away / 2))
        finally:
            _application.tookTurn(time.perf_counter() - start)
            self._leftAt = _application.clock()
            views.ResumeRender()  # draws the views if a frame is due, also after the last turn of a run
            _application.needed(_application.clock() - self._leftAt)

    def _advance(self, end):
        value = None
        try:
            # Ends with the time, or with the iterator, whose values are never None.
            while value is None or time.perf_counter() < end:
                found = next(self._iterator)
                if found is ELSEWHERE:
                    break
                value = found
        except StopIteration:
            self._finish(None)
        except Exception as error:
            # Every exception has to stop the timer, or it would fire for ever; the panel shows it.
            self._finish(error)
        else:
            if value is not None:
                self._onProgress(value)

    def _finish(self, error):
        self._timer.stop()
        self._iterator = None
        self._onDone(error)


_left = []
"""Abandoned threads."""


class RestedRun:
    """Runs what follows from a change, once that has rested for some ms, so that nothing is done for what a hand still moves.

    `portions()` is an iterator as that of a `SteppedRun`, `onDone(error)` is called in the end.
    """

    def __init__(self, portions, onDone, restMs):
        self._portions = portions
        self._whose = self._what = None
        self._run = SteppedRun(lambda _value: None, onDone)
        self._timer = Clock.timer(self._begin, restMs)

    @property
    def isBusy(self):
        """Whether something is done, or about to be."""
        return self._run.isRunning or self._timer.isActive()

    def follow(self, whose, what):
        """Follow a change: for whom something is to be done now, and on what that depends, None for nothing; called whenever these may have changed.

        For what comes first nothing is done: it is as it was left.
        """
        isSame = whose == self._whose
        if isSame and what == self._what:
            return
        self._cancel()
        self._whose, self._what = whose, what
        if isSame and what is not None:
            self._timer.start()

    def hurry(self):
        """Begin now what would begin after a longer rest; returns whether something is done."""
        if self._timer.isActive():
            self._timer.stop()
            self._begin()
        return self._run.isRunning

    def finish(self):
        """Do the pending work at once."""
        if self.isBusy:
            self._cancel()
            untilDone(self._portions())

    def _cancel(self):
        self._timer.stop()
        self._run.cancel()

    def _begin(self):
        self._run.start(working(self._portions()))


def inPortions(function):
    """Run a function on a thread of its own; a generator that yields None until it is done and returns what it
    returned.

    It yields once more at the end, so that the caller's further work begins in a new turn if the time of this one is
    used up.

    The function must not touch the scene, VTK or Qt, which belong to the application's thread. Closing the generator
    does not stop the function, but nobody waits for its result any more. An exception of the function is raised here.

    A thread only advances while the application's own thread waits for it, so whoever iterates decides how much time it
    gets.
    """
    outcome = {}

    def run():
        try:
            outcome["value"] = function()
        except BaseException as error:
            outcome["error"] = error

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    thread.join(Clock.wait())
    try:
        # Ends with the function; a caller who does not want to wait closes the generator.
        while thread.is_alive():
            yield None
            thread.join(Clock.wait())
        yield None
    finally:
        if thread.is_alive():
            _left.append(thread)
    if "error" in outcome:
        raise outcome["error"]
    return outcome["value"]


class Jointly:
    """Calculations in portions, each made once for all who ask for it meanwhile; whoever waits for it brings it on."""

    def __init__(self):
        self._begun = {}

    def portions(self, kind, stamp, begin):
        """Make what a kind of thing is at a stamp, by the generator `begin()`: a generator that yields its portions and returns its value.

        Closing it leaves the calculation to the others. One of another stamp is not waited for.
        """
        begun = self._begun.get(kind)
        if begun is None or begun.stamp != stamp:
            begun = self._begun[kind] = _Begun(stamp, begin())
        try:
            # Ends: with the calculation.
            while not begun.isDone:
                yield from begun.portion()
        finally:
            if begun.isDone and self._begun.get(kind) is begun:
                del self._begun[kind]
        return begun.outcome()


class _Begun:
    """A calculation that several wait for."""

    def __init__(self, stamp, portions):
        self.stamp, self.isDone = stamp, False
        self._portions, self._value, self._error = portions, None, None

    def portion(self):
        """Bring it on; yields what comes of that."""
        try:
            value = next(self._portions)
        except StopIteration as end:
            self._value, self.isDone = end.value, True
        except Exception as error:
            self._error, self.isDone = error, True
        else:
            yield value

    def outcome(self):
        """The value in the end; raises what the calculation did."""
        if self._error is not None:
            raise self._error
        return self._value


def isPortion(value):
    """Whether a value that a calculation yielded is a portion, and not a result."""
    return value is None or value is ELSEWHERE


def waiting(answer):
    """Wait for another process: a generator that yields `ELSEWHERE` until `answer()` is a tuple with a value, and returns that."""
    # Ends: with the answer; a caller who does not want to wait closes the generator.
    while not (values := answer()):
        yield ELSEWHERE
    return values[0]


def countLeft():
    """Number of abandoned functions that still run; waits a while for one, which would not advance otherwise."""
    _left[:] = [thread for thread in _left if thread.is_alive()]
    for thread in _left[:1]:
        thread.join(Clock.turn(0.0))
    return len(_left)


def working(portions, fraction=float):
    """Yield the fraction done, which `fraction()` gives, for every portion calculated here; returns the result of the calculation."""
    # Ends: with the calculation.
    while True:
        try:
            portion = next(portions)
        except StopIteration as end:
            return end.value
        yield portion if portion is ELSEWHERE else fraction()


def untilDone(portions):
    """Run all portions of a calculation at once, and return its result."""
    # Ends: with the calculation.
    while True:
        try:
            next(portions)
        except StopIteration as end:
            return end.value
