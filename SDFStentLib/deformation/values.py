"""A deployment as values: its task, its states and its result."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..certificate import Certificate, LumenCheck, MotionCheck
from ..field import CapsuleChain, as_chain, radius_correction
from ..geometry import (
    Precision,
    Surface,
    SurfaceIndex,
    as_surface,
    oriented_triangles,
    side_lengths,
    signed_volume,
)
from ..units import place_text
from ..validation import DeploymentError, Points, Triangles, as_length, as_place, as_points, plain
from .settings import THINNEST_AND_WIDEST_RADIUS, DeploymentSettings
from .stent_checks import Expected, lumen_check
from .untangle import Relief

NEARLY_DONE = 1 - 1e-9
"""Largest fraction of an unfinished state."""


class DeploymentState(NamedTuple):
    """The vessel at one radius of the stent."""

    radius: float
    """Radius of the stent, mm."""
    fraction: float
    """Radius over target radius, in [0, 1]; 1 for the finished state only."""
    indices: NDArray[np.int64]
    """(k,) points that have moved since the start."""
    coordinates: Points
    """(k, 3) their places now, mm."""
    companions: Points
    """(c, 3) all companion points (the centerline), mm."""

    @property
    def is_grown(self) -> bool:
        """Whether the stent is as wide as it becomes, and the wall is still to be finished."""
        return NEARLY_DONE <= self.fraction < 1

    def applied_to(self, points: ArrayLike) -> Points:
        """Undeformed points (n, 3) with this state's coordinates in their place, mm; a copy."""
        copy = np.array(points, dtype=np.float64)
        copy[self.indices] = self.coordinates
        return copy


FINE = 0.25
"""Advised edge length over the stent's radius: in 120 stents of straight and bent phantoms the
lumen was 0.5 % too narrow with it."""


@dataclass(frozen=True)
class DeploymentResult:
    """The finished deployment. Immutable.

    Attributes
    ----------
    state : DeploymentState
        The final state.
    surface : Surface
        The deformed surface.
    certificate : Certificate or None
        None when the settings did not ask for one.
    untangling_rounds : int
        Rounds of local smoothing that were needed to take folds apart; mostly 0.
    relief : Relief or None
        The place where facets had to stay inside the prescribed lumen for that; mostly None.
    estimated_error : float
        Stated distance to the converged limit of the radius steps, mm; 0 for published steps,
        which do not estimate theirs. It concerns the transition zone, not the finished lumen.
    motion : MotionCheck
        Motion of the wall compared with its bound by the method.
    """

    state: DeploymentState
    surface: Surface
    certificate: Certificate | None
    untangling_rounds: int
    relief: Relief | None
    estimated_error: float
    motion: MotionCheck

    @property
    def points(self) -> Points:
        """The points (n, 3) of the deformed surface, mm."""
        return self.surface.points


