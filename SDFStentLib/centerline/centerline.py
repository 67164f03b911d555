"""The centerline of a vessel tree as one immutable value: points, radii and parents."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from ..geometry import Line, closest_on_segments
from ..validation import (
    Floats,
    Indices,
    InputError,
    Points,
    as_number,
    as_point,
    as_points,
    read_only,
)
from .branch_lumen import SAME_PLACE, BranchLumen, branch_of_points, lumens_of
from .from_lines import tree_from_lines
from .path import CenterlinePath, JunctionChoice, Location
from .point_tree import (
    NO_LOOPS,
    NeighborTable,
    PointTree,
    ancestry_of,
    as_loops,
    as_parents,
    as_radii,
    branches_of,
    interpolated,
    mixed_radius,
    neighbor_table,
    points_between,
    resampled_tree,
    run_starts,
    sums_to_root,
)
from .root import Widths
from .vessel_lines import LumenPlace, VesselLines


@dataclass(frozen=True)
class Centerline:
    """A vessel tree given by its points.

    Parameters
    ----------
    points : array_like, shape (n, 3)
        Points, mm, in any order.
    inscribed_radius : array_like, shape (n,)
        Radius of the maximum inscribed sphere, mm; not positive or not finite counts as unknown
        and becomes NaN.
    parent : array_like of int, shape (n,)
        The next point toward the root, -1 at a root. Proximal is the root's side, always.
    loops : array_like of int, shape (k, 2), optional
        Places where vessels that parted meet again: the last point of one, which is an end of the
        tree, and the point of the other at which it meets that.

    Raises
    ------
    InputError
        Fewer than two points, wrong shapes, a parent that does not exist, or a circle of parents.
    """

    points: Points
    inscribed_radius: Floats
    parent: Indices
    loops: Indices = field(default_factory=lambda: NO_LOOPS)

    def __post_init__(self) -> None:
        points = as_points(self.points, "centerline points", minimum=2)
        parent = as_parents(self.parent, len(points))
        object.__setattr__(self, "points", read_only(points))
        object.__setattr__(self, "parent", read_only(parent))
        object.__setattr__(self, "loops", read_only(as_loops(self.loops, len(points))))
        radius = read_only(as_radii(self.inscribed_radius, len(points)))
        object.__setattr__(self, "inscribed_radius", radius)

    @classmethod
    def from_lines(
        cls,
        points: ArrayLike,
        lines: Sequence[ArrayLike],
        inscribed_radius: ArrayLike | None = None,
        *,
        inlet: ArrayLike | None = None,
        wall: ArrayLike | None = None,
        widths: Widths | None = None,
    ) -> Centerline:
        """The tree that the lines of a centerline file describe, whichever program wrote it.

        Points that coincide are one. Lines within a tenth of the inscribed radius of each other are
        one line up to where they part; pieces are joined across a gap within a sphere. Their order
        and direction do not matter. The radii of the nearest points, or distances to the wall,
        stand in for unknown radii; without any, lines within 0.1 % of the extent are one line and
        gaps of 1 % are joined. A loop is opened where its limbs meet again; a spur that ends blind
        within its junction's sphere is dropped.

        The root is the end nearest to `inlet`. By default it is the end from which lines lead all
        the way to several others, else the widest end. If the two ends of a single line are alike
        to a tenth, it is the one where the line begins.

        Parameters
        ----------
        points : array_like, shape (n, 3)
            Points, mm; those that no line uses are left out.
        lines : sequence of arrays of int
            Point indices of every line, in the order of the cell.
        inscribed_radius : array_like, shape (n,), optional
            Radius of the maximum inscribed sphere, mm.
        inlet : array_like, shape (3,), optional
            A point near the end that is the root, mm.
        wall : array_like, shape (m, 3), optional
            Points of the surface in which the lines lie, mm.
        widths : callable, optional
            Function that measures the vessel at its ends, see `Widths`; by default the radii serve.

        Raises
        ------
        InputError
            No line, a line through one place only, a closed loop only, indices that do not exist,
            coordinates that are not finite, or pieces too far apart.
        """
        return cls(*tree_from_lines(points, lines, inscribed_radius, inlet, wall, widths))

    @property
    def roots(self) -> Indices:
        """Indices (r,) of points without parent, the proximal ends."""
        return np.flatnonzero(self.parent < 0)

    @property
    def leaves(self) -> Indices:
        """Indices (l,) of points without children, the distal ends."""
        return np.flatnonzero(self._child_counts == 0)

    @property
    def junctions(self) -> Indices:
        """Indices (j,) of points with more than one child."""
        return np.flatnonzero(self._child_counts > 1)

    @cached_property
    def arc_length(self) -> Floats:
        """Arc length (n,) from the root for every point, mm."""
        steps = self.points - self.points[self.parent]
        steps[self.parent < 0] = 0.0
        return read_only(sums_to_root(self.parent, np.linalg.norm(steps, axis=1)))

    @cached_property
    def branches(self) -> tuple[Indices, ...]:
        """Point indices from root or junction to the next junction or leaf, both included."""
        return tuple(read_only(branch) for branch in branches_of(self.parent))

    @cached_property
    def _child_counts(self) -> Indices:
        return np.bincount(self.parent[self.parent >= 0], minlength=len(self.parent))

    def children(self, index: int) -> Indices:
        """Indices (c,) of points whose parent is `index`."""
        return np.array([n for n in self.neighbors.of(index) if self.parent[n] == index], dtype=int)

    @cached_property
    def neighbors(self) -> NeighborTable:
        """The parent and the children of every point."""
        return neighbor_table(self.parent)

    def ancestry(self, index: int) -> Indices:
        """Indices (k,) of the points from the root down to `index`, both included."""
        return ancestry_of(self.parent, index, self._run_starts)

    @cached_property
    def _run_starts(self) -> Indices:
        return run_starts(self.parent)

    def project(self, point: ArrayLike) -> Location:
        """The nearest place on the segments to a finite point; `InputError` for any other."""
        return self._nearest(point, np.flatnonzero(self.parent >= 0))

    def _nearest(self, point: ArrayLike, ends: Indices) -> Location:
        """The nearest place to a point on the segments that lead to some points."""
        starts = self.parent[ends]
        query = as_point(point, "point")[None]
        found = closest_on_segments(self.points[starts], self.points[ends], query)
        index, fraction = int(ends[found.segments[0]]), float(found.fractions[0])
        above = int(self.parent[index])
        at, radius = self.arc_length, self.inscribed_radius
        along = (1.0 - fraction) * at[above] + fraction * at[index]
        local = mixed_radius(radius[above], radius[index], fraction)
        if along - at[above] <= SAME_PLACE and self.parent[above] >= 0:
            # A place at a junction lies on the segment above it, so that rounding chooses no
            # branch.
            index, fraction = above, 1.0
        place = read_only(found.points[0])
        distance = float(found.distances[0])
        return Location(place, distance, index, fraction, float(along), float(local))

    def point_at(self, branch: int, distance: float) -> Floats:
        """The place (3,) on a branch at a distance along it, mm.

        Parameters
        ----------
        branch : int
            Index into `branches`.
        distance : float
            Distance from the start of the branch, its end nearest to the root, mm.

        Raises
        ------
        InputError
            No such branch, or a distance beyond its ends.
        """
        if not isinstance(branch, int | np.integer) or not 0 <= branch < len(self.branches):
            raise InputError(
                f"branch: expected an index from 0 to {len(self.branches) - 1}, got {branch!r}."
            )
        points = self.branches[branch]
        along = self.arc_length[points] - self.arc_length[points[0]]
        # A length that was printed and read again may lie beyond the end by its rounding.
        at = as_number(distance, "distance", unit="mm", minimum=0, maximum=along[-1] + SAME_PLACE)
        return np.array([np.interp(at, along, column) for column in self.points[points].T])

    def path(
        self, from_point: ArrayLike | Location, to_point: ArrayLike | Location
    ) -> CenterlinePath:
        """The way between the projections of two points, across junctions, in either direction.

        It runs between `ends_of_path`; a single point when both project to the same place.

        Raises
        ------
        InputError
            The points lie on trees with different roots.
        """
        start, end = self.ends_of_path(from_point, to_point)
        nodes = points_between(self.ancestry(start.index), self.ancestry(end.index))
        if nodes is None:
            raise InputError(
                "centerline path: expected two points of one vessel tree, got points on trees "
                "with different roots; choose both on one."
            )
        points = np.concatenate([start.point[None], self.points[nodes], end.point[None]])
        radius = np.array(
            [start.inscribed_radius, *self.inscribed_radius[nodes], end.inscribed_radius]
        )
        line = Line(points)
        return CenterlinePath(line.without_repeats(), radius[line.distinct])

    def ends_of_path(
        self, from_point: ArrayLike | Location, to_point: ArrayLike | Location
    ) -> tuple[Location, Location]:
        """The places on the centerline where the way between two places begins and ends.

        A point in a lumen that leads to the other place is put on the line that arrives there.
        """
        start, end = self._location(from_point), self._location(to_point)
        if start is not from_point:
            start = self._on_line_to(end, start)
        if end is not to_point:
            end = self._on_line_to(start, end)
        return start, end

    def path_around(self, center: ArrayLike | Location, length: float) -> CenterlinePath:
        """The path of a length, mm, half of it up toward the root and half down toward the
        outlets.

        It follows the line of the vessel in whose lumen the place lies, whichever line is nearest.
        Where that vessel divides, the path follows the widest branch, or the straightest where a
        radius is unknown; `choices` lists these divisions. It ends where the centerline ends.
        """
        half = as_number(length, "length", unit="mm", above=0) / 2
        return self._path_through(center, half, half)

    def path_from_distal(self, distal: ArrayLike | Location, length: float) -> CenterlinePath:
        """The path of `length` mm from a distal end toward the root; shorter if the line ends."""
        return self._path_through(distal, as_number(length, "length", unit="mm", above=0), 0.0)

    def path_from_proximal(self, proximal: ArrayLike | Location, length: float) -> CenterlinePath:
        """The path of `length` mm from a proximal end downstream; divisions as `path_around`."""
        return self._path_through(proximal, 0.0, as_number(length, "length", unit="mm", above=0))

    def resampled(self, spacing: float) -> Centerline:
        """The tree with points about `spacing` mm apart along branches, whose ends stay."""
        spacing = as_number(spacing, "spacing", unit="mm", above=0)
        tree = PointTree(self.points, self.inscribed_radius, self.parent, self.loops)
        return Centerline(*resampled_tree(tree, spacing))

    def with_points(self, new_points: ArrayLike) -> Centerline:
        """The same tree with each of its points moved elsewhere."""
        return replace(self, points=np.asarray(new_points))

    def _location(self, place: ArrayLike | Location) -> Location:
        return place if isinstance(place, Location) else self.project(place)

    def _path_through(self, place: ArrayLike | Location, up: float, down: float) -> CenterlinePath:
        """The path from `up` mm above a place to `down` mm below it, along its vessel."""
        near = self._location(place)
        if not self.lumens:
            return CenterlinePath(Line(near.point[None]), np.array([near.inscribed_radius]))
        stretch = self._stretch_at(near)
        nodes = self.ancestry(self._vessel_lines.end_of(stretch))
        if near.index not in nodes:
            near = self._nearest(near.point if isinstance(place, Location) else place, nodes[1:])
        first, last = near.arc_length - up, near.arc_length + down
        choices: list[JunctionChoice] = []
        if down > 0:
            choices += self._vessel_lines.choices(LumenPlace(stretch, near.arc_length), last)
        at = self.arc_length[nodes]
        count = int(np.searchsorted(at, last - SAME_PLACE)) + 1
        nodes, at = nodes[:count], at[:count]
        ends = np.clip([first, last], 0.0, at[-1])
        inner = nodes[(at > ends[0]) & (at < ends[1])]
        points, radius = interpolated(Line(self.points[nodes]), self.inscribed_radius[nodes], ends)
        points = np.concatenate([points[:1], self.points[inner], points[1:]])
        radius = np.concatenate([radius[:1], self.inscribed_radius[inner], radius[1:]])
        line = Line(points)
        return CenterlinePath(line.without_repeats(), radius[line.distinct], tuple(choices))

    def _on_line_to(self, end: Location, start: Location) -> Location:
        """Place moved onto the line that arrives there, where its lumen leads to another's."""
        nodes = self.ancestry(end.index)
        if not self.lumens or start.index in nodes or start.arc_length > end.arc_length:
            return start
        if not self._vessel_lines.is_above(self._stretch_at(start), self._stretch_at(end)):
            return start
        return self._nearest(start.point, nodes[1:])

    def _stretch_at(self, place: Location) -> int:
        branch = int(self._branch_of[place.index])
        start = self.arc_length[self.branches[branch][0]]
        return self._vessel_lines.stretch_at(branch, float(place.arc_length - start))

    @cached_property
    def _branch_of(self) -> Indices:
        """Index into `branches` for every point; the next branch where one has no length."""
        return branch_of_points(self.lumens, self.branches, self.arc_length)

    @cached_property
    def lumens(self) -> tuple[BranchLumen, ...]:
        """Stations along all branches that have a length, with the widths of the
        tree's own points."""
        tree = PointTree(self.points, self.inscribed_radius, self.parent)
        return lumens_of(tree, self.branches, self.arc_length)

    @cached_property
    def _vessel_lines(self) -> VesselLines:
        return VesselLines(self.lumens)
