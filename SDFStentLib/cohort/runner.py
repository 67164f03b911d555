"""Carrying out a sweep: hand over cases that are not whole, count outcomes, survive failures."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterable
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from dataclasses import replace
from functools import partial
from time import monotonic

from ..validation import DeploymentError, InputError
from .cases import Cases, SweepCase
from .estimate import Tally, save_tally
from .executors import LOOK, Workplace, finished, workplace
from .manifest import cohort_document, write_manifest
from .store import COHORT, WHOLE, Store, StoreError, as_json
from .value import Sweep
from .worker import Outcome, Task, task_of, write_failure

ROUNDS = 3
"""Number of executors in a row that break before any case is finished: it is not the cases then."""

BLAMED = 2
"""Number of workers that end with nothing but one case to do, before that case is blamed."""

TOO_LONG = "it took longer than the time limit of {:g} s; allow more, or look at its worker"

KILLED = "its worker ended without a word: killed, or out of memory"

SAVE = 2.0
"""Interval, s, after which progress is saved in the store."""

Progress = Callable[[Tally], None]


def run_sweep(
    sweep: Sweep,
    folder: str | os.PathLike[str],
    *,
    workers: int | None = None,
    executor: Executor | str | None = None,
    progress: Progress | None = None,
) -> Tally:
    """Carry out all cases of a sweep that the folder does not have yet, and write its manifest.

    Parameters
    ----------
    sweep : Sweep
    folder : path
        Folder, made if it is missing. Cases that are whole in it are skipped, failed ones are done
        again. Every worker has to see it, and the files of the patients, under the same path.
    workers : int, optional
        Processes on this machine; by default one per core.
    executor : concurrent.futures.Executor or str, optional
        Instead of `workers`: any executor, which the caller ends, or the address of a Dask
        scheduler.
    progress : callable, optional
        Function that is called with the counts, twice a second.

    Returns
    -------
    Tally

    Raises
    ------
    InputError
        Another sweep is running in the folder, it holds cases that are not in this one, or the
        scheduler does not answer.
    DeploymentError
        The store cannot be written, or the workers are lost for good. Whole cases are kept, and
        the next run goes on from there, as it does after `KeyboardInterrupt`.
    """
    place = workplace(workers, executor, sweep.time_limit)
    store, cases = Store(folder), list(Cases(sweep))
    with store.locked():
        _prepare(store, sweep, cases)
        run = _Run(store, place, progress, Tally(len(cases)))
        try:
            run.carry_out([task_of(sweep, case, store) for case in run.left(cases)])
        except BaseException:
            with suppress(StoreError):  # what went wrong first is what counts
                run.recount(cases)
                run.end()
            raise
        run.end()
        return run.tally


def _prepare(store: Store, sweep: Sweep, cases: list[SweepCase]) -> None:
    """Write the document of the cohort; a folder may grow, but no whole case may go."""
    document = cohort_document(sweep, cases, store.folder)
    if (store.folder / COHORT).exists():
        own = {case.id for case in cases}
        others = [row[0] for row in store.cohort()["cases"] if row[0] not in own]
        gone = sum(store.is_whole(case) for case in others)
        if gone:
            raise InputError(
                f"{store.folder}: expected a folder of this sweep, or of a part of it, got one "
                f"with {gone} other cases; name another folder."
            )
        for case in others:  # failed ones, such as those of a file that is mended now
            store.remove(case)
    store.clear_leftovers()
    store.write(COHORT, as_json(document))


class _Run:
    """A run of a sweep, with its counts."""

    def __init__(
        self, store: Store, place: Workplace, progress: Progress | None, tally: Tally
    ) -> None:
        self.store, self.place, self.progress, self.tally = store, place, progress, tally
        self._start, self._saved, self._shown, self._asked = monotonic(), -SAVE, -LOOK, -SAVE
        self._blamed: dict[str, int] = {}
        self._late: set[str] = set()
        self._is_under_way = False

    def left(self, cases: Iterable[SweepCase]) -> list[SweepCase]:
        """The cases that are not whole when the run begins, counting the others as found."""
        left = self._left(cases)
        self.tally = replace(self.tally, found=self.tally.finished)
        return left

    def _left(self, cases: Iterable[SweepCase]) -> list[SweepCase]:
        """The cases that are not whole; all others are counted."""
        left = []
        for case in cases:
            known = self.store.case(case.id)
            if known is None or known["status"] not in WHOLE:
                left.append(case)
                continue
            rows = known["rows"]
            certified = rows[0].get("certified") if rows else None
            certified = None if certified == "" else certified
            outcome = Outcome(case.id, known["status"], certified, known["reason"])
            self.tally = self.tally.counted(outcome)
        return left

    def carry_out(self, tasks: list[Task]) -> None:
        """Carry out all tasks, with as many executors as it takes."""
        waiting, suspects, idle = deque(tasks), deque[Task](), 0
        # Ends: every round finishes a case, blames one, or counts as idle.
        while waiting or suspects:
            before = self.tally.finished, sum(self._blamed.values())
            alone = bool(suspects)
            queue = suspects if alone else waiting
            lost = self._round(queue, 1 if alone else self.place.window)
            if lost is None:
                continue
            error, unfinished = lost[0], self._not_whole(lost[1])
            if not self.place.is_renewable:
                raise _gave_up(error) from error
            if self._late:
                queue.extendleft(reversed(self._after_time_is_up(unfinished)))
            elif isinstance(error, BrokenProcessPool) and not self.place.blames:
                unfinished = self._after_a_death(unfinished, alone)
                suspects.extendleft(reversed(unfinished))
            else:
                queue.extendleft(reversed(unfinished))
            idle = 0 if before != (self.tally.finished, sum(self._blamed.values())) else idle + 1
            if idle >= ROUNDS:
                raise _gave_up(error) from error

    def recount(self, cases: Iterable[SweepCase]) -> None:
        """Count the cases in the store: some may have got there unnoticed."""
        self.tally = Tally(self.tally.total, failed=self.tally.failed, found=self.tally.found)
        self._left(cases)

    def end(self) -> None:
        """Leave a folder that shows how far the sweep got, however it ended."""
        self.tally = replace(self.tally, lacks_workers=False)
        self.report(is_last=True)
        self.store.clear_leftovers()
        write_manifest(self.store.folder)

    def report(self, *, is_last: bool = False) -> None:
        """Report and save the counts when due."""
        now = monotonic()
        self.tally = replace(self.tally, seconds=now - self._start)
        if self.progress is not None and (is_last or now - self._shown >= LOOK):
            self._shown = now
            self.progress(self.tally)
        if is_last or now - self._saved >= SAVE:
            self._saved = now
            with suppress(StoreError):  # the cases report that a store cannot be written
                save_tally(self.store, self.tally)

    def _looked(self, executor: Executor) -> None:
        """Report the counts and whether there are workers; end workers that take too long."""
        if self.place.watch is not None:
            self._late.update(self.place.watch.overdue())
        if monotonic() - self._asked >= SAVE:
            self._asked = monotonic()
            lacks_workers = self.place.lacks_workers(executor)
            self.tally = replace(self.tally, lacks_workers=lacks_workers)
        self.report()

    def _round(self, queue: deque[Task], window: int) -> tuple[Exception, list[Task]] | None:
        """Work off a queue with one executor; return the error that broke it and its open tasks."""
        at_work: dict[Future[Outcome], Task] = {}
        self._late.clear()
        try:
            with self.place.opened() as executor:
                try:
                    tick = partial(self._looked, executor)
                    for task, outcome in finished(executor, queue, window, at_work, tick):
                        if self.place.watch is not None:
                            self.place.watch.finished(task.case.id)
                        if outcome is None:
                            self._fail(task)
                        else:
                            self.tally = self.tally.counted(outcome)
                except BaseException:
                    # A pool of processes that breaks gives up at a future that others canceled.
                    if not self.place.takes_back:
                        for future in at_work:
                            future.cancel()
                    raise
        except StoreError:
            raise
        except (BrokenExecutor, CancelledError, OSError, TimeoutError) as error:
            return error, list(at_work.values())
        except InputError as error:  # of a scheduler that does not answer any more
            if not self._is_under_way:
                raise
            return error, list(at_work.values())
        finally:
            self._is_under_way = True
        return None

    def _after_a_death(self, unfinished: list[Task], alone: bool) -> list[Task]:
        """Tasks to repeat after a worker ended: one by one, to find the case that ended it."""
        if not alone:
            return unfinished
        left = []
        for task in unfinished:
            times = self._blamed[task.case.id] = self._blamed.get(task.case.id, 0) + 1
            if times < BLAMED:
                left.append(task)
            else:
                self._fail(task)
        return left

    def _after_time_is_up(self, unfinished: list[Task]) -> list[Task]:
        """Tasks left after workers were ended for cases that took too long."""
        assert self.place.watch is not None
        late, self._late = self._late, set()
        for task in unfinished:
            if task.case.id in late:
                self._fail(task, TOO_LONG.format(self.place.watch.seconds))
        return [task for task in unfinished if task.case.id not in late]

    def _fail(self, task: Task, reason: str = KILLED) -> None:
        self.tally = self.tally.counted(write_failure(self.store, task, reason))

    def _not_whole(self, tasks: Iterable[Task]) -> list[Task]:
        """The tasks whose cases did not reach the store; all others are counted."""
        found = {case.id for case in self._left(task.case for task in tasks)}
        return [task for task in tasks if task.case.id in found]


def _gave_up(error: Exception) -> DeploymentError:
    words = f"the workers were lost ({str(error) or type(error).__name__})"
    if isinstance(error, InputError):
        words = "the scheduler does not answer any more"
    return DeploymentError(f"{words}; what is whole is kept, run the sweep again to go on.")
