"""Lesions on a surface: their narrowest places against references that are known already."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..geometry import Surface, arc_lengths, tangents
from ..lumen import InscribedSpheres, MovedWall, equivalent_diameters, inscribed_spheres
from ..validation import Flags, Floats, Points
from .lesion_value import Lesion, Place

SECTIONS = 16
"""At least so many sections along a lesion, and two to a station: by areas of a vessel that are a
quarter of its radius apart the smallest is known to the next ones."""

OWN_SECTION = 1.5
"""Times the inscribed diameter up to which the circle of a section's area may be wide: what is
wider is the section of the vessel from which this one comes, or goes on into a branch."""

ABOUT = 1.01
"""Times the narrowest up to which another place is as narrow."""

_MATTERS = 3.0
"""Wall farther from a lesion's line than so many diameters of its reference bounds neither its
spheres nor its sections."""

_BESIDE = 1.02
"""Wall farther from a place than so many times what may matter does not."""

FINE_STATIONS = 17
"""Spheres between the neighbors of the narrowest station of a lesion's line, and sections between
those of the smallest one: a smooth throat is missed by less than 0.03 % of its reference."""


def measured(lesions: Sequence[Lesion], surface: Surface) -> list[Lesion]:
    """The lesions with all that depends on the surface, against their references.

    Parameters
    ----------
    lesions : sequence of Lesion
        Their diameters are those on this surface.
    surface : Surface
    """
    fine = [_round_narrowest(lesion) for lesion in lesions]
    spheres = _spheres(surface, [(places, ways) for _, places, ways in fine])
    begun = [
        _with_sphere(lesion, along, found)
        for lesion, (along, _, _), found in zip(lesions, fine, spheres, strict=True)
    ]
    return _with_sections(begun, surface)


def lesions_after(
    lesions: Sequence[Lesion], surface: Surface, moved: MovedWall | None = None
) -> list[Lesion]:
    """The same parts of a vessel against the same references after treatment.

    Parameters
    ----------
    lesions : sequence of Lesion
        As found before it.
    surface : Surface
        After it.
    moved : MovedWall, optional
        From then to now: what it comes nowhere near is not measured again, and a lesion that it
        does not touch at all stays what it is.
    """
    changed = {
        number: which
        for number, lesion in enumerate(lesions)
        if (which := _changed(lesion, moved)) is not None
    }
    lines = [(_line(lesions[number]), which) for number, which in changed.items()]
    pieces = [(line[which], ways[which]) for (line, ways), which in lines]
    begun = []
    for (number, which), found in zip(changed.items(), _spheres(surface, pieces), strict=True):
        diameters = lesions[number].diameters.copy()
        diameters[which] = 2 * found.radii
        begun.append(replace(lesions[number], diameters=diameters))
    after = dict(zip(changed, measured(begun, surface), strict=True))
    return [after.get(number, lesion) for number, lesion in enumerate(lesions)]


def _changed(lesion: Lesion, moved: MovedWall | None) -> Flags | None:
    """At which points (k,) of a lesion's line the sphere may be another one.

    None where neither a sphere nor a section of the lesion can have changed.
    """
    if moved is None:
        return np.ones(len(lesion.line), dtype=bool)
    near = moved.within(lesion.line, _MATTERS * float(lesion.healthy.max()))
    # A sphere holds its place: no wall that it touches is farther from there than its diameter.
    unknown = np.isnan(lesion.diameters)
    reach = np.where(unknown, lesion.reference_diameter, lesion.diameters)
    changed = near.comes_near(lesion.line, _BESIDE * reach)
    if not changed.any() and not near.crosses(*_on_line(lesion, _sections(lesion))).any():
        return None
    return np.asarray(changed | unknown)


def _spheres(surface: Surface, lines: Sequence[tuple[Points, Points]]) -> list[InscribedSpheres]:
    """Spheres at the points of some lines with their directions, all searched together."""
    if not lines:
        return []
    places, ways = (np.concatenate(column) for column in zip(*lines, strict=True))
    found = inscribed_spheres(surface.points, surface.triangles, places, ways)
    ends = np.cumsum([len(line) for line, _ in lines])[:-1]
    return [found.at(part) for part in np.split(np.arange(len(places)), ends)]


def _line(lesion: Lesion) -> tuple[Points, Points]:
    return lesion.line, tangents(lesion.line)


def _with_sphere(lesion: Lesion, along: Floats, spheres: InscribedSpheres) -> Lesion:
    """With the smallest of the spheres at some arc lengths from its start."""
    if not np.isfinite(spheres.radii).any():
        unknown = float("nan")
        return replace(lesion, minimum_diameter=unknown, percent_diameter=unknown)
    references = np.interp(along, arc_lengths(lesion.line), lesion.healthy)
    tightest = _tightest(spheres.radii, references)
    minimum, at = 2 * float(spheres.radii[tightest]), float(along[tightest])
    reference = float(references[tightest])
    branch_start = lesion.arc_length - lesion.branch_arc_length
    return replace(
        lesion,
        arc_length=lesion.start + at,
        branch_arc_length=max(0.0, lesion.start + at - branch_start),
        point=as_place(spheres.centers[tightest]),
        minimum_diameter=minimum,
        reference_diameter=reference,
        percent_diameter=100 * (1 - minimum / reference),
    )


def _tightest(sizes: Floats, references: Floats) -> int:
    """The narrowest place; of those that are about as narrow, the one that should be widest.

    A stent is as wide everywhere: what is left in it is told where most is missing.
    """
    about = sizes <= ABOUT * np.nanmin(sizes)
    return int(np.where(about, references / sizes, -np.inf).argmax())


def _with_sections(lesions: Sequence[Lesion], surface: Surface) -> list[Lesion]:
    """With the smallest of the sections along each that are those of its vessel."""
    places = [_sections(lesion) for lesion in lesions]
    areas = _own_areas(lesions, places, surface)
    fine = [
        _round(at, _tightest(own, _wanted(lesion, at)) if np.isfinite(own).any() else 0)
        for lesion, at, own in zip(lesions, places, areas, strict=True)
    ]
    more = zip(fine, _own_areas(lesions, fine, surface), strict=True)
    pairs = zip(lesions, places, areas, more, strict=True)
    return [
        _with_section(lesion, np.r_[at, near], np.r_[own, others])
        for lesion, at, own, (near, others) in pairs
    ]


def _own_areas(
    lesions: Sequence[Lesion], places: Sequence[Floats], surface: Surface
) -> list[Floats]:
    """Areas of the sections at some arc lengths of every lesion, NaN for those of other vessels."""
    if not lesions:
        return []
    stations = [_on_line(*one) for one in zip(lesions, places, strict=True)]
    points, ways = (np.concatenate(column) for column in zip(*stations, strict=True))
    cut = equivalent_diameters(surface.points, surface.triangles, points, ways)
    ends = np.cumsum([len(at) for at in places])[:-1]
    found = []
    for lesion, at, sections in zip(lesions, places, np.split(cut, ends), strict=True):
        known = np.isfinite(lesion.diameters)
        widths = np.full(len(at), np.nan)
        if known.any():
            widths = np.interp(at, arc_lengths(lesion.line)[known], lesion.diameters[known])
        is_own = sections <= OWN_SECTION * widths
        found.append(np.where(is_own, np.pi / 4 * sections**2, np.nan))
    return found


def _with_section(lesion: Lesion, along: Floats, areas: Floats) -> Lesion:
    """With the smallest of the areas at some arc lengths from its start."""
    wanted, unknown = _wanted(lesion, along), float("nan")
    largest = OWN_SECTION**2 * np.pi / 4 * lesion.minimum_diameter**2
    # Where a branch leaves at the throat, no section there is this vessel's alone.
    if not (np.isfinite(wanted) & (areas <= largest)).any():
        return replace(lesion, minimum_area=unknown, reference_area=unknown, percent_area=unknown)
    smallest = _tightest(areas, wanted)
    return replace(
        lesion,
        minimum_area=float(areas[smallest]),
        reference_area=float(wanted[smallest]),
        percent_area=100 * (1 - float(areas[smallest] / wanted[smallest])),
    )


def _wanted(lesion: Lesion, along: Floats) -> Floats:
    """Areas of the healthy vessel at some arc lengths from a lesion's start."""
    healthy = np.interp(along, arc_lengths(lesion.line), lesion.healthy)
    return np.asarray(healthy**2 * _area_of_healthy(lesion))