@dataclass(frozen=True, eq=False, repr=False)
class DeploymentTask:
    """Checked inputs of a deployment, and values derived from them. Immutable.

    Parameters and errors as for `Deployment`; None stands for what is not given.
    """

    surface: Surface
    chain: CapsuleChain
    radius: float
    settings: DeploymentSettings = field(default_factory=DeploymentSettings)
    _: KW_ONLY
    companions: Points = field(default_factory=lambda: np.empty((0, 3)))
    precision: Precision = field(default_factory=Precision)

    def __post_init__(self) -> None:
        companions = () if self.companions is None else self.companions
        self._set("surface", as_surface(self.surface))
        self._set("chain", as_chain(self.chain))
        self._set("radius", as_length(self.radius, "stent radius", *THINNEST_AND_WIDEST_RADIUS))
        self._set("settings", self.settings or DeploymentSettings())
        self._set("companions", as_points(companions, "companion points"))
        self._set("precision", self.precision or Precision())

    def _set(self, name: str, value: object) -> None:
        object.__setattr__(self, name, value)

    @property
    def capsules(self) -> CapsuleChain:
        """The chain with its nodes in an order that does not depend on the axis' direction."""
        return self.chain.undirected

    @cached_property
    def target_level(self) -> float:
        """Field level of the expanded stent: the radius less the smooth minimum's inflation, mm."""
        calibration = self.settings.calibration
        if calibration == "none":
            return self.radius
        if calibration == "paper":
            return max(self.radius - self.chain.smoothing_width / 4, 0.5 * self.radius)
        return self.radius - radius_correction(self.capsules, self.radius)

    @cached_property
    def is_used(self) -> NDArray[np.bool_]:
        """Whether each point (n,) belongs to a triangle; files exist with points that do not."""
        is_used = np.zeros(len(self.surface.points), dtype=bool)
        is_used[self.surface.triangles.ravel()] = True
        return is_used

    def lumen_checks(
        self, before: Surface, after: Surface, own: tuple[Surface, Surface] | None = None
    ) -> tuple[LumenCheck, ...]:
        """The `lumen_check` of this stent; empty where the settings do not promise the lumen."""
        if not (self.settings.finish and self.settings.facet_compensation):
            return ()
        stent = Expected(self.capsules, self.radius, self.settings.influence_distance)
        return (lumen_check(before, after, stent, own),)

    @property
    def has_several_parts(self) -> bool:
        """Whether the surface has several parts, each with a winding of its own."""
        return self.surface.topology.component_count > 1

    @property
    def may_have_several_parts(self) -> bool:
        """False where the parts are known and there is only one."""
        known = self.surface.known_topology
        return known is None or known.component_count > 1

    @property
    def is_known_consistently_wound(self) -> bool:
        """Whether the winding is known and is the same everywhere."""
        known = self.surface.known_topology
        return known is not None and known.is_consistently_wound

    @property
    def wound_triangles(self) -> Triangles:
        """Triangles (m, 3) with one winding, outward or not."""
        if self.surface.topology.is_consistently_wound:
            return self.surface.triangles
        return self.outward_triangles

    @cached_property
    def outward_triangles(self) -> Triangles:
        """Triangles (m, 3) wound so that normals point out of the lumen, whatever the file had.

        The signed volume decides for a closed surface in one piece; any other is turned part by
        part, open parts away from the stent axis.
        """
        shape, points, triangles = (
            self.surface.topology,
            self.surface.points,
            self.surface.triangles,
        )
        if shape.is_closed and shape.is_consistently_wound and shape.component_count == 1:
            return triangles if signed_volume(points, triangles) > 0 else triangles[:, ::-1]
        return oriented_triangles(points, triangles, inside=self.capsules.nodes)


def away_from_wall(task: DeploymentTask) -> DeploymentError:
    """The error for a stent that no point of the wall is near.

    The wall itself may be near, between points that are farther apart than the vessel is wide.
    """
    reach = task.radius + task.settings.influence_distance
    found = SurfaceIndex(task.surface.points, task.surface.triangles).distances(task.capsules.nodes)
    nearest = int(found.distance.argmin())
    if found.distance[nearest] >= reach:
        return DeploymentError(
            f"stent: expected the vessel's wall within {reach:.1f} mm of the stent "
            "axis, got none; check that surface and axis are in the same unit and frame, and that "
            "the stent is not far too thin for the lumen."
        )
    triangle = task.surface.triangles[found.triangle[[nearest]]]
    longest = side_lengths(task.surface.points, triangle).max()
    place = place_text(as_place(found.closest_point[nearest]), "mm")
    return DeploymentError(
        f"stent: expected points of the wall within {reach:.1f} mm of the stent axis, got none; "
        f"the wall is {found.distance[nearest]:.1f} mm away near {place}, but its triangles have "
        f"sides of {plain(longest, '.3g')} mm there: refine the surface near the stent to edges of "
        f"at most {FINE * task.radius:.2g} mm."
    )
