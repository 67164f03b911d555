"""`Host`: the application as a test sees it."""

import contextlib
import ctypes
import importlib.util
import logging
import os
import re
import sys
import time
import types
from pathlib import Path

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
if not os.environ.get("DISPLAY"):
    # Without a screen VTK finds this window by itself, but only after a warning.
    os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")

import slicer

if sys.version_info < (3, 12):
    # PySide6 6.12 gives back None, True and False without counting them, which only later Pythons, where they are
    # immortal, allow: after some ten thousand calls the interpreter would abort ("deallocating None").
    for constant in (None, True, False):
        ctypes.c_ssize_t.from_address(id(constant)).value += 1 << 40

from PySide6 import QtCore, QtTest, QtWidgets

from . import mrml, slicer_stand_in
from .event_loop import Frames, deliverEvents, passTime
from .qt_stand_in import wrapped
from .skins import qMRMLWidget

LOOK_MS = 20
"""Time between two looks at a condition that is waited for, while no event comes. An application sleeps until there is
one; to look again and again would keep a core busy, and take the interpreter from the threads that are waited for."""


@contextlib.contextmanager
def withoutLaterModules(name):
    """Remove the classes of loadable modules after `name` in the alphabet from `slicer` within the block: Slicer loads
    them later."""
    later = {}
    for attribute, cls in vars(slicer).items():
        owner = re.search(r"vtkSlicer(\w+)Module", getattr(cls, "__module__", "") or "")
        if owner and owner.group(1) > name:
            later[attribute] = cls
    for attribute in later:
        delattr(slicer, attribute)
    try:
        yield
    finally:
        vars(slicer).update(later)


