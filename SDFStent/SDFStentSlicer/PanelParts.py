"""Parts of the panel that know nothing of stents: texts, folders, its size."""

import slicer
from slicer.i18n import tr as _

from . import Clock
from .Desktop import desktop
from .Portions import SteppedRun


def cut(text, longest):
    """A text, or the beginning of one with more characters than that."""
    return text if len(text) <= longest else text[: longest - 1] + "\N{HORIZONTAL ELLIPSIS}"


def tellOnce(ui):
    """Show the sentence on lesions, but not while the line below *Deploy* tells the same."""
    told = ui.statusLabel.text.splitlines()
    ui.lesionLabel.visible = any(line not in told for line in ui.lesionLabel.text.splitlines())


class RunButton:
    """Begins something long; while that runs the button says how far it is, and another click stops it.

    `begin()` returns an iterator over what `words(value)` says, which returns what was made, or None where there is nothing to do.
    `attempt(action)` does what is asked for and says why when it cannot be done; `onDone(made)` is called when it was.
    """

    def __init__(self, button, begin, words, attempt, onDone):
        self._button, self._words, self._text = button, words, button.text
        self._begin, self._attempt, self._onDone = begin, attempt, onDone
        self._made = None
        self._run = SteppedRun(self._onProgress, self._finished)
        button.connect("clicked()", self._onClicked)

    @property
    def isRunning(self):
        """Whether something is being made."""
        return self._run.isRunning

    def stop(self):
        """Stop the run; nothing of it is left."""
        self._run.cancel()
        self._button.text = self._text

    def _onClicked(self):
        if self.isRunning:
            self.stop()
        else:
            self._attempt(self._start)

    def _start(self):
        steps = self._begin()
        if steps is not None:
            run = self._untilMade(steps)
            self._onProgress(next(run))
            self._run.start(run)

    def _untilMade(self, steps):
        self._made = yield from steps

    def _onProgress(self, value):
        text = self._words(value)
        if self._button.text != text:
            self._button.text = text

    def _finished(self, error):
        self._button.text = self._text
        self._attempt(lambda: self._end(error))

    def _end(self, error):
        if error is not None:
            raise error
        made, self._made = self._made, None
        self._onDone(made)


class FolderButton(RunButton):
    """Asks for a folder and runs the iterator `stepsInto(folder)`, which yields fractions done and returns a path.

    By its first value the iterator needs the scene no more; `attempt` and `onDone` as of a `RunButton`.
    """

    def __init__(self, button, title, stepsInto, attempt, onDone):
        def begin():
            folder = desktop().folder(button, title)
            return stepsInto(folder) if folder else None

        super().__init__(button, begin, stopWords, attempt, onDone)


def stopWords(fraction):
    """Text of a button that stops what is done to a fraction."""
    return _("Stop, {percent:.0f} %").format(percent=100 * fraction)


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
        """Height of the window beyond what the panel needs, pixels; 0 in the page, which scrolls."""
        height = getattr(self._panel, "height", 0)
        return max(0, height - self._panel.layout().heightForWidth(self._panel.width))

    def fit(self):
        """Fit the panel after a change that may have made it higher or lower."""
        self._timer.start()

    def _fit(self):
        desktop().layOut()
        needed = self._panel.layout().heightForWidth(self._panel.width)
        self._panel.minimumHeight = max(0, needed)  # -1 where no text is shown
        width = self._panel.layout().minimumSize().width()
        self._panel.minimumWidth = max(self._panel.minimumWidth, width)
