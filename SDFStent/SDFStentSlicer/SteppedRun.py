"""Long work in small portions on the application's own thread."""

import time

import qt


class SteppedRun:
    """Advances an iterator by a timer, for a limited time per tick, so that the application stays responsive.

    `onProgress(value)` gets the latest value once per tick; `onDone(error)` is called once: with None at the end, with the
    exception when one was raised. `cancel()` ends the run at once without calling `onDone`.
    """

    def __init__(self, iterator, onProgress, onDone, budget=0.025):
        self._iterator, self._onProgress, self._onDone, self._budget = (
            iterator,
            onProgress,
            onDone,
            budget,
        )
        self._startTime = time.perf_counter()
        self._timer = qt.QTimer()
        self._timer.setInterval(0)
        self._timer.connect("timeout()", self._tick)
        self._timer.start()

    @property
    def age(self):
        """Seconds since the start."""
        return time.perf_counter() - self._startTime

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
