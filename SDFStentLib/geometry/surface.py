"""Triangle surface: checked once, its derived values worked out once."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..validation import (
    Flags,
    Floats,
    Indices,
    InputError,
    Points,
    Triangles,
    as_patient_points,
    as_triangles,
    in_short,
    read_only,
)
from .closing import Closing
from .faces import compacted, face_areas, face_normals, vertex_normals
from .fans import component_labels
from .inside import Inside
from .seams import Triangulation
from .topology import Topology, VertexNeighbors


@dataclass(frozen=True, eq=False, init=False)
class Surface:
    """Points joined by triangles. Immutable, checked when it is made and never again.

    Points of a seam that lie on each other without being shared count as one: the triangles use the
    first of them, and the others, its `copies`, follow it. A triangle that repeats another is no
    wall and is left out of the triangles; `whole` has it. Points keep the numbers that were given;
    `cells` holds the numbers that the triangles had.

    Parameters
    ----------
    points : array_like, shape (n, 3)
        mm; copied.
    triangles : array_like, shape (m, 3)
        Indices of the corners, any winding; copied.
    name : str
        Name of the surface in messages.
    is_left_out : array_like of bool, shape (m,), optional
        Triangles that do not count, such as ghost cells; they are not in `whole` either.

    Raises
    ------
    InputError
        Fewer than three points, coordinates that are no finite numbers, no triangle, or one that
        names a point that does not exist.
    """

    points: Points
    triangles: Triangles
    _mesh: Triangulation = field(repr=False)

    def __init__(
        self,
        points: ArrayLike,
        triangles: ArrayLike,
        name: str = "surface",
        is_left_out: Flags | None = None,
    ) -> None:
        checked = as_patient_points(points, f"{name} points", minimum=3)
        corners = read_only(as_triangles(triangles, len(checked), f"{name} triangles"))
        self._keep(checked, Triangulation(checked, corners, is_left_out))

    def with_points(self, points: ArrayLike, name: str = "surface points") -> Surface:
        """A surface of the same triangles with other points; the topology is not worked out again.

        Raises
        ------
        InputError
            Not as many points as before, or coordinates that are no finite numbers.
        """
        moved = as_patient_points(points, name)
        if moved.shape != self.points.shape:
            raise InputError(
                f"{name}: expected {len(self.points)} points as before, got {len(moved)}; "
                "give another state of the same surface."
            )
        return self._with(moved, self._mesh)

    @property
    def whole(self) -> Surface:
        """The surface with every triangle that belongs to it, also those that repeat others."""
        mesh = self._mesh.of_whole
        return self if mesh is self._mesh else self._with(self.points, mesh)

    @property
    def cells(self) -> Indices | None:
        """(m,) numbers that the triangles had when the surface was made; None where all of them
        count."""
        return self._mesh.cells

    @property
    def made_of(self) -> int:
        """Number of triangles of which the surface was made."""
        return len(self._mesh.given)

    @property
    def unshared_points(self) -> int:
        """Number of copies that close a seam."""
        return self._mesh.unshared

    @property
    def followers(self) -> Indices:
        """(f,) points that are no wall but follow it, such as those of its outer side."""
        return self._mesh.followers

    @property
    def again_count(self) -> int:
        """Number of triangles that repeat others."""
        return self._mesh.again_count

    @property
    def copies(self) -> Indices:
        """(c,) points that lie on a point of the wall and count as that point."""
        return self._mesh.copies

    def given_numbers(self, triangles: Indices) -> Indices:
        """Numbers that some triangles (k,) of the surface had when it was made."""
        return triangles if self.cells is None else self.cells[triangles]

    def of_given(self, values: NDArray[Any]) -> NDArray[Any]:
        """Rows for the triangles of the surface, from rows (k, ...) for all that were given."""
        return values if self.cells is None else values[self.cells]

    def to_given(self, values: NDArray[Any]) -> NDArray[Any]:
        """Rows (g, ...) for all triangles that were given, from rows (m, ...) for those of the
        surface; NaN or 0 elsewhere."""
        if self.cells is None:
            return values
        fill = np.nan if values.dtype.kind == "f" else 0
        rows = np.full((self.made_of, *values.shape[1:]), fill, dtype=values.dtype)
        rows[self.cells] = values
        return rows

    def followed(
        self, indices: Indices, coordinates: Points, before: Points | None = None
    ) -> tuple[Indices, Points]:
        """Moved points of the wall (k,) and their new places, mm, with all points that follow them.

        Parameters
        ----------
        indices, coordinates : (k,) and (k, 3) arrays
        before : (n, 3) array, optional
            Places before the move; by default the points of this surface.
        """
        mesh = self._mesh
        if mesh.weights is not None:
            before = self.points if before is None else before
            shift = np.zeros((mesh.point_count, 3))
            shift[indices] = coordinates - before[indices]
            along = mesh.weights @ shift
            moves = along.any(axis=1)
            where = mesh.followers[moves]
            indices = np.concatenate([indices, where])
            coordinates = np.concatenate([coordinates, before[where] + along[moves]])
        if len(mesh.copies):
            row = np.full(mesh.point_count, -1, dtype=np.int64)
            row[indices] = np.arange(len(indices))
            found = row[mesh.originals]
            follows = found >= 0
            indices = np.concatenate([indices, mesh.copies[follows]])
            coordinates = np.concatenate([coordinates, coordinates[found[follows]]])
        return indices, coordinates

    def with_copies(self, points: Points) -> Points:
        """Points (n, 3), mm, with every copy at the place of its original; written into the given
        array."""
        points[self._mesh.copies] = points[self._mesh.originals]
        return points

    def without(self, is_apart: Flags, is_island: Flags) -> Surface:
        """The surface without some of its triangles (m,), which are in its `whole` as before.

        Points of the triangles apart, such as the outer side of a wall, follow the nearest wall.
        Points of islands stay where they are.
        """
        return self._with(self.points, self._mesh.without(self.points, is_apart, is_island))

    @property
    def islands(self) -> Triangles:
        """(k, 3) triangles of closed parts that float in the lumen, and are no wall of it."""
        return self._mesh.islands

    def with_islands(self, line: Points) -> Surface:
        """The surface with its islands behind its own triangles, except those that hold a place of
        a line.

        Parameters
        ----------
        line : (k, 3) array
            Axis along which is measured, mm: an island that it runs through is no wall beside it.
        """
        if not len(self.islands):
            return self
        islands = self.islands
        label = component_labels(len(self.points), islands[:, :2].ravel(), islands[:, 1:].ravel())
        part = label[islands[:, 0]]
        kept = [
            own
            for own in (islands[part == number] for number in np.unique(part))
            if not Surface(*compacted(self.points, own)).contains(line).any()
        ]
        surface = Surface(self.points, np.concatenate([self.triangles, *kept]))
        object.__setattr__(surface, "_wall", self)
        return surface

    @property
    def wall(self) -> Surface:
        """The surface without the islands that `with_islands` has put behind its triangles."""
        return self.__dict__.get("_wall", self)

    @property
    def topology(self) -> Topology:
        """Connectivity of the triangles; worked out once for all surfaces of these triangles."""
        return self._mesh.topology

    @property
    def known_topology(self) -> Topology | None:
        """The topology if it is known already. Only for choosing the quicker of two equal ways."""
        return self._mesh.__dict__.get("topology")

    @property
    def corners(self) -> Triangles:
        """The first, second and third corners (3, m) of the triangles: rows of three are slow."""
        return self._mesh.corners

    @property
    def neighbors(self) -> VertexNeighbors:
        """The points that share an edge with each point; worked out once, as the topology is."""
        return self._mesh.neighbors

    @property
    def wound_triangles(self) -> Triangles:
        """The triangles (m, 3), neighbors wound alike: see `consistently_wound`."""
        return self._mesh.wound_triangles

    @cached_property
    def face_areas(self) -> Floats:
        """Areas (m,) of the triangles, mm^2."""
        return read_only(face_areas(self.points, self.triangles))

    @cached_property
    def face_normals(self) -> Floats:
        """Unit normals (m, 3) as the triangles are wound; zero for one without area."""
        return read_only(face_normals(self.points, self.triangles))

    @cached_property
    def vertex_normals(self) -> Floats:
        """Unit normals (n, 3) of the points: the faces' normals, weighted with their areas."""
        return read_only(vertex_normals(self.points, self.triangles))

    @property
    def closing(self) -> Closing:
        """Closing of every part of the surface; worked out once, as the topology is."""
        return self._mesh.closing

    @cached_property
    def closed(self) -> Surface:
        """The surface with a fan of triangles over every hole, to the middle of its rim."""
        if not len(self.closing.rims):
            return self
        fans = self.closing.fans(len(self.points))
        points = np.vstack([self.points, self.closing.middles(self.points)])
        return Surface(points, np.vstack([self.triangles, fans]))

    def contains(self, places: Points) -> Flags:
        """Whether each place (k, 3), mm, lies inside of the surface or on it, see `Inside`.

        Whatever its winding; open ends count as closed by `closed`. Inside of any part of it
        counts, so that a lumen is inside also where its outer wall is in the same surface.
        """
        return self._inside.contains(places)

    @cached_property
    def _inside(self) -> Inside:
        known = self.closing
        if not len(known.rims):
            is_own = known.triangles is self.triangles
            corners = self.corners if is_own else np.ascontiguousarray(known.triangles.T)
            return Inside(self.points, corners, known.part)
        points = np.vstack([self.points, known.middles(self.points)])
        triangles = np.vstack([known.triangles, known.fans(len(self.points))])
        part = np.r_[known.part, known.hole_part[known.hole]]
        return Inside(points, np.ascontiguousarray(triangles.T), part)

    @staticmethod
    def _with(points: Points, mesh: Triangulation) -> Surface:
        surface = object.__new__(Surface)
        surface._keep(points, mesh)
        return surface

    def _keep(self, points: Points, mesh: Triangulation) -> None:
        object.__setattr__(self, "points", read_only(points))
        object.__setattr__(self, "triangles", mesh.triangles)
        object.__setattr__(self, "_mesh", mesh)


def as_surface(value: Any, name: str = "surface") -> Surface:
    """The value itself if it is a `Surface`; `InputError` for all else, such as an array of
    points."""
    if not isinstance(value, Surface):
        raise InputError(
            f"{name}: expected a Surface, got {in_short(type(value).__name__)}; "
            "make one of arrays by Surface(points, triangles)."
        )
    return value


def state_of(surface: Surface, after: Surface | ArrayLike, name: str = "after") -> Surface:
    """Another state of a surface, given as a surface with the same triangles or as its points.

    Raises
    ------
    InputError
        A surface with other triangles, or points that are not as many as before.
    """
    if not isinstance(after, Surface):
        return surface.with_points(after, name)
    if after.triangles is surface.triangles:
        return after
    # As they were given: points that came to lie on each other later are still their own.
    one, other = surface._mesh.given, after._mesh.given
    if one.shape != other.shape or (one != other).any():
        raise InputError(
            f"{name}: expected the triangles of the surface before, got others; "
            "give another state of the same surface."
        )
    return surface.with_points(after.points, name)
