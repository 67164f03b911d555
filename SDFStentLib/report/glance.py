"""A result at a glance: a few lines beside the stent while a hand moves it, and tiles below."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from operator import attrgetter
from typing import Any

from ..cautions import Caution
from ..certificate import Certificate
from ..scan import Ranged, VoxelRange
from ..treatment import (
    PlacedStent,
    PreviewedNumbers,
    SizeRatios,
    TreatedLesion,
    TreatedStent,
    stent_ratios,
)
from ..vessel import Lesion, lesions_within
from .branches import BRANCHES
from .diameters import LUMEN
from .facts import GLANCE, LINES, Fact, Facts, Tile
from .flow import flow_facts
from .sizing import ratio_sentence
from .stents import measured_facts
from .summary import (
    STENOSIS,
    SURFACE,
    UNCOVERED,
    outcome_facts,
    range_of,
    surface_fact,
    warning_facts,
)
from .words import UNKNOWN, degree_word

PREVIEW, MEASURING = "preview", "measuring..."
COMPARED = (LUMEN, STENOSIS, BRANCHES, SURFACE)
"""The tiles that every result has: what differs between plans."""


def preview_facts(numbers: Sequence[PreviewedNumbers], lesions: Sequence[Lesion] = ()) -> Facts:
    """Facts on some stents of a preview, all of them approximate.

    Parameters
    ----------
    numbers : sequence of PreviewedNumbers
        Numbers of one stent or more.
    lesions : sequence of Lesion
        Lesions of the vessel, as far as they are known.
    """
    lumens = [one.lumen for one in numbers if math.isfinite(one.lumen)]
    covered = [one.lesion for one in numbers if one.lesion is not None]
    facts = [_about_lumen(min(lumens, default=math.nan), covered)]
    if covered:
        left = numbers[0].left  # the same of every stent: by all of them together
        few = degree_word(left)
        few = f"about {few}" if few.endswith("%") else few
        before = degree_word(max(one.percent_diameter for one in covered))
        beneath, hand = f"before {before}, {PREVIEW}", f"stenosis {before} -> {few}"
        facts.append(
            Fact(
                "stenosis",
                "",
                None,
                left,
                "",
                few,
                level=GLANCE,
                few=few,
                hand=hand,
                tile=STENOSIS,
                beneath=beneath,
            )
        )
    elif lesions:
        facts.append(Fact(words=UNCOVERED, level=GLANCE, hand=UNCOVERED))
    for one in numbers:
        if one.covered is not None and one.covered[0] != one.covered[1]:
            hand = "branches: {} -> about {} covered".format(*one.covered)
            facts.append(Fact(words=hand, level=GLANCE, hand=hand))
    return Facts(facts)


def _about_lumen(lumen: float, covered: Sequence[Lesion]) -> Fact:
    """Told at a glance where it is known; of a proxy that is too coarse only that it is not."""
    if not math.isfinite(lumen):
        return Fact("lumen", "Minimum lumen", after=lumen, unit="mm", words=UNKNOWN, level=LINES)
    was = "".join(f"{min(one.minimum_diameter for one in covered):.1f} -> " for _ in covered[:1])
    words = f"about {lumen:.1f} mm"
    return Fact(
        "lumen",
        "Minimum lumen",
        after=lumen,
        unit="mm",
        words=words,
        level=GLANCE,
        few=words,
        hand=f"narrowest {was}{words}",
        tile=LUMEN,
        beneath=PREVIEW,
    )


def previewed_lines(
    placed: PlacedStent, numbers: PreviewedNumbers, lesions: Sequence[Lesion]
) -> list[str]:
    """Lines of a preview: size, about the narrowest lumen and the stenosis left; that it is one.

    And how many branches are covered, where these are not as many as before.
    `lesions` are those of the vessel, as far as they are known.
    """
    cautions = [one for ratios in _ratios(placed, lesions) for one in ratios.cautions()]
    facts = [*preview_facts([numbers], lesions).at(GLANCE), *warning_facts(cautions)]
    return [_size(placed), *(one.at_hand for one in facts), PREVIEW]


def previewed_sentences(
    placed: PlacedStent, numbers: PreviewedNumbers, lesions: Sequence[Lesion]
) -> list[str]:
    """Sentences on a previewed stent, and on its ratios to the tightest lesion that it covers."""
    told = [f"{one} ({PREVIEW})" for one in preview_facts([numbers], lesions) if one.label]
    for ratios in _ratios(placed, lesions):
        told += [ratio_sentence(ratios), *(one.sentence() for one in ratios.cautions())]
    return told


def previewed_tiles(numbers: Sequence[PreviewedNumbers]) -> list[Tile]:
    """Tiles of a preview, by its numbers of every stent: narrowest lumen and stenosis left."""
    return [one.tiled for one in preview_facts(numbers).at(GLANCE) if one.tile]


def _ratios(placed: PlacedStent, lesions: Sequence[Lesion]) -> Iterator[SizeRatios]:
    """Ratios of a stent to the tightest lesion that it covers; nothing where it covers none."""
    for lesion in lesions_within(lesions, placed.axis.points)[:1]:
        yield stent_ratios(placed.stent, lesion)


def measuring_lines(placed: PlacedStent) -> list[str]:
    """Lines of a stent that is in its place, and not measured yet."""
    return [_size(placed), MEASURING]


def measured_lines(
    treated: TreatedStent,
    stents: Sequence[TreatedStent],
    lesions: Sequence[TreatedLesion] | None,
    certificate: Certificate | None,
    cautions: Sequence[Caution] = (),
    flow: Mapping[str, Any] | None = None,
) -> list[str]:
    """Lines on a deployed stent, at most eight; the last is the certificate's word.

    Before that is the gravest warning, where there is one, that of the stent first of equals.

    The other parameters are as those of `result_tiles`, of the whole treatment.
    """
    own = sorted(cautions, key=lambda one: one.stent != treated.number)
    told = [
        _size(treated),
        *(one.at_hand for one in measured_facts(treated).at(GLANCE)),
        *(one.at_hand for one in outcome_facts([treated], lesions, stents)),
        "" if flow is None else _flow(flow, treated.row),
        *(one.at_hand for one in warning_facts(own)),
        surface_fact(certificate).at_hand,
    ]
    return [*filter(None, told)]


def _size(placed: PlacedStent) -> str:
    axis = placed.axis  # what is set is the length as packed
    lost = axis.nominal_length - axis.deployed_length
    packed = f" ({axis.nominal_length:.3g} mm as packed)" if lost > 0.05 else ""
    return f"{placed.stent.diameter:.1f} x {axis.deployed_length:.1f} mm{packed}"


def _flow(flow: Mapping[str, Any], row: int) -> str:
    """The side that gains most at the mean flow, and the drop over the stent."""
    facts = flow_facts(flow, "mean").at(GLANCE)
    return ", ".join(one.at_hand for one in facts if one.key in ("share", f"stent {row}"))


def result_tiles(
    stents: Sequence[TreatedStent],
    lesions: Sequence[TreatedLesion] | None,
    certificate: Certificate | None,
    cautions: Sequence[Caution] = (),
    flow: Mapping[str, Any] | None = None,
    voxels: VoxelRange | None = None,
) -> list[Tile]:
    """Tiles of a treatment, cautions in front; all of `COMPARED` are among them.

    Parameters
    ----------
    stents : sequence of TreatedStent
        At least one.
    lesions : sequence of TreatedLesion or None
        Lesions of the vessel; None where none were looked for.
    certificate : Certificate or None
        Certificate of the surface; None where none was asked for.
    cautions : sequence of Caution
        Cautions of the whole treatment.
    flow : mapping, optional
        `flow_section` before and after treatment.
    voxels : VoxelRange, optional
        Ranges of lumen, stenosis and pressure drop, where the vessel was made of voxels.
    """
    lumens = [one for stent in stents for one in _lumen_within(stent, voxels)]
    drops = () if flow is None else flow_facts(flow, "mean").at(GLANCE)
    if voxels is not None:
        drops = [_within(one, one.key, voxels.drops) for one in drops]
    told = [
        *warning_facts(cautions),
        *_worst(lumens),
        *outcome_facts(stents, lesions, ranges=() if voxels is None else voxels.stenoses),
        *_worst(drops),
        surface_fact(certificate),
    ]
    # What is the engineer's comes last, whatever it says.
    told.sort(key=lambda one: (one.tile == SURFACE, not one.is_caution))
    return [one.tiled for one in told]


def _lumen_within(stent: TreatedStent, voxels: VoxelRange | None) -> Iterator[Fact]:
    """Facts on a stent at a glance, its lumen with the range."""
    for one in measured_facts(stent).at(GLANCE):
        if voxels is None or one.tile != LUMEN:
            yield one
        else:
            yield _within(one, f"stent {stent.row}", voxels.lumens)


def _within(fact: Fact, name: str, ranges: Sequence[Ranged]) -> Fact:
    """A fact with the range, of all, of the thing with a name."""
    return fact._replace(within=range_of(name, ranges))


def _worst(facts: Iterable[Fact]) -> Iterator[Fact]:
    """Worst fact of all stents for every one at a glance; NaN is worse than any."""
    alike: dict[str, list[Fact]] = {}
    for one in facts:
        alike.setdefault(one.tile or one.label, []).append(one)
    for some in alike.values():
        unknown = [one for one in some if not math.isfinite(one.after)]
        yield some[0].worst(unknown or some, key=attrgetter("after"))
