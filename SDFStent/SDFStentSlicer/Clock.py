"""Event loop of the module, to be called later: Qt's in Slicer, another one where an application has it."""

import contextlib


class QtTimer:
    """Calls a function some milliseconds after `start`: once, or again and again until `stop`.

    Make one and start it as often as needed: in PythonQt a timer and the method that it calls keep each other for ever.
    """

    WAIT_S = 0.005
    """Time that a turn waits for a thread at once: in Slicer threads advance only while the application waits for them."""

    TURN_S = (0.01, 0.5)
    """Least time of a turn, and its longest with the frame that is drawn after it."""

    def __init__(self, call, milliseconds, isRepeated):
        import qt

        self._timer = qt.QTimer()
        self._timer.setSingleShot(not isRepeated)
        self._timer.setInterval(milliseconds)
        self._timer.connect("timeout()", call)

    def start(self):
        """Wait from now on; anew where it was waiting already."""
        self._timer.start()

    def stop(self):
        """Call no more."""
        self._timer.stop()

    def isActive(self):
        """Whether a call is still to come."""
        return self._timer.isActive()


_kinds, _lists = [QtTimer], []


def timer(call, milliseconds, isRepeated=False):
    """Timer as `QtTimer`, of the event loop in use; it waits for its `start`."""
    made = _kinds[-1](call, milliseconds, isRepeated)
    for timers in _lists:
        timers.append(made)
    return made


@contextlib.contextmanager
def listed():
    """Gives a list of all timers that are made within the block: who makes their owners can stop every one of them."""
    timers = []
    _lists.append(timers)
    try:
        yield timers
    finally:
        _lists.pop()


def wait():
    """Seconds that a turn of the event loop may wait for a thread at once."""
    return _kinds[-1].WAIT_S


def turn(away):
    """Seconds that a turn of the event loop may take where the application needs some in between, mostly to draw a frame.

    Twice as long, as what is begun should rather be seen in the next frame than in the next but two; but with a frame after it
    no longer than a hand can do without an answer.
    """
    least, most = _kinds[-1].TURN_S
    return max(least, min(2 * away, most - away))


def longest():
    """Seconds that a turn of the event loop may take at most."""
    return _kinds[-1].TURN_S[1]


def use(kind):
    """Make timers of another class from now on, for an application without Qt; it is made, called and asked as `QtTimer`."""
    _kinds[:] = [kind]
