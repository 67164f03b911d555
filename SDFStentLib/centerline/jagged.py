"""Whether a line goes to and fro, as one traced from voxels or by a shaky hand does."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..geometry import Line, dot
from ..validation import Floats

JAGGED = 20.0
"""Median angle, degrees, by which lines turn to and fro, from which on they count as jagged. Lines
of the anatomies have 3 at most; with noise that makes it 20 they are 5 to 8 % longer than the
vessel."""


def zigzag(lines: Sequence[Line]) -> float:
    """The angle by which lines turn to and fro, degrees: the median over their inner points.

    Turns in one direction, as in a bend, count as 0, however few points it has.
    """
    found = [_to_and_fro(line) for line in lines]
    turns = np.concatenate([np.empty(0), *found])
    return float(np.median(turns)) if len(turns) else 0.0


def _to_and_fro(line: Line) -> Floats:
    """The part of every turn (k,) but the first that undoes the one before, degrees."""
    solid = line.pieces > 0
    ways = np.diff(line.points, axis=0)[solid] / line.pieces[solid, None]
    bends = np.diff(ways, axis=0)
    turns = np.degrees(np.arccos(np.clip(dot(ways[1:], ways[:-1]), -1.0, 1.0)))
    is_back = dot(bends[1:], bends[:-1]) < 0
    return np.where(is_back, np.minimum(turns[1:], turns[:-1]), 0.0)
