"""A bent axis made straighter without a change of its length.

Every piece of the axis keeps its length and turns towards the chord, by a share of the angle
between them. So bends lose that share of their curvature, the two ends move apart along the chord,
and a stent that is straightened is as long as one that is not.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..geometry import arc_lengths
from ..validation import Floats, InputError, Points, as_number, as_points
from .stent import KEPT


class StraightWay(NamedTuple):
    """How the points of an axis go when it is straightened."""

    points: Points
    """(n, 3) as they are, mm."""
    lengths: Floats
    """(n - 1,) of the pieces between them, mm."""
    along: Points
    """(n - 1, 3) their directions."""
    across: Points
    """(n - 1, 3) perpendicular to these, in the plane in which the piece turns."""
    angles: Floats
    """(n - 1,) to the chord, rad."""
    keeps: str
    """As of `Stent`: the end that stays, or the middle between both."""

    def at(self, fraction: float) -> Points:
        """The points at a fraction of the way, 0 to 1."""
        if fraction == 0:
            return self.points
        turned = (fraction * self.angles)[:, None]
        pieces = np.cos(turned) * self.along + np.sin(turned) * self.across
        line = np.zeros(self.points.shape)
        np.cumsum(self.lengths[:, None] * pieces, axis=0, out=line[1:])
        return line + (_kept_place(self.points, self.keeps) - _kept_place(line, self.keeps))

    @property
    def longest(self) -> Floats:
        """(n,) mm that each point goes at most on the whole way, on its curve."""
        gone = np.r_[0.0, np.cumsum(self.lengths * self.angles)]
        return {
            "proximal": gone,
            "distal": gone[-1] - gone,
            "center": np.full(len(gone), gone[-1] / 2),
        }[self.keeps]


def straight_way(points: ArrayLike, keeps: str = "center") -> StraightWay:
    """How a polyline becomes straight.

    Parameters
    ----------
    points : array_like, shape (n, 3)
        Polyline, mm.
    keeps : {"center", "proximal", "distal"}
        Whether the middle between both ends stays where it is, or one of them.

    Raises
    ------
    InputError
        The polyline has no length, its ends are at one place, or `keeps` is another word.
    """
    polyline = as_points(points, "polyline", minimum=2)
    if keeps not in KEPT:
        raise InputError(f"keeps: expected one of {', '.join(KEPT)}, got {keeps!r}.")
    at, chord = arc_lengths(polyline), polyline[-1] - polyline[0]
    if at[-1] <= 0:
        raise InputError("stent axis: expected two different points, got one place only.")
    if not chord.any():
        raise InputError("stent axis: expected two ends apart to straighten it, got a closed line.")
    lengths = np.diff(at)
    steps, goal = np.diff(polyline, axis=0), chord / np.linalg.norm(chord)
    along = np.where(lengths[:, None] > 0, steps, goal)
    along = along / np.linalg.norm(along, axis=1)[:, None]
    across = goal - (along @ goal)[:, None] * along
    sines = np.linalg.norm(across, axis=1)
    # A piece that points back turns in any plane.
    across = np.where(sines[:, None] > 0, across, _perpendicular(along))
    across /= np.linalg.norm(across, axis=1)[:, None]
    return StraightWay(polyline, lengths, along, across, np.arctan2(sines, along @ goal), keeps)


def straightened(points: ArrayLike, fraction: float, keeps: str = "center") -> Points:
    """The polyline made straighter; every piece keeps its length.

    Parameters
    ----------
    points, keeps
        As for `straight_way`, errors likewise.
    fraction : float
        0 as it is, 1 straight: the share by which each piece turns from its own direction to that
        of the chord.

    Raises
    ------
    InputError
        The fraction is outside 0 to 1.
    """
    fraction = as_number(fraction, "straightening fraction", minimum=0, maximum=1)
    return straight_way(points, keeps).at(fraction)


def _kept_place(line: Points, keeps: str) -> Floats:
    ends = {"proximal": line[[0]], "distal": line[[-1]], "center": line[[0, -1]]}[keeps]
    return np.asarray(ends.mean(axis=0))


def _perpendicular(directions: Points) -> Points:
    """(n, 3) one to each of the directions (n, 3)."""
    axes = np.eye(3)[np.argmin(np.abs(directions), axis=1)]
    return np.cross(directions, axes)
