"""Stents in a vessel that are too wide for it, without effect, or in each other, or too short."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from ..cautions import Caution
from ..geometry import Line, Surface, nearest_distances, norm
from ..lumen import DiameterProfile, off_caps
from ..stent import StentAxis
from ..validation import InputError, Points, plain
from ..vessel import NeighborLumen
from .branches import branches_beside
from .lesions import TreatedLesion
from .placing import NOTICED, uncovered_length
from .ratios import ratio_cautions
from .value import TreatedStent

WIDEST = 4.0
"""Largest diameter of a stent over that of the lumen; more is another unit or a slip."""

HANGING = 1 / 3
"""Part of a stent hanging free from which on a caution is given: round, for want of a source.

Of 15 stents by the rule of sizing, in five vessels, 13 hung free over at most 3 %, two over 12 and
30 %, across ostia. At a lesion, 0.7 times as wide as the healthy vessel, one hung free over 48 %,
0.8 times over 26 %; beside lesions those of 0.9 times and less over 59 % and more.
"""

_SPACING, _ROUNDING = 0.1, 1e-6


def check_width(
    diameter: float, axis: StentAxis, surface: Surface, probes: Points | None = None
) -> None:
    """Refuse a stent far wider than the vessel, before hours are spent on it.

    Parameters
    ----------
    diameter : float
        Diameter of the stent, mm.
    axis : StentAxis
        Axis, whose inscribed radius is believed where it is known.
    surface : Surface
        Surface, whose nearest point stands for the wall where the radius is unknown; caps are none.
    probes : (n, 3) array, optional
        Points of the surface, mm; asked first.

    Raises
    ------
    InputError
        More than `WIDEST` times as wide as the widest lumen along the axis.
    """
    radii = axis.inscribed_radius[np.isfinite(axis.inscribed_radius)]
    if not len(radii):
        wall = surface.points if probes is None else probes
        # One place that is wide enough will do; most ends of stents lie in healthy vessel.
        if any(diameter <= 2 * WIDEST * norm(wall - end).min() for end in axis.points[[0, -1]]):
            return
        radii = nearest_distances(axis.points, wall)
        if diameter > 2 * WIDEST * radii.max():
            radii = nearest_distances(axis.points, off_caps(surface))
    lumen = 2 * float(radii.max())
    if diameter > WIDEST * lumen:
        raise InputError(
            f"stent diameter: expected at most {WIDEST:g} times the lumen of "
            f"{plain(lumen, '.3g')} mm where it lies, got {diameter:g} mm; check the "
            "diameter, and the unit of the files",
            "units",
            end=".",
        )


def overlap_length(first: Line, first_radius: float, second: Line, second_radius: float) -> float:
    """Length of the second stent's axis along which the two stents overlap, mm.

    A place of the second axis counts when it lies beside the first one, between its ends, and
    nearer to it than the sum of the radii.

    Parameters
    ----------
    first, second : Line
        Their axes.
    first_radius, second_radius : float
        mm.
    """
    even = second.resampled(_SPACING)
    # Each piece of the second axis counts by its middle.
    nearest = first.nearest((even.points[1:] + even.points[:-1]) / 2)
    # What lies beyond an end is nearest to that end, up to rounding.
    inner = np.clip(nearest.arc_lengths, _ROUNDING, first.length - _ROUNDING)
    beside = nearest.arc_lengths == inner
    near = nearest.distances < first_radius + second_radius
    return float(even.pieces[beside & near].sum())


def nothing_moved(
    treated: TreatedStent, left: DiameterProfile | None, shows: Sequence[Caution] = ()
) -> Iterator[Caution]:
    """Whether a stent moved nothing, and why; `left` is the lumen that earlier stents left it.

    `shows` is what `too_coarse` says of it: no point of the wall was there to be moved.
    """
    if treated.moved_points or shows:
        return
    lumen, diameter = left or treated.before, treated.stent.diameter
    if lumen.maximum > 0:
        widths = {"minimum_mm": lumen.minimum, "maximum_mm": lumen.maximum}
        as_left = "" if left is None else " as the earlier stents left it"
        numbers: dict[str, float | str] = {**widths, "as_left": as_left}
        numbers["stent_diameter_mm"] = diameter
        yield Caution("without-effect", numbers)
    else:
        yield Caution("outside-without-effect", {"stent_diameter_mm": diameter})


def hangs_free(treated: TreatedStent) -> Iterator[Caution]:
    """Whether a stent hangs free over so much of its length that it may migrate."""
    found = treated.apposition
    if found is not None and found.hanging_length >= HANGING * found.length:
        yield Caution("hangs-free", {"free_mm": found.hanging_length, "length_mm": found.length})


def narrowed(own: DiameterProfile, final: DiameterProfile) -> Iterator[Caution]:
    """Whether a lumen is narrower after later stents than the stent itself left it."""
    if final.minimum < 0.97 * own.minimum:
        widths = {"minimum_mm": final.minimum, "earlier_minimum_mm": own.minimum}
        yield Caution("narrowed", widths)


def overlap(first: TreatedStent, second: TreatedStent) -> Iterator[Caution]:
    """Whether two stents overlap."""
    common = overlap_length(
        first.axis.line, first.stent.radius, second.axis.line, second.stent.radius
    )
    if common > 0:
        numbers = {"first": first.row, "second": second.row, "length_mm": common}
        yield Caution("overlap", numbers)


def narrowed_neighbors(
    treated: Sequence[TreatedStent], label: Callable[[int], str]
) -> Iterator[Caution]:
    """Lumens beside the stents that are narrowed; a branch beside several stents only once.

    So is the vessel beyond the end of a stent that is dilated again.

    Each is measured before any stent and after all of them, wherever that stent moved its wall:
    of a branch the place counts that lost most. `label` names a stent by its number.
    """
    groups = [
        (one.narrowed_by, one.lumen)
        for one in branches_beside(treated)
        if one.lumen is not None and one.narrowed_by
    ]
    ends: dict[tuple[int, str], list[tuple[int, NeighborLumen]]] = {}
    for done in treated:
        for lumen in done.neighbors:
            if lumen.is_narrowed and not lumen.is_branch:
                both = done.again or done.number, lumen.name
                ends.setdefault(both, []).append((done.number, lumen))
    for group in ends.values():
        numbers, lumens = zip(*group, strict=True)
        groups.append((numbers, max(lumens, key=lambda lumen: lumen.loss)))
    for numbers, worst in sorted(groups, key=lambda group: group[0][0]):
        if len(numbers) == 1:
            yield replace(worst.caution(), stent=numbers[0]).labeled(label(numbers[0]))
        else:
            rows = {one.number: one.row for one in treated}
            named = dict.fromkeys(rows[number] for number in numbers)
            yield worst.caution().labeled(f"Stent{'s' * (len(named) > 1)} {_and(named)}: ")


def _and(numbers: Iterable[int]) -> str:
    *others, last = map(str, numbers)
    return f"{', '.join(others)} and {last}"


def size_cautions(
    stents: Sequence[TreatedStent],
    lesions: Sequence[TreatedLesion] | None,
    label: Callable[[int], str] = "".format,
) -> Iterator[Caution]:
    """Cautions for stents too short for their lesions, or as wide as no source had them.

    Parameters
    ----------
    stents : sequence of TreatedStent
    lesions : sequence of TreatedLesion or None
        Lesions of their vessel; None where they were not looked for.
    label : callable
        Names a stent by its number.
    """
    yield from _uncovered(stents, lesions or (), label)
    yield from ratio_cautions(stents, lesions, label)


def _uncovered(
    stents: Sequence[TreatedStent], lesions: Sequence[TreatedLesion], label: Callable[[int], str]
) -> Iterator[Caution]:
    """Cautions where the tightest lesion that a stent covers goes on beyond all stents in it."""
    told: set[int] = set()
    for one in stents:
        own = [lesion for lesion in lesions if one.number in lesion.stents]
        for lesion in own[:1]:
            # Another one may cover what this one leaves, though not the narrowest place.
            left = uncovered_length(lesion.before, [stent.axis.line for stent in stents])
            if left > NOTICED and lesion.number not in told:
                told.add(lesion.number)
                yield Caution(
                    "lesion-uncovered",
                    {
                        "lesion": lesion.number,
                        "uncovered_mm": left,
                        "lesion_mm": lesion.before.length,
                        "deployed_mm": one.axis.deployed_length,
                        "packed": _packed(one),
                    },
                    stent=one.number,
                ).labeled(label(one.number))


def _packed(one: TreatedStent) -> str:
    """Length before it shortened, in words; empty where it did not."""
    if one.axis.nominal_length <= one.axis.deployed_length:
        return ""
    return f", {one.axis.nominal_length:.3g} mm as packed"
