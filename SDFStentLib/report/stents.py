"""Facts on a treated stent: documents, pages, tables, lines and tiles are made of these."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from ..plan import to_document
from ..stent import OfStent, Stent
from ..treatment import SizeRatios, TreatedLesion, TreatedStent, TreatmentResult, treated_ratios
from ..units import MILLIMETERS
from ..validation import check_is_a
from .branches import again_as, beside_facts
from .devices import device_facts, device_sentences
from .diameters import lumen_facts, prescribed_words
from .facts import COMPARED, LINES, Fact, Facts, size
from .sizing import balloon_sentences, ratio_facts, ratio_sentence
from .words import millimeters, number_text, plain_text, point_words, size_words

PLACEMENTS = {
    "AtCenter": "by its middle",
    "AtDistalEnd": "by its distal end",
    "AtProximalEnd": "by its proximal end",
    "BetweenPoints": "between two points on the centerline",
    "AlongAxis": "along a given curve",
    "OfStent": "where the earlier one lies",
    "AtLesion": "at a lesion",
    "OnBranch": "on a branch",
}

CUT = 0.1
"""Length, mm, by which a stent is shorter than prescribed where it is called cut; as its warning
has it."""

Lesions = Sequence[TreatedLesion] | None


def stent_facts(
    treated: TreatedStent, lesions: Lesions, units: str = "mm", frame: str | None = None
) -> Facts:
    """Facts on a treated stent.

    Parameters
    ----------
    treated : TreatedStent
    lesions : sequence of TreatedLesion or None
        Lesions of the vessel; None where none were looked for.
    units, frame : str
        Unit and frame of the surface's file, in which its ends are given, too.
    """
    covered = [one for one in lesions or () if treated.number in one.stents]
    ratios = treated_ratios(treated, lesions)
    return Facts(
        (
            Fact("number", after=treated.number, column="stent"),
            Fact("name" if treated.stent.name else "", after=treated.stent.name, column="name"),
            *device_facts(treated.stent.device),
            *_sizes(treated, covered),
            *ratio_facts(ratios),
            *_shape(treated),
            *_lengths(treated),
            *_place(treated, units, frame),
            *_reach(treated, None if lesions is None else covered),
            *lumen_facts(treated),
            *_compared(treated.stent, covered, ratios),
            *beside_facts(treated),
        )
    )


def measured_facts(treated: TreatedStent) -> Facts:
    """Facts on the result of a treated stent: its lumen, and the branches and wall beside it."""
    return Facts((*lumen_facts(treated), *beside_facts(treated)))


def _sizes(treated: TreatedStent, covered: Sequence[TreatedLesion]) -> Iterable[Fact]:
    stent, balloon = treated.stent, treated.stent.balloon
    words, placed = deployed_words(treated), PLACEMENTS[type(stent.placement).__name__]
    again = f", {again_as(treated)}" if treated.again else ""
    yield Fact("_deployed", words=words + again)
    yield Fact("_whole", words=f"{words[:1].upper()}{words[1:]}, placed {placed}{again}.")
    if isinstance(stent.placement, OfStent):
        number, row = stent.placement.number, treated.earlier_row
        words = "at once" if row == treated.row else f"of stent {row}"
        yield Fact("redilates", "Redilation", after=number, words=words)
    if treated.again is not None:
        yield Fact("dilated_again_as", after=treated.again)
    yield Fact(
        "lumen_diameter_mm",
        "Prescribed lumen diameter",
        after=stent.diameter,
        unit="mm",
        words=(size_words if balloon is None else millimeters)(stent.diameter),
        level=COMPARED,
        column="diameter_mm",
    )
    yield Fact(after=float(stent.widest_diameter), column="widest_diameter_mm")
    inflated = None if balloon is None else balloon.diameter
    yield size("balloon_diameter_mm", "Balloon diameter", inflated, level=COMPARED)
    yield Fact(after=math.nan if inflated is None else float(inflated), column="balloon_mm")
    share, reason = (None, None) if balloon is None else (balloon.recoil_fraction, balloon.reason)
    words = "" if share is None else f"{100 * share:g} % of the balloon: {reason}"
    yield Fact("recoil_fraction", "Recoil", after=share, words=words)
    yield Fact("recoil_reason", after=reason)
    reference = covered[0].before.reference_diameter if covered else None
    label = "Reference diameter of the lesion"
    yield size("reference_diameter_mm", label, reference, level=COMPARED)


def _shape(treated: TreatedStent) -> Iterable[Fact]:
    """Facts on the shape of a stent that is no cylinder, with its profile; null for a cylinder."""
    shape, profile = treated.stent.shape, treated.axis.profile
    if shape is None or profile is None:
        yield Fact("shape")
        return
    document = to_document(shape)
    yield Fact(
        "shape",
        after={
            "cap_height": shape.cap_height,
            **document,
            "fractions": profile.fractions,
            "diameters_mm": profile.diameters,
        },
    )
    if waist := document.get("waist"):
        yield Fact("", "Waist", words=millimeters(waist["diameter"]))
    for key, words in (("start", "Proximal end"), ("end", "Distal end")):
        if end := document.get(key):
            sizes = f"{millimeters(end['diameter'])} at the end, over {millimeters(end['length'])}"
            yield Fact("", f"{words} of the stent", words=sizes)
    if document.get("table"):
        yield Fact("", "Profile", words=f"a table of {len(document['table'])} diameters")
    span = f"{profile.diameters.min():.2f} to {profile.widest:.2f} mm"
    yield Fact("", "Prescribed along it", words=span)
    if shape.cap_height != 1:
        caps = f"{number_text(shape.cap_height, 2)} of the radius"
        yield Fact("", "Caps beyond its ends", words=caps)


def _lengths(treated: TreatedStent) -> Iterable[Fact]:
    axis, reason = treated.axis, shortening_reason(treated.stent)
    lost = treated.stent.foreshortening
    share = f"{number_text(100 * lost, 0)} % of nominal length"
    nominal, deployed = float(axis.nominal_length), float(axis.deployed_length)
    yield size("nominal_length_mm", "Nominal length", nominal, 1, column="length_mm")
    label = "Deployed length along the axis"
    yield size("deployed_length_mm", label, deployed, 1, column="deployed_length_mm")
    yield Fact(
        "foreshortening_fraction",
        "Foreshortening on expansion",
        after=lost,
        words=f"{share}, {reason}" if reason else share,
    )
    yield Fact("foreshortening_reason", after=reason)


def _place(treated: TreatedStent, units: str, frame: str | None) -> Iterable[Fact]:
    """Facts on the stent's placement, and on its place: points in mm, and as the file has them."""
    axis, kind = treated.axis, type(treated.stent.placement).__name__
    yield Fact("placement", "Placed", after=kind, words=PLACEMENTS[kind])
    where = f"x, y, z{f', {frame}' if frame else ''}"
    for name, label, point in (
        ("start", "Proximal end", axis.points[0]),
        ("end", "Distal end", axis.points[-1]),
    ):
        yield Fact(
            f"axis.{name}_mm",
            f"{label} ({where})",
            after=point,
            words=point_words(point, units),
            column=f"{name}_{{}}_mm",
        )
        yield Fact(f"axis.{name}", after=point / MILLIMETERS[units])
    yield Fact("axis.units", after=units)
    yield Fact("axis.length_mm", after=axis.deployed_length)
    yield size("axis.chord_mm", "Straight distance of its ends", axis.chord, 1)
    radius = axis.minimum_bend_radius(treated.stent.radius)
    words = _bend_words(radius, treated.stent.diameter, axis.deployed_length)
    yield Fact("axis.min_bend_radius_mm", "Tightest bend of its axis", after=radius, words=words)


