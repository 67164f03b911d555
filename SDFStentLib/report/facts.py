"""What is told of a result, worded once: for the shell, the report, its page and the panel."""

from __future__ import annotations

from typing import NamedTuple

from ..vessel import Ostium
from .words import degree_text


class Fact(NamedTuple):
    """One quantity of a result."""

    label: str
    value: float | None
    """None or NaN where it is not known."""
    unit: str
    words: str
    """The value as a reader wants it, with its unit where it has one."""

    def __str__(self) -> str:
        return f"{self.label}: {self.words}"


def coverage_fact(branch: Ostium) -> Fact:
    """How much of a branch's ostium a stent covers."""
    label = branch.name[:1].upper() + branch.name[1:]
    return Fact(label, 100 * branch.covered_share, "%", branch.coverage)


def stenosis_fact(number: int, percent: float | None, kind: str = "diameter") -> Fact:
    """How much narrower than its reference a lesion is, by `diameter` or by `area`."""
    return Fact(f"Lesion {number}, {kind} stenosis", percent, "%", degree_text(percent))
