"""Facts on the views from which a stretch of vessel is seen."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ...geometry import Line
from ...treatment import PlacedStent, TreatedLesion
from ...units import Frame
from ...validation import Floats, InputError
from ...vessel import Lesion
from ...view import (
    ArmLimits,
    SeenStenosis,
    SeenView,
    WorkingViews,
)
from ..facts import LINES, Fact, Facts
from ..words import RESEARCH_USE, UNKNOWN, degree_word, millimeters, number_text

SCHEMA = "sdfstent-views"
BEST, SECOND, WORST, TYPED = "Best view", "Second view", "Worst view", "View"


@dataclass(frozen=True, eq=False)
class Stretch:
    """A stretch to look at: a lesion, a stent, or a part of a vessel."""

    title: str
    line: Line
    """Axis of the stretch, mm."""
    radii: Floats
    """(k,) of the lumen at its points, mm."""
    length: float
    """mm"""
    lesion: Lesion | None = None
    """Lesion before treatment, where it is one,"""
    after: Lesion | None = None
    """and after it."""


class ToldViews(NamedTuple):
    """The views of a stretch, and the facts of each."""

    stretch: Stretch
    frame: Frame
    limits: ArmLimits
    found: WorkingViews
    typed: tuple[SeenView, ...]
    """Views that the user asks about."""
    facts: tuple[Facts, ...]
    """Facts on the best view, the second, the worst, and on those."""

    @property
    def sentences(self) -> list[str]:
        """A sentence for each view, and that no second one is there."""
        told = [sentence for one in self.facts for sentence in one.sentences]
        if self.found.second is None:
            told.insert(1, "The arm reaches no second view that is far enough from the best one.")
        return told


def lesion_stretch(number: int, lesion: Lesion, after: Lesion | None = None) -> Stretch:
    """A lesion from its start to its end, and the same after treatment."""
    title, radii = f"Lesion {number}", lesion.diameters / 2
    return Stretch(title, lesion.line, radii, lesion.length, lesion, after)


def stent_stretch(stent: PlacedStent, lesions: Sequence[TreatedLesion] | None) -> Stretch:
    """A stent, with the first of the lesions that it covers."""
    line, half = stent.axis.line, stent.stent.diameter / 2
    title, radii = f"Stent {stent.number}", np.full(len(line), half)
    for treated in lesions or ():
        if stent.number in treated.stents:
            return Stretch(title, line, radii, line.length, treated.before, treated.after)
    return Stretch(title, line, radii, line.length)


def known_frame(frame: Frame | None) -> Frame:
    """The frame itself; `InputError` where none is known."""
    if frame is None:
        raise InputError(
            "expected a surface whose frame is known, RAS or LPS, got one that does not say it; "
            "angles of a C-arm are told from the patient's left, front and head: name the frame",
            remedy="frame",
            otherwise=" in the file, as Slicer does, or in the plan",
            end=".",
        )
    return frame


def view_facts(
    role: str,
    seen: SeenView,
    length: float,
    over: Sequence[str],
    stenoses: Sequence[Stenosis],
) -> Iterator[Fact]:
    """Facts on a view of a stretch of that length, mm, under branches of these names."""
    projected = length * (1 - seen.foreshortening)
    yield Fact("role", "View", after=role.lower(), words=role.removesuffix(" view"))
    yield Fact("words", "Angles", after=seen.view.words, words=seen.view.words)
    yield Fact("lao_deg", after=seen.view.primary)
    yield Fact("cra_deg", after=seen.view.secondary)
    for key, label, share in (
        ("foreshortening_percent", "Foreshortened", seen.foreshortening),
        ("covered_percent", "Under other vessels", seen.covered),
        ("ostia_covered_percent", "Ostia beside it covered", seen.ostia_covered),
    ):
        yield Fact(key, label, after=100 * share, unit="%", words=f"{100 * share:.0f} %")
    yield Fact("covered_by", after=over)
    words = f"{number_text(projected, 1)} of {millimeters(length, 1)}"
    yield Fact("projected_length_mm", "Length in the picture", after=projected, words=words)
    yield from (fact for one in stenoses for fact in one.facts())
    lost = f"foreshortened {100 * seen.foreshortening:.0f} %"
    words = f"{seen.view.words}: {lost}, {_covered_words(seen, over)}"
    yield Fact("_view", words=words)
    shown = ", ".join([f"{projected:.1f} of {length:.1f} mm long", *map(str, stenoses)])
    yield Fact("_shown", words=shown)
    yield Fact("_sentence", words=f"{role} {words}, {shown}.", level=LINES)


def _covered_words(seen: SeenView, names: Sequence[str]) -> str:
    """Words for the vessels over a stretch and over the ostia beside it."""
    over, ostia = round(100 * seen.covered), round(100 * seen.ostia_covered)
    told = f"{over} % under other vessels (most under {names[0]})" if over else "nothing over it"
    return f"{told}, {ostia} % of the ostia beside it covered" if ostia else told


class Stenosis(NamedTuple):
    """Stenosis of a lesion in the picture, and in truth."""

    state: str
    """before or after"""
    seen: SeenStenosis
    in_3d: float
    """Percent by the inscribed diameter."""

    def facts(self) -> Iterator[Fact]:
        """Facts on the stenosis in the picture and in 3D."""
        percent, key = self.seen.percent, f"stenosis.{self.state}"
        words = f"{degree_word(percent)} ({degree_word(self.in_3d)} in 3D)"
        label = f"Stenosis {self.state}"
        yield Fact(f"{key}.percent", label, after=percent, unit="%", words=words)
        yield Fact(f"{key}.in_3d_percent", after=self.in_3d)
        yield Fact(f"{key}.width_mm", after=self.seen.width)
        yield Fact(f"{key}.reference_mm", after=self.seen.reference)

    def __str__(self) -> str:
        treated = " after treatment" if self.state == "after" else ""
        if math.isnan(self.seen.percent):
            return f"stenosis in the picture{treated} {UNKNOWN}"
        in_3d = degree_word(self.in_3d)
        return f"stenosis{treated} {degree_word(self.seen.percent)} in the picture ({in_3d} in 3D)"


def limits_document(limits: ArmLimits) -> dict[str, Any]:
    """Limits of the arm's angles, for JSON."""
    return {
        "lao_rao_deg": limits.lao_rao,
        "cra_cau_deg": limits.cra_cau,
        "table": [list(row) for row in limits.table],
    }


def views_document(told: ToldViews, **files: Any) -> dict[str, Any]:
    """Document of the views: files by name, the views, and the map of all angles."""
    grid = told.found.map
    percent = {
        "foreshortening_percent": grid.foreshortening,
        "covered_percent": grid.covered,
        "ostia_covered_percent": grid.ostia_covered,
    }
    return {
        "schema": SCHEMA,
        "version": 1,
        "notice": RESEARCH_USE,
        **files,
        "frame": told.frame,
        "looked_at": told.stretch.title,
        "length_mm": told.stretch.length,
        "limits": limits_document(told.limits),
        "views": [one.as_dict() for one in told.facts],
        "map": {
            "lao_deg": grid.primary,
            "cra_deg": grid.secondary,
            **{key: np.round(100 * values, 1) for key, values in percent.items()},
            "is_reached": grid.is_reached,
        },
    }