def _bend_words(radius: float, diameter: float, length: float) -> str:
    """The radius, and over which length of the axis it was found: it depends on that."""
    if not math.isfinite(radius):
        return "none, the axis is straight"
    window = min(diameter, length) / 2
    return (
        f"radius {millimeters(radius, 1)}, of the circle through three points of the axis that are "
        f"{millimeters(window, 1)} apart "
        f"({'the stent radius' if window == diameter / 2 else 'half of its length'})"
    )


def _reach(treated: TreatedStent, covered: Lesions) -> Iterable[Fact]:
    """The points that the stent moved, and the lesions that it covers."""
    moved = treated.moved_points
    label = "Surface points that it moved"
    yield Fact("moved_points", label, after=moved, words=plain_text("", moved))
    yield Fact("lesions", after=covered and [one.number for one in covered])


def _compared(stent: Stent, covered: Sequence[TreatedLesion], ratios: SizeRatios) -> Iterable[Fact]:
    """Sentences on how device, balloon and vessel compare."""
    reference = covered[0].before.reference_diameter if covered else None
    for sentence in (
        *device_sentences(stent),
        *balloon_sentences(stent, reference),
        *([] if math.isnan(ratios.adjacent_diameter) else [ratio_sentence(ratios)]),
    ):
        yield Fact(words=sentence, level=LINES)


