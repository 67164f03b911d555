"""A run of a deployment: the points that can move, the radius steps, the finished lumen."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..certificate import Comparison, MotionCheck
from ..field import CapsuleChain
from ..geometry import consistently_wound, dot, twins, vertex_normals
from ..lumen import caps_near
from ..validation import Floats, Indices, Points, Triangles
from .draped import draped
from .event_steps import event_steps, published_steps
from .lumen import (
    COARSEST_REACH,
    Expanded,
    OnStent,
    OwnWall,
    drawn_in,
    facets_compensated,
    finished,
)
from .motion import Motion
from .patch import Patch
from .profiles import StepRule
from .stent_checks import CAPS_WITHIN, motion_check
from .untangle import Relief, Tangle, taken_apart
from .values import NEARLY_DONE, DeploymentState, DeploymentTask, away_from_wall
from .wall_around import own_share

WALL_CLEARANCE = 0.9
"""Largest radius of the crimped stent, as a share of the nearest wall's distance from the axis."""

GAP_RAMP = (-0.5, 0.5)
"""Cosines of facing between which the tissue gap grows from nothing to its full thickness."""

Reached = tuple[Indices, NDArray[np.int32]]
"""Numbers of points, and the nearest node of each, as of `within_reach`."""

NOTHING = np.empty(0, dtype=np.int64)


class Growth:
    """The radius steps of one stent, and the lumen that it leaves.

    Attributes
    ----------
    task : DeploymentTask
    motion : Motion
        Motion of the points that can move, those of the wall first.
    numbers : (n,) array
        Their numbers among all points of the wall and, behind these, the companions.
    wall_count : int
        Number of those of the wall.
    start : (n, 3) array
        Positions before the motion, mm.
    """

    def __init__(
        self,
        task: DeploymentTask,
        points: Points,
        near_wall: Reached,
        near_companions: Reached,
        below: float = np.inf,
    ) -> None:
        """Begin with those of some points of a wall, mm, and of the companions that are reached.

        Without what is on the field level `below`, mm, or above it.
        """
        self.task = task
        (wall, beside_wall), (dragged, beside_dragged) = near_wall, near_companions
        motion = Motion(
            task.capsules,
            np.concatenate([points[wall], task.companions[dragged]]),
            np.arange(len(wall) + len(dragged)) < len(wall),
            np.concatenate([beside_wall, beside_dragged]),
        )
        # A companion inside the expanded stent stays where it is.
        keep = motion.touchable | (motion.level >= task.target_level)
        motion.restricted(keep & (motion.level < below))
        self.motion = motion
        self.numbers = np.concatenate([wall, len(points) + dragged])[motion.indices]
        self.wall_count = int(motion.touchable.sum())
        if not self.wall_count:
            raise away_from_wall(task)
        self.start = motion.positions.copy()
        nearest = float(motion.level[: self.wall_count].min())
        self._crimped = min(task.settings.crimped_radius, WALL_CLEARANCE * nearest)

    def steps(self, rule: StepRule | None = None) -> Iterator[float]:
        """Run the radius steps, by the settings' rule or another one; yields the field level
        reached after each."""
        rule = rule or self.task.settings.step_rule()
        run = event_steps if self.task.settings.rule == "events" else published_steps
        return run(self.motion, rule, self._crimped, self.task.target_level)

    def keep_tissue(self, thickness: Floats) -> None:
        """Keep a thickness of tissue (n,), mm, between the stent and the points of the wall."""
        offset = np.zeros(len(self.motion.level))
        offset[: self.wall_count] = thickness
        self.motion.set_offset(offset)

    @property
    def expanded(self) -> Expanded:
        """The stent in the end."""
        task = self.task
        return Expanded(task.target_level, task.radius, task.settings.contact_tolerance)

    def settled(self) -> OnStent:
        """Points after the last step, those that belong there on the prescribed lumen."""
        self.motion.settled(self.task.target_level)
        return finished(self.motion, self.expanded)


