"""Whether a surface and a centerline belong together, by unit, frame and size."""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..cautions import Caution
from ..geometry import Surface, as_surface, box_of, dot, norm, signed_volume
from ..units import flipped
from ..validation import InputError, Points, as_points

UNIT_FACTORS = (10.0, 0.1, 1000.0, 0.001)
"""Factors between millimeters, centimeters and meters, both ways."""

_SAMPLES = 150  # centerline points that are tested
_ENOUGH_INSIDE = 0.5
# Ends on a cap or a rim fall on either side; they are not worth a sentence.
_NEARLY_ALL = 0.95
# Part of the surface's extent that a line in a larger unit has at least once it is shrunk. A line
# shrunk to a spot fits into every vessel that passes near the origin, and says nothing.
_SMALLEST_PART = 0.2
_SMALLEST_EXTENT, _LARGEST_EXTENT = 20.0, 2000.0  # mm, of a vessel model
_SMALLEST_LUMEN, _LARGEST_LUMEN = 2.0, 100.0  # mm, diameter; an aorta in cm has 1.7
_NO_VOLUME = 1e-9  # share of area times extent; rounding leaves so much of nothing

_LOOKS = 15  # places of the line at which it is looked round
_AROUND, _CANCELS = 3.0, 0.4  # times the nearest; half a sphere of directions leaves 0.5


class _SpaceFit(NamedTuple):
    factor: float
    is_flipped: bool
    inside_fraction: float


def check_same_space(
    surface: Surface,
    centerline_points: ArrayLike,
    *,
    surface_name: str = "surface",
    centerline_name: str = "centerline",
) -> tuple[Caution, ...]:
    """Check that a centerline or an axis lies inside a surface, open or closed.

    Inside means `Surface.contains`. Ends that stick out of a vessel are tolerated, unless another
    unit or frame would explain them by bringing nearly all of the line inside.

    Parameters
    ----------
    surface : Surface
    centerline_points : array_like, shape (k, 3)
        Points of the centerline in any order, mm; about 150 of them are tested.
    surface_name, centerline_name : str
        Names of both in messages: files or nodes.

    Returns
    -------
    tuple of Caution
        A single caution if a part of the centerline is outside, otherwise empty.

    Raises
    ------
    InputError
        Less than half of the centerline is inside, or nearly all of it would be in another unit or
        frame, which is named.
    """
    centers = as_points(centerline_points, centerline_name, minimum=1)
    count = min(len(centers), _SAMPLES)
    centers = centers[np.linspace(0, len(centers) - 1, count).round().astype(int)]
    surface = as_surface(surface)
    inside = float(surface.contains(centers).mean())
    if inside >= _NEARLY_ALL:
        return ()
    best = _best_fit(surface, centers)
    if inside >= _ENOUGH_INSIDE and not _explains(best, inside):
        numbers: dict[str, float | str] = {"outside_percent": 100 * (1 - inside)}
        numbers["surface"] = surface_name
        return (Caution("partly-outside", numbers, label=f"{centerline_name}: "),)
    found = f"{centerline_name}: expected it inside {surface_name}, got {100 * inside:.0f} % inside"
    if best is None and _goes_round(surface, centers):
        raise InputError(
            f"{found}; it lies in a hole of it, as in that of a wall with two sides, a solid: "
            "give the surface of the lumen alone."
        )
    raise _explained(best).labeled(f"{found}; ")


