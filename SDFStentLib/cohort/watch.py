"""Life of a worker process: its begin, its time at a case, and its end in any event."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnContext, SpawnProcess
from time import monotonic
from typing import Any, NoReturn

ONE_THREAD = (
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS",
)
"""Environment variables that linear algebra libraries read once, when they are loaded."""


@contextmanager
def one_thread() -> Iterator[None]:
    """Give processes that start within the block one thread of linear algebra each."""
    before = {name: os.environ.get(name) for name in ONE_THREAD}
    os.environ.update(dict.fromkeys(ONE_THREAD, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


_begun: list[Connection] = []


def start_worker(sweep: Connection, begun: Connection | None = None) -> None:
    """Leave Ctrl-C to the sweep, and end when the other end of its pipe is closed.

    `begun` is the pipe by which the sweep learns which case is begun, if it has to know.
    """
    if begun is not None:
        _begun.append(begun)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT, signal.SIGTERM})
    threading.Thread(target=_end_with, args=(sweep,), daemon=True).start()


def begin(case: str) -> None:
    """Tell a sweep that listens that this process begins a case.

    Workers share the pipe without a lock, as a stopped worker would keep it: so few bytes are
    always written at once.
    """
    for pipe in _begun:
        with suppress(OSError):
            pipe.send_bytes(f"{os.getpid()} {case}".encode())


def _end_with(sweep: Connection) -> NoReturn:
    with suppress(EOFError, OSError):
        sweep.recv_bytes()
    os._exit(1)


START_SECONDS = 60.0
"""Time, s, in which a worker starts and begins a case even on a busy machine; a lower limit of a
case does not count before."""


class WorkerContext(SpawnContext):
    """Spawns processes and remembers them.

    Attributes
    ----------
    made : list of SpawnProcess
    """

    def __init__(self) -> None:
        super().__init__()
        self.made: list[SpawnProcess] = []

    def Process(self, *arguments: Any, **named: Any) -> SpawnProcess:  # type: ignore[override]
        """A new process, as of any context."""
        self.made.append(SpawnProcess(*arguments, **named))
        return self.made[-1]

    def end(self, seconds: float) -> None:
        """Kill the processes that have not ended by themselves after some seconds.

        A process that is stopped, or waits for a disk that does not answer, never ends by itself.
        """
        started = [process for process in self.made if process.pid is not None]
        last, alive = monotonic() + seconds, {process.sentinel for process in started}
        # Ends: every wait ends a process or is the last one.
        while alive and monotonic() < last:
            alive -= {*wait(alive, timeout=max(last - monotonic(), 0.0))}
        for process in started:
            if process.sentinel in alive:
                process.kill()


class Watch:
    """A time limit for each case of a pool.

    Parameters
    ----------
    seconds : float
        Time that a case may take from its beginning, s.
    """

    def __init__(self, seconds: float) -> None:
        self.seconds = seconds
        self.begin(None, ())

    def begin(self, begun: Connection | None, processes: Iterable[SpawnProcess]) -> None:
        """Watch another pool, whose workers report every case that they begin through `begun`."""
        self._begun, self._processes = begun, processes
        self._at_work: dict[str, tuple[int, float]] = {}
        self._last = monotonic()

    def finished(self, case: str) -> None:
        """Note that no worker is at this case any more."""
        self._at_work.pop(case, None)
        self._last = monotonic()

    def overdue(self) -> list[str]:
        """End the workers whose cases have taken too long; return these cases.

        If no worker is at a case and none begins one, all of them are ended, as one keeps the
        others from beginning.
        """
        now = monotonic()
        # Ends: workers say once of every case that they begin it.
        while self._begun is not None and self._begun.poll():
            worker, case = self._begun.recv_bytes().decode().split()
            self._at_work[case], self._last = (int(worker), now), now
        late = [case for case, (_, at) in self._at_work.items() if now - at > self.seconds]
        workers = {self._at_work[case][0] for case in late}
        is_stuck = not self._at_work and now - self._last > max(self.seconds, START_SECONDS)
        for process in self._processes:
            if is_stuck or process.pid in workers:
                process.kill()
        return late
