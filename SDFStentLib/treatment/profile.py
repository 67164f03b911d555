"""Stent in its turn: its diameters along its axis in the vessel."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..centerline import Centerline
from ..deformation import Deployment, DeploymentResult, DeploymentState
from ..geometry import Surface, nearest_distances
from ..lumen import off_caps
from ..stent import Stent, StentAxis
from ..validation import Floats
from .value import PlacedStent, labeled


def with_profile(axis: StentAxis, stent: Stent, surface: Surface) -> StentAxis:
    """The axis of a stent with the diameters that it has along it; unchanged for a cylinder.

    Raises
    ------
    InputError
        Ends that are together longer than the stent.
    """
    if stent.shape is None:
        return axis
    profile = stent.shape.along(
        stent.diameter, axis.deployed_length, narrowest_fraction(axis, surface)
    )
    return replace(axis, profile=profile)


def narrowest_fraction(axis: StentAxis, surface: Surface) -> float:
    """Part of its length at which the vessel round an axis is narrowest.

    By its inscribed radius; where that is not known, by the nearest vertex of the wall.
    """
    radius = axis.inscribed_radius
    if not np.isfinite(radius).any():
        radius = nearest_distances(axis.points, off_caps(surface))
    along = axis.line.arc_lengths
    return float(along[np.nanargmin(radius)] / along[-1])


def named_states(deployment: Deployment, label: str) -> Iterator[DeploymentState]:
    """The states of a deployment; its errors name the stent."""
    with labeled(label):
        yield from deployment


class Stage(NamedTuple):
    """A stent as its turn found the vessel; it is measured when all are in place."""

    placed: PlacedStent
    centerline: Centerline | None
    deployment: Deployment

    @property
    def number(self) -> int:
        """The number of the stent in the plan, from 1."""
        return self.placed.number

    @property
    def stent(self) -> Stent:
        """The stent with all of its sizes."""
        return self.placed.stent

    @property
    def axis(self) -> StentAxis:
        """The axis on which it lies."""
        return self.placed.axis

    @property
    def result(self) -> DeploymentResult:
        """Its deployment, before the stents after it."""
        return self.deployment.result

    def radius_at(self, arc_length: Floats) -> Floats:
        """Radii (n,) of the stent at arc lengths (n,) of its axis, mm."""
        return self.placed.prescribed(arc_length) / 2
