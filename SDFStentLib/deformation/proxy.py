"""The preview of a deployment on a proxy: few points of the wall are deployed, the others follow.

A preview has no use for 300,000 triangles. A sample of the wall's vertices, as coarse as keeps the
part near the stent small, is moved by the radius steps of the method; fixed weights carry its
displacements to all other vertices nearby. So the cost of the steps does not grow with the mesh,
and that of the rest does by one sparse product over the vertices near the stent.

>>> proxy = Proxy(surface)                                          # doctest: +SKIP
>>> while dragging:
...     state = proxy.deployed(settings.chain(axis), radius=3.0).state
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..field import CapsuleChain
from ..geometry import Surface, as_surface
from ..lumen import looks_across
from ..validation import Indices, Points, as_points
from .attempt import GAP_RAMP, Growth, tissue_offset, within_reach
from .profiles import StepRule
from .proxy_sample import Near, SampledWall, Spreading, moved_rows
from .settings import DeploymentSettings
from .stent_checks import CAPS_WITHIN
from .values import DeploymentState, DeploymentTask

SAMPLED = 1500
"""Most points, about, that a sample has within reach of the stent; it has at least half as many."""

LONGEST_STEP, TOLERANCE = 3.2, 0.4
"""Least values for the adaptive radius steps, mm: the proxy's own error is larger than theirs."""

FIRST_SHARE = 0.5
"""First radius step of a sample over the longest; without a sample it is the rule's own.

With the rule's, an eighth, the mean distance to the full preview is 0.034 mm instead of 0.037 (36
seeded stents), and a preview costs a quarter more.
"""

DENSITY = 0.5
"""Points that a sample has in a square whose edge is its spacing."""


class ProxyState(NamedTuple):
    """The vessel at the end of a preview."""

    state: DeploymentState
    """Everything that has moved, in the surface's numbers, as in the state of a `Deployment`."""
    points: Points
    """(p, 3) places of the sample of the wall near the stent on the finished lumen, mm."""
    normals: Points
    """(p, 3) unit normals of these points out of the lumen, before the deployment."""
    spacing: float
    """Spacing of the sample, mm; 0 where all vertices were deployed."""


@dataclass(frozen=True)
class _Level:
    """A sample of the wall; it has all vertices where `spreading` is None."""

    sample: Indices
    spreading: Spreading | None
    spacing: float


class Proxy:
    """A vessel on which stents are tried out, one place after another.

    Samples and weights are made for the neighborhood of a stent when they are first needed there,
    and kept.

    Parameters
    ----------
    surface : Surface
        Surface of the vessel; open or closed, any winding.
    inside : array_like, shape (k, 3), optional
        Points in the lumen, mm, such as the centerline: they tell which side of an open surface is
        out. Default: the axis of the first stent.
    """

    def __init__(self, surface: Surface, inside: ArrayLike | None = None) -> None:
        self.surface = as_surface(surface)
        self._inside = None if inside is None else as_points(inside, "points in the lumen")
        self._wall: SampledWall | None = None
        self._levels: dict[int | None, _Level] = {}

    def deployed(
        self,
        chain: CapsuleChain,
        radius: float,
        settings: DeploymentSettings | None = None,
        *,
        points: Points | None = None,
        companions: ArrayLike = (),
    ) -> ProxyState:
        """The wall after a stent has expanded.

        Parameters
        ----------
        chain, radius, settings, companions
            As for `Deployment`; by default the settings are `DeploymentSettings.preview()`. The
            lumen is neither finished nor certified, whatever the settings say.
        points : (n, 3) array, optional
            Points of the surface as earlier stents left it, mm.

        Raises
        ------
        InputError, DeploymentError
            As `Deployment`.
        """
        task = DeploymentTask(
            self.surface,
            chain,
            radius,
            settings or DeploymentSettings.preview(),
            companions=as_points(companions, "companion points"),
        )
        wall = self._wall_with(task.capsules.nodes)
        reach = _reach(task)
        level = self._level(wall, wall.near(task.capsules, reach + task.capsules.smoothing_width))
        start = _taken(wall, level.sample, points)
        rule = _rule(task.settings, is_sample=level.spreading is not None)
        moved = _expanded(task, rule, start, wall.normals[level.sample])
        cells = wall.cells_near(task.capsules, reach + level.spacing)
        rows, displacement = _carried(wall, level, cells, moved.displacement)
        before = _taken(wall, rows, points)
        indices, coordinates = self.surface.followed(
            wall.vertices[rows], before + displacement, points
        )
        state = DeploymentState(
            radius=task.radius,
            fraction=1.0,
            indices=indices,
            coordinates=coordinates,
            companions=moved.companions,
        )
        normals = wall.normals[level.sample[moved.near]]
        return ProxyState(state, moved.on_lumen, normals, level.spacing)

    def probes(self, axis: Points) -> Points:
        """Points (k, 3) of the wall, spread evenly among all its vertices, mm."""
        return self._wall_with(axis).probes

    def _wall_with(self, axis: Points) -> SampledWall:
        if self._wall is None:
            self._wall = SampledWall(self.surface, axis if self._inside is None else self._inside)
        return self._wall

    def _level(self, wall: SampledWall, near: Near) -> _Level:
        """The finest sample with few enough points at a place; always the same one for the same
        place."""
        key = None
        if near.count > SAMPLED:
            # Levels are half a power of two apart.
            key = int(np.ceil(np.log2(DENSITY * near.area / SAMPLED)))
        if key not in self._levels:
            self._levels[key] = _made(wall, key)
        return self._levels[key]


