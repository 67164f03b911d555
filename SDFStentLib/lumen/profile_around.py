"""Diameters along a stent and beyond both of its ends."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..geometry import Line, Surface
from ..validation import Flags, Floats, Points
from .extended_axis import ExtendedAxis
from .metrics import DiameterProfile, profile_of
from .stations import SPACING, Stations
from .tolerances import NOTHING


class AxisStations(NamedTuple):
    """Stations along an extended axis: the ends of the stent are among them.

    Attributes
    ----------
    arc_length : (n,) array
        Positions from the proximal end of the stent, mm; negative proximal of it.
    points, directions : (n, 3) arrays
        Points, mm, and unit directions of the axis.
    own : slice
        The stations along the stent.
    parts : tuple of slice
        The parts before, beyond and along the stent; the ends of the stent are in two.
    """

    arc_length: Floats
    points: Points
    directions: Points
    own: slice
    parts: tuple[slice, ...]


def axis_stations(axis: ExtendedAxis, spacing: float = SPACING) -> AxisStations:
    """Stations of about equal spacing, mm, beyond each end and along the stent."""
    last = axis.before + axis.stent_length
    # The ends of the stent are stations of its own part.
    columns = [_part(axis.of_stent, spacing, 0.0)]
    first, count = 0, len(columns[0][0])
    if axis.before > NOTHING:
        proximal = _part(axis.line.cut(0.0, axis.before), spacing, -axis.before)
        first = len(proximal[0]) - 1
        columns.insert(0, tuple(column[:-1] for column in proximal))
    if axis.after > NOTHING:
        distal = _part(axis.line.cut(last, np.inf), spacing, axis.stent_length)
        columns.append(tuple(column[1:] for column in distal))
    arc_length, points, directions = map(np.concatenate, zip(*columns, strict=True))
    own = slice(first, first + count)
    beside = slice(0, own.start + 1), slice(own.stop - 1, len(points))
    parts = [part for part in beside if part.stop - part.start > 1]
    return AxisStations(arc_length, points, directions, own, (*parts, own))


def _part(line: Line, spacing: float, start: float) -> tuple[Floats, ...]:
    even = line.resampled(spacing)
    return start + even.arc_lengths, even.points, even.directions


def profile_around(
    surface: Surface, stations: AxisStations, measured: Stations, caps: Flags
) -> DiameterProfile:
    """The profile of a stent and its surroundings; the profile of the stent alone is a part of it.

    Parameters
    ----------
    surface : Surface
        mm.
    stations : AxisStations
        Stations along the extended axis of the stent.
    measured : Stations
        The results there.
    caps : (m,) bool array
        The triangles that were in flat caps before any stent.

    Returns
    -------
    DiameterProfile
        Positions count from the proximal end of the stent. Vessels may be closed at both ends of
        the extended axis, not at those of the stent.
    """
    return profile_of(surface, stations.arc_length, measured, caps, stations.parts)
