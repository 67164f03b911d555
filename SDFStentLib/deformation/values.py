"""What a deployment is about and what comes of it: task, states and result, as values."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..certificate import Certificate, LumenCheck, MotionCheck
from ..field import CapsuleChain, radius_correction
from ..geometry import Precision, Topology, oriented_triangles, signed_volume, surface_topology
from ..validation import Points, Triangles, as_length, as_points, as_triangles
from .settings import THINNEST_AND_WIDEST_RADIUS, DeploymentSettings
from .stent_checks import lumen_check
from .untangle import Relief


class DeploymentState(NamedTuple):
    """The vessel at one radius of the stent."""

    radius: float
    """mm."""
    fraction: float
    """Radius over target radius, in [0, 1]; 1 for the finished state only."""
    indices: NDArray[np.int64]
    """(k,) points that have moved since the start."""
    coordinates: Points
    """(k, 3) where they are now, mm."""
    companions: Points
    """(c, 3) all companion points (the centerline), mm."""

    def applied_to(self, points: ArrayLike) -> Points:
        """A copy of the undeformed points with this state's coordinates in their place."""
        copy = np.array(points, dtype=np.float64)
        copy[self.indices] = self.coordinates
        return copy


@dataclass(frozen=True)
class DeploymentResult:
    """The finished deployment. Immutable.

    Attributes
    ----------
    state : DeploymentState
        The final state.
    points : (n, 3) array
        All points of the surface, mm.
    certificate : Certificate or None
        None when the settings did not ask for one.
    untangling_rounds : int
        Rounds of local smoothing that were needed to take folds apart; mostly 0.
    relief : Relief or None
        Where facets had to stay inside the prescribed lumen for that; mostly None.
    estimated_error : float
        Stated distance to the converged limit of the radius steps, mm; 0 for published steps,
        which do not estimate theirs. It concerns the transition zone, not the finished lumen.
    motion : MotionCheck
        How far the wall moved against what the method can move.
    """

    state: DeploymentState
    points: Points
    certificate: Certificate | None
    untangling_rounds: int
    relief: Relief | None
    estimated_error: float
    motion: MotionCheck


class DeploymentTask:
    """What is deployed where, checked, with what follows from it. Nothing here changes.

    Parameters and errors as for `Deployment`.
    """

    def __init__(
        self,
        points: ArrayLike,
        triangles: ArrayLike,
        axis: CapsuleChain | ArrayLike,
        radius: float,
        settings: DeploymentSettings,
        companions: ArrayLike | None,
        precision: Precision | None,
        topology: Topology | None,
    ) -> None:
        self._topology = topology
        self.settings = settings
        self.points = as_points(points, "surface points", minimum=3)
        self.triangles = as_triangles(triangles, len(self.points), "surface triangles")
        self.radius = as_length(radius, "stent radius", *THINNEST_AND_WIDEST_RADIUS)
        if not isinstance(axis, CapsuleChain):
            axis = CapsuleChain.along(
                axis,
                capsule_length=settings.capsule_length,
                smoothing_width=settings.smoothing_width,
            )
        self.chain = axis
        self.companions = as_points(() if companions is None else companions, "companion points")
        self.precision = precision or Precision()

    @cached_property
    def target_level(self) -> float:
        """Field level of the expanded stent: the radius less the smooth minimum's inflation, mm."""
        calibration = self.settings.calibration
        if calibration == "none":
            return self.radius
        if calibration == "paper":
            return max(self.radius - self.chain.smoothing_width / 4, 0.5 * self.radius)
        return self.radius - radius_correction(self.chain, self.radius)

    @cached_property
    def is_used(self) -> NDArray[np.bool_]:
        """Which points (n,) belong to a triangle; files exist with points that do not."""
        is_used = np.zeros(len(self.points), dtype=bool)
        is_used[self.triangles.ravel()] = True
        return is_used

    @cached_property
    def topology(self) -> Topology:
        """How the triangles hang together; looked at once."""
        return self._topology or surface_topology(self.triangles)

    def lumen_checks(
        self, before: Points, after: Points, own: tuple[Points, Points] | None = None
    ) -> tuple[LumenCheck, ...]:
        """`lumen_check` of this stent; none where the settings do not promise the lumen."""
        if not (self.settings.finish and self.settings.facet_compensation):
            return ()
        return (lumen_check(before, after, self.triangles, self.chain, self.radius, own),)

    @property
    def has_several_parts(self) -> bool:
        """Whether the surface is known to have parts, each with a winding of its own.

        A preview that was not given the topology does not spend the time to find out.
        """
        return self.may_have_several_parts and self.topology.component_count > 1

    @property
    def may_have_several_parts(self) -> bool:
        """False where the parts were counted and there is one, or will not be counted at all."""
        if self._topology is None:
            return self.settings.certify
        return self._topology.component_count > 1

    @property
    def is_known_consistently_wound(self) -> bool:
        """Whether the winding has been looked at and is the same everywhere."""
        return self._topology is not None and self._topology.is_consistently_wound

    @property
    def wound_triangles(self) -> Triangles:
        """The triangles with one winding, outward or not."""
        return self.triangles if self.topology.is_consistently_wound else self.outward_triangles

    @cached_property
    def outward_triangles(self) -> Triangles:
        """The triangles wound so that normals point out of the lumen; files exist with others.

        Of a closed surface in one piece the signed volume tells; anything else is turned part by
        part, open parts away from the stent axis.
        """
        shape = self.topology
        if shape.is_closed and shape.is_consistently_wound and shape.component_count == 1:
            outward = signed_volume(self.points, self.triangles) > 0
            return self.triangles if outward else self.triangles[:, ::-1]
        return oriented_triangles(self.points, self.triangles, inside=self.chain.nodes)
