"""Long work in small portions on the application's own thread."""

import time

from . import Clock


class SteppedRun:
    """Advances an iterator by a timer, for a limited time per tick, so that the application stays responsive.

    `onProgress(value)` gets the latest value once per tick; `onDone(error)` is called once per run: with None at the end, with
    the exception when one was raised. `cancel()` ends a run at once without calling `onDone`.

    One object serves one run after another, as a `Clock` timer does.
    """

    def __init__(self, onProgress, onDone):
        self._onProgress, self._onDone, self._budget = onProgress, onDone, 2 * Clock.wait()
        self._iterator = None
        self._timer = Clock.timer(self._tick, 0, isRepeated=True)

    def start(self, iterator):
        """Begin a run; another one must not be under way."""
        self._iterator = iterator
        self._timer.start()

    @property
    def isRunning(self):
        """Whether a run is under way."""
        return self._iterator is not None

    def cancel(self):
        """Stop; the iterator's `finally` blocks run now."""
        self._timer.stop()
        iterator, self._iterator = self._iterator, None
        if iterator is not None:
            iterator.close()

    def _tick(self):
        if self._iterator is None:
            return
        end, value = time.perf_counter() + self._budget, None
        try:
            # Ends: with the time, or with the iterator, whose values are never None.
            while value is None or time.perf_counter() < end:
                value = next(self._iterator)
        except StopIteration:
            self._finish(None)
        except Exception as error:
            # Every exception has to stop the timer, or it would fire for ever; the panel shows it.
            self._finish(error)
        else:
            self._onProgress(value)

    def _finish(self, error):
        self._timer.stop()
        self._iterator = None
        self._onDone(error)
