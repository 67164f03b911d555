"""Time and disk space that a sweep will take, estimated from a few cases, and its progress."""

from __future__ import annotations

import os
import tempfile
from contextlib import suppress
from dataclasses import asdict, astuple, dataclass, replace
from pathlib import Path
from time import perf_counter
from typing import NamedTuple

from ..certificate import CERTIFIED, NOT_CERTIFIED, NOT_READY, said_of
from ..validation import InputError
from .cases import Cases
from .store import PROGRESS, Store, as_json
from .value import Sweep
from .worker import Outcome, Task, run_case, task_of

TRIED = 3
"""Number of cases that are tried: the first, one in the middle, the last."""


class Estimate(NamedTuple):
    """Time and space that some cases took; never NaN, as at least one is tried."""

    tried: int
    failed: int
    case_seconds: float
    """Time of one case, s, once the patient is read."""
    read_seconds: float
    """Time to read a patient, s."""
    case_bytes: float
    """Space of one case on the disk, in whole blocks."""

    def seconds(self, cases: int, patients: int, workers: int) -> float:
        """Time of a sweep, s, if every worker has to read every patient."""
        return cases * self.case_seconds / workers + patients * self.read_seconds


def estimated(sweep: Sweep, cases: Cases) -> Estimate:
    """Estimate from a few cases, run in a temporary folder."""
    chosen = [cases[at] for at in sorted({0, len(cases) // 2, len(cases) - 1})][:TRIED]
    seconds, sizes, failed, read = [], [], 0, 0.0
    with tempfile.TemporaryDirectory(prefix="sdfstent-") as folder:
        store = Store(folder)
        for case in chosen:
            task = task_of(sweep, case, store)
            first = _seconds(task)
            again = _seconds(task)  # the patient is known now
            read = max(read, first - again)
            seconds.append(again)
            failed += (store.case(case.id) or {})["status"] == "failed"
            sizes.append(sum(_on_disk(path) for path in store.path(case.id).iterdir()))
    return Estimate(len(chosen), failed, sum(seconds) / len(seconds), read, sum(sizes) / len(sizes))


def _seconds(task: Task) -> float:
    start = perf_counter()
    run_case(task)
    return perf_counter() - start


def _on_disk(path: Path) -> int:
    status = path.stat()
    return int(getattr(status, "st_blocks", 0)) * 512 or status.st_size


_VERDICTS = {True: "certified", False: "uncertified", None: "unjudged"}


@dataclass(frozen=True)
class Tally:
    """Counts of a sweep, and the seconds that this run has taken so far.

    Attributes
    ----------
    total : int
        Cases of the sweep.
    certified, unready, uncertified, unjudged, excluded, failed : int
        Finished cases by outcome. Unready cases are no worse than a surface that was never ready
        for a mesher; unjudged ones have a plan that asks for no certificate.
    found : int
        Number of finished cases that were whole when this run began.
    seconds : float
    lacks_workers : bool
        Whether the sweep waits for a cluster that has no worker (yet).
    """

    total: int
    certified: int = 0
    unready: int = 0
    uncertified: int = 0
    unjudged: int = 0
    excluded: int = 0
    failed: int = 0
    found: int = 0
    seconds: float = 0.0
    lacks_workers: bool = False

    @property
    def finished(self) -> int:
        """Number of cases that have an outcome."""
        done = self.certified + self.unready + self.uncertified + self.unjudged
        return done + self.excluded + self.failed

    @property
    def fraction(self) -> float:
        """Share of the cases that are finished."""
        return self.finished / self.total if self.total else 1.0

    @property
    def rate(self) -> float:
        """Cases per second in this run; 0 before the first one."""
        return (self.finished - self.found) / self.seconds if self.seconds > 0 else 0.0

    @property
    def seconds_left(self) -> float | None:
        """Time left at this rate, s; None before the first case."""
        return (self.total - self.finished) / self.rate if self.rate > 0 else None

    def counted(self, outcome: Outcome) -> Tally:
        """The tally with one more case."""
        name = outcome.status
        if name == "done":
            name = _VERDICTS[outcome.certified]
        if name == "uncertified" and outcome.reason.startswith(said_of(NOT_READY)):
            name = "unready"
        return replace(self, **{name: getattr(self, name) + 1})

    @property
    def verdicts(self) -> list[str]:
        """Counts of cases by the word of their certificate; the first is listed even if it is 0."""
        others = (self.unready, NOT_READY), (self.uncertified, NOT_CERTIFIED)
        known = [f"{count} {word}" for count, word in others if count]
        return [f"{self.certified} {CERTIFIED}", *known]

    def note(self) -> str:
        """The text behind the progress bar."""
        certified, *others = self.verdicts
        parts = [certified, f"{self.failed} failed", *others]
        if self.unjudged:
            parts.append(f"{self.unjudged} not judged")
        if self.excluded:
            parts.append(f"{self.excluded} excluded")
        if self.lacks_workers:
            parts.append("the cluster has no workers: waiting for them")
        elif self.rate > 0 and self.seconds_left is not None:
            parts += [f"{self.rate:.3g}/s", f"{duration_in_words(self.seconds_left)} left"]
        return ", ".join(parts)


def save_tally(store: Store, tally: Tally) -> None:
    """Keep the counts beside the cases, for `last_tally`."""
    store.write(PROGRESS, as_json(asdict(tally)))


def last_tally(folder: str | os.PathLike[str]) -> tuple[Tally, bool]:
    """Last tally of the sweep in a folder, and whether the sweep is running."""
    store = Store(folder)
    total = len(store.cohort()["cases"])
    tally = Tally(total)  # killed before its first case
    with suppress(InputError, TypeError):
        known = Tally(**store.read(PROGRESS))
        if all(isinstance(value, int | float) for value in astuple(known)):
            tally = known
    return tally, store.is_running()


def duration_in_words(seconds: float) -> str:
    """A rough duration in words."""
    if seconds < 90:
        return f"{seconds:.0f} s"
    if seconds < 5400:
        return f"{seconds / 60:.0f} min"
    return f"{seconds / 3600:.1f} h" if seconds < 172_800 else f"{seconds / 86_400:.1f} days"