def _taken(wall: SampledWall, rows: Indices, points: Points | None) -> Points:
    """Points of some rows of the wall, mm: as it was, or where its surface is now."""
    # The wall's own points lie side by side in memory where they do in space.
    return wall.points[rows] if points is None else points[wall.vertices[rows]]


def _made(wall: SampledWall, key: int | None) -> _Level:
    if key is None:
        return _Level(np.arange(len(wall.vertices)), None, 0.0)
    spacing = 2 ** (key / 2)
    sample = wall.sample(spacing)
    return _Level(sample, Spreading(wall, sample), spacing)


class _MovedSample(NamedTuple):
    displacement: Points
    """(p, 3) displacement of the whole sample, mm."""
    companions: Points
    """(c, 3) places of the companions now, mm."""
    on_lumen: Points
    """(k, 3) places on the finished lumen of the points of the sample near the stent, mm."""
    near: Indices
    """(k,) numbers of these points in the sample."""


def _expanded(
    task: DeploymentTask, rule: StepRule, points: Points, normals: Points
) -> _MovedSample:
    """Run the radius steps of the method on some points of the wall."""
    reach, capsules = _reach(task), task.capsules
    wall, dragged = (within_reach(one, capsules, reach) for one in (points, task.companions))
    growth = Growth(task, points, wall, dragged)
    motion, own = growth.motion, slice(growth.wall_count)
    facing, positions = normals[growth.numbers[own]], motion.positions[own]
    motion.drags = motion.touchable.copy()
    within = CAPS_WITHIN * task.radius
    motion.drags[own] = ~looks_across(positions, facing, capsules.nodes, within)
    gap = task.settings.tissue_gap
    growth.keep_tissue(tissue_offset(facing, motion.outward[own], GAP_RAMP, gap))
    for _ in growth.steps(rule):
        pass
    on_lumen = growth.settled().positions[own]
    displacement = np.zeros((len(points) + len(task.companions), 3))
    displacement[growth.numbers] = motion.positions - growth.start
    of_wall, of_companions = np.split(displacement, [len(points)])
    return _MovedSample(of_wall, task.companions + of_companions, on_lumen, growth.numbers[own])


def _reach(task: DeploymentTask) -> float:
    """Field level, mm, from which on no wall moves."""
    return task.target_level + task.settings.influence_distance + task.settings.tissue_gap


def _rule(settings: DeploymentSettings, *, is_sample: bool) -> StepRule:
    """A step rule with longer radius steps than those of the settings."""
    rule = settings.step_rule()
    if settings.rule == "published":
        return rule
    share = FIRST_SHARE if is_sample else rule.first_share
    step, tolerance = max(rule.step, LONGEST_STEP), max(rule.tolerance, TOLERANCE)
    return replace(rule, step=step, tolerance=tolerance, first_share=share)


def _carried(
    wall: SampledWall, level: _Level, cells: Indices, displacement: Points
) -> tuple[Indices, Points]:
    """Rows of the wall that move, and their displacement, mm."""
    if level.spreading is None:
        rows = moved_rows(displacement)
        return rows, displacement[rows]
    rows, spread = wall.rows_of(cells), level.spreading.carried(cells, displacement)
    moved = moved_rows(spread)
    return rows[moved], spread[moved].astype(np.float64)