def _area_of_healthy(lesion: Lesion) -> float:
    """Area of the healthy vessel beside a lesion over its squared diameter."""
    sides = [side for side in (lesion.proximal, lesion.distal) if side is not None]
    ratios = [side.area / side.diameter**2 for side in sides if np.isfinite(side.area)]
    return float(np.mean(ratios)) if ratios else float("nan")


def _sections(lesion: Lesion) -> Floats:
    """Where it is cut, arc lengths (k,) from its start."""
    return np.linspace(0.0, arc_lengths(lesion.line)[-1], max(SECTIONS, 2 * len(lesion.line)))


def _round_narrowest(lesion: Lesion) -> tuple[Floats, Points, Points]:
    """Arc lengths, points and directions round the tightest station of a lesion's line."""
    known = np.isfinite(lesion.diameters)
    middle = len(lesion.line) // 2
    tightest = _tightest(lesion.diameters, lesion.healthy) if known.any() else middle
    fine = _round(arc_lengths(lesion.line), tightest)
    return (fine, *_on_line(lesion, fine))


def _round(along: Floats, number: int) -> Floats:
    """Arc lengths between the neighbors of one of some."""
    ends = along[max(number - 1, 0)], along[min(number + 1, len(along) - 1)]
    return np.linspace(*ends, FINE_STATIONS)


def _on_line(lesion: Lesion, along: Floats) -> tuple[Points, Points]:
    """Points and directions (k, 3) at some arc lengths of a lesion's line."""
    line, directions = _line(lesion)
    at = arc_lengths(line)
    places, ways = (
        np.column_stack([np.interp(along, at, column) for column in values.T])
        for values in (line, directions)
    )
    return places, ways


def as_place(point: Floats) -> Place:
    """A point as a value."""
    x, y, z = point.tolist()
    return (x, y, z)