class Attempt(Growth):
    """A run of the radius steps on the wall itself, with one tissue gap.

    Attributes
    ----------
    positions : (n, 3) array
        Positions of the points of `motion`, mm: its own as long as it runs, then those on the
        finished lumen.
    """

    def __init__(self, task: DeploymentTask, ramp: tuple[float, float], gap: float) -> None:
        self._gap = gap
        self._copies = self._copied = NOTHING
        reach = task.settings.influence_distance + gap
        if task.settings.finish and task.settings.facet_compensation:
            # Corners that nothing drags along may have to make way for the edge between them.
            reach = max(reach, (COARSEST_REACH - 1) * task.radius)
        reach += task.target_level
        wall, dragged = _wall(task, reach), self._dragged(task, reach)
        # A point beyond reach never moves.
        super().__init__(task, task.surface.points, wall, dragged, below=reach)
        self.positions = self.motion.positions
        self.ascending = np.argsort(self.numbers[: self.wall_count])
        self.patch = Patch.around(task.surface, self.numbers[: self.wall_count])
        self.patch_start = self.patch.points(task.surface.points, self.start[: self.wall_count])
        self.motion.drags = self._drags()
        # A wall point that is certain to be of the stented lumen; unknown unless that is finished.
        self._nearest_own: int | None = None
        self._uncompensated = self.start
        self.relief: Relief | None = None
        if gap > 0 or task.settings.finish:
            self._keep_tissue(ramp, gap)

    def state(self, level: float) -> DeploymentState:
        """Everything that has moved so far, in the caller's numbering."""
        task, target = self.task, self.task.target_level
        x, y, z = (self.positions != self.start).T
        moved = x | y | z
        wall = self.ascending[moved[self.ascending]]
        dragged = self.wall_count + np.flatnonzero(moved[self.wall_count :])
        companions = task.companions.copy()
        companions[self.numbers[dragged] - len(task.surface.points)] = self.positions[dragged]
        companions[self._copies] = companions[self._copied]
        indices, coordinates = task.surface.followed(self.numbers[wall], self.positions[wall])
        return DeploymentState(
            radius=task.radius - max(target - level, 0.0),
            fraction=min(level / target, 1.0) * NEARLY_DONE,
            indices=indices,
            coordinates=coordinates,
            companions=companions,
        )

    def finish(self) -> None:
        """Put the wall in contact on the prescribed lumen after the last step, if asked to."""
        positions = self._on_lumen() if self.task.settings.finish else self.motion.positions
        self.motion.freeze()
        self.positions = positions

    def motion_check(self) -> MotionCheck:
        """Motion of the wall compared with the bound of the method."""
        before, after = self.start[: self.wall_count], self.positions[: self.wall_count]
        return motion_check(before, after, self.task.capsules, self.task.radius, self._gap)

    def _on_lumen(self) -> Points:
        task, settings = self.task, self.task.settings
        positions, on_stent = self.settled()
        if self._nearest_own is not None:
            share = self._own_share(self._nearest_own)
            own = np.flatnonzero(share)
            drawn = OwnWall(own, share[own], self.start[own])
            positions, back = drawn_in(self.motion, positions, drawn, self.expanded)
            on_stent = np.union1d(on_stent, back)
        self._uncompensated = positions
        if not settings.facet_compensation:
            return positions
        # Points that are only dragged along have no edges; behind the wall, the patch has corners
        # that never move.
        triangles = self._wall_triangles()
        wall, others = np.split(positions, [self.wall_count])
        wall = facets_compensated(self.motion, wall, triangles, on_stent, task.radius)
        if task.capsules.shares is not None:
            corners = self.patch.points(task.surface.points, wall)
            wall = draped(self.motion, corners, triangles, task.radius)[: self.wall_count]
        return np.concatenate([wall, others])

    def _wall_triangles(self) -> Triangles:
        """The patch without flat caps across the stent's ends, which are no lumen to be kept wide.

        Corners of a cap move apart to all sides; no push would take its middle off the axis.
        """
        return self.patch.triangles[~self._is_cap]

    @cached_property
    def _is_cap(self) -> NDArray[np.bool_]:
        """Mask of the patch's faces that belong to flat caps across the stent's ends."""
        nodes, reach = self.task.capsules.nodes, CAPS_WITHIN * self.task.radius
        return caps_near(self.task.surface, nodes, reach)[self.patch.faces]

    def untangle(self, faulty: NDArray[np.int64]) -> int:
        """Take apart faulty faces of the surface; return the number of rounds that it took."""
        task = self.task
        # A fault may lie in a face that is only crossed by a moved one, outside the patch.
        local = np.flatnonzero(np.isin(self.patch.faces, faulty))
        if not len(local):
            return 0
        wound = self.patch.triangles
        if not task.is_known_consistently_wound:
            wound, _ = consistently_wound(wound)
        comparison = Comparison(self.patch_start, wound, task.precision)
        wall, others = np.split(self.positions, [self.wall_count])
        folded = Tangle(self.patch.points(task.surface.points, wall), local)
        best = taken_apart(self.motion, task.target_level, comparison, folded, self._uncompensated)
        self.relief = best.relief
        wall = best.positions[: self.wall_count]
        self.positions = np.concatenate([wall, others])
        return best.rounds

    def _dragged(self, task: DeploymentTask, reach: float) -> Reached:
        """Companions within reach; of those at one place the first, for all of them."""
        dragged, near = within_reach(task.companions, task.capsules, reach)
        # A tree and the file that it was made of, or overlapping lines, have the same points.
        twin = twins(task.companions, dragged)
        is_first = np.ones(len(dragged), dtype=bool) if twin is None else twin[dragged] == dragged
        self._copies = dragged[~is_first]
        self._copied = self._copies if twin is None else twin[self._copies]
        return dragged[is_first], near[is_first]

    def _keep_tissue(self, ramp: tuple[float, float], gap: float) -> None:
        """Let walls of other lumens keep a tissue thickness from the stent.

        Such a wall looks back at the stent: its outward normal does not point along the field.
        Without the gap it would be swept onto the same surface as the wall of the stented lumen.
        """
        wall = slice(0, self.wall_count)
        direction = self.motion.outward[wall]
        level = self.motion.level[wall]
        normals = None
        # A known topology costs nothing; the patch costs little, the whole surface much.
        task = self.task
        may_have = task.may_have_several_parts and self.patch.has_several_parts
        if not (may_have and task.has_several_parts):
            normals = self.patch.outward_normals(
                self.patch_start, direction, level, task.is_known_consistently_wound
            )
        if normals is None:
            normals = vertex_normals(task.surface.points, task.outward_triangles)
            normals = normals[self.numbers[wall]]
        if gap > 0:
            offset = tissue_offset(normals, direction, ramp, gap)
            self.keep_tissue(offset)
            self._tissue = offset / gap
        else:
            self._tissue = tissue_offset(normals, direction, ramp, 1.0)
        if not task.settings.finish:
            return
        # The middle of a cap ahead may be nearest although no free points join it to any wall.
        is_own = (self._tissue == 0) & self._is_beside()
        self._nearest_own = int(np.where(is_own, level, np.inf).argmin())

    def _is_beside(self) -> NDArray[np.bool_]:
        """Mask of the wall's points beside the stent: not beyond an end, nor in a cap."""
        points, nodes = self.positions[: self.wall_count], self.task.capsules.nodes
        nearest = self.motion.distance_at(self.motion.level)[: self.wall_count]
        reach = nearest + self.task.capsules.smoothing_width
        is_beside = np.ones(len(points), dtype=bool)
        for end, inner in (nodes[:2], nodes[:-3:-1]):
            offset = points - end
            is_nearest = dot(offset, offset) <= reach**2
            is_beside &= ~(is_nearest & (offset @ (end - inner) > 0))
        in_cap = np.unique(self.patch.triangles[self._is_cap])
        is_beside[in_cap[in_cap < len(points)]] = False
        return is_beside

    def _drags(self) -> NDArray[np.bool_]:
        """Whether each point in contact drags others along: wall and the rims of caps do, caps do
        not."""
        drags = self.motion.touchable.copy()
        if self.task.settings.rule == "events" and self._is_cap.any():
            triangles = self.patch.triangles
            inner = np.setdiff1d(triangles[self._is_cap], triangles[~self._is_cap])
            drags[inner[inner < self.wall_count]] = False
        return drags

    def _own_share(self, nearest: int) -> NDArray[np.float64]:
        """Share with which each point of the wall belongs to the stented lumen, see `own_share`.

        The point known to belong is the nearest to the axis of those without tissue offset.
        """
        tissue = np.ones(len(self.patch.vertices))
        tissue[: self.wall_count] = self._tissue
        sides = np.concatenate([self.patch.triangles[:, :2], self.patch.triangles[:, 1:]])
        return own_share(sides, tissue, nearest)[: self.wall_count]


