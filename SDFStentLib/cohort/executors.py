"""Where cases are carried out: executors of `concurrent.futures`, made anew when they break.

Processes on this machine are spawned, never forked, with one thread of linear algebra each. They
end when the sweep does, however that ends: each holds the reading end of a pipe whose other
end only the sweep has.
"""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass
from multiprocessing import get_context
from multiprocessing.connection import Connection

from ..validation import InputError
from .threads import one_thread, start_worker

MOST_WORKERS = 61 if os.name == "nt" else 1000
"""Windows waits for no more processes at a time; elsewhere more would be a slip."""

SCHEDULER_SECONDS = 30.0
"""How long a scheduler is waited for."""

DASK_WINDOW = 1000
"""Cases that are handed to a cluster at a time: enough for it to grow by."""


@dataclass(frozen=True)
class Workplace:
    """An executor that can be had, and how to use it.

    Attributes
    ----------
    opened : callable
        Gives the executor for the time of a block.
    window : int
        How many cases are handed over at a time.
    is_renewable : bool
        Whether another one can be opened when this one breaks.
    blames : bool
        Whether the executor itself finds the case that kills its workers.
    takes_back : bool
        Whether the executor itself takes back what waits when it is closed.
    lacks_workers : callable
        Of the executor: whether cases wait for workers that are not there (yet).
    """

    opened: Callable[[], AbstractContextManager[Executor]]
    window: int
    is_renewable: bool
    blames: bool = True
    takes_back: bool = False
    lacks_workers: Callable[[Executor], bool] = lambda _: False


def processes(workers: int | None = None) -> Workplace:
    """Worker processes on this machine, as many as it has cores by default."""
    count = worker_count(workers)
    return Workplace(
        lambda: _pool(count), 2 * count, is_renewable=True, blames=False, takes_back=True
    )


def worker_count(workers: int | None = None) -> int:
    """As many as asked for, or as this process may use cores; `InputError` for no such number."""
    count = cores() if workers is None else workers
    if isinstance(count, bool) or not isinstance(count, int) or not 0 < count <= MOST_WORKERS:
        raise InputError(
            f"workers: expected a whole number from 1 to {MOST_WORKERS}, got {count!r}."
        )
    return count


def dask(address: str) -> Workplace:
    """The workers of a Dask scheduler, such as `tcp://host:8786`.

    Raises
    ------
    InputError
        Dask is not installed.
    """
    try:
        import distributed  # noqa: F401
    except ImportError as error:
        raise InputError(
            "scheduler: expected the package distributed, it is not installed; install it: "
            "pip install 'sdfstent[cohort]'."
        ) from error
    return Workplace(
        lambda: _client(address), DASK_WINDOW, is_renewable=True, lacks_workers=_is_empty_cluster
    )


def given(executor: Executor) -> Workplace:
    """An executor of the caller's, who also ends it."""
    if not hasattr(executor, "submit"):
        raise InputError(f"executor: expected one of concurrent.futures, got {executor!r}.")
    return Workplace(lambda: nullcontext(executor), DASK_WINDOW, is_renewable=False)


def cores() -> int:
    """That this process may use, at most what a pool can have."""
    count = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return min(count or 1, MOST_WORKERS)


@contextmanager
def signals_held() -> Iterator[None]:
    """Let interruptions wait: what is started in the block starts without them.

    A process begins with the signals of its parent; one that is interrupted among its imports
    would print where.
    """
    if not hasattr(signal, "pthread_sigmask") or not _is_main_thread():
        yield
        return
    held = {signal.SIGINT, signal.SIGTERM}
    before = signal.pthread_sigmask(signal.SIG_BLOCK, held)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _pool(workers: int) -> Iterator[Executor]:
    context = get_context("spawn")
    reading, writing = context.Pipe(duplex=False)
    with one_thread():
        pool = ProcessPoolExecutor(
            workers, mp_context=context, initializer=start_worker, initargs=(reading,)
        )
        try:
            yield pool
            pool.shutdown()
        finally:
            # After an interruption nobody waits for cases that have begun: workers end now.
            _close(writing)
            pool.shutdown(cancel_futures=True)
            _close(reading)


@contextmanager
def _client(address: str) -> Iterator[Executor]:
    from distributed import Client

    try:
        client = Client(address, timeout=SCHEDULER_SECONDS, set_as_default=False)
    except (OSError, ValueError) as error:
        raise InputError(
            f"scheduler: expected one at {address}, none answered in {SCHEDULER_SECONDS:g} s "
            f"({type(error).__name__}); start `dask scheduler`, or correct the address."
        ) from error
    try:
        yield client.get_executor()
    finally:
        client.close(timeout=5)


def _is_empty_cluster(executor: Executor) -> bool:
    """Whether a scheduler has no worker; one that does not answer is told of by its futures."""
    try:
        return not executor._client.nthreads()  # type: ignore[attr-defined]
    except (OSError, TimeoutError):
        return False


def _close(end: Connection) -> None:
    if not end.closed:
        end.close()


def _is_main_thread() -> bool:
    return threading.current_thread() is threading.main_thread()
