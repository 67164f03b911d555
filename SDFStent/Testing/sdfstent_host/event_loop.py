"""Time in the application: Python threads rest while Qt's event loop runs, and each frame of the 3D view takes a given
time."""

import ctypes
import sys
import time
import weakref
from pathlib import Path

import PySide6
from PySide6 import QtCore
from vtkmodules.vtkCommonCore import vtkCommand

FRAME_EVERY_MS = 16
"""Shortest time between two frames of `ctkVTKAbstractView`, which draws at most 60 times a second."""

QT_CORE = Path(PySide6.__file__).parent / "Qt" / "lib" / "libQt6Core.so.6"
PROCESS_EVENTS = "_ZN16QCoreApplication13processEventsE6QFlagsIN10QEventLoop17ProcessEventsFlagEE"
if sys.platform.startswith("linux"):
    # Neither Slicer nor CTK lets other threads of Python advance while it waits for events or draws; PySide6 does.
    _processEvents = ctypes.PyDLL(str(QT_CORE))[PROCESS_EVENTS]
    _usleep = ctypes.PyDLL(None).usleep
else:

    def _processEvents(flags):
        QtCore.QCoreApplication.processEvents(QtCore.QEventLoop.ProcessEventsFlag(flags))

    def _usleep(microseconds):
        time.sleep(microseconds / 1e6)


def deliverEvents(isWaiting=False):
    """Let Qt deliver its events, timers included; if it waits, only once there is one."""
    events = QtCore.QEventLoop
    _processEvents((events.WaitForMoreEvents if isWaiting else events.AllEvents).value)


class QTimer(QtCore.QTimer):
    """A timer of the module. When nothing else is left to do, a test need not wait until it is due."""

    known = weakref.WeakSet()

    def __init__(self, *arguments):
        super().__init__(*arguments)
        self.known.add(self)


def passTime():
    """End the wait of the timer that is due next, as if its time had passed; returns whether there was one, and nothing
    else under way."""
    waiting = [timer for timer in QTimer.known if QtCore.QTimer.isActive(timer)]
    if not waiting or any(QtCore.QTimer.interval(timer) == 0 for timer in waiting):
        return False
    due = min(waiting, key=QtCore.QTimer.remainingTime)
    if QtCore.QTimer.isSingleShot(due):
        due.stop()
    due.timeout.emit()
    return True


class Frames:
    """Frames of a view that are asked for as `ctkVTKAbstractView` asks; each keeps the application busy for some
    seconds.

    `count` is the number of frames drawn, `onFrame()` is called before each.
    """

    def __init__(self, group, applicationLogic, seconds):
        self._seconds, self._asked, self._pauses = seconds, None, 0
        self.count, self.onFrame = 0, lambda: None
        self._timer = QtCore.QTimer(singleShot=True, interval=FRAME_EVERY_MS)
        self._timer.timeout.connect(self._draw)
        self._observed = [
            (source, source.AddObserver(event, lambda *_, method=method: method()))
            for source, event, method in (
                (group, vtkCommand.UpdateEvent, self._schedule),
                (applicationLogic, applicationLogic.PauseRenderEvent, self._pause),
                (applicationLogic, applicationLogic.ResumeRenderEvent, self._resume),
            )
        ]

    def stop(self):
        """Draw no more."""
        self._timer.stop()
        for source, tag in self._observed:
            source.RemoveObserver(tag)

    def _pause(self):
        self._pauses += 1

    def _resume(self):
        self._pauses -= 1
        if self._asked is not None:
            self._schedule()

    def _schedule(self):
        if self._asked is None:
            self._asked = time.perf_counter()
            self._timer.start()
        elif time.perf_counter() - self._asked > FRAME_EVERY_MS / 1000:
            self._draw()  # overdue: drawn within the call that asks

    def _draw(self):
        if self._pauses > 0 or self._asked is None:
            return
        self._timer.stop()
        self._asked = None
        self.count += 1
        self.onFrame()
        _usleep(round(1e6 * self._seconds))
