"""Lesions on a surface: their narrowest places against references that are known already."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..geometry import Surface, arc_lengths, resampled_to, tangents
from ..validation import Flags, Points
from .cross_section import equivalent_diameters
from .inscribed import InscribedSpheres, inscribed_spheres
from .lesion_value import HealthyPlace, Lesion, Place
from .moved_wall import MovedWall

Floats = NDArray[np.float64]

STATIONS = 100
"""At least so many sections along a lesion: the throat of a smooth one is missed by less than
0.03 % of its reference."""

_MATTERS = 3.0
"""Wall farther from a lesion's line than so many diameters of its reference bounds neither its
spheres nor its sections."""

_BESIDE = 1.02
"""Wall farther from a place than so many times what may matter does not."""

FINE_STATIONS = 17
"""Spheres between the neighbors of the narrowest station of a lesion's line: for the same."""


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
    return [
        _with_section(_with_sphere(lesion, lesion.start + along, found), surface)
        for lesion, (along, _, _), found in zip(lesions, fine, spheres, strict=True)
    ]


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
    near = moved.within(lesion.line, _MATTERS * _width(lesion))
    # A sphere holds its place: no wall that it touches is farther from there than its diameter.
    unknown = np.isnan(lesion.diameters)
    reach = np.where(unknown, lesion.reference_diameter, lesion.diameters)
    changed = near.comes_near(lesion.line, _BESIDE * reach)
    sections = _sections(lesion)
    if not changed.any() and not near.crosses(sections, tangents(sections)).any():
        return None
    return np.asarray(changed | unknown)


def _width(lesion: Lesion) -> float:
    return max(lesion.reference_diameter, float(np.sqrt(lesion.reference_area)))


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


def _with_sphere(lesion: Lesion, at: Floats, spheres: InscribedSpheres) -> Lesion:
    """With the tightest of the spheres at some arc lengths from the root."""
    references = _tapering(lesion, [side.diameter for side in _sides(lesion)], at)
    tightest = int(np.nanargmax(1 - 2 * spheres.radii / references))
    minimum, reference = 2 * float(spheres.radii[tightest]), float(references[tightest])
    return replace(
        lesion,
        arc_length=float(at[tightest]),
        point=as_place(spheres.centers[tightest]),
        minimum_diameter=minimum,
        reference_diameter=reference,
        percent_diameter=100 * (1 - minimum / reference),
    )


def _with_section(lesion: Lesion, surface: Surface) -> Lesion:
    """With the tightest of the sections along it."""
    line = _sections(lesion)
    at = lesion.start + np.linspace(0.0, lesion.length, len(line))
    sections = equivalent_diameters(surface.points, surface.triangles, line, tangents(line))
    areas = np.pi / 4 * sections**2
    wanted = _tapering(lesion, [np.sqrt(side.area) for side in _sides(lesion)], at) ** 2
    smallest = int(np.nanargmax(1 - areas / wanted)) if np.isfinite(areas / wanted).any() else 0
    return replace(
        lesion,
        minimum_area=float(areas[smallest]),
        reference_area=float(wanted[smallest]),
        percent_area=100 * (1 - float(areas[smallest] / wanted[smallest])),
    )


def _sections(lesion: Lesion) -> Points:
    """Where it is cut, (k, 3)."""
    return resampled_to(lesion.line, max(STATIONS, 2 * len(lesion.line)))


def _round_narrowest(lesion: Lesion) -> tuple[Floats, Points, Points]:
    """Arc lengths, points and directions round the narrowest station of a lesion's line."""
    line, directions = _line(lesion)
    along = arc_lengths(line)
    widths = [side.diameter for side in _sides(lesion)]
    references = _tapering(lesion, widths, lesion.start + along)
    narrowest = int(np.nanargmax(1 - lesion.diameters / references))
    ends = along[max(narrowest - 1, 0)], along[min(narrowest + 1, len(line) - 1)]
    fine = np.linspace(*ends, FINE_STATIONS)
    places, ways = (
        np.column_stack([np.interp(fine, along, column) for column in values.T])
        for values in (line, directions)
    )
    return fine, places, ways


def _sides(lesion: Lesion) -> list[HealthyPlace]:
    return [side for side in (lesion.proximal, lesion.distal) if side is not None]


def _tapering(lesion: Lesion, values: list[float], at: Floats) -> Floats:
    """What has these values at the healthy places, on the straight line through them."""
    places = [side.arc_length for side in _sides(lesion)]
    if len(places) == 1:
        return np.full(len(at), values[0])
    slope = (values[1] - values[0]) / (places[1] - places[0])
    return np.asarray(values[0] + slope * (at - places[0]))


def median_area(surface: Surface, line: Points, directions: Points) -> float:
    """Of the sections at some stations, mm^2; NaN where none is closed."""
    wide = equivalent_diameters(surface.points, surface.triangles, line, directions)
    wide = wide[np.isfinite(wide)]
    return float(np.pi / 4 * np.median(wide) ** 2) if len(wide) else float("nan")


def as_place(point: Floats) -> Place:
    """A point as a plain tuple."""
    x, y, z = point.tolist()
    return x, y, z