def shortening_reason(stent: Stent) -> str | None:
    """Reason for the foreshortening of a stent; None where no length was given."""
    if stent.length is None and stent.foreshortening_fraction is None:
        return None
    if isinstance(stent.placement, OfStent) and not stent.foreshortening:
        return None
    if stent.foreshortening_fraction is not None:
        return "as given"
    if stent.device is None:
        return "the usual share, assumed without a device"
    return f"as known of {stent.device.name}"


def deployed_words(treated: TreatedStent) -> str:
    """A stent by its sizes, as deployed and as packed."""
    stent, axis = treated.stent, treated.axis
    name = "stent of" if stent.device is None else f"{stent.device.name},"
    size = prescribed_words(treated).replace(" mm", "")
    words = f"{name} {size} x {axis.deployed_length:.1f} mm"
    told = []
    if stent.balloon is not None:
        told.append(f"balloon {round(stent.balloon.diameter, 2):g} mm")
    reason = shortening_reason(stent)
    if reason is not None and stent.foreshortening:
        percent = 100 * stent.foreshortening
        change = f"{abs(percent):.3g} % {'shorter' if percent > 0 else 'longer'}"
        packed = round(axis.nominal_length, 2)
        told.append(f"{packed:g} mm as packed, {change} once expanded: {reason}")
        if axis.deployed_length < axis.prescribed_length - CUT:
            told.append(f"of {axis.prescribed_length:.1f} mm the rest lies beyond the centerline")
    return f"{words} ({'; '.join(told)})" if told else words


def stent_rows(result: TreatmentResult) -> list[dict[str, Any]]:
    """A flat row per stent, for a table: plain texts, numbers and truth values.

    Lengths in mm, times in s; a number that is not known is NaN, a text empty. Every row has
    the same columns; those of the certificate and the times are of the whole treatment.

    Raises
    ------
    InputError
        Something else than a result.
    """
    check_is_a(result, TreatmentResult, "result")
    judged = result.certificate
    common = {
        "moved_points": len(result.indices),
        "certified": "" if judged is None else bool(judged.passed),
        "warnings": len(result.warnings),
        **{f"{name}_s": seconds for name, seconds in result.timings.items()},
    }
    return [{**stent_facts(stent, None).columns(), **common} for stent in result.stents]


def stent_titles(stents: Sequence[Mapping[str, Any]]) -> list[str]:
    """Titles such as "Stent 1 of 2: main"; one stent alone has no number.

    Stents of the plan that are switched off are not in a report: the numbers are then those of
    the plan, as in the warnings.
    """
    numbers = [stent["number"] for stent in stents]
    if numbers != [*range(1, len(stents) + 1)]:
        titles = [f"Stent {number} of the plan" for number in numbers]
    elif len(stents) > 1:
        titles = [f"Stent {number} of {len(stents)}" for number in numbers]
    else:
        titles = ["Stent"] * len(stents)
    return [
        f"{title}: {stent['name']}" if stent.get("name") else title
        for title, stent in zip(titles, stents, strict=True)
    ]
