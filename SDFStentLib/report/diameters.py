"""Facts of diameters along a line, and of what a stent did to them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ..geometry import Line
from ..lumen import DiameterProfile
from ..treatment import TreatedStent
from ..units import MILLIMETERS
from ..validation import Floats, Points, coordinates
from .facts import COMPARED, GLANCE, LINES, Fact, Facts, width
from .words import UNKNOWN, millimeters

LUMEN = "Narrowest lumen"
"""The name of the lumen on a tile."""

ERROR = "diameters.over_stented_length.mean_after_minus_prescribed_mm"
"""Key of the sentence below the table of diameters."""


class MeasuredLine(NamedTuple):
    """A line along which diameters were measured."""

    title: str
    line: Line
    profile: DiameterProfile


def line_facts(line: MeasuredLine, units: str = "mm") -> Facts:
    """Facts on the diameters along a line, at every place; `units` are those of the file."""
    profile, points = line.profile, line.line.points
    ends = " to ".join(filed_point(points[end], units) for end in (0, -1))
    words = f"{line.title}: {line.line.length:.1f} mm, from {ends} {units}"
    lowest = (
        f"inscribed: narrowest {profile.minimum:.2f} mm at {profile.minimum_arc_length:.1f} mm, "
        f"mean {profile.mean:.2f} mm, widest {profile.maximum:.2f} mm"
    )
    return Facts(
        (
            Fact("_head", words=words),
            Fact("title", after=line.title),
            Fact("start_mm", after=points[0]),
            Fact("end_mm", after=points[-1]),
            Fact("length_mm", after=line.line.length),
            Fact("arc_length_mm", "at", after=profile.arc_length, unit="mm"),
            Fact("inscribed_mm", "inscribed", after=profile.inscribed_diameter, unit="mm"),
            Fact("equivalent_mm", "equivalent", after=profile.equivalent_diameter, unit="mm"),
            Fact("minimum_mm", after=profile.minimum),
            Fact("mean_mm", after=profile.mean),
            Fact("maximum_mm", after=profile.maximum),
            Fact("_lowest", words=lowest if math.isfinite(profile.minimum) else ""),
        )
    )


def diameter_table(facts: Facts) -> str:
    """The table of `line_facts`: lines of text, a row per place."""
    columns = [one for one in facts if one.label]
    heads = [f"{one.label} ({one.unit})" for one in columns]
    digits = [1, *[2] * (len(columns) - 1)]
    rows = [facts.named("_head").words, f"  {'  '.join(heads)}"]
    for values in zip(*(one.after for one in columns), strict=True):
        cells = map(_cell, values, digits)
        aligned = (cell.rjust(len(head)) for cell, head in zip(cells, heads, strict=True))
        rows.append(f"  {'  '.join(aligned)}")
    lowest = facts.named("_lowest").words
    return "\n".join([*rows, *([f"  {lowest}"] if lowest else []), ""])


def filed_point(point: Points, units: str) -> str:
    """A point, mm, as a file in that unit has it."""
    return coordinates(point / MILLIMETERS[units])


def _cell(value: float, digits: int) -> str:
    return f"{value:.{digits}f}" if math.isfinite(value) else "-"


def prescribed_words(treated: TreatedStent) -> str:
    """The prescribed diameter, or the smallest and the largest one."""
    profile = treated.axis.profile
    if profile is None or profile.diameters.min() == profile.widest:
        return f"{round(treated.stent.diameter, 2):g} mm"
    return f"{profile.diameters.min():.2f} to {profile.widest:.2f} mm"


def lumen_facts(treated: TreatedStent) -> Iterator[Fact]:
    """Facts on the lumen before and after, along a stent and beyond its ends."""
    before, after, own = treated.before, treated.after, treated.before.arc_length
    narrow, over = "diameters.minimum_lumen", "diameters.over_stented_length"
    wanted = treated.prescribed(own)
    along = _along(treated, wanted)
    yield Fact("diameters.along", after=along)
    yield Fact("diameters.stent_ends_mm", after=own[[0, -1]])
    yield width(
        f"{narrow}.{{}}_mm",
        "Minimum lumen diameter",
        before.minimum,
        after.minimum,
        level=GLANCE,
        note=f", prescribed {prescribed_words(treated)}",
        column="lumen_{}_mm",
        short="narrowest",
        tile=LUMEN,
    )
    places = before.minimum_arc_length, after.minimum_arc_length
    yield Fact(f"{narrow}.{{}}_at_mm", "", *places)
    beyond = (_beyond(own, one) for one in (treated.around_before, treated.around_after))
    label = "Minimum lumen beyond the ends"
    yield width(f"{narrow}.beyond_{{}}_mm", label, *beyond, level=COMPARED)
    yield Fact(
        f"{over}.{{}}.mean_mm",
        "Mean lumen diameter \N{PLUS-MINUS SIGN} SD",
        before.mean,
        after.mean,
        "mm",
        _mean_sd(after),
        _mean_sd(before),
        LINES,
        column="mean_lumen_{}_mm",
    )
    yield Fact(f"{over}.{{}}.sd_mm", "", before.sd, after.sd)
    was, words = (_span([one.minimum, one.maximum]) for one in (before, after))
    ends = before.minimum, after.minimum
    yield Fact(f"{over}.{{}}.minimum_mm", "Smallest to largest", *ends, "mm", words, was)
    yield Fact(f"{over}.{{}}.maximum_mm", "", before.maximum, after.maximum)
    equivalent = (_mean(one.equivalent_diameter) for one in (before, after))
    yield width(f"{over}.{{}}.equivalent_mean_mm", "Mean equivalent diameter", *equivalent)
    error = _mean(after.inscribed_diameter - wanted)
    words = (
        f"Prescribed lumen diameter: {_span(along['prescribed_mm'])}. Mean after minus prescribed: "
        f"{millimeters(error, signed=True)}."
    )
    yield Fact(ERROR, after=error, words=words)


def _along(treated: TreatedStent, prescribed: Floats) -> dict[str, Floats]:
    """The curves of the plot: nothing is prescribed beyond the ends of the stent."""
    before, after, own = treated.around_before, treated.around_after, treated.before.arc_length
    return {
        "arc_length_mm": before.arc_length,
        "mis_before_mm": before.inscribed_diameter,
        "mis_after_mm": after.inscribed_diameter,
        "equivalent_before_mm": before.equivalent_diameter,
        "equivalent_after_mm": after.equivalent_diameter,
        "prescribed_mm": np.interp(before.arc_length, own, prescribed, left=np.nan, right=np.nan),
    }


def _beyond(own: Floats, around: DiameterProfile) -> float:
    """The narrowest of the measured vessel before and behind the stent; NaN where there is none."""
    is_beyond = (around.arc_length < own[0]) | (around.arc_length > own[-1])
    return around.taken(is_beyond).minimum


def _mean(values: Floats) -> float:
    known = values[np.isfinite(values)]
    return float(known.mean()) if len(known) else math.nan


def _mean_sd(profile: DiameterProfile) -> str:
    if not math.isfinite(profile.mean):
        return UNKNOWN
    return f"{profile.mean:.2f} \N{PLUS-MINUS SIGN} {profile.sd:.2f} mm"


def _span(values: Sequence[float] | Floats) -> str:
    known = [one for one in values if math.isfinite(one)]
    if not known:
        return UNKNOWN
    low, high = min(known), max(known)
    if round(low, 2) == round(high, 2):
        return f"{low:.2f} mm"
    return f"{low:.2f} to {high:.2f} mm"
