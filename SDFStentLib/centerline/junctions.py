"""Junctions at which a path down a centerline had to choose a branch."""

from __future__ import annotations

from typing import Literal, NamedTuple

from ..validation import Floats

Rule = Literal["widest", "straightest", "nearest"]


class JunctionChoice(NamedTuple):
    """A junction where a path downstream chose the widest, the straightest or the nearest branch.

    The nearest is that of a place that lies within the junction's own sphere.
    """

    point: Floats
    rule: Rule
