"""How far the vessel lets a stent's axis be smoothed and straightened.

An axis that is moved leaves the middle of a bent lumen. Nearer to the wall than the facets are long
it pushes their corners apart to both sides, and outside of the lumen it pushes the wall inward: the
lumen would become narrower. So the axis goes where it shall only as long as it keeps away.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..cautions import Caution
from ..centerline import Centerline
from ..geometry import Surface, arc_lengths, resampled, smoothed_line
from ..geometry import length as length_of
from ..measure import LocalSurface
from ..stent import Stent, StentAxis, moved_axis, stent_axis, straightened
from ..validation import Points
from .in_lumen import Lumen
from .profile import with_profile

Floats = NDArray[np.float64]

KEPT = 0.5
"""Share of its distance from the wall that the axis keeps, or of the stent's radius if less."""

SPACING = 1.0
"""Of the places of the axis that are looked at, mm."""

ROUNDS = 64
"""Steps towards the goal. Each is proven to stay in the lumen, so that stopping early is safe."""

NOTICEABLE = 1e-3
"""Share of the way that is worth a word."""


class AxisChange(NamedTuple):
    """What is done to the axis of a stent."""

    straightening_fraction: float = 0.0
    """Share of the way to its chord."""
    smoothing_length: float = 0.0
    """As for `smoothed_line`, mm; before it is straightened."""


NONE = AxisChange()


def axis_in_vessel(
    stent: Stent,
    centerline: Centerline | None,
    vessel: Surface | Lumen,
    change: AxisChange = NONE,
    *,
    lies_on: StentAxis | None = None,
) -> StentAxis:
    """The axis of a stent, smoothed and straightened as asked for, as far as the vessel permits.

    Parameters and errors as for `stent_axis`; a warning tells where less than asked for was used.
    The vessel is given as its lumen where many axes are asked for. `InputError` for points of the
    placement outside of it.
    """
    lumen = vessel if isinstance(vessel, Lumen) else Lumen(vessel)
    axis = stent_axis(stent, centerline, lies_on=lies_on)
    if centerline is not None:
        lumen.check(stent.placement, centerline)
    # An earlier stent's has been moved already.
    if change.smoothing_length and lies_on is None:
        goal = smoothed_line(axis.points, change.smoothing_length)
        axis = _moved(axis, _Move(goal, 1.0, "smoothed-less"), stent, lumen.surface)
    if change.straightening_fraction and lies_on is None:
        goal = straightened(axis.points, 1.0)
        move = _Move(goal, change.straightening_fraction, "straightened-less")
        axis = _moved(axis, move, stent, lumen.surface)
    return with_profile(axis, stent, lumen.surface)


class _Move(NamedTuple):
    """Where an axis shall go."""

    goal: Points
    """(n, 3) of its points at the end of the way, mm."""
    fraction: float
    """Of the way that is asked for."""
    less: str
    """Kind of the warning that it goes less far."""


def _moved(native: StentAxis, move: _Move, stent: Stent, surface: Surface) -> StentAxis:
    used, place = permitted(native.points, move.goal, stent.radius, surface, move.fraction)
    points = (1 - used) * native.points + used * move.goal
    points[0], points[-1] = native.points[0], native.points[-1]
    axis = moved_axis(native, points, stent.radius)
    if used > move.fraction - NOTICEABLE:
        return axis
    x, y, z = place.tolist()
    fractions = {"fraction": used, "prescribed_fraction": move.fraction}
    limited = Caution(move.less, fractions, (x, y, z))
    return replace(axis, warnings=(*axis.warnings, limited))


def permitted(
    axis: Points, goal: Points, radius: float, vessel: Surface, fraction: float
) -> tuple[float, Points]:
    """The part of a way that keeps the axis off the wall.

    Every place of the axis goes along its way to the goal by steps no longer than the wall is
    away, less what it has to keep; so it cannot pass through one.

    Parameters
    ----------
    axis : (n, 3) array
        Before it is moved, mm.
    goal : (n, 3) array
        Its points at the end of their ways, mm.
    radius : float
        Of the stent, mm.
    vessel : Surface
    fraction : float
        Share of the way that is asked for.

    Returns
    -------
    float
        At most `fraction`.
    (3,) array
        Where the axis then is nearest to what it has to keep, mm.
    """
    start = resampled(axis, SPACING)
    at = np.linspace(0, 1, len(start)) * length_of(axis)
    way = np.stack([np.interp(at, arc_lengths(axis), one) for one in goal.T], axis=1) - start
    length = np.linalg.norm(way, axis=1)
    places = np.concatenate([start, start + fraction * way])
    surface = LocalSurface(vessel.points, vessel.triangles, places)
    distance = surface.distances(start)
    kept = KEPT * np.minimum(distance, radius)
    is_going = length * fraction > NOTICEABLE * radius
    done = np.where(is_going, 0.0, fraction)
    active = np.flatnonzero(is_going)
    for _ in range(ROUNDS):
        room = np.maximum(distance[active] - kept[active], 0)
        done[active] = np.minimum(done[active] + room / length[active], fraction)
        # Where the room is used up the others need not go on any farther.
        is_stopped = room < NOTICEABLE * radius
        limit = done[active[is_stopped]].min(initial=fraction)
        active = active[~is_stopped & (done[active] < limit)]
        if not len(active):
            break
        distance[active] = surface.distances(start[active] + done[active, None] * way[active])
    first = int(done.argmin())
    used = float(done[first])
    return used, start[first] + used * way[first]
