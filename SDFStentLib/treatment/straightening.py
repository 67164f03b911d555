"""How far the vessel lets a stent's axis be straightened.

A straightened axis leaves the middle of a bent lumen. Nearer to the wall than the facets are long
it pushes their corners apart to both sides, and outside of the lumen it pushes the wall inward: the
lumen would become narrower. So the axis goes towards its chord only as long as it keeps away.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..cautions import Caution
from ..centerline import Centerline
from ..geometry import Surface, resampled
from ..measure import LocalSurface
from ..stent import Stent, StentAxis, stent_axis, straightened, straightened_axis
from ..validation import Points
from .in_lumen import Lumen
from .profile import with_profile

Floats = NDArray[np.float64]

KEPT = 0.5
"""Share of its distance from the wall that the axis keeps, or of the stent's radius if less."""

SPACING = 1.0
"""Of the places of the axis that are looked at, mm."""

ROUNDS = 64
"""Steps towards the chord. Each is proven to stay in the lumen, so that stopping early is safe."""

NOTICEABLE = 1e-3
"""Share of the way to the chord that is worth a word."""


def axis_in_vessel(
    stent: Stent,
    centerline: Centerline | None,
    vessel: Surface | Lumen,
    straightening_fraction: float = 0.0,
    *,
    lies_on: StentAxis | None = None,
) -> StentAxis:
    """The axis of a stent, straightened as far as asked for and as the vessel permits.

    Parameters and errors as for `stent_axis`; a warning tells where less than asked for was used.
    The vessel is given as its lumen where many axes are asked for. `InputError` for points of the
    placement outside of it.
    """
    lumen = vessel if isinstance(vessel, Lumen) else Lumen(vessel)
    axis = stent_axis(stent, centerline, lies_on=lies_on)
    if centerline is not None:
        lumen.check(stent.placement, centerline)
    # An earlier stent's has been straightened already.
    if straightening_fraction and lies_on is None:
        axis = _straightened(axis, stent, lumen.surface, straightening_fraction)
    return with_profile(axis, stent, lumen.surface)


def _straightened(
    native: StentAxis, stent: Stent, surface: Surface, straightening_fraction: float
) -> StentAxis:
    used, place = permitted(native.points, stent.radius, surface, straightening_fraction)
    axis = straightened_axis(native, used, stent.radius)
    if used > straightening_fraction - NOTICEABLE:
        return axis
    x, y, z = place.tolist()
    fractions = {"fraction": used, "prescribed_fraction": straightening_fraction}
    limited = Caution("straightened-less", fractions, (x, y, z))
    return replace(axis, warnings=(*axis.warnings, limited))


def permitted(
    axis: Points, radius: float, vessel: Surface, fraction: float
) -> tuple[float, Points]:
    """The part of a straightening that keeps the axis off the wall.

    Every place of the axis goes along its way to the chord by steps no longer than the wall is
    away, less what it has to keep; so it cannot pass through one.

    Parameters
    ----------
    axis : (n, 3) array
        Before it is straightened, mm.
    radius : float
        Of the stent, mm.
    vessel : Surface
    fraction : float
        Share of the way to the chord that is asked for.

    Returns
    -------
    float
        At most `fraction`.
    (3,) array
        Where the axis then is nearest to what it has to keep, mm.
    """
    start = resampled(axis, SPACING)
    way = straightened(start, 1.0) - start
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
