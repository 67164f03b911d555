"""Parts of the panel that know nothing of stents: texts, folders, its size."""

import slicer
from slicer.i18n import tr as _

from . import Clock
from .Desktop import desktop
from .Portions import SteppedRun


def cut(text, longest):
    """A text, or the beginning of one with more characters than that."""
    return text if len(text) <= longest else text[: longest - 1] + "\N{HORIZONTAL ELLIPSIS}"


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
        folder = desktop().folder(self._button, self._title)
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


class PanelSize:
    """Gives the panel the height that it needs, as its least one, and never less width than it has needed.

    A folded section needs little width: without this one the views beside the panel would move when the widest section is folded.

    From the second visit of a module on, Slicer's module panel keeps the height that it was told first, and squeezes what does not fit
    (`qSlicerModulePanel::removeModule` leaves an item of the layout behind, which alone hears that sizes change). Least sizes it asks for anew.
    """

    def __init__(self, panel):
        self._panel = panel
        self._timer = Clock.timer(self._fit, 0)
        for section in slicer.util.findChildren(panel, className="ctkCollapsibleButton"):
            section.connect("contentsCollapsed(bool)", lambda _isCollapsed: self.fit())

    @property
    def room(self):
        """How much higher the window is than what the panel needs, pixels; 0 in the page, which scrolls."""
        height = getattr(self._panel, "height", 0)
        return max(0, height - self._panel.layout().heightForWidth(self._panel.width))

    def fit(self):
        """Something in the panel may be higher or lower now."""
        self._timer.start()

    def _fit(self):
        desktop().layOut()
        needed = self._panel.layout().heightForWidth(self._panel.width)
        self._panel.minimumHeight = max(0, needed)  # -1 where no text is shown
        width = self._panel.layout().minimumSize().width()
        self._panel.minimumWidth = max(self._panel.minimumWidth, width)
