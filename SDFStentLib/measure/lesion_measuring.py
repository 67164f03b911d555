"""A lesion on a surface: its narrowest place against a reference that is known already."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..geometry import Surface, arc_lengths, resampled_to, tangents
from ..validation import Points
from .cross_section import equivalent_diameters
from .inscribed import InscribedSpheres, inscribed_spheres
from .lesion_value import HealthyPlace, Lesion, Place

Floats = NDArray[np.float64]

STATIONS = 100
"""At least so many sections along a lesion: the throat of a smooth one is missed by less than
0.03 % of its reference."""

FINE_STATIONS = 17
"""Spheres between the neighbors of the narrowest station of a lesion's line: for the same."""


def measured(lesion: Lesion, surface: Surface, diameters: Floats | None = None) -> Lesion:
    """The lesion with all that depends on the surface, against its reference.

    Parameters
    ----------
    lesion : Lesion
    surface : Surface
    diameters : (k,) array, optional
        Inscribed, at the points of the lesion's line, where they are known already, mm.
    """
    line = resampled_to(lesion.line, max(STATIONS, 2 * len(lesion.line)))
    at = lesion.start + np.linspace(0.0, lesion.length, len(line))
    sections = equivalent_diameters(surface.points, surface.triangles, line, tangents(line))
    areas = np.pi / 4 * sections**2
    wanted = _tapering(lesion, [np.sqrt(side.area) for side in _sides(lesion)], at) ** 2
    narrow_at, spheres = _narrowest_part(lesion, surface, diameters)
    references = _tapering(lesion, [side.diameter for side in _sides(lesion)], narrow_at)
    tightest = int(np.nanargmax(1 - 2 * spheres.radii / references))
    minimum = 2 * float(spheres.radii[tightest])
    smallest = int(np.nanargmax(1 - areas / wanted)) if np.isfinite(areas / wanted).any() else 0
    return replace(
        lesion,
        arc_length=float(narrow_at[tightest]),
        point=as_place(spheres.centers[tightest]),
        minimum_diameter=minimum,
        reference_diameter=float(references[tightest]),
        percent_diameter=100 * (1 - minimum / float(references[tightest])),
        minimum_area=float(areas[smallest]),
        reference_area=float(wanted[smallest]),
        percent_area=100 * (1 - float(areas[smallest] / wanted[smallest])),
    )


def _narrowest_part(
    lesion: Lesion, surface: Surface, diameters: Floats | None
) -> tuple[Floats, InscribedSpheres]:
    """Arc lengths from the root, and spheres there, round the narrowest station of its line."""
    points, triangles = surface.points, surface.triangles
    line, directions = lesion.line, tangents(lesion.line)
    along = arc_lengths(line)
    if diameters is None:
        diameters = 2 * inscribed_spheres(points, triangles, line, directions).radii
    widths = [side.diameter for side in _sides(lesion)]
    narrowest = int(np.nanargmax(1 - diameters / _tapering(lesion, widths, lesion.start + along)))
    ends = along[max(narrowest - 1, 0)], along[min(narrowest + 1, len(line) - 1)]
    fine = np.linspace(*ends, FINE_STATIONS)
    places, ways = (
        np.column_stack([np.interp(fine, along, column) for column in values.T])
        for values in (line, directions)
    )
    return lesion.start + fine, inscribed_spheres(points, triangles, places, ways)


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
