"""Executors of `concurrent.futures` that carry out cases, opened anew when they break.

Processes on this machine are spawned, never forked, with one thread of linear algebra each. They
end when the sweep does, however it ends: each holds the reading end of a pipe whose writing end
only the sweep has.
"""

from __future__ import annotations

import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ProcessPoolExecutor, wait
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass

from ..threads import cores
from ..validation import InputError
from .watch import Watch, WorkerContext, one_thread, start_worker
from .worker import Outcome, Task, run_case

MOST_WORKERS = 61 if os.name == "nt" else 1000
"""Most workers: Windows cannot wait for more processes; elsewhere more would be a typing error."""

SCHEDULER_SECONDS = 30.0
"""Time to wait for a scheduler, s."""

LOOK = 0.5
"""Interval, s, after which progress is reported."""

END_SECONDS = 5.0
"""Time, s, in which workers that are asked to end should do so; then they are killed."""

DASK_WINDOW = 1000
"""Number of cases handed to a cluster at a time: enough to make it grow."""


@dataclass(frozen=True)
class Workplace:
    """A way to open an executor, and how to use it.

    Attributes
    ----------
    opened : callable
        Function that opens the executor for the time of a block.
    window : int
        Number of cases handed over at a time.
    is_renewable : bool
        Whether another executor can be opened when this one breaks.
    blames : bool
        Whether the executor itself finds the case that kills its workers.
    takes_back : bool
        Whether the executor itself takes back waiting cases when it is closed.
    lacks_workers : callable
        Function of the executor: whether cases wait for workers that are not there (yet).
    watch : Watch, optional
        The watch that enforces the time limit of a case.
    """

    opened: Callable[[], AbstractContextManager[Executor]]
    window: int
    is_renewable: bool
    blames: bool = True
    takes_back: bool = False
    lacks_workers: Callable[[Executor], bool] = lambda _: False
    watch: Watch | None = None


def workplace(
    workers: int | None, executor: Executor | str | None, limit: float | None
) -> Workplace:
    """The workplace of a sweep: processes on this machine by default.

    Raises
    ------
    InputError
        Workers as well as an executor, or a time limit, s, with workers that cannot be ended.
    """
    if executor is None:
        return processes(workers, limit)
    if workers is not None:
        raise InputError("executor: expected workers or an executor, got both; leave one out.")
    if limit is not None:
        raise InputError(
            "time_limit: expected worker processes on this machine with it, whose cases can be "
            "ended, got another executor; leave it out."
        )
    return dask(executor) if isinstance(executor, str) else given(executor)


def processes(workers: int | None = None, time_limit: float | None = None) -> Workplace:
    """Worker processes on this machine, as many as it has cores by default.

    With a time limit, s, a worker that takes longer for a case is ended.
    """
    count, watch = worker_count(workers), None if time_limit is None else Watch(time_limit)
    return Workplace(
        lambda: _pool(count, watch),
        2 * count,
        is_renewable=True,
        blames=False,
        takes_back=True,
        watch=watch,
    )


def worker_count(workers: int | None = None) -> int:
    """The number of workers: as asked for, else the cores of this process;
    `InputError` if invalid."""
    count = min(cores(), MOST_WORKERS) if workers is None else workers
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
    """A caller's own executor, which the caller also ends."""
    if not hasattr(executor, "submit"):
        raise InputError(f"executor: expected one of concurrent.futures, got {executor!r}.")
    return Workplace(lambda: nullcontext(executor), DASK_WINDOW, is_renewable=False)


@contextmanager
def signals_held() -> Iterator[None]:
    """Hold interruptions back: processes that start in the block start without them.

    A process inherits the blocked signals of its parent; if it were interrupted during its imports,
    it would print a traceback.
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


def finished(
    executor: Executor,
    queue: deque[Task],
    window: int,
    at_work: dict[Future[Outcome], Task],
    tick: Callable[[], None],
) -> Iterator[tuple[Task, Outcome | None]]:
    """Tasks with their outcomes, as they come; None for a task that no worker survived.

    `at_work` holds the tasks that the executor has.
    """
    # Ends: every turn hands over or takes back a task, or waits for one that is at work.
    while queue or at_work:
        with signals_held():
            # Ends: at the window.
            while queue and len(at_work) < window:
                future = executor.submit(run_case, queue[0])
                at_work[future] = queue.popleft()
        done, _ = wait(at_work, timeout=LOOK, return_when=FIRST_COMPLETED)
        for future in done:
            # Dask's word for a case that killed its workers; Dask may not be installed.
            is_deadly = type(future.exception()).__name__ == "KilledWorker"
            outcome = None if is_deadly else future.result()
            yield at_work.pop(future), outcome
        tick()  # afterward: it asks the scheduler, and would wait for a lost one


@contextmanager
def _pool(workers: int, watch: Watch | None = None) -> Iterator[Executor]:
    context = WorkerContext()
    reading, writing = context.Pipe(duplex=False)
    reports, begun = context.Pipe(duplex=False)
    if watch is not None:
        watch.begin(reports, context.made)
    with one_thread():
        pool = ProcessPoolExecutor(
            workers,
            mp_context=context,
            initializer=start_worker,
            initargs=(reading, None if watch is None else begun),
        )
        try:
            yield pool
            pool.shutdown(wait=False)
            context.end(END_SECONDS)
        finally:
            # After an interruption nobody waits for cases that have begun: workers end now.
            writing.close()
            context.end(END_SECONDS)
            pool.shutdown(cancel_futures=True)
            for end in (reading, reports, begun):
                end.close()


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
    """Whether a scheduler has no worker; the futures report one that does not answer."""
    try:
        return not executor._client.nthreads()  # type: ignore[attr-defined]
    except (OSError, TimeoutError):
        return False


def _is_main_thread() -> bool:
    return threading.current_thread() is threading.main_thread()