def _goes_round(surface: Surface, places: Points) -> bool:
    """Whether surface lies on all sides of most of some places (k, 3), as round a hole.

    Round a hole, directions to the surface, weighted by solid angle, cancel; beside it they do not.
    """
    middles, normals = surface.points[surface.triangles].mean(axis=1), surface.face_normals
    count = 0
    for place in places[:: max(1, len(places) // _LOOKS)]:
        offset = middles - place
        distance = np.maximum(norm(offset), np.finfo(float).tiny)
        near = np.flatnonzero(distance < _AROUND * distance.min())
        way = offset[near] / distance[near, None]
        seen = surface.face_areas[near] * np.abs(dot(way, normals[near])) / distance[near] ** 2
        count += bool(np.linalg.norm(seen @ way) < _CANCELS * seen.sum())
    return count > _LOOKS // 2


def check_joined(surface: Surface, name: str) -> None:
    """Raise `InputError` for triangles of which no two share a point: they bound no vessel."""
    parts, triangles = surface.topology.component_count, len(surface.triangles)
    if 1 < triangles == parts:
        raise InputError(
            f"{name}: expected triangles that share their points, got {triangles} that share none, "
            "and lie apart, so they bound no vessel; join them first (MeshLab: Merge Close "
            "Vertices)."
        )


def size_warnings(surface: Surface, name: str, units: str = "mm") -> tuple[Caution, ...]:
    """A caution if a surface does not have the size of a vessel in millimeters.

    The extent is the longest side of its box; the lumen of a closed surface is measured by
    four times volume over area, the diameter of a long tube.
    """
    points, triangles = surface.points, surface.triangles
    is_used = np.zeros(len(points), dtype=bool)
    is_used[triangles] = True
    extent = float(np.ptp(points.compress(is_used, axis=0), axis=0).max())
    lumen = None
    if surface.topology.is_closed:
        area = float(surface.face_areas.sum())
        volume = abs(signed_volume(points, surface.wound_triangles))
        # A surface that encloses nothing, such as a doubled sheet, has no width.
        lumen = 4 * volume / area if volume > _NO_VOLUME * area * extent else None
    is_odd = not _SMALLEST_EXTENT <= extent <= _LARGEST_EXTENT
    if lumen is not None:
        is_odd = is_odd or not _SMALLEST_LUMEN <= lumen <= _LARGEST_LUMEN
    if not is_odd:
        return ()
    numbers: dict[str, float | str] = {"unit": units, "extent_mm": extent}
    if lumen is None:
        return (Caution("unusual-extent", numbers, label=f"{name}: "),)
    return (Caution("unusual-size", {**numbers, "lumen_mm": lumen}, label=f"{name}: "),)


def _best_fit(surface: Surface, centers: Points) -> _SpaceFit | None:
    """Unit or frame with the most points inside, of the other ones; None if none has half of
    them."""
    extent, fits = float(np.subtract(*box_of(surface.points)[::-1]).max()), []
    for factor, is_flipped in product((1.0, *UNIT_FACTORS), (False, True)):
        if factor == 1.0 and not is_flipped:
            continue
        if factor < 1.0 and factor * np.ptp(centers, axis=0).max() < _SMALLEST_PART * extent:
            continue
        moved = flipped(factor * centers) if is_flipped else factor * centers
        fits.append(_SpaceFit(factor, is_flipped, float(surface.contains(moved).mean())))
    # The first of equals: one change rather than two.
    best = max(fits, key=lambda fit: (fit.inside_fraction, fit.factor == 1.0, not fit.is_flipped))
    return best if best.inside_fraction >= _ENOUGH_INSIDE else None


def _explains(best: _SpaceFit | None, inside: float) -> bool:
    """Whether another unit or frame brings nearly all inside, and most of what is outside here.

    In a vessel that looks the same from both sides both frames fit about equally well: then the one
    that the files name holds.
    """
    if best is None or best.inside_fraction < _NEARLY_ALL:
        return False
    return 2 * (1 - best.inside_fraction) < 1 - inside


def _explained(best: _SpaceFit | None) -> InputError:
    if best is None:
        return InputError(
            "it lies elsewhere, and neither other units nor the other frame (RAS, LPS) explain "
            "that: it is not of this vessel; check that the two belong together."
        )
    units = (
        f"the two are in different units (it would fit {best.factor:g} times as large): save "
        "both in one unit and name that"
    )
    frame = (
        "one is in RAS and the other in LPS (it would fit with x and y negated): save both in "
        "one frame, or with the SPACE tag that Slicer writes"
    )
    if best.factor == 1.0:
        return InputError(f"{frame}.")
    return InputError(units, "one_unit", end=f"; also, {frame}." if best.is_flipped else ".")
