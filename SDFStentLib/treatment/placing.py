"""Placement of a stent that treats a lesion, and the healthy vessel that it is compared with."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..centerline import Centerline
from ..geometry import Line
from ..lumen import DiameterProfile
from ..stent import DEFAULT_FORESHORTENING, AtCenter, AtDistalEnd
from ..validation import Flags, Floats, Points, as_number
from ..vessel import Lesion, lesions_within

NOTICED = 1.0
"""Length of a lesion beyond a stent's ends, mm, up to which it counts as covered: a lesion's ends
are not known to better than the stations along its vessel."""

_SPACING = 0.1
_SAME = 1e-6


def uncovered_length(lesion: Lesion, axes: Sequence[Line]) -> float:
    """Length of a lesion beyond the ends of stents with these axes, or in another vessel, mm."""
    line = lesion.line.resampled(_SPACING)
    radii = np.interp(line.arc_lengths, lesion.line.arc_lengths, lesion.healthy) / 2
    beyond = np.all([_is_beyond(line.points, radii, axis) for axis in axes], axis=0)
    return float(beyond.mean() * line.length)


def _is_beyond(places: Points, radii: Floats, axis: Line) -> Flags:
    nearest = axis.nearest(places)
    along = nearest.arc_lengths
    is_beyond: Flags = (along <= _SAME) | (along >= axis.length - _SAME)
    return is_beyond | (nearest.distances > radii)


def placement_at(
    lesion: Lesion,
    centerline: Centerline,
    stent_length: float,
    foreshortening_fraction: float = DEFAULT_FORESHORTENING,
) -> AtCenter | AtDistalEnd:
    """The placement of a stent whose middle is that of a lesion's extent.

    A stent that is shorter than the lesion moves from there as far as it takes to have the
    narrowest place in its middle half.

    Parameters
    ----------
    lesion : Lesion
    centerline : Centerline
        Centerline of the vessel in which it was found.
    stent_length : float
        Nominal, mm.
    foreshortening_fraction : float
        Foreshortening of the stent, as in `Stent`.

    Returns
    -------
    AtCenter or AtDistalEnd
        The second where the way down from the middle chooses a branch at a junction within the
        lesion, or goes into another one than the lesion's, which is rarely the widest.

    Raises
    ------
    InputError
        A length that is not above 0.
    """
    nominal = as_number(stent_length, "stent length", unit="mm", above=0)
    half = nominal * (1 - foreshortening_fraction) / 2
    line = lesion.line
    extent = line.length
    narrowest, at = lesion.arc_length - lesion.start, extent / 2
    if 2 * half < extent:
        at = min(max(at, narrowest - half / 2), narrowest + half / 2)
    middle = line.at(at)
    path = centerline.path_around(middle, 2 * half)
    around, within = path.line, max(extent - 2 * half, 0.0) + NOTICED
    # A junction within the lesion leaves no choice to tell of: its branch is the lesion's.
    along = [centerline.project(choice.point).arc_length for choice in path.choices]
    is_clear = not along or max(along) > lesion.end
    if (
        is_clear
        and lesions_within([lesion], around, beyond=0.0)
        and uncovered_length(lesion, [around]) <= within
    ):
        return AtCenter(middle)
    if at + half <= extent:
        return AtDistalEnd(line.at(at + half))
    beyond = centerline.path_from_proximal(line.points[-1], at + half - extent)
    return AtDistalEnd(beyond.points[-1])


_SHOULDER = 0.5
"""Diameters within which the widest place stands for the vessel at an end: at the shoulder of a
lesion, where the lumen is less than a tenth narrower than the reference, it is no narrower."""

_PART = 1.0
"""Diameters likewise between the ends: narrower over less than twice that is a slope, and no
healthy part."""


class HealthyVessel(NamedTuple):
    """Diameters of the healthy vessel where a stent lies, mm; NaN where not known."""

    proximal: float
    """The diameter at its proximal end,"""
    distal: float
    """at its distal end,"""
    narrowest: float
    """and the least of these and of what lies between."""


def beside_lesion(lesion: Lesion) -> HealthyVessel:
    """Healthy vessel of a lesion: on both sides of it, and the narrower of these."""
    proximal, distal = (
        math.nan if one is None else one.diameter for one in (lesion.proximal, lesion.distal)
    )
    return HealthyVessel(proximal, distal, float(np.nanmin([proximal, distal, *lesion.healthy])))


def healthy_vessel(
    native: DiameterProfile, stent_length: float, lesions: Sequence[Lesion] | None
) -> HealthyVessel:
    """Healthy vessel along a stent: the reference in a lesion, elsewhere the native lumen.

    Parameters
    ----------
    native : DiameterProfile
        Diameters before any stent, along it from arc length 0 and beyond both of its ends.
    stent_length : float
        Length of the expanded stent, mm.
    lesions : sequence of Lesion or None
        Lesions of the vessel. None where they were not looked for: what is healthy is not known
        then, and the widest lumen within the stent stands for it.
    """
    # Outside of the lumen the diameter is 0.
    known = native.inscribed_diameter > 0
    along, lumen = native.arc_length[known], native.inscribed_diameter[known]
    own = np.flatnonzero((along >= -_SAME) & (along <= stent_length + _SAME))
    if not len(own):
        return HealthyVessel(math.nan, math.nan, math.nan)
    if lesions is None:
        widest = float(lumen[own].max())
        return HealthyVessel(math.nan, math.nan, widest)
    reference, is_deep = _references(native.centers[known], lesions)
    lumen = np.where(_in_junction(native.centers[known], lumen, lesions), np.nan, lumen)
    known_best = np.where(np.isnan(reference), lumen, reference)
    at_end, part = (
        np.where(np.isnan(reference), _widest_near(along, known_best, reach * lumen), reference)
        for reach in (_SHOULDER, _PART)
    )
    ends = []
    for end, way in ((own[0], -1), (own[-1], 1)):
        # A reference that is that of a wider vessel is bounded by what is measured beyond the end.
        beyond = way * (along - along[end])
        near = (beyond >= 0) & (beyond <= at_end[end])
        measured = math.inf if is_deep[end] else np.fmax.reduce(lumen[near], initial=np.nan)
        ends.append(float(np.fmin(at_end[end], measured)))
    return HealthyVessel(ends[0], ends[1], float(np.fmin.reduce([*ends, *part[own]])))


def _references(places: Floats, lesions: Sequence[Lesion]) -> tuple[Floats, Flags]:
    """The reference of the lesion at each place (n, 3), mm, NaN where there is none, and whether
    the place is in it by more than its ends are known to."""
    found = np.full(len(places), np.nan)
    is_deep = np.zeros(len(places), dtype=bool)
    for lesion in lesions:
        line = lesion.line
        nearest, whole = line.nearest(places), line.length
        along = nearest.arc_lengths
        healthy = np.interp(along, line.arc_lengths, lesion.healthy)
        # Beyond an end of the line its end is the nearest, up to rounding.
        inside = (along > _SAME) & (along < whole - _SAME) & (nearest.distances <= healthy / 2)
        found[inside] = np.fmin(found, healthy)[inside]
        is_deep |= inside & (np.minimum(along, whole - along) > NOTICED)
    return found, is_deep


def _in_junction(places: Floats, lumen: Floats, lesions: Sequence[Lesion]) -> Flags:
    """Mask (n,) of the spheres of a junction, for a lesion begins or ends at it within them."""
    ends = [
        lesion.line.points[end]
        for lesion in lesions
        for side, end in ((lesion.proximal, 0), (lesion.distal, -1))
        if side is None
    ]
    away = np.linalg.norm(places[:, None] - np.reshape(ends, (-1, 3)), axis=2)
    return np.asarray((away < lumen[:, None] / 2).any(axis=1))


def _widest_near(along: Floats, widths: Floats, reach: Floats) -> Floats:
    """The greatest known one of some widths within a reach of each station (n,), mm."""
    near = np.abs(along[:, None] - along[None, :]) <= reach[:, None]
    return np.asarray(np.fmax.reduce(np.where(near, widths[None, :], np.nan), axis=1))
