"""How long a sweep will take and how much disk, from a few of its cases carried out here."""

from __future__ import annotations

import tempfile
from pathlib import Path
from time import perf_counter
from typing import NamedTuple

from .cases import Cases
from .store import Store
from .value import Sweep
from .worker import Task, run_case, task_of

TRIED = 3
"""Cases that are carried out: the first, one in the middle, the last."""


class Estimate(NamedTuple):
    """What some cases took; NaN-free, for at least one is tried."""

    tried: int
    failed: int
    case_seconds: float
    """Of one case, once the patient is read."""
    read_seconds: float
    """Of a patient."""
    case_bytes: float
    """That one case takes on the disk, in whole blocks."""

    def seconds(self, cases: int, patients: int, workers: int) -> float:
        """Of a sweep: every worker reads every patient at worst."""
        return cases * self.case_seconds / workers + patients * self.read_seconds


def estimated(sweep: Sweep, cases: Cases) -> Estimate:
    """Carry out a few cases in a temporary folder, and forget them."""
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
