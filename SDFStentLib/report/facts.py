"""What is told of a result, worded once: for the shell, the report, its page and the panel."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..lumen import DiameterProfile
from ..treatment import PlacedStent, Residual, TreatedLesion, TreatedStent, residual_of
from ..vessel import Apposition, Ostium
from .flow import share_gained
from .words import UNKNOWN, degree_text, degree_word, number_text

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
    return Fact(CONTACT, free, "mm", words)


# Beside a stent while a hand moves it: a few short lines, to be read at arm's length.

PREVIEW, MEASURING = "preview", "measuring..."
CERTIFIED, NOT_CERTIFIED = "certified for meshing", "not certified"
"""What the last of the lines says."""

MOST_LINES = 6


def previewed_lines(placed: PlacedStent, lumen: float) -> list[str]:
    """Of a preview: the size, about the narrowest lumen in the stent, mm, and that it is one.

    Parameters
    ----------
    placed : PlacedStent
    lumen : float
        NaN where it is not known.
    """
    known = [f"narrowest about {lumen:.1f} mm"] if math.isfinite(lumen) else []
    return [_size(placed), *known, PREVIEW]


def measuring_lines(placed: PlacedStent) -> list[str]:
    """Of a stent that is in its place, and not measured yet."""
    return [_size(placed), MEASURING]


def measured_lines(
    treated: TreatedStent,
    stents: Sequence[TreatedStent],
    lesions: Sequence[TreatedLesion] | None,
    is_certified: bool,
    flow: Mapping[str, Any] | None = None,
) -> list[str]:
    """Of a stent after its deployment, at most `MOST_LINES`; the last says whether it is certified.

    Parameters
    ----------
    treated : TreatedStent
        The one that is told of,
    stents : sequence of TreatedStent
        and all of the treatment.
    lesions : sequence of TreatedLesion or None
        Of the vessel; None where none were looked for.
    is_certified : bool
        Whether the surface with all stents is.
    flow : mapping, optional
        `flow_section` before and after treatment.
    """
    lumens = (treated.before.minimum, treated.after.minimum)
    told = [
        _size(treated),
        f"narrowest {' -> '.join(number_text(one, 1) for one in lumens)} mm",
        _left(treated, stents, lesions or ()),
        _branches(treated),
        "" if flow is None else _flow(flow, treated.number),
        _contact(treated),
    ]
    told = [line for line in told if line][: MOST_LINES - 1]
    return [*told, CERTIFIED if is_certified else NOT_CERTIFIED]


def _size(placed: PlacedStent) -> str:
    return f"{placed.stent.diameter:.1f} x {placed.axis.deployed_length:.1f} mm"


def _left(
    treated: TreatedStent, stents: Sequence[TreatedStent], lesions: Sequence[TreatedLesion]
) -> str:
    """The worst lesion that the stent covers, and what is left in its vessel, wherever that is.

    Of one that covers none the lesion beside it.
    """
    covered = [one.before.percent_diameter for one in lesions if treated.number in one.stents]
    left = residual_of(lesions, stents)
    if not lesions:
        return ""
    if not covered or left is None:
        points = np.array([one.after.point for one in lesions])
        beside = lesions[int(treated.axis.line.nearest(points).distances.argmin())]
        degree = degree_word(beside.after.percent_diameter)
        return f"no lesion covered; lesion {beside.number}: {degree} left"
    return f"stenosis {degree_word(max(covered))} -> {degree_word(left.percent)}"


def _branches(treated: TreatedStent) -> str:
    """How many branches it changes."""
    covered = sum(not branch.is_free for branch in treated.branches)
    names = {branch.name for branch in treated.branches}
    narrowed = sum(one.is_narrowed for one in treated.neighbors if one.name in names)
    said = [f"{covered} covered" if covered else "", f"{narrowed} narrowed" if narrowed else ""]
    words = ", ".join(filter(None, said))
    return words and f"branches: {words}"


def _flow(flow: Mapping[str, Any], number: int) -> str:
    """At the mean flow: the side that gains most, and the drop over the stent."""
    before, after = flow["before"]["mean"], flow["after"]["mean"]
    drops = [
        one["recovered_mmhg"]["value"]
        for state in (before, after)
        for one in state["narrowings"]
        if one["name"] == f"stent {number}"
    ]
    drop = f"drop {' -> '.join(number_text(one, 1) for one in drops)} mmHg" if drops else ""
    return ", ".join(filter(None, [share_gained(before, after), drop]))


def _contact(treated: TreatedStent) -> str:
    found = treated.apposition
    if found is None or not found.free_length > 0:
        return ""
    return f"off the wall over {found.free_length:.0f} of {found.length:.0f} mm"
