"""Threads of this process: work side by side, where NumPy and SciPy let go of the interpreter.

One until `use_threads` asks for more, as commands do. Results are the same whatever their number:
what is done ahead is done by the code that would do it later, alone.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from contextlib import suppress
from contextvars import copy_context
from functools import cache, partial
from queue import SimpleQueue
from threading import Event, Lock, Thread
from typing import TypeVar
from weakref import ref

from .validation import InputError

Item = TypeVar("Item")
Given = TypeVar("Given")

_WAIT = 0.2
"""Longest wait at a time, s: on Windows Ctrl-C is only seen between waits."""


def cores() -> int:
    """Number of cores that this process may use."""
    count = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return count or 1


def use_threads(count: int | None) -> None:
    """Use so many threads from now on, the calling one among them; None: one per core.

    `InputError` for less than one.
    """
    if count is not None and count < 1:
        raise InputError(f"threads: expected a whole number from 1, got {count}.")
    _pool.count = cores() if count is None else count


def threads() -> int:
    """Number of threads in use."""
    return _pool.count


def are_busy() -> bool:
    """Whether a thread still does what nobody waits for, as after a failure."""
    return bool(_pool.at_work)


def ahead(work: Callable[[], object]) -> Callable[[], None]:
    """Begin in another thread what will be asked for later, and is kept by who works it out.

    Returns a function that waits until that is done, if it was begun; call it before asking. A
    failure shows when the same fails again, with the sentence that it has there.
    """
    if _pool.count == 1:
        return lambda: None
    task = _Task(work)
    _pool.give(task)
    return task.settle


def side_by_side(work: Callable[[Item], Given], items: Iterable[Item]) -> list[Given]:
    """What work gives for each of some items, done in as many threads at once as are free.

    The last item that fails shows its failure, whatever the number of threads.
    """
    kept = [cache(partial(work, item)) for item in items]
    settled = [ahead(one) for one in kept]
    found = []
    # Threads begin with the first one; what none has begun is done here.
    for settle, one in zip(reversed(settled), reversed(kept), strict=True):
        settle()
        found.append(one())
    return found[::-1]


class _Task:
    """Work that a thread does unless it is asked for before."""

    def __init__(self, work: Callable[[], object]) -> None:
        # What NumPy is to say about overflows goes along.
        self._context, self._work = copy_context(), work
        self._free, self._is_done = Lock(), Event()

    def begin(self) -> None:
        """Do the work unless it has been asked for."""
        if not self._free.acquire(blocking=False):
            return
        try:
            with suppress(Exception):
                self._context.run(self._work)
        finally:
            self._end()

    def settle(self) -> None:
        """Wait until it is done; where no thread has begun it, none will."""
        if self._free.acquire(blocking=False):
            self._end()
        # Ends: who has begun sets it.
        while not self._is_done.wait(_WAIT):
            pass

    def _end(self) -> None:
        del self._work, self._context
        self._is_done.set()


class _Pool:
    """Threads that take tasks, the first one given first. They end with the process, whatever they
    do."""

    def __init__(self) -> None:
        self.count = 1
        self.at_work: set[_Task] = set()
        self._started = 1
        self._lock = Lock()
        # What nobody waits for any more is not done, nor kept.
        self._tasks: SimpleQueue[ref[_Task]] = SimpleQueue()

    def give(self, task: _Task) -> None:
        """Let a thread do a task as soon as one is free."""
        self._tasks.put(ref(task))
        with self._lock:
            for _ in range(self._started, self.count):
                Thread(target=self._serve, daemon=True).start()
            self._started = max(self._started, self.count)

    def _serve(self) -> None:
        # Ends with the process.
        while True:
            if (task := self._tasks.get()()) is not None:
                self.at_work.add(task)
                task.begin()
                self.at_work.discard(task)
            del task


_pool = _Pool()
