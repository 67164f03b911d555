"""The view of a before-and-after picture, and where its labels go."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...geometry import Line, across
from ...validation import Floats, Points

WIDTH, HEIGHT = 1200, 700
"""The size of a picture of two panels, pixels."""

PANEL_WIDTH = WIDTH // 2
"""pixels."""

TOP, BOTTOM = 105, 602
"""Rows between which the vessel is; words are above, scales below."""

WIDEST = 1.6
"""The whole vessel is shown when that takes at most this much more than the stented part."""

VIEW_POINTS = 2000
"""About as many surface points judge a view; more change nothing but the time."""

VIEWS = 72
"""Directions around the stents that are tried, every 5 degrees."""

FRONT = {"RAS": (0.0, 1.0, 0.0), "LPS": (0.0, -1.0, 0.0), None: (0.0, 0.0, 0.0)}
"""Direction to the patient's front, by the frame of the surface."""


class Viewpoint(NamedTuple):
    """A parallel projection: the point (3,) in its middle, mm, and unit vectors (3,) across."""

    focus: Floats
    toward_camera: Floats
    up: Floats
    half_height: float
    """Half the height of what the picture shows, mm."""

    def flat(self, points: Points) -> Floats:
        """Places (n, 2) of points (n, 3) in the picture, mm to the right and up of its middle."""
        right = np.cross(self.up, self.toward_camera)
        return (points - self.focus) @ np.stack([right, self.up], axis=1)

    @property
    def per_mm(self) -> float:
        """Scale of the picture, pixels/mm."""
        return (BOTTOM - TOP) / 2 / self.half_height

    def pixels(self, points: Points) -> Floats:
        """Pixels (n, 2) of points (n, 3) in the left panel, right of and down from the corner."""
        middle = np.array([PANEL_WIDTH / 2, (TOP + BOTTOM) / 2])
        return np.asarray(middle + self.per_mm * self.flat(points) * (1, -1))

    def framing(self, points: Points, aspect: float) -> Viewpoint:
        """Viewpoint of the same direction, with all points in a picture of that width over
        height."""
        flat = self.flat(points)
        width, height = np.ptp(flat, axis=0)
        x, y = (flat.min(axis=0) + flat.max(axis=0)) / 2
        focus = self.focus + x * np.cross(self.up, self.toward_camera) + y * self.up
        half_height = max(0.54 * float(height), 0.54 * float(width) / aspect, self.half_height)
        return self._replace(focus=focus, half_height=half_height)


def best_view(
    axes: Sequence[Line], radius: float, cloud: Points, aspect: float, frame: str | None
) -> Viewpoint:
    """The view in which the stents lie flat, and the vessels around them beside each other.

    Parameters
    ----------
    axes : sequence of Line
        Stent axes, mm.
    radius : float
        Largest radius of a stent, mm.
    cloud : (n, 3) array
        Surface points before and after, mm.
    aspect : float
        Width over height of the picture.
    frame : str or None
        Patient frame: of two opposite views, equally good, that from the front is taken.

    Returns
    -------
    Viewpoint
        Across the main direction of the stents; of such directions the one along which stents
        and surroundings are least deep, so that little lies before them. The head (z) is up
        unless the view is along it.
    """
    stations = np.concatenate([axis.at(np.linspace(0, axis.length, 25)) for axis in axes])
    reach = max(1.3 * max(axis.length for axis in axes), 6 * radius)
    some = cloud[:: max(1, len(cloud) // (4 * VIEW_POINTS))]
    far = np.min([np.linalg.norm(some - each, axis=1) for each in stations], axis=0)
    nearby = np.vstack([some[far < reach], stations])

    first, second = across(np.linalg.svd(stations - stations.mean(axis=0))[2][:1])[0]
    angles = np.arange(VIEWS)[:, None] * (2 * np.pi / VIEWS)
    ways = np.cos(angles) * first + np.sin(angles) * second
    deep = np.std(nearby @ ways.T, axis=0) + np.ptp(stations @ ways.T, axis=0)
    share = deep / np.linalg.norm(np.ptp(nearby, axis=0))
    way = ways[np.argmin(share + 0.05 * np.abs(ways[:, 2]) - 0.03 * ways @ FRONT[frame])]

    up = np.array([0.0, 0.0, 1.0]) if abs(way[2]) < 0.95 else np.array([0.0, 1.0, 0.0])
    up = up - (up @ way) * way
    view = Viewpoint(stations.mean(axis=0), way, up / np.linalg.norm(up), radius)
    close, whole = view.framing(nearby, aspect), view.framing(cloud, aspect)
    return whole if whole.half_height < WIDEST * close.half_height else close


def label_side(
    flat: Floats, center: Floats, gap: float, size: Floats, labels: Floats | None = None
) -> Floats:
    """Offset of a label (width and height `size`) by a `center` that covers fewest points (n, 2).

    It covers the middles of other `labels` (k, 2) less gladly than all points.

    Returns
    -------
    (2,) array
        From the center to the middle of the label, to the right and up, mm; the nearer edge is
        `gap` away.
    """
    angles = np.arange(16) * (np.pi / 8)
    ways = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    places = ways * (gap + 0.5 * np.abs(ways) @ size)[:, None]

    def covered(points: Floats, place: Floats) -> int:
        return int((np.abs(points - center - place) < 0.6 * size).all(axis=1).sum())

    others = np.empty((0, 2)) if labels is None else labels
    worth = len(flat) + 1
    costs = [covered(flat, place) + worth * covered(others, place) for place in places]
    return np.asarray(places[np.argmin(costs)])
