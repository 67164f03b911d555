"""Where a stent goes that treats a lesion, and how much of the lesion it leaves uncovered."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..centerline import Centerline
from ..geometry import Line
from ..stent import DEFAULT_FORESHORTENING, AtCenter, AtDistalEnd
from ..validation import Flags, Floats, Points, as_number
from ..vessel import Lesion, lesions_within

NOTICED = 1.0
"""Less of a lesion beyond the ends of a stent is not told, mm: a lesion's ends are not known to
better than the stations along its vessel."""

_SPACING = 0.1
_SAME = 1e-6


def uncovered_length(lesion: Lesion, axes: Sequence[Line]) -> float:
    """How much of a lesion is beyond the ends of stents with these axes, or in another
    vessel than they are, mm."""
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
        That of the vessel in which it was found.
    stent_length : float
        Nominal, mm.
    foreshortening_fraction : float
        Of the stent, as in `Stent`.

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
        and lesions_within([lesion], around)
        and uncovered_length(lesion, [around]) <= within
    ):
        return AtCenter(middle)
    if at + half <= extent:
        return AtDistalEnd(line.at(at + half))
    beyond = centerline.path_from_proximal(line.points[-1], at + half - extent)
    return AtDistalEnd(beyond.points[-1])