def _wall(task: DeploymentTask, reach: float) -> Reached:
    """The points of the wall within reach."""
    wall, near = within_reach(task.surface.points, task.capsules, reach)
    # A point that no triangle uses is no wall; nobody would see it touched.
    is_used = task.is_used[wall]
    return wall[is_used], near[is_used]


def tissue_offset(
    normals: Points, direction: Points, ramp: tuple[float, float], gap: float
) -> Floats:
    """Tissue (n,), mm, between the stent and walls: the more they face it, the more is kept."""
    share = np.clip((-dot(normals, direction) - ramp[0]) / (ramp[1] - ramp[0]), 0, 1)
    return np.asarray(gap * share**2 * (3 - 2 * share))


def within_reach(points: Points, chain: CapsuleChain, reach: float) -> Reached:
    """Points whose field may be below a level, mm, and the nearest node of each.

    Points outside of a box round the axis are skipped first.
    """
    # The smooth distance is less than k below the true one.
    reach = reach + chain.smoothing_width
    low, high = chain.nodes.min(axis=0) - reach, chain.nodes.max(axis=0) + reach
    inside = np.flatnonzero((points[:, 0] > low[0]) & (points[:, 0] < high[0]))
    for axis in (1, 2):
        column = points[inside, axis]
        inside = inside[(column > low[axis]) & (column < high[axis])]
    near, distance = chain.folding.nearest_nodes(points[inside])
    kept = distance < reach
    return inside[kept], near[kept]
