"""Whether a line goes to and fro, as one does that was traced from voxels or by a shaky hand."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..geometry import Line, dot
from ..validation import Floats

JAGGED = 20.0
"""Degrees by which at least half of the turns of a jagged line go to and fro. Those of the
anatomies do by 3 at most; with noise that makes it 20 they are 5 to 8 % longer than the vessel."""


def zigzag(lines: Sequence[Line]) -> float:
    """By how much lines turn to and fro, degrees: the median over their inner points.

    Turns in one direction, as in a bend, count as 0, however few points it has.
    """
    found = [_to_and_fro(line) for line in lines]
    turns = np.concatenate([np.empty(0), *found])
    return float(np.median(turns)) if len(turns) else 0.0


def _to_and_fro(line: Line) -> Floats:
    """How much every turn (k,) but the first turns back of the one before, degrees."""
    solid = line.pieces > 0
    ways = np.diff(line.points, axis=0)[solid] / line.pieces[solid, None]
    bends = np.diff(ways, axis=0)
    turns = np.degrees(np.arccos(np.clip(dot(ways[1:], ways[:-1]), -1.0, 1.0)))
    is_back = dot(bends[1:], bends[:-1]) < 0
    return np.where(is_back, np.minimum(turns[1:], turns[:-1]), 0.0)
