"""Room for the panel in a low window: its lines below *Deploy* lie beneath Slicer's *Data Probe* there."""

import slicer

from .Desktop import desktop

LOW = 950
"""Height of a main window, pixels, in which, with *Data Probe* open, the rows of tiles do not all fit: all but the panel takes 410."""


class LowWindow:
    """Folds *Data Probe* while the module is shown in a low window, and unfolds it behind it, and where the window becomes higher.

    Its header stays: who unfolds it meanwhile has it.
    """

    def __init__(self):
        self._folded, self._unwatch = None, lambda: None

    def enter(self):
        """Make room while the module is shown."""
        window = None if slicer.app.layoutManager() is None else slicer.util.mainWindow()
        if window is not None:
            self._unwatch()
            self._unwatch = desktop().onEvent(window, "Resize", lambda: self._look(window))
            self._look(window)

    def leave(self):
        """Undo that when the module is left."""
        self._unwatch()
        self._unwatch = lambda: None
        self._unfold()

    def _look(self, window):
        if window.height >= LOW:
            self._unfold()
        elif self._folded is None:
            for probe in slicer.util.findChildren(window, name="DataProbeCollapsibleWidget"):
                if not probe.collapsed:
                    probe.collapsed = True
                    self._folded = probe

    def _unfold(self):
        folded, self._folded = self._folded, None
        if folded is not None:
            folded.collapsed = False
