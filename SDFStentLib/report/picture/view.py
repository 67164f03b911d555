"""From where a before-and-after picture is taken, and where its labels go."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...geometry import arc_lengths, closest_points, length, resampled, tangents
from ...validation import Floats, Points

WIDEST = 1.6
"""The whole vessel is shown when that takes at most this much more than the stented part."""

VIEW_POINTS = 5000
"""About as many surface points judge a view; more change nothing but the time."""

VIEWS = 72
"""Directions around the stent that are tried, every 5 degrees."""


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

    @property
    def right(self) -> Floats:
        """Unit vector to the right of the picture."""
        return np.cross(self.up, self.toward_camera)


def best_view(
    axis: Points,
    radius: float,
    clouds: tuple[Points, Points],
    aspect: float = 1.0,
    anterior: tuple[float, float, float] = (0.0, 1.0, 0.0),
) -> View:
    """The view in which the stent lies flat, hidden by nothing, and the branching spreads out.

    Parameters
    ----------
    axis : (k, 3) array
        Stent axis, mm.
    radius : float
        Largest radius of the stent, mm.
    clouds : two (n, 3) arrays
        Surface points before and after, mm.
    aspect : float
        Width over height of the picture.
    anterior : (3,) floats
        Where the patient's front is (RAS: +y, LPS: -y); of two opposite views, equally good,
        the one from there is taken.

    Returns
    -------
    View
        Across the chord of the stent. Of such directions the one with the fewest wall points in
        front of the stent, and the least depth of stent and surroundings, is taken; the head
        (z) is up unless the view is along it.
    """
    reach = max(1.3 * length(axis), 6 * radius)
    step = max(1, len(clouds[0]) // VIEW_POINTS)
    nearby = [_near(cloud[::step], axis, reach) for cloud in clouds]
    scene = np.vstack([*nearby, axis])
    directions = _directions_across(axis[-1] - axis[0], axis)
    stations = resampled(axis, max(length(axis) / 24, 1e-6))
    penalties = [
        _penalty(direction, stations, nearby[0], radius) - 0.03 * float(direction @ anterior)
        for direction in directions
    ]
    direction = directions[int(np.argmin(penalties))]

    up = np.array([0.0, 0.0, 1.0]) if abs(direction[2]) < 0.95 else np.array([0.0, 1.0, 0.0])
    up = up - (up @ direction) * direction
    up = up / np.linalg.norm(up)
    right = np.cross(up, direction)
    (close, half), (far, whole) = (
        _frame(points @ np.stack([right, up], axis=1), aspect)
        for points in (scene, np.vstack([*clouds, axis]))
    )
    # All of the vessel when it is not much larger than the surroundings of the stent.
    middle, half_height = (far, whole) if whole < WIDEST * half else (close, half)
    depth = float((scene @ direction).mean())
    focus = middle[0] * right + middle[1] * up + depth * direction
    return View(focus, direction, up, max(half_height, radius))


def label_side(view: View, cloud: Points, center: Floats, gap: float, size: Floats) -> Floats:
    """Where a label beside a point covers least of the vessel.

    Parameters
    ----------
    view : View
    cloud : (n, 3) array
        Surface points, mm.
    center : (3,) array
        What the label belongs to, mm.
    gap : float
        Distance of the label from it, mm.
    size : (2,) array
        Width and height of the label, mm.

    Returns
    -------
    (2,) array
        From the point to the middle of the label, to the right and up, mm.
    """
    flat = (cloud - center) @ np.stack([view.right, view.up], axis=1)
    angles = np.arange(16) * (np.pi / 8)
    ways = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    places = ways * (gap + 0.5 * np.abs(ways) @ size)[:, None]
    covered = [
        int((np.abs(flat - place) < 0.6 * np.asarray(size)).all(axis=1).sum()) for place in places
    ]
    return np.asarray(places[int(np.argmin(covered))])


def _frame(flat: Floats, aspect: float) -> tuple[Floats, float]:
    """Middle and half height of a picture that shows points (n, 2), with a margin."""
    lower, upper = flat.min(axis=0), flat.max(axis=0)
    width, height = upper - lower
    return (lower + upper) / 2, 0.54 * max(float(height), float(width) / aspect)


def _near(cloud: Points, axis: Points, reach: float) -> Points:
    return cloud[closest_points(axis, cloud).distances < reach]


def _directions_across(chord: Floats, axis: Points) -> Floats:
    """Unit vectors across the chord, starting with the horizontal one nearest to the front."""
    if np.linalg.norm(chord) < 1e-3 * length(axis):
        chord = tangents(axis)[0]  # a closed loop has no chord
    chord = chord / np.linalg.norm(chord)
    start = np.cross(chord, [0.0, 0.0, 1.0])
    if np.linalg.norm(start) < 0.1:
        start = np.array([0.0, 1.0, 0.0])
    start = start - (start @ chord) * chord
    start = start / np.linalg.norm(start)
    angles = np.arange(VIEWS)[:, None] * (2 * np.pi / VIEWS)
    return np.asarray(np.cos(angles) * start + np.sin(angles) * np.cross(chord, start))


def _penalty(direction: Floats, stations: Points, cloud: Points, radius: float) -> float:
    """How badly a direction shows the stent: covered, or with depth, or from above."""
    flat = np.eye(3) - np.outer(direction, direction)
    foot = closest_points(stations @ flat, cloud @ flat)
    nearest = np.argmin(np.abs(arc_lengths(stations @ flat)[:, None] - foot.arc_lengths), axis=0)
    ahead = cloud @ direction - stations[nearest] @ direction
    covered = np.mean((foot.distances < radius) & (ahead > 1.6 * radius)) if len(cloud) else 0.0
    size = np.linalg.norm(np.ptp(cloud, axis=0)) if len(cloud) else 1.0
    depth = (np.ptp(stations @ direction) + np.std(cloud @ direction)) / size
    return float(4 * covered + depth + 0.05 * abs(direction[2]))