class Host:
    """The application of a process: `Host.start()` returns the same object each time.

    The environment variable SLICER_CHECKOUT may name a folder of Slicer's sources: its own Python layer is used then.
    """

    _instance = None

    @classmethod
    def start(cls):
        if cls._instance is None:
            cls._instance = cls()
        return cls._instance

    def __init__(self):
        self.qtApplication = QtWidgets.QApplication.instance() or QtWidgets.QApplication([])
        self.qtApplication.setStyle("Fusion")
        self._alarm = QtCore.QTimer(singleShot=True)
        self.application = mrml.Application()
        self.files = []
        slicer_stand_in.install(self.application, self.files, os.environ.get("SLICER_CHECKOUT"))
        slicer.util.reloadScriptedModule = lambda name: self.loadModule(
            getattr(slicer.modules, name.lower()).path
        )
        self.pythonErrors = []
        sys.excepthook = self._onException  # slots and VTK observers report here, not to the caller
        self._panels, self._rulers = [], {}
        self.sitsOutWaits = False  # True when a test measures times, which needs real waits
        logging.getLogger().addHandler(LogList(self.pythonErrors))
        self.application.errorLog.clear()  # messages of Slicer's own start-up are not the module's

    @property
    def scene(self):
        return self.application.scene

    def loadModule(self, path):
        """Execute a module file as Slicer's factory does: with its folder on the path, and its class made with a
        parent."""
        path = Path(path).resolve()
        if str(path.parent) not in sys.path:
            sys.path.append(str(path.parent))
        spec = importlib.util.spec_from_file_location(path.stem, path)
        python = importlib.util.module_from_spec(spec)
        sys.modules[path.stem] = python
        with withoutLaterModules(path.stem):
            spec.loader.exec_module(python)
        parent = types.SimpleNamespace(path=str(path))
        entry = types.SimpleNamespace(path=str(path), name=path.stem, python=python, parent=parent)
        setattr(slicer.modules, path.stem.lower(), entry)
        entry.module = getattr(python, path.stem)(parent)
        slicer.app.completeStartup()
        return entry

    def openPanel(self, entry, width=520, height=1000):
        """The module's widget, set up and entered, in a window of the given size."""
        parent = wrapped(qMRMLWidget)()
        QtWidgets.QVBoxLayout(parent)
        panel = getattr(entry.python, entry.name + "Widget")(parent)
        panel.setup()
        parent.resize(width, height)
        parent.show()
        self._panels.append(panel)
        self._rulers[panel] = Ruler(parent)
        self.enter(panel)
        return panel

    @contextlib.contextmanager
    def drawing(self, seconds):
        """Draw the 3D view as the application does, with frames that take this time each; yields the `Frames`."""
        application = self.application
        frames = Frames(application.view.group, application.applicationLogic, seconds)
        before, self.sitsOutWaits = self.sitsOutWaits, True
        try:
            yield frames
        finally:
            self.sitsOutWaits = before
            frames.stop()

    def widths(self, panel):
        """The widths in pixels that the application has given to a panel so far: each is its minimum width at some
        time."""
        self.process()
        return self._rulers[panel].widths

    def enter(self, panel):
        """Change over to a panel's module."""
        panel.parent.isEntered = True
        panel.enter()
        self.process()

    def leave(self, panel):
        """Change over to another module."""
        panel.exit()
        panel.parent.isEntered = False
        self.process()

    def closePanel(self, panel):
        self.leave(panel)
        panel.cleanup()
        panel.layout.itemAt(0).widget().setMRMLScene(None)  # as when it is destroyed
        self._panels.remove(panel)
        del self._rulers[panel]
        panel.parent.close()
        panel.parent.deleteLater()
        self.process()

    def newScene(self):
        """Close the scene, as File / Close Scene does."""
        self.scene.Clear(0)
        self.process()

    def saveAndLoad(self, path):
        """Save the scene as an MRB file, close it, and load the file."""
        assert self.scene.WriteToMRB(str(path))
        self.newScene()
        assert self.scene.ReadFromMRB(str(path), True)
        self.process()

    def process(self, seconds=0.0):
        """Let Qt deliver its events, timers included."""
        end = time.perf_counter() + seconds
        while True:
            deliverEvents()
            left = end - time.perf_counter()
            if left <= 0:
                return
            self._sleep(round(1000 * left))

    def processUntil(self, condition, seconds=1800.0):
        """Let Qt run until the condition holds; fails after `seconds`."""
        end = time.perf_counter() + seconds
        while not condition():
            if time.perf_counter() > end:
                raise TimeoutError(f"Still waiting after {seconds} s.")
            if self.sitsOutWaits or not passTime():
                self._sleep()

    def _sleep(self, milliseconds=LOOK_MS):
        """Wait until there is an event, and deliver it."""
        self._alarm.start(milliseconds)
        deliverEvents(isWaiting=True)

    def click(self, button):
        """Click with the left button in the middle of a button that the user can see and press."""
        if not button.isEnabled():
            raise AssertionError(f"{button.objectName} is disabled: {button.toolTip}")
        QtTest.QTest.mouseClick(button, QtCore.Qt.LeftButton)
        self.process()

    def choose(self, comboBox, index):
        """Pick an item of a combo box, as a user does."""
        comboBox.currentIndex = index
        comboBox.activated.emit(index)
        self.process()

    def grab(self, widget, path):
        """Save the picture of a widget as a PNG file."""
        self.process()
        if not widget.grab().save(str(path)):
            raise OSError(f"Could not write {path}")
        return Path(path)

    def errors(self):
        """All errors since the last call: the log of VTK and MRML, and Python errors in slots and observers."""
        found = [line for line in self.application.errorLog.text().splitlines() if line.strip()]
        found += self.pythonErrors
        self.application.errorLog.clear()
        self.pythonErrors.clear()
        return found

    def _onException(self, kind, value, traceback):
        logging.getLogger().error("in a slot or observer", exc_info=(kind, value, traceback))


class Ruler(QtCore.QObject):
    """Measures the width that a panel needs, as `qSlicerModulePanel` does, whenever something in it asks for another
    size."""

    def __init__(self, parent):
        super().__init__(parent)
        self._parent, self.widths = parent, set()
        parent.installEventFilter(self)

    def eventFilter(self, _watched, event):
        if event.type() == QtCore.QEvent.LayoutRequest:
            self.widths.add(QtWidgets.QWidget.minimumSizeHint(self._parent).width())
        return False


class LogList(logging.Handler):
    """Python's log from errors upward, with tracebacks, as Slicer's error log shows it."""

    def __init__(self, texts):
        super().__init__(logging.ERROR)
        self._texts = texts

    def emit(self, record):
        self._texts.append(self.format(record))
