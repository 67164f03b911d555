"""Which of many balls come near which of many places, by halving both again and again.

Places are halved across their widest extent, balls are left out that do not reach the box round
what is left. No tree is built: a search costs a few passes over the balls, and what it finds.
"""

from __future__ import annotations

import numpy as np

from ..validation import Floats, Indices, Points
from .rows import dot, product

_TOGETHER, _FEW = 16, 64
"""So many places, or balls, are paired at once, without halving once more."""

_SLACK = 1e-12
"""What rounding may do to a sum, or to a difference of squares, over its largest term."""


def near_balls(
    places: Points, reach: Floats, middles: Points, radii: Floats
) -> tuple[Indices, Indices]:
    """Pairs of a place and a ball whose surfaces are at most `reach` of the place apart.

    Parameters
    ----------
    places, reach : (n, 3) and (n,) arrays
    middles, radii : (m, 3) and (m,) arrays
        Of the balls.

    Returns
    -------
    place, ball : (p,) arrays of int
        Sorted by place, then by ball. All pairs that are near enough; of others only those that
        rounding cannot tell from them.
    """
    columns = np.ascontiguousarray(middles.T)
    found = [(np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64))]
    todo = [(np.arange(len(places)), np.arange(len(middles)))]
    # Ends: every part is half of another, and parts of a few are not halved.
    while todo:
        ours, theirs = todo.pop()
        theirs = _in_box(places.take(ours, axis=0), reach[ours], columns, radii, theirs)
        if len(ours) <= _TOGETHER or len(theirs) <= _FEW:
            one, other = _near_all(
                places.take(ours, axis=0), reach[ours], middles.take(theirs, axis=0), radii[theirs]
            )
            found.append((ours.take(one), theirs.take(other)))
            continue
        half = len(ours) // 2
        widest = int(np.ptp(places[ours], axis=0).argmax())
        order = np.argpartition(places[ours, widest], half)
        todo += [(np.sort(ours[part]), theirs) for part in (order[:half], order[half:])]
    place, ball = (np.concatenate(column) for column in zip(*found, strict=True))
    order = np.argsort(place, kind="stable")
    return place.take(order), ball.take(order)


def nearest_distances(places: Points, points: Points) -> Floats:
    """Distance (n,) from every place to the nearest of some points; at least one."""
    # Late: scipy costs what a first frame should not pay.
    from scipy.spatial import cKDTree

    # The tree is asked once: it is made as quickly as can be.
    tree = cKDTree(points, balanced_tree=False, compact_nodes=False)
    return np.asarray(tree.query(places)[0])


def _in_box(
    places: Points, reach: Floats, columns: Floats, radii: Floats, which: Indices
) -> Indices:
    """Those of the balls that come into the box round all that is within reach."""
    radius = radii if len(which) == len(radii) else radii.take(which)
    for column, coordinates in zip(columns, places.T, strict=True):
        low = (coordinates - reach).min(initial=np.inf)
        high = (coordinates + reach).max(initial=-np.inf)
        slack = _SLACK * (abs(low) + abs(high)) if len(coordinates) else 0.0
        low, high = low - slack, high + slack
        middle = column.take(which)
        meets = (middle + radius >= low) & (middle - radius <= high)
        which, radius = which.compress(meets), radius.compress(meets)
    return which


def _near_all(
    places: Points, reach: Floats, middles: Points, radii: Floats
) -> tuple[Indices, Indices]:
    """The same from all pairs.

    Squares are compared, |a - b|^2 <= (r + s)^2 with all that is mixed in one product of matrices;
    what rounding may do to a difference of large squares is let through.
    """
    if not len(middles) or not len(places):
        return np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
    origin = middles.mean(axis=0)
    theirs, ours = middles - origin, places - origin
    squared, own = dot(theirs, theirs), dot(ours, ours)
    left = np.column_stack([ours, reach, np.full(len(ours), -0.5)])
    right = np.vstack([theirs.T, radii, squared - radii**2])
    slack = _SLACK * (squared.max() + own.max() + (reach.max() + radii.max()) ** 2)
    limit = (own - reach**2 - slack) / 2
    one, other = np.divmod(np.flatnonzero(product(left, right) >= limit[:, None]), len(middles))
    return one, other
