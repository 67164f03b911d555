"""What is told of a result, worded once: for the shell, the report, its page and the panel."""

from __future__ import annotations

import math
from typing import NamedTuple

from ..lumen import DiameterProfile
from ..treatment import Residual
from ..vessel import Apposition, Ostium
from .words import UNKNOWN, degree_text, number_text

MINIMUM, BEYOND = "Minimum lumen diameter", "Minimum lumen beyond the ends"
"""Of a stent."""

LEFT = "Left in the treated vessel"
LINE_LOST = "the wall was moved past the line along which it is measured"
CONTACT = "Contact with the wall"
ALL_ROUND = "all round"

RATIOS = {
    "stent_to_adjacent": "where that is narrowest",
    "stent_to_proximal": "at the proximal end",
    "stent_to_distal": "at the distal end",
}
"""Where the healthy vessel is to which a report has the ratio of a stent, by its key."""

TO_HEALTHY = "Stent : healthy vessel"


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


def lumen_fact(before: DiameterProfile, after: DiameterProfile) -> Fact:
    """The narrowest place of a stent, before and after treatment."""
    change = " -> ".join(number_text(profile.minimum, 2) for profile in (before, after))
    return Fact(MINIMUM, after.minimum, "mm", f"{change} mm")


def coverage_fact(branch: Ostium) -> Fact:
    """How much of a branch's ostium a stent covers."""
    label = branch.name[:1].upper() + branch.name[1:]
    return Fact(label, 100 * branch.covered_share, "%", branch.coverage)


def stenosis_fact(number: int, percent: float | None, kind: str = "diameter") -> Fact:
    """How much narrower than its reference a lesion is, by `diameter` or by `area`."""
    return Fact(f"Lesion {number}, {kind} stenosis", percent, "%", degree_text(percent))


def residual_fact(residual: Residual) -> Fact:
    """What is narrowest in the treated vessels, and where."""
    sizes = f"{residual.minimum:.2f} of {residual.reference:.2f} mm"
    words = f"{degree_text(residual.percent, sizes)}, {residual.place()}"
    if math.isnan(residual.percent):
        words = f"{UNKNOWN}, as in lesion {residual.lesion}, {residual.place()}: {LINE_LOST}"
    return Fact(LEFT, residual.percent, "%", words)


def contact_fact(found: Apposition) -> Fact:
    """Over which length a stent does not touch the wall all round."""
    free, words = found.free_length, ALL_ROUND
    if found.stretches:
        words = f"not {ALL_ROUND} over {free:.1f} of {found.length:.1f} mm"
    if found.is_loose:
        words = f"none over all of {found.length:.1f} mm"
    return Fact(CONTACT, free, "mm", words)
