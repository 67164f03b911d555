"""A bent axis made straighter or smoother without a change of its length.

Every piece of the axis keeps its length and turns by a share of the angle between it and its goal:
the chord, or the same piece of a smoother line. So bends lose that share of their curvature, the
two ends move apart, and a stent that is straightened or smoothed is as long as one that is not.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..geometry import Line, dot, norm
from ..validation import Floats, InputError, Points
from .stent import KEPT


class TurnedWay(NamedTuple):
    """Motion of the points of an axis as its pieces turn."""

    line: Line
    """Line before it moves."""
    along: Points
    """(n - 1, 3) directions of its pieces."""
    across: Points
    """(n - 1, 3) perpendicular to these, in the plane in which the piece turns."""
    angles: Floats
    """(n - 1,) angles between the pieces and their goals, rad."""
    keeps: str
    """Place that stays, as of `Stent`: the end that stays, or the middle between both."""

    def at(self, fraction: float) -> Line:
        """The axis at a fraction of the way, 0 to 1."""
        if fraction == 0:
            return self.line
        turned = (fraction * self.angles)[:, None]
        pieces = np.cos(turned) * self.along + np.sin(turned) * self.across
        points = np.zeros(self.line.points.shape)
        np.cumsum(self.lengths[:, None] * pieces, axis=0, out=points[1:])
        kept = _kept_place(self.line.points, self.keeps) - _kept_place(points, self.keeps)
        return Line(points + kept)

    @property
    def lengths(self) -> Floats:
        """Lengths (n - 1,) of the pieces, mm."""
        return norm(np.diff(self.line.points, axis=0))

    @property
    def longest(self) -> Floats:
        """(n,) mm that each point goes at most on the whole way, on its curve."""
        gone = np.r_[0.0, np.cumsum(self.lengths * self.angles)]
        return {
            "proximal": gone,
            "distal": gone[-1] - gone,
            "center": np.full(len(gone), gone[-1] / 2),
        }[self.keeps]


def straight_way(line: Line, keeps: str = "center") -> TurnedWay:
    """Motion of a polyline that becomes straight.

    Parameters
    ----------
    line : Line
        mm.
    keeps : {"center", "proximal", "distal"}
        Whether the middle between both ends stays where it is, or one of them.

    Raises
    ------
    InputError
        The polyline has no length, its ends are at one place, or `keeps` is another word.
    """
    chord = line.points[-1] - line.points[0]
    if not line.length > 0:
        raise InputError(
            "stent axis: expected two different points, got one place only; draw it longer."
        )
    if not chord.any():
        raise InputError(
            "stent axis: expected two ends apart to straighten it, got a closed line; leave "
            "straightening out, or draw it open."
        )
    return turned_way(line, np.broadcast_to(chord, (len(line) - 1, 3)), keeps)


def turned_way(line: Line, goals: Floats, keeps: str = "center") -> TurnedWay:
    """Motion of a polyline of which every piece turns toward a goal.

    Parameters
    ----------
    line, keeps
        As for `straight_way`.
    goals : array, shape (n - 1, 3)
        Goals of the pieces: directions of any length; a piece with a zero keeps its own.

    Raises
    ------
    InputError
        `keeps` is another word, or there is not one goal for each piece.
    """
    if keeps not in KEPT:
        raise InputError(f"keeps: expected one of {', '.join(KEPT)}, got {keeps!r}; choose one.")
    if len(goals) != len(line) - 1:
        raise InputError(
            f"goals: expected one for each of {len(line) - 1} pieces, got {len(goals)}; give "
            "as many."
        )
    steps = np.diff(line.points, axis=0)
    along = _unit(np.where(norm(steps)[:, None] > 0, steps, goals))
    goal = _unit(np.where(norm(goals)[:, None] > 0, goals, along))
    cosines = dot(along, goal)
    across = goal - cosines[:, None] * along
    sines = norm(across)
    # A piece that points back turns in any plane.
    across = _unit(np.where(sines[:, None] > 0, across, _perpendicular(along)))
    return TurnedWay(line, along, across, np.arctan2(sines, cosines), keeps)


def _kept_place(line: Points, keeps: str) -> Floats:
    ends = {"proximal": line[[0]], "distal": line[[-1]], "center": line[[0, -1]]}[keeps]
    return np.asarray(ends.mean(axis=0))


def _unit(vectors: Floats) -> Floats:
    """(n, 3) of length 1; zeros become any direction."""
    lengths = norm(vectors)[:, None]
    return np.where(lengths > 0, vectors / np.where(lengths > 0, lengths, 1.0), (0.0, 0.0, 1.0))


def _perpendicular(directions: Points) -> Points:
    """(n, 3) one to each of the directions (n, 3)."""
    axes = np.eye(3)[np.argmin(np.abs(directions), axis=1)]
    return np.cross(directions, axes)
