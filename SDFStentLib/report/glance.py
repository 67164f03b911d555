"""A result at a glance: a few lines beside the stent while a hand moves it, and tiles below."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from operator import attrgetter
from typing import Any, NamedTuple

import numpy as np

from ..cautions import Caution, by_gravity
from ..certificate import (
    CERTIFIED,
    CERTIFIED_IN_PIECES,
    CERTIFIED_OPEN,
    NOT_CERTIFIED,
    NOT_READY,
    Certificate,
)
from ..treatment import (
    PlacedStent,
    PreviewedNumbers,
    TreatedLesion,
    TreatedStent,
    branches_beside,
    residual_of,
    stent_ratios,
)
from ..vessel import Lesion, lesions_within
from .branches import ALL_ROUND, CONTACT
from .diameters import LUMEN
from .facts import GLANCE, Fact
from .flow import flow_facts
from .stents import measured_facts
from .words import degree_word, number_text

PREVIEW, MEASURING = "preview", "measuring..."
UNCOVERED = "no lesion covered"
WARNING = "warning: "
"""What a line begins with that tells of one: whoever colors lines goes by that."""

WARNINGS = "Warnings"
STENOSIS, BRANCHES, SURFACE = "Stenosis left", "Branches", "Surface"
_OF_SURFACE = {
    CERTIFIED: (CERTIFIED, ""),
    CERTIFIED_OPEN: (CERTIFIED, "once its openings are closed"),
    CERTIFIED_IN_PIECES: (CERTIFIED, "once its points are merged"),
    NOT_READY: ("not ready for a mesher", "no worse than before"),
    NOT_CERTIFIED: (NOT_CERTIFIED, ""),
}
"""Its tile, by the word of the certificate."""
_SHORT = {
    "hangs-free": "hangs free over {free_mm:.0f} of {length_mm:.0f} mm",
    "lesion-uncovered": "lesion {lesion} uncovered over {uncovered_mm:.1f} mm",
    "overdilated": "overdilated {times:.1f} x",
    "shortened": "shortened to {available_mm:.1f} mm",
    "narrower": "{percent:.0f} % narrower than prescribed",
    "narrowed": "narrowed to {minimum_mm:.1f} mm by later stents",
    "neighbor-narrowed": "{name} narrowed {before_mm:.1f} -> {after_mm:.1f} mm",
    "overlap": "overlap of {length_mm:.1f} mm",
    "ratio-stenosis": "balloon {ratio:.1f} x as wide as the stenosis",
}
"""Of a warning in a line; others are called by their kind."""
COMPARED = (LUMEN, STENOSIS, BRANCHES, SURFACE)
"""The tiles that every result has: what differs between plans."""


class Tile(NamedTuple):
    """One quantity of a result: its value large, its name small, before and reference beneath."""

    name: str
    value: str
    beneath: str = ""
    is_caution: bool = False
    """Whether it has to be known before one relies on the others."""


def previewed_lines(
    placed: PlacedStent, numbers: PreviewedNumbers, lesions: Sequence[Lesion]
) -> list[str]:
    """Of a preview: size, about the narrowest lumen and the stenosis left, and that it is one.

    And how many branches are covered, where these are not as many as before.
    `lesions` are those of the vessel, as far as they are known.
    """
    told, lesion = [_size(placed)], numbers.lesion
    if math.isfinite(numbers.lumen):
        before = "" if lesion is None else f"{lesion.minimum_diameter:.1f} -> "
        told.append(f"narrowest {before}about {numbers.lumen:.1f} mm")
    if lesion is not None:
        told.append(f"stenosis {degree_word(lesion.percent_diameter)} -> {_about(numbers.left)}")
    elif lesions:
        told.append(UNCOVERED)
    if numbers.covered is not None and numbers.covered[0] != numbers.covered[1]:
        told.append("branches: {} -> about {} covered".format(*numbers.covered))
    return [*told, *_warning_line(_ratio_cautions(placed, lesions)), PREVIEW]


def _ratio_cautions(placed: PlacedStent, lesions: Sequence[Lesion]) -> list[Caution]:
    """Of a stent against the tightest lesion that it covers."""
    covered = lesions_within(lesions, placed.axis.points)[:1]
    return [one for lesion in covered for one in stent_ratios(placed.stent, lesion).cautions()]


def _about(percent: float) -> str:
    word = degree_word(percent)
    return f"about {word}" if word.endswith("%") else word


def measuring_lines(placed: PlacedStent) -> list[str]:
    """Of a stent that is in its place, and not measured yet."""
    return [_size(placed), MEASURING]


def measured_lines(
    treated: TreatedStent,
    stents: Sequence[TreatedStent],
    lesions: Sequence[TreatedLesion] | None,
    certificate: Certificate | None,
    cautions: Sequence[Caution] = (),
    flow: Mapping[str, Any] | None = None,
) -> list[str]:
    """Of a stent after its deployment, at most eight; the last is the certificate's word.

    Before that is the gravest warning, where there is one, that of the stent first of equals.

    The other parameters are as those of `result_tiles`, of the whole treatment.
    """
    told = [
        _size(treated),
        *(one.at_hand for one in measured_facts(treated).at(GLANCE)),
        _left(treated, stents, lesions or ()),
        "" if flow is None else _flow(flow, treated.row),
        _branches(treated),
        _contact(treated),
        *_warning_line(sorted(cautions, key=lambda one: one.stent != treated.number)),
    ]
    return [*filter(None, told), _word(certificate)]


def _warning_line(cautions: Sequence[Caution]) -> list[str]:
    """The gravest of warnings, and how many others there are; nothing without any."""
    if not cautions:
        return []
    first, *others = by_gravity(cautions)
    words = _SHORT.get(first.kind, first.kind.replace("-", " ")).format_map(first.numbers)
    return [f"{WARNING}{words}{f', {len(others)} more' if others else ''}"]


def _word(certificate: Certificate | None) -> str:
    return NOT_CERTIFIED if certificate is None else certificate.word


def _size(placed: PlacedStent) -> str:
    axis = placed.axis  # what is set is the length as packed
    lost = axis.nominal_length - axis.deployed_length
    packed = f" ({axis.nominal_length:.3g} mm as packed)" if lost > 0.05 else ""
    return f"{placed.stent.diameter:.1f} x {axis.deployed_length:.1f} mm{packed}"


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
        beside = _nearest_lesion([treated], lesions)
        degree = degree_word(beside.after.percent_diameter)
        return f"{UNCOVERED}; lesion {beside.number}: {degree} left"
    return f"stenosis {degree_word(max(covered))} -> {degree_word(left.percent)}"


def _nearest_lesion(
    stents: Sequence[TreatedStent], lesions: Sequence[TreatedLesion]
) -> TreatedLesion:
    """The lesion that is nearest to a stent."""
    points = np.array([one.after.point for one in lesions])
    apart = [one.axis.line.nearest(points).distances for one in stents]
    return lesions[int(np.min(apart, axis=0).argmin())]


def _branches(treated: TreatedStent) -> str:
    """How many branches it changes."""
    counts = {
        "covered": sum(not branch.is_free for branch in treated.branches),
        "narrowed": sum(one.is_narrowed for one in treated.neighbors if one.is_branch),
    }
    words = ", ".join(f"{count} {what}" for what, count in counts.items() if count)
    return words and f"branches: {words}"


def _flow(flow: Mapping[str, Any], row: int) -> str:
    """At the mean flow: the side that gains most, and the drop over the stent."""
    facts = flow_facts(flow, "mean").at(GLANCE)
    return ", ".join(one.at_hand for one in facts if one.key in ("share", f"stent {row}"))


def _contact(treated: TreatedStent) -> str:
    found = treated.apposition
    if found is None or not found.free_length > 0:
        return ""
    return f"off the wall over {found.free_length:.0f} of {found.length:.0f} mm"


def previewed_tiles(numbers: Sequence[PreviewedNumbers]) -> list[Tile]:
    """Of a preview, by what there is of every stent: narrowest lumen and stenosis left, about."""
    lumens = [one.lumen for one in numbers if math.isfinite(one.lumen)]
    tiles = [Tile(LUMEN, f"about {min(lumens):.1f} mm", PREVIEW)] if lumens else []
    before = [one.lesion.percent_diameter for one in numbers if one.lesion is not None]
    if before:
        beneath = f"before {degree_word(max(before))}, {PREVIEW}"
        tiles.append(Tile(STENOSIS, _about(numbers[0].left), beneath))
    return tiles


def result_tiles(
    stents: Sequence[TreatedStent],
    lesions: Sequence[TreatedLesion] | None,
    certificate: Certificate | None,
    cautions: Sequence[Caution] = (),
    flow: Mapping[str, Any] | None = None,
) -> list[Tile]:
    """Of a treatment, what has to be known first in front; all of `COMPARED` are among them.

    Parameters
    ----------
    stents : sequence of TreatedStent
        At least one.
    lesions : sequence of TreatedLesion or None
        Of the vessel; None where none were looked for.
    certificate : Certificate or None
        Of the surface; None where none was asked for.
    cautions : sequence of Caution
        All that there are.
    flow : mapping, optional
        `flow_section` before and after treatment.
    """
    tiles = [
        *_warnings(cautions),
        *_worst(one for stent in stents for one in measured_facts(stent).at(GLANCE)),
        _stenosis(stents, lesions or ()),
        _beside(stents),
        *_touching(stents),
        *([] if flow is None else _worst(flow_facts(flow, "mean").at(GLANCE))),
        _surface(certificate),
    ]
    # What is the engineer's comes last, whatever it says.
    return sorted(tiles, key=lambda tile: (tile.name == SURFACE, not tile.is_caution))


def _surface(certificate: Certificate | None) -> Tile:
    is_certified = certificate is not None and certificate.passed
    return Tile(SURFACE, *_OF_SURFACE[_word(certificate)], not is_certified)


def _warnings(cautions: Sequence[Caution]) -> Iterator[Tile]:
    """How many there are, and of what, the gravest first."""
    if not cautions:
        return
    kinds = dict.fromkeys(one.kind for one in by_gravity(cautions))
    topics = ", ".join(kind.replace("-", " ") for kind in kinds)
    yield Tile(WARNINGS, str(len(cautions)), topics, True)


def _worst(facts: Iterable[Fact]) -> Iterator[Tile]:
    """Of every fact that is told first the worst of all stents; NaN is worse than any."""
    alike: dict[str, list[Fact]] = {}
    for one in facts:
        alike.setdefault(one.tile or one.label, []).append(one)
    for some in alike.values():
        unknown = [one for one in some if not math.isfinite(one.after)]
        yield Tile(*some[0].worst(unknown or some, key=attrgetter("after")).tiled)


def _stenosis(stents: Sequence[TreatedStent], lesions: Sequence[TreatedLesion]) -> Tile:
    left = residual_of(lesions, stents)
    if left is None and lesions:
        beside = _nearest_lesion(stents, lesions)
        beneath = f"{UNCOVERED}; that of lesion {beside.number}"
        return Tile(STENOSIS, degree_word(beside.after.percent_diameter), beneath, True)
    if left is None:
        return Tile(STENOSIS, degree_word(None), "no lesions are known")
    # There is one: else nothing would be said to be left.
    before = degree_word(max(one.before.percent_diameter for one in lesions if one.stents))
    beneath = f"before {before}, healthy {number_text(left.reference, 1)} mm"
    return Tile(STENOSIS, degree_word(left.percent), beneath)


def _beside(stents: Sequence[TreatedStent]) -> Tile:
    every = branches_beside(stents)
    if not every:
        return Tile(BRANCHES, "none near")
    covered = sum(not one.ostium.is_free for one in every)
    narrowed = sum(one.lumen is not None and one.lumen.is_narrowed for one in every)
    beneath = f"{narrowed} narrowed" if narrowed else "none narrowed"
    return Tile(BRANCHES, f"{covered} of {len(every)} covered", beneath)


def _touching(stents: Sequence[TreatedStent]) -> Iterator[Tile]:
    """How much of the stents does not touch the wall; none where that was not looked for."""
    found = [one.apposition for one in stents if one.apposition is not None]
    if not found:
        return
    free, length = (sum(getattr(one, name) for one in found) for name in ("free_length", "length"))
    off = f"{free:.0f} mm off" if free > 0 else ALL_ROUND
    yield Tile(CONTACT, off, f"of {length:.0f} mm")
