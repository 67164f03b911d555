"""What a treatment gives: a state per step, and the result."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..centerline import Centerline
from ..certificate import Certificate
from ..deformation import DeploymentState
from ..measure import BranchOstium, DiameterProfile
from ..stent import Stent, StentAxis
from ..validation import Points


@dataclass(frozen=True)
class TreatmentState:
    """The vessel at one radius of one of the stents.

    Attributes
    ----------
    number : int
        Of the stent in the plan, from 1.
    fraction : float
        Done of the whole treatment, in [0, 1].
    deployment : DeploymentState
        Radius, and the points that this stent has moved.
    before : (n, 3) array
        The surface as the earlier stents have left it, mm.
    axis : StentAxis
        Where this stent lies.
    """

    number: int
    fraction: float
    deployment: DeploymentState
    before: Points
    axis: StentAxis

    def points(self) -> Points:
        """All points of the surface in this state, mm."""
        return self.deployment.applied_to(self.before)


@dataclass(frozen=True)
class TreatedStent:
    """One stent after the treatment.

    Attributes
    ----------
    number : int
        In the plan, from 1.
    stent : Stent
    axis : StentAxis
        Where it lies.
    before, after : DiameterProfile
        Of the vessel along the axis, before any stent and after all of them.
    branches : tuple of BranchOstium
        Side branches near it; empty without a centerline.
    moved_points : int
        How many points of the surface it moved.
    """

    number: int
    stent: Stent
    axis: StentAxis
    before: DiameterProfile
    after: DiameterProfile
    branches: tuple[BranchOstium, ...]
    moved_points: int


@dataclass(frozen=True)
class TreatmentResult:
    """What came of a treatment.

    Attributes
    ----------
    points : (n, 3) array
        The surface after all stents, mm.
    indices : (k,) array
        Points that moved; the others have the bits of the input.
    centerline : Centerline or None
        Moved along.
    companions : (c, 3) array
        Further points that were dragged along, mm.
    stents : tuple of TreatedStent
        Those that were switched on, in order.
    certificate : Certificate or None
        From the input to the end of the whole plan; None when the settings ask for none.
    warnings : tuple of str
        Sentences for the user.
    timings : dict
        Seconds for setup, deploy, measure and certify.
    """

    points: Points
    indices: NDArray[np.int64]
    centerline: Centerline | None
    companions: Points
    stents: tuple[TreatedStent, ...]
    certificate: Certificate | None
    warnings: tuple[str, ...]
    timings: dict[str, float]

    @property
    def coordinates(self) -> Points:
        """(k, 3) where the moved points are, mm."""
        return self.points[self.indices]
