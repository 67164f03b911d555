"""What the module needs of an event loop: to be called later. Qt's in Slicer, another one where an application has it."""


class QtTimer:
    """Calls a function some milliseconds after `start`: once, or again and again until `stop`.

    Make one and start it as often as needed: in PythonQt a timer and the method that it calls keep each other for ever.
    """

    WAIT_S = 0.005
    """How long a turn waits for a thread: in Slicer threads advance only while the application waits for them."""

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


_kinds = [QtTimer]


def timer(call, milliseconds, isRepeated=False):
    """A timer as `QtTimer`, of the event loop that there is; it waits for its `start`."""
    return _kinds[-1](call, milliseconds, isRepeated)


def wait():
    """Seconds that a turn of the event loop may wait for a thread."""
    return _kinds[-1].WAIT_S


def use(kind):
    """From now on make timers of another class, for an application without Qt; it is made, called and asked as `QtTimer`."""
    _kinds[:] = [kind]
