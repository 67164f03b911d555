"""What is told beside a stent while a hand moves it: a few short lines."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from ..treatment import PlacedStent, TreatedLesion, TreatedStent, residual_of
from .flow import share_gained
from .words import degree_text, number_text

PREVIEW, MEASURING, OLD = "preview", "measuring...", "changed since"
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
    """The worst lesion that the stent covers, and what is left in its vessel, wherever it is."""
    covered = [one.before.percent_diameter for one in lesions if treated.number in one.stents]
    left = residual_of(lesions, stents)
    if not covered or left is None:
        return ""
    return f"stenosis {degree_text(max(covered))} -> {degree_text(left.percent).partition(' (')[0]}"


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
    drop = f"drop {' -> '.join(f'{one:.1f}' for one in drops)} mmHg" if drops else ""
    return ", ".join(filter(None, [share_gained(before, after), drop]))


def _contact(treated: TreatedStent) -> str:
    found = treated.apposition
    if found is None or not found.free_length > 0:
        return ""
    return f"off the wall over {found.free_length:.0f} of {found.length:.0f} mm"
