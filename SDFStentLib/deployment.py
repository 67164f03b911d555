"""Deploy a stent: an iterable with one state per radius step, and a one-call form.

>>> deployment = Deployment(points, triangles, axis, radius=3.0)     # doctest: +SKIP
>>> for state in deployment:                                        # stop iterating to cancel
...     show(state.indices, state.coordinates)
>>> deployment.result.certificate.passed
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .capsule_chain import CapsuleChain
from .certificate import Certificate, certify
from .event_steps import event_steps
from .lumen import facets_compensated, finished, projected, radius_correction
from .motion import Motion
from .patch import Patch
from .published_steps import published_steps
from .settings import DeploymentSettings
from .surface import oriented_triangles, signed_volume, vertex_normals
from .topology import Topology, consistently_wound, surface_topology
from .untangle import Faults, Precision, untangled
from .validation import (
    DeploymentError,
    Points,
    Triangles,
    as_number,
    as_points,
    as_triangles,
    read_only,
)

GAP_RAMP = (-0.5, 0.5)
"""Facing cosine between which the tissue gap grows from nothing to its full thickness."""

RETRIES = (((-1.0, 1.0), 1.0), (GAP_RAMP, 2.0), (GAP_RAMP, 0.5), (GAP_RAMP, 3.0))
"""Ramps and multiples of the tissue gap that are tried in turn when a fold stays."""

WALL_CLEARANCE = 0.9
"""The crimped stent never reaches beyond this share of the nearest wall's distance."""


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
        Rounds of local smoothing that were needed; 0 nearly always.
    estimated_error : float
        Stated distance to the converged limit of the radius steps, mm; 0 for published steps,
        which do not estimate theirs. It concerns the transition zone, not the finished lumen.
    """

    state: DeploymentState
    points: Points
    certificate: Certificate | None
    untangling_rounds: int
    estimated_error: float


class Deployment:
    """A stent that expands in a vessel. Iterating runs it; every step stays addressable.

    Parameters
    ----------
    points, triangles : array_like, shapes (n, 3) and (m, 3)
        Surface of the vessel, mm; open or closed, any winding. Never modified.
    axis : CapsuleChain or (k, 3) array_like
        The stent: a capsule chain, or its axis from the proximal to the distal end.
    radius : float
        Prescribed radius of the lumen, mm.
    settings : DeploymentSettings, optional
    companions : array_like, shape (c, 3), optional
        Points that are dragged along but never touched, such as the centerline. Those inside the
        expanded stent stay.
    precision : Precision, optional
        How the result will be stored; the certificate is about the stored numbers.
    topology : Topology, optional
        `surface_topology(triangles)` where known, to look at it once for many deployments.

    Raises
    ------
    InputError
        Points, triangles, axis or radius that cannot be used.
    DeploymentError
        While iterating: a surface of which no point is near the stent.
    """

    def __init__(
        self,
        points: ArrayLike,
        triangles: ArrayLike,
        axis: CapsuleChain | ArrayLike,
        radius: float,
        settings: DeploymentSettings | None = None,
        *,
        companions: ArrayLike | None = None,
        precision: Precision | None = None,
        topology: Topology | None = None,
    ) -> None:
        self._topology = topology
        self.settings = settings or DeploymentSettings()
        self.points = as_points(points, "surface points", minimum=3)
        self.triangles = as_triangles(triangles, len(self.points), "surface triangles")
        self.radius = as_number(radius, "stent radius", unit="mm", above=0)
        if not isinstance(axis, CapsuleChain):
            axis = CapsuleChain.along(
                axis,
                capsule_length=self.settings.capsule_length,
                smoothing_width=self.settings.smoothing_width,
            )
        self.chain = axis
        self.companions = as_points(() if companions is None else companions, "companion points")
        self.precision = precision or Precision()
        self.states: list[DeploymentState] = []
        self._result: DeploymentResult | None = None

    def __iter__(self) -> Iterator[DeploymentState]:
        """Yield a state per radius step with motion, then the finished state."""
        self.states = []
        attempt = _Attempt(self, GAP_RAMP, self.settings.tissue_gap)
        for radius in attempt.steps():
            self.states.append(attempt.state(radius))
            yield self.states[-1]
        self._result = self._finish(attempt)
        self.states.append(self._result.state)
        yield self._result.state

    @property
    def result(self) -> DeploymentResult:
        """The finished deployment; runs it to the end when that has not happened."""
        if self._result is None:
            for _ in self:
                pass
        assert self._result is not None
        return self._result

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
    def topology(self) -> Topology:
        """How the triangles hang together; looked at once."""
        return self._topology or surface_topology(self.triangles)

    def _finish(self, attempt: _Attempt) -> DeploymentResult:
        """Finish the lumen; certify, and untangle or retry with other gaps when that fails."""
        attempt.finish()
        certificate, rounds = None, 0
        if self.settings.certify or self.settings.untangle:
            certificate = self._certificate(attempt)
        if self.settings.untangle and certificate is not None and not certificate.passed:
            attempt, certificate, rounds = self._untangled(attempt, certificate)
        state = attempt.state(self.target_level)._replace(fraction=1.0)
        return DeploymentResult(
            state=state,
            points=read_only(state.applied_to(self.points)),
            certificate=certificate if self.settings.certify else None,
            untangling_rounds=rounds,
            estimated_error=attempt.motion.estimated_error,
        )

    def _untangled(
        self, attempt: _Attempt, certificate: Certificate
    ) -> tuple[_Attempt, Certificate, int]:
        """The first attempt without a fault, or the one with the fewest."""
        rounds = attempt.untangle(_faulty(certificate))
        best = (attempt, self._certificate(attempt), rounds)
        retries = RETRIES if self.settings.tissue_gap > 0 else ()
        for ramp, factor in retries:
            if best[1].passed:
                break
            attempt = _Attempt(self, ramp, factor * self.settings.tissue_gap)
            for _ in attempt.steps():
                pass
            attempt.finish()
            rounds = attempt.untangle(_faulty(self._certificate(attempt)))
            certificate = self._certificate(attempt)
            if len(_faulty(certificate)) < len(_faulty(best[1])):
                best = (attempt, certificate, rounds)
        return best

    def _certificate(self, attempt: _Attempt) -> Certificate:
        state = attempt.state(self.target_level)
        return certify(
            self.points,
            state.applied_to(self.points),
            self.outward_triangles,
            moved=state.indices,
            dtype=self.precision.dtype,
            scale=self.precision.scale,
            topology=self.topology,
        )

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


def _faulty(certificate: Certificate) -> NDArray[np.int64]:
    return np.unique(
        np.concatenate(
            [
                certificate.new_self_intersecting,
                certificate.new_inverted,
                certificate.new_degenerate,
            ]
        )
    )


def deploy(
    points: ArrayLike,
    triangles: ArrayLike,
    axis: CapsuleChain | ArrayLike,
    radius: float,
    settings: DeploymentSettings | None = None,
    *,
    companions: ArrayLike | None = None,
    precision: Precision | None = None,
    topology: Topology | None = None,
    progress: Callable[[DeploymentState], None] | None = None,
) -> DeploymentResult:
    """Run a deployment to its end; parameters and errors as for `Deployment`.

    `progress` is called with every state.
    """
    deployment = Deployment(
        points,
        triangles,
        axis,
        radius,
        settings,
        companions=companions,
        precision=precision,
        topology=topology,
    )
    for state in deployment:
        if progress is not None:
            progress(state)
    return deployment.result


class _Attempt:
    """One run of the radius steps with one tissue gap."""

    def __init__(self, deployment: Deployment, ramp: tuple[float, float], gap: float) -> None:
        self.deployment = deployment
        self.motion, self.numbers = self._active(gap)
        self.start = self.motion.positions.copy()
        self.wall_count = int(self.motion.touchable.sum())
        if not self.wall_count:
            raise DeploymentError(
                "stent: expected the vessel's wall within "
                f"{deployment.radius + deployment.settings.influence_distance:.1f} mm of the stent "
                "axis, got none; check that surface and axis are in the same unit and frame."
            )
        self.patch = Patch.around(
            deployment.triangles, self.numbers[: self.wall_count], len(deployment.points)
        )
        self.patch_start = self.patch.points(deployment.points, self.start[: self.wall_count])
        nearest = float(self.motion.level[: self.wall_count].min())
        self.start_radius = min(deployment.settings.crimped_radius, WALL_CLEARANCE * nearest)
        if gap > 0:
            self._keep_tissue(ramp, gap)

    def steps(self) -> Iterator[float]:
        """Run the radius steps; yields the field level reached after each."""
        settings = self.deployment.settings
        run = event_steps if settings.rule == "events" else published_steps
        return run(
            self.motion, settings.step_rule(), self.start_radius, self.deployment.target_level
        )

    def state(self, level: float) -> DeploymentState:
        """What has moved so far, in the caller's numbers."""
        deployment, target = self.deployment, self.deployment.target_level
        moved = np.flatnonzero((self.motion.positions != self.start).any(axis=1))
        wall, dragged = np.split(moved, [np.searchsorted(moved, self.wall_count)])
        companions = deployment.companions.copy()
        companions[self.numbers[dragged] - len(deployment.points)] = self.motion.positions[dragged]
        wall = wall[np.argsort(self.numbers[wall])]
        return DeploymentState(
            radius=min(level + deployment.radius - target, deployment.radius),
            fraction=min(level / target, 1.0) * (1 - 1e-9),
            indices=self.numbers[wall],
            coordinates=self.motion.positions[wall],
            companions=companions,
        )

    def finish(self) -> None:
        """After the last step: put the wall in contact on the prescribed lumen."""
        deployment, settings = self.deployment, self.deployment.settings
        if not settings.finish:
            return
        self.motion.refreshed()
        projected(self.motion, deployment.target_level)
        on_stent = finished(
            self.motion,
            deployment.target_level,
            deployment.radius,
            settings.contact_tolerance,
        )
        if settings.facet_compensation:
            facets_compensated(self.motion, self.patch.triangles, on_stent, deployment.radius)

    def untangle(self, faulty: NDArray[np.int64]) -> int:
        """Take apart faulty faces of the surface; returns the rounds that it took."""
        deployment = self.deployment
        # A fault may lie in a face that is only crossed by a moved one, outside the patch.
        local = np.flatnonzero(np.isin(self.patch.faces, faulty))
        if not len(local):
            return 0
        wound, _ = consistently_wound(self.patch.triangles)
        faults = Faults(self.patch_start, wound, deployment.precision)
        folded = self.motion.positions.copy()
        outcome = untangled(self.motion, faults, self.wall_count, deployment.target_level, local)
        if len(outcome.remaining) >= len(local):
            self.motion.positions[:] = folded
        return outcome.rounds

    def _active(self, gap: float) -> tuple[Motion, NDArray[np.int64]]:
        """The points that can move, and their numbers among points and companions."""
        deployment = self.deployment
        everything = np.concatenate([deployment.points, deployment.companions])
        reach = deployment.target_level + deployment.settings.influence_distance + gap
        near = _within(everything, deployment.chain, reach)
        motion = Motion(deployment.chain, everything[near], near < len(deployment.points))
        # A companion inside the expanded stent stays; a point beyond reach never moves.
        keep = motion.touchable | (motion.level >= deployment.target_level)
        motion.restricted(keep & (motion.level < reach))
        return motion, near[motion.indices]

    def _keep_tissue(self, ramp: tuple[float, float], gap: float) -> None:
        """Let walls of other lumens keep a tissue thickness from the stent.

        Such a wall looks back at the stent: its outward normal does not point along the field.
        Without the gap it would be swept onto the same surface as the wall of the stented lumen.
        """
        wall = slice(0, self.wall_count)
        direction = self.motion.direction[wall]
        level = self.motion.level[wall]
        normals = self.patch.outward_normals(self.patch_start, direction, level)
        if normals is None:
            normals = vertex_normals(self.deployment.points, self.deployment.outward_triangles)
            normals = normals[self.numbers[wall]]
        facing = -np.einsum("ij,ij->i", normals, direction)
        share = np.clip((facing - ramp[0]) / (ramp[1] - ramp[0]), 0, 1)
        offset = np.zeros(len(self.motion.level))
        offset[wall] = gap * share**2 * (3 - 2 * share)
        self.motion.set_offset(offset)


def _within(points: Points, chain: CapsuleChain, reach: float) -> NDArray[np.int64]:
    """Points whose field may be below reach: a box first, then spheres round every few nodes."""
    # The smooth distance is less than k below the true one.
    nodes, reach = chain.nodes, reach + chain.smoothing_width
    near = np.flatnonzero(
        ((points > nodes.min(axis=0) - reach) & (points < nodes.max(axis=0) + reach)).all(axis=1)
    )
    stride = max(1, len(nodes) // 8)
    sampled = np.append(nodes[::stride], nodes[-1:], axis=0)
    # No axis point is farther from a sampled node than half the arc between two of them.
    arcs = np.linalg.norm(np.diff(nodes, axis=0), axis=1)
    slack = stride * float(arcs.max()) / 2
    kept = np.zeros(len(near), dtype=bool)
    for node in sampled:
        offset = points[near] - node
        kept |= np.einsum("ij,ij->i", offset, offset) < (reach + slack) ** 2
    return near[kept]
