"""Many deployments of one plan: a sweep document, its cases, a store that is whole at any time.

What is named here is imported when it is first asked for: workers set their threads before NumPy.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..late import late_names

if TYPE_CHECKING:
    from .cases import Case, cases_of
    from .document import load_sweep, sweep_from_document
    from .estimate import Estimate, estimated
    from .executors import worker_count
    from .manifest import write_manifest
    from .reader import Cohort
    from .runner import run_sweep
    from .tally import Tally, duration_in_words, last_tally
    from .value import Patient, Sweep

__all__ = [
    "Case",
    "Cohort",
    "Estimate",
    "Patient",
    "Sweep",
    "Tally",
    "cases_of",
    "duration_in_words",
    "estimated",
    "last_tally",
    "load_sweep",
    "run_sweep",
    "sweep_from_document",
    "worker_count",
    "write_manifest",
]

__getattr__, __dir__ = late_names(
    __name__,
    {
        "cases": ["Case", "cases_of"],
        "document": ["load_sweep", "sweep_from_document"],
        "estimate": ["Estimate", "estimated"],
        "manifest": ["write_manifest"],
        "reader": ["Cohort"],
        "runner": ["run_sweep"],
        "executors": ["worker_count"],
        "tally": ["Tally", "duration_in_words", "last_tally"],
        "value": ["Patient", "Sweep"],
    },
)
