"""Long calculations without nodes, off the application's thread."""

import threading

from . import Clock

_left = []
"""Threads that nobody waits for any more."""


def inPortions(function):
    """Run a function on a thread of its own; a generator that yields None until it is done and returns what it returned.

    It yields once more when it is done, so that what is done with it begins anew where the time of a turn is used up.

    The function must not touch the scene, VTK or Qt, which belong to the application's thread. Closing the generator does not
    stop the function, but nobody waits for it or hears of it any more. What it raises is raised here.

    A thread only advances while the application's own thread waits for it, so whoever iterates decides how much time it gets.
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
        # Ends: with the function; who does not want to wait closes the generator.
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


def countLeft():
    """How many functions still run though nobody waits for them; waits for one a while, as it would not advance otherwise."""
    _left[:] = [thread for thread in _left if thread.is_alive()]
    for thread in _left[:1]:
        thread.join(Clock.turn(0.0))
    return len(_left)


def working(portions, fraction=float):
    """Yield a fraction done, 0.0 or what `fraction()` gives, for every portion of a calculation; returns what it returns."""
    # Ends: with the calculation.
    while (end := _next(portions)) is None:
        yield fraction()
    return end.value


def untilDone(portions):
    """Run all portions of a calculation at once; returns what it returns."""
    # Ends: with the calculation.
    while (end := _next(portions)) is None:
        pass
    return end.value


def _next(portions):
    """None, or the `StopIteration` that ends it."""
    try:
        next(portions)
    except StopIteration as end:
        return end
    return None
