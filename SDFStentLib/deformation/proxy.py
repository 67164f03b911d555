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
from .attempt import CAPS_WITHIN, WALL_CLEARANCE, tissue_offset, within_reach
from .deployment import GAP_RAMP
from .event_steps import event_steps, published_steps
from .lumen import Expanded, finished
from .motion import Motion
from .profiles import StepRule
from .proxy_sample import Near, SampledWall, Spreading, moved_rows
from .settings import DeploymentSettings
from .values import DeploymentState, DeploymentTask, away_from_wall

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
        """Some points of the wall, spread evenly among all its vertices, mm."""
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
    reach = _reach(task)
    wall, near_wall = within_reach(points, task.capsules, reach)
    dragged, near_dragged = within_reach(task.companions, task.capsules, reach)
    if not len(wall):
        raise away_from_wall(task)
    motion = Motion(
        task.capsules,
        np.concatenate([points[wall], task.companions[dragged]]),
        np.arange(len(wall) + len(dragged)) < len(wall),
        np.concatenate([near_wall, near_dragged]),
    )
    numbers = np.concatenate([wall, len(points) + dragged])[motion.indices]
    keep = motion.touchable | (motion.level >= task.target_level)
    motion.restricted(keep)
    numbers = numbers[keep]
    offset = np.zeros(len(numbers))
    is_wall = motion.touchable
    facing = normals[numbers[is_wall]]
    gap = task.settings.tissue_gap
    offset[is_wall] = tissue_offset(facing, motion.outward[is_wall], GAP_RAMP, gap)
    within, nodes = CAPS_WITHIN * task.radius, task.capsules.nodes
    motion.drags = is_wall.copy()
    motion.drags[is_wall] = ~looks_across(motion.positions[is_wall], facing, nodes, within)
    nearest = float(motion.level[is_wall].min())
    motion.set_offset(offset)
    start = motion.positions.copy()
    crimped = min(task.settings.crimped_radius, WALL_CLEARANCE * nearest)
    steps = published_steps if task.settings.rule == "published" else event_steps
    for _ in steps(motion, rule, crimped, task.target_level):
        pass
    motion.settled(task.target_level)
    stent = Expanded(task.target_level, task.radius, task.settings.contact_tolerance)
    displacement = np.zeros((len(points) + len(task.companions), 3))
    displacement[numbers] = motion.positions - start
    of_wall, of_companions = np.split(displacement, [len(points)])
    on_lumen = finished(motion, stent).positions[is_wall]
    return _MovedSample(of_wall, task.companions + of_companions, on_lumen, numbers[is_wall])


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
