"""One stent of a treatment between its turn and the measuring."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from ..centerline import Centerline
from ..deformation import Deployment, DeploymentResult, DeploymentState
from ..stent import Stent, StentAxis
from ..validation import Floats
from .profile import prescribed_diameters
from .value import labeled


def named_states(deployment: Deployment, label: str) -> Iterator[DeploymentState]:
    """Of a deployment; its errors name the stent."""
    with labeled(label):
        yield from deployment


class Stage(NamedTuple):
    """One stent as its turn found the vessel; it is measured when all are in place."""

    number: int
    stent: Stent
    axis: StentAxis
    centerline: Centerline | None
    deployment: Deployment

    @property
    def result(self) -> DeploymentResult:
        """What came of it, before the stents after it."""
        return self.deployment.result

    def radius_at(self, arc_length: Floats) -> Floats:
        """Of the stent at some arc lengths of its axis, mm."""
        return prescribed_diameters(self.stent, self.axis, arc_length) / 2
