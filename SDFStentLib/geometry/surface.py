"""A triangle surface as one value: checked once, never changed, and known once."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

from ..validation import Floats, InputError, Points, Triangles, as_points, as_triangles, read_only
from .faces import face_normals, vertex_normals
from .topology import Topology, VertexNeighbors, surface_topology, vertex_neighbors


class _Mesh:
    """What follows from the triangles alone; surfaces that differ in their points share it."""

    def __init__(self, triangles: Triangles, point_count: int) -> None:
        self.triangles = triangles
        self.point_count = point_count

    @cached_property
    def topology(self) -> Topology:
        return surface_topology(self.triangles)

    @cached_property
    def neighbors(self) -> VertexNeighbors:
        found = vertex_neighbors(self.triangles, self.point_count)
        return VertexNeighbors(read_only(found.offsets), read_only(found.indices))


@dataclass(frozen=True, eq=False)
class Surface:
    """Points joined by triangles. Immutable, checked when it is made and never again.

    Parameters
    ----------
    points : array_like, shape (n, 3)
        mm; copied.
    triangles : array_like, shape (m, 3)
        Indices of the corners, any winding; copied.

    Raises
    ------
    InputError
        Fewer than three points, coordinates that are no finite numbers, no triangle, or one that
        names a point that does not exist.
    """

    points: Points
    triangles: Triangles
    _mesh: _Mesh = field(init=False, repr=False)

    def __post_init__(self) -> None:
        points = as_points(self.points, "surface points", minimum=3)
        triangles = read_only(as_triangles(self.triangles, len(points), "surface triangles"))
        self._keep(points, _Mesh(triangles, len(points)))

    def with_points(self, points: Points) -> Surface:
        """The same triangles at other places; what follows from them alone is not looked at again.

        Raises
        ------
        InputError
            As many points as before did not come, or they are no finite numbers.
        """
        moved = as_points(points, "surface points")
        if moved.shape != self.points.shape:
            raise InputError(
                f"surface points: expected {len(self.points)} points as before, got {len(moved)}; "
                "make a new surface for other triangles."
            )
        surface = object.__new__(Surface)
        surface._keep(moved, self._mesh)
        return surface

    @property
    def topology(self) -> Topology:
        """How the triangles hang together; looked at once for all surfaces of these triangles."""
        return self._mesh.topology

    @property
    def neighbors(self) -> VertexNeighbors:
        """The points that share an edge with each; looked at once as the topology is."""
        return self._mesh.neighbors

    @cached_property
    def face_normals(self) -> Floats:
        """Unit normals (m, 3) as the triangles are wound; zero for one without area."""
        return read_only(face_normals(self.points, self.triangles))

    @cached_property
    def vertex_normals(self) -> Floats:
        """Unit normals (n, 3) of the points, the faces' weighted with their areas."""
        return read_only(vertex_normals(self.points, self.triangles))

    def _keep(self, points: Points, mesh: _Mesh) -> None:
        object.__setattr__(self, "points", read_only(points))
        object.__setattr__(self, "triangles", mesh.triangles)
        object.__setattr__(self, "_mesh", mesh)
