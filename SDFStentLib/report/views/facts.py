"""What is told of the views from which a stretch of vessel is seen."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ...geometry import Line
from ...treatment import Vessel
from ...units import Frame
from ...validation import Floats, InputError
from ...vessel import Lesion
from ...view import (
    ArmLimits,
    ArmView,
    SeenStenosis,
    SeenView,
    Shown,
    WorkingViews,
    seen_stenosis,
    working_views,
)
from ..facts import LINES, Fact, Facts
from ..words import RESEARCH_USE, UNKNOWN, degree_word, millimeters

SCHEMA = "sdfstent-views"
BEST, SECOND, WORST, TYPED = "Best view", "Second view", "Worst view", "View"


@dataclass(frozen=True, eq=False)
class Stretch:
    """What is looked at: a lesion, a stent, or a part of a vessel."""

    title: str
    line: Line
    """Its axis, mm."""
    radii: Floats
    """(k,) of the lumen at its points, mm."""
    length: float
    """mm"""
    lesion: Lesion | None = None
    """As found before treatment, where it is one,"""
    after: Lesion | None = None
    """and the same after it."""


class ToldViews(NamedTuple):
    """The views of a stretch, and the facts of each."""

    stretch: Stretch
    frame: Frame
    limits: ArmLimits
    found: WorkingViews
    typed: tuple[SeenView, ...]
    """Those that the user asks about."""
    facts: tuple[Facts, ...]
    """Of the best view, the second, the worst, and of those."""

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


def known_frame(frame: Frame | None) -> Frame:
    """The frame itself; `InputError` where none is known."""
    if frame is None:
        raise InputError(
            "expected a surface whose frame is known, RAS or LPS, got one that does not say it; "
            "angles of a C-arm are told from the patient's left, front and head: name the frame",
            remedy="frame",
            otherwise=" in the file, as Slicer does",
            end=".",
        )
    return frame


def told_views(
    stretch: Stretch,
    vessel: Vessel,
    frame: Frame | None,
    limits: ArmLimits,
    apart: float,
    typed: Sequence[ArmView] = (),
) -> ToldViews:
    """The best views of a stretch, the worst, and any others.

    Raises
    ------
    InputError
        No frame is known, no centerline or none with radii, or an arm that reaches no view.
    """
    frame = known_frame(frame)
    if vessel.centerline is None:
        raise InputError(
            "expected a centerline, which tells what may lie in the way, got none; give one."
        )
    shown = Shown(vessel.centerline, stretch.line, stretch.radii, frame)
    found = working_views(shown, limits, apart)
    asked = tuple(shown.seen_from(view) for view in typed)
    roles = ((BEST, found.best), (SECOND, found.second), (WORST, found.worst))
    told = [(role, seen) for role, seen in roles if seen is not None]
    facts = tuple(
        Facts(_view_facts(role, seen, stretch, vessel, frame))
        for role, seen in [*told, *((TYPED, one) for one in asked)]
    )
    return ToldViews(stretch, frame, limits, found, asked, facts)


def _view_facts(
    role: str, seen: SeenView, stretch: Stretch, vessel: Vessel, frame: Frame
) -> Iterator[Fact]:
    length = stretch.length
    projected = length * (1 - seen.foreshortening)
    names = [vessel.branch_names[number] for number in seen.over_it]
    yield Fact("role", after=role.lower())
    yield Fact("words", role, after=seen.view.words, words=seen.view.words)
    yield Fact("lao_deg", after=seen.view.primary)
    yield Fact("cra_deg", after=seen.view.secondary)
    for key, label, share in (
        ("foreshortening_percent", "foreshortened", seen.foreshortening),
        ("covered_percent", "covered", seen.covered),
        ("ostia_covered_percent", "ostia covered", seen.ostia_covered),
    ):
        yield Fact(key, label, after=100 * share, unit="%", words=f"{100 * share:.0f} %")
    yield Fact("covered_by", after=names)
    words = f"{millimeters(projected, 1)} of {millimeters(length, 1)}"
    yield Fact("projected_length_mm", "length in the picture", after=projected, words=words)
    stenoses = list(_stenoses(seen, stretch, vessel, frame))
    yield from (fact for name, one in stenoses for fact in _stenosis_facts(name, one))
    parts = [
        f"foreshortened {100 * seen.foreshortening:.0f} %",
        _covered_words(seen, names),
        f"{projected:.1f} of {length:.1f} mm long",
        *(_stenosis_words(name, one, stretch) for name, one in stenoses),
    ]
    words = f"{role} {seen.view.words}: {', '.join(parts)}."
    yield Fact("_sentence", words=words, level=LINES)


def _covered_words(seen: SeenView, names: Sequence[str]) -> str:
    """What lies over a stretch and over the ostia beside it."""
    over, ostia = round(100 * seen.covered), round(100 * seen.ostia_covered)
    told = f"{over} % under other vessels (most under {names[0]})" if over else "nothing over it"
    return f"{told}, {ostia} % of the ostia beside it covered" if ostia else told


def _stenoses(
    seen: SeenView, stretch: Stretch, vessel: Vessel, frame: Frame
) -> Iterator[tuple[str, SeenStenosis]]:
    """Of a lesion before, and after where it was treated."""
    lesion, tree = stretch.lesion, vessel.centerline
    if lesion is None or tree is None:
        return
    toward = seen.view.axes(frame)[2]
    for name, state in (("before", lesion), ("after", stretch.after)):
        if state is not None:
            yield name, seen_stenosis(lesion, state, tree, toward)


def _stenosis_facts(name: str, one: SeenStenosis) -> Iterator[Fact]:
    words = degree_word(one.percent)
    key = f"stenosis.{name}"
    yield Fact(f"{key}.percent", f"stenosis in the picture {name}", after=one.percent, words=words)
    yield Fact(f"{key}.width_mm", after=one.width)
    yield Fact(f"{key}.reference_mm", after=one.reference)


def _stenosis_words(name: str, one: SeenStenosis, stretch: Stretch) -> str:
    state = stretch.lesion if name == "before" else stretch.after
    assert state is not None
    treated = " after treatment" if name == "after" else ""
    if math.isnan(one.percent):
        return f"stenosis in the picture{treated} {UNKNOWN}"
    true = degree_word(state.percent_diameter)
    return f"stenosis{treated} {degree_word(one.percent)} in the picture ({true} in 3D)"


def views_document(told: ToldViews, **files: Any) -> dict[str, Any]:
    """All of it for JSON: files by name, the views, and the map of all angles."""
    grid, limits = told.found.map, told.limits
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
        "limits": {
            "lao_rao_deg": limits.lao_rao,
            "cra_cau_deg": limits.cra_cau,
            "table": [list(row) for row in limits.table],
        },
        "views": [one.as_dict() for one in told.facts],
        "map": {
            "lao_deg": grid.primary,
            "cra_deg": grid.secondary,
            **{key: np.round(100 * values, 1) for key, values in percent.items()},
            "is_reached": grid.is_reached,
        },
    }
