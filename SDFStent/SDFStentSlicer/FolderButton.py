"""A button that writes a new folder, in portions, and stops that when it is clicked again."""

import qt
from slicer.i18n import tr as _

from .SteppedRun import SteppedRun


class FolderButton:
    """Asks for a folder and runs the iterator `stepsInto(folder)`, which yields fractions done and returns a path.

    By its first value the iterator needs the scene no more. `attempt(action)` does what is asked for and says why when it cannot be
    done; `onDone(path)` is called when it was.
    """

    def __init__(self, button, title, stepsInto, attempt, onDone):
        self._button, self._title, self._text = button, title, button.text
        self._stepsInto, self._attempt, self._onDone = stepsInto, attempt, onDone
        self._path = None
        self._run = SteppedRun(self._onProgress, self._finished)
        button.connect("clicked()", self._onClicked)

    @property
    def isRunning(self):
        """Whether something is being written."""
        return self._run.isRunning

    def stop(self):
        """Stop what is under way; its folder goes again."""
        self._run.cancel()
        self._button.text = self._text

    def _onClicked(self):
        if self.isRunning:
            self.stop()
            return
        folder = qt.QFileDialog.getExistingDirectory(self._button, self._title)
        if folder:
            self._attempt(lambda: self._begin(folder))

    def _begin(self, folder):
        run = self._untilPath(self._stepsInto(folder))
        self._onProgress(next(run))
        self._run.start(run)

    def _untilPath(self, steps):
        self._path = None
        self._path = yield from steps

    def _onProgress(self, fraction):
        self._button.text = _("Stop, {percent:.0f} %").format(percent=100 * fraction)

    def _finished(self, error):
        self._button.text = self._text
        self._attempt(lambda: self._end(error))

    def _end(self, error):
        if error is not None:
            raise error
        self._onDone(self._path)
