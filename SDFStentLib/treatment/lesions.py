"""What stents do to a vessel's lesions, and where a stent goes that treats one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..centerline import Centerline
from ..geometry import Surface, arc_lengths, length
from ..measure import Lesion, lesions_after, lesions_within, moved_wall
from ..stent import DEFAULT_FORESHORTENING, AtCenter, AtDistalEnd
from ..validation import Points, as_number
from .value import PlacedStent

_LEAST_LEFT = 0.5
"""Percent, by diameter or by area; less is told as 0 %, or as wider than the reference."""


@dataclass(frozen=True)
class TreatedLesion:
    """A lesion before and after a treatment, against the same reference.

    Attributes
    ----------
    number : int
        Among the vessel's lesions, from 1 for the tightest.
    before, after : Lesion
        The same part of the vessel before any stent and after all of them.
    stents : tuple of int
        Numbers of the stents that cover its narrowest place.
    is_left_beyond : bool
        Whether something is left of it, and what is narrowest then lies beyond all of the stents.
    """

    number: int
    before: Lesion
    after: Lesion
    stents: tuple[int, ...]
    is_left_beyond: bool = False


def treated_lesions(
    lesions: Sequence[Lesion],
    stents: Sequence[PlacedStent],
    after: Surface,
    before: Surface | None = None,
) -> tuple[TreatedLesion, ...]:
    """All lesions of a vessel with what a treatment left of them.

    Parameters
    ----------
    lesions : sequence of Lesion
        `find_lesions` of the vessel before treatment.
    stents : sequence of PlacedStent
        Where they lie, such as those of a result.
    after : Surface
        After all stents.
    before : Surface, optional
        Before any, the same triangles: lesions far from what has moved stay what they are.
    """
    moved = None if before is None else moved_wall(before, after)
    left = lesions_after(lesions, after, moved)
    treated = []
    for number, pair in enumerate(zip(lesions, left, strict=True), start=1):
        covering, left_in = (
            tuple(stent.number for stent in stents if lesions_within([one], stent.axis.points))
            for one in pair
        )
        percents = pair[1].percent_diameter, pair[1].percent_area
        is_left = any(percent >= _LEAST_LEFT for percent in percents)
        treated.append(TreatedLesion(number, *pair, covering, is_left and not left_in))
    return tuple(treated)


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
        The second where the way down from the middle would go into another branch than the
        lesion's, which is rarely the widest one.

    Raises
    ------
    InputError
        A length that is not above 0.
    """
    nominal = as_number(stent_length, "stent length", unit="mm", above=0)
    half = nominal * (1 - foreshortening_fraction) / 2
    extent = length(lesion.line)
    narrowest = lesion.arc_length - lesion.start
    at = min(max(extent / 2, narrowest - half / 2), narrowest + half / 2)
    middle = _on_line(lesion, at)
    if lesions_within([lesion], centerline.path_around(middle, 2 * half).points):
        return AtCenter(middle)
    if at + half <= extent:
        return AtDistalEnd(_on_line(lesion, at + half))
    beyond = centerline.path_from_proximal(lesion.line[-1], at + half - extent)
    return AtDistalEnd(beyond.points[-1])


def _on_line(lesion: Lesion, at: float) -> Points:
    """The place of a lesion's line at an arc length from its start, mm."""
    along = arc_lengths(lesion.line)
    return np.array([np.interp(at, along, column) for column in lesion.line.T])
