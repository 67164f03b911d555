"""From where a before-and-after picture is taken, and where its labels go."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...geometry import across, length, point_at
from ...validation import Floats, Points

WIDEST = 1.6
"""The whole vessel is shown when that takes at most this much more than the stented part."""

VIEW_POINTS = 2000
"""About as many surface points judge a view; more change nothing but the time."""

VIEWS = 72
"""Directions around the stents that are tried, every 5 degrees."""

FRONT = {"RAS": (0.0, 1.0, 0.0), "LPS": (0.0, -1.0, 0.0), None: (0.0, 0.0, 0.0)}
"""Where the patient's front is, by the frame of the surface."""


class View(NamedTuple):
    """A parallel projection.

    Attributes
    ----------
    focus : (3,) array
        Point in the middle of the picture, mm.
    toward_camera, up : (3,) arrays
        Unit vectors, perpendicular to each other.
    half_height : float
        Half the height of what the picture shows, mm.
    """

    focus: Floats
    toward_camera: Floats
    up: Floats
    half_height: float

    def flat(self, points: Points) -> Floats:
        """Where (n, 3) points are in the picture: (n, 2), mm to the right and up of its middle."""
        right = np.cross(self.up, self.toward_camera)
        return (points - self.focus) @ np.stack([right, self.up], axis=1)


def best_view(
    axes: Sequence[Points], radius: float, cloud: Points, aspect: float, frame: str | None
) -> View:
    """The view in which the stents lie flat, hidden by nothing, and the branching spreads out.

    Parameters
    ----------
    axes : sequence of (k, 3) arrays
        Stent axes, mm.
    radius : float
        Largest radius of a stent, mm.
    cloud : (n, 3) array
        Surface points before and after, mm.
    aspect : float
        Width over height of the picture.
    frame : str or None
        Of two opposite views, equally good, the one from the patient's front is taken.

    Returns
    -------
    View
        Across the main direction of the stents. Of such directions the one with the fewest wall
        points in front of a stent, and the least depth of stents and surroundings, is taken;
        the head (z) is up unless the view is along it.
    """
    stations = np.concatenate([point_at(axis, np.linspace(0, length(axis), 25)) for axis in axes])
    reach = max(1.3 * max(map(length, axes)), 6 * radius)
    some = cloud[:: max(1, len(cloud) // (4 * VIEW_POINTS))]
    far = np.min([np.linalg.norm(some - each, axis=1) for each in stations], axis=0)
    nearby = some[far < reach]
    judges = nearby[:: max(1, len(nearby) // VIEW_POINTS)]
    main = np.linalg.svd(stations - stations.mean(axis=0))[2][:1]
    first, second = across(main)[0]
    angles = np.arange(VIEWS)[:, None] * (2 * np.pi / VIEWS)
    directions = np.cos(angles) * first + np.sin(angles) * second
    penalties = [_penalty(way, stations, judges, radius) for way in directions]
    way = directions[int(np.argmin(penalties - 0.03 * directions @ FRONT[frame]))]

    up = np.array([0.0, 0.0, 1.0]) if abs(way[2]) < 0.95 else np.array([0.0, 1.0, 0.0])
    up = up - (up @ way) * way
    view = View(stations.mean(axis=0), way, up / np.linalg.norm(up), radius)
    close, whole = (_framed(view, np.vstack([part, stations]), aspect) for part in (nearby, cloud))
    # All of the vessel when it is not much larger than the surroundings of the stents.
    return whole if whole.half_height < WIDEST * close.half_height else close


def label_side(flat: Floats, center: Floats, gap: float, size: Floats) -> Floats:
    """Where a label (width and height `size`) beside a `center` covers fewest points (n, 2).

    Returns
    -------
    (2,) array
        From the center to the middle of the label, to the right and up, mm; the nearer edge is
        `gap` away.
    """
    angles = np.arange(16) * (np.pi / 8)
    ways = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    places = ways * (gap + 0.5 * np.abs(ways) @ size)[:, None]
    covered = [
        int((np.abs(flat - center - place) < 0.6 * size).all(axis=1).sum()) for place in places
    ]
    return np.asarray(places[int(np.argmin(covered))])


def _framed(view: View, points: Points, aspect: float) -> View:
    """The same direction, with all points in the picture, with a margin."""
    flat = view.flat(points)
    width, height = np.ptp(flat, axis=0)
    x, y = (flat.min(axis=0) + flat.max(axis=0)) / 2
    focus = view.focus + x * np.cross(view.up, view.toward_camera) + y * view.up
    half_height = max(0.54 * float(height), 0.54 * float(width) / aspect, view.half_height)
    return view._replace(focus=focus, half_height=half_height)


def _penalty(way: Floats, stations: Points, cloud: Points, radius: float) -> float:
    """How badly a direction shows the stents: covered, or with depth, or from above."""
    flat = across(way[None])[0].T
    away = np.linalg.norm((cloud @ flat)[:, None] - stations @ flat, axis=2)
    depth, ahead = stations @ way, cloud @ way
    covered = (away.min(axis=1) < radius) & (ahead - depth[away.argmin(axis=1)] > 1.6 * radius)
    size = np.linalg.norm(np.ptp(cloud, axis=0))
    spread = (np.ptp(depth) + np.std(ahead)) / size
    return float(4 * np.mean(covered) + spread + 0.05 * abs(way[2]))
