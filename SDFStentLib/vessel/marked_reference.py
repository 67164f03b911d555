"""Healthy vessel that the user marks, and lesions against it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from ..centerline import Centerline
from ..geometry import Line, Surface, as_surface
from ..lumen import LocalSurface, equivalent_diameters, inscribed_spheres
from ..validation import Floats, InputError, as_place, as_point
from .lesion_measuring import measured
from .lesion_value import HealthyPlace, Lesion, reference_words


def lesions_against(
    lesions: Sequence[Lesion],
    places: Sequence[ArrayLike],
    surface: Surface,
    centerline: Centerline,
) -> tuple[Lesion, ...]:
    """Lesions of a vessel, that beside the marked places against these.

    Parameters
    ----------
    lesions : sequence of Lesion
        Their order, and so their numbers, stay.
    places, surface, centerline
        As for `lesion_against`; the lesion is the one to which the ways from all places are the
        shortest.

    Raises
    ------
    InputError
        No lesion, or places that `lesion_against` refuses.
    """
    if not lesions:
        raise InputError(
            "reference: expected a vessel with a lesion to measure against it, got one in which "
            "none was found; leave the reference out."
        )
    ways = [sum(centerline.path(one.point, place).length for place in places) for one in lesions]
    chosen = int(np.argmin(ways))
    marked = lesion_against(lesions[chosen], places, surface, centerline)
    return (*lesions[:chosen], marked, *lesions[chosen + 1 :])


def lesion_against(
    lesion: Lesion, places: Sequence[ArrayLike], surface: Surface, centerline: Centerline
) -> Lesion:
    """Lesion against healthy vessel that the user marked.

    Parameters
    ----------
    lesion : Lesion
    places : sequence of one or two (3,) arrays
        Places near the centerline where the vessel is healthy, mm. Two, one on each side: the
        reference tapers from one to the other. One: it is the reference everywhere.
    surface : Surface
        Surface in which the lesion was found.
    centerline : Centerline

    Raises
    ------
    InputError
        No place or more than two, two on the same side, or a place beside the vessel.
    """
    as_surface(surface)
    if len(places) not in (1, 2):
        raise InputError(f"reference: expected one or two marked places, got {len(places)}.")
    marked = [_marked(lesion, place, surface, centerline) for place in places]
    proximal = [place for place in marked if place.arc_length <= lesion.arc_length]
    distal = [place for place in marked if place.arc_length > lesion.arc_length]
    if max(len(proximal), len(distal)) == 2:
        raise InputError(
            "reference: expected a place on each side of the lesion, got two "
            f"{'proximal' if proximal else 'distal'} to it; mark one of them only."
        )
    sides = (proximal[0] if proximal else None, distal[0] if distal else None)
    changed = replace(
        lesion,
        proximal=sides[0],
        distal=sides[1],
        reference=reference_words(sides, by="the vessel marked", other=""),
        healthy=_tapering(lesion, marked),
    )
    wall = LocalSurface(surface.points, surface.triangles, changed.line.points)
    return measured([changed], surface, wall)[0]


def _marked(
    lesion: Lesion, place: ArrayLike, surface: Surface, centerline: Centerline
) -> HealthyPlace:
    """Healthy vessel where the user says so, measured on the way from the lesion."""
    location = centerline.project(as_point(place, "reference"))
    path = centerline.path(lesion.line.points[len(lesion.line) // 2], location)
    along = path.line.arc_lengths
    near = path.points[along >= along[-1] - 1.0]
    station = location.point[None]
    direction = Line(near).directions[-1:]
    spheres = inscribed_spheres(surface.points, surface.triangles, station, direction)
    radius = float(spheres.radii[0])
    if not location.distance <= radius:
        raise InputError(
            f"reference: expected a place inside of the vessel, got one {location.distance:.1f} mm "
            "from the centerline; mark one in the lumen."
        )
    section = equivalent_diameters(surface.points, surface.triangles, station, direction)
    area = partial(float, np.pi / 4 * section[0] ** 2)
    return HealthyPlace(as_place(location.point), location.arc_length, 2 * radius, area)


def _tapering(lesion: Lesion, marked: Sequence[HealthyPlace]) -> Floats:
    """Healthy diameters (k,) along a lesion's line: on the straight line through the marked."""
    order = sorted(marked, key=lambda place: place.arc_length)
    along = lesion.start + lesion.line.arc_lengths
    places = [place.arc_length for place in order]
    return np.asarray(np.interp(along, places, [place.diameter for place in order]))
