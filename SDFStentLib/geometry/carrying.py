"""A straight body laid along a line, such as a stent along its axis."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..validation import Floats, Points, as_number, as_points
from .bends import frames_along
from .line import Line

WINDOW = 2.0
"""Half the length, mm, of the chord that gives the direction of the line at its middle."""

STATIONS_PER_WINDOW = 8
MOST_STATIONS = 20_000


class _Guide(NamedTuple):
    """A line with frames of minimal twist at even stations."""

    line: Line
    frames: Floats

    def laid(self, points: Points, at: Floats) -> Points:
        """Points (n, 3) laid across the line at arc lengths (n,), mm; only their x and y count."""
        inside = np.clip(at, 0.0, self.line.length)
        place = inside / self.line.length * (len(self.frames) - 1)
        first = np.minimum(place.astype(np.int64), len(self.frames) - 2)
        weight = (place - first)[:, None, None]
        mixed = (1 - weight) * self.frames[first] + weight * self.frames[first + 1]
        along = _unit(mixed[:, 0])
        normal = _unit(mixed[:, 1] - np.sum(mixed[:, 1] * along, axis=1)[:, None] * along)
        across = np.cross(along, normal)
        # Beyond the ends the line goes straight on.
        center = self.line.at(inside) + (at - inside)[:, None] * along
        return np.asarray(center + points[:, :1] * normal + points[:, 1:2] * across)


def carried(
    points: ArrayLike,
    line: Line,
    *,
    middle: float | None = None,
    window: float = WINDOW,
) -> Points:
    """A straight body laid along a line without twist.

    Sections across z become sections across the line: every point keeps its distance from the
    axis, and its arc length along it is its z. Where the line bends more tightly than the body is
    wide, sections cross on the inner side.

    Parameters
    ----------
    points : array_like, shape (n, 3)
        Points of the body, mm: its axis is z, its middle z = 0.
    line : Line
        Line along which the body is laid, mm; beyond its ends it goes straight on.
    middle : float, optional
        Arc length of the line to which the body's middle goes, mm; by default the line's middle.
    window : float
        Half the length, mm, of the chord that gives the line's direction, so that jitter of the
        line does not tilt the sections.

    Returns
    -------
    array, shape (n, 3)

    Raises
    ------
    InputError
        A line without length, or values that are not finite.
    """
    body = as_points(points, "points")
    guide = _guide(line.without_repeats(), window)
    start = guide.line.length / 2 if middle is None else as_number(middle, "middle", unit="mm")
    return guide.laid(body, start + body[:, 2])


def _guide(line: Line, window: float) -> _Guide:
    line.check_length()
    total = line.length
    reach = as_number(window, "window", unit="mm", above=0)
    count = int(np.clip(STATIONS_PER_WINDOW * total / reach, 16, MOST_STATIONS)) + 1
    at = np.linspace(0.0, total, count)
    # The direction is that of a parabola through three places: at its middle that of the chord,
    # which on an arc is the arc's own; near the ends of the line, where the middle of the parabola
    # stays behind, its slope goes on turning as the line bends.
    room = min(reach, total / 2)
    middle = np.clip(at, room, total - room)
    before, here, after = (line.at(middle + way * room) for way in (-1, 0, 1))
    bend = (after - here) - (here - before)
    along = (after - before) / 2 + ((at - middle) / room)[:, None] * bend
    return _Guide(line, frames_along(_unit(along)))


def _unit(vectors: Floats) -> Floats:
    sizes = np.linalg.norm(vectors, axis=-1, keepdims=True)
    # A line that turns back exactly has no direction there; any will do.
    return np.where(sizes > 1e-12, vectors / np.maximum(sizes, 1e-12), [0.0, 0.0, 1.0])
