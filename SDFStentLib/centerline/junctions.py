"""Junctions at which a path down a centerline had to choose a branch."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from ..validation import Floats, Indices, read_only

Rule = Literal["widest", "longest", "nearest"]


class JunctionChoice(NamedTuple):
    """A junction where a path downstream chose the widest, the longest or the nearest branch.

    The nearest is that of a place that lies within the junction's own sphere.
    """

    point: Floats
    rule: Rule


def chosen_by_place(
    points: Floats, radius: Floats, distance: Floats, child_counts: Indices
) -> list[JunctionChoice]:
    """The junction in whose sphere a place lies, on one of the branches below it; else none.

    Parameters
    ----------
    points, radius, distance, child_counts : arrays, shapes (n, 3) and (n,)
        Of the centerline's points above the place, down from the root: where they are, inscribed
        radius, distance from the place along the centerline (mm), number of children.
    """
    junctions = np.flatnonzero(child_counts > 1)
    if not len(junctions):
        return []
    last = junctions[-1]
    # At the junction itself the path chooses, and says so.
    if not 1e-9 < distance[last] < radius[last]:
        return []
    return [JunctionChoice(read_only(points[last]), "nearest")]
