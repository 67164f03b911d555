"""A triangle surface as one value, checked and known once, and the parts that a model has of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

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
    one_line,
    read_only,
)
from .closing import Closing, closing
from .faces import face_areas, face_normals, vertex_normals
from .inside import Inside
from .topology import (
    Topology,
    VertexNeighbors,
    consistently_wound,
    surface_topology,
    vertex_neighbors,
)


class _Mesh:
    """What follows from the triangles alone; surfaces that differ in their points share it."""

    def __init__(self, triangles: Triangles, point_count: int) -> None:
        self.triangles = triangles
        self.point_count = point_count

    @cached_property
    def topology(self) -> Topology:
        return surface_topology(self.triangles)

    @cached_property
    def corners(self) -> Triangles:
        return read_only(np.ascontiguousarray(self.triangles.T))

    @cached_property
    def neighbors(self) -> VertexNeighbors:
        found = vertex_neighbors(self.triangles, self.point_count)
        return VertexNeighbors(read_only(found.offsets), read_only(found.indices))

    @cached_property
    def wound_triangles(self) -> Triangles:
        if self.topology.is_consistently_wound:
            return self.triangles
        return read_only(consistently_wound(self.triangles)[0])

    @cached_property
    def closing(self) -> Closing:
        return closing(self.triangles, self.topology)


@dataclass(frozen=True, eq=False, init=False)
class Surface:
    """Points joined by triangles. Immutable, checked when it is made and never again.

    Parameters
    ----------
    points : array_like, shape (n, 3)
        mm; copied.
    triangles : array_like, shape (m, 3)
        Indices of the corners, any winding; copied.
    name : str
        What to call it in messages.

    Raises
    ------
    InputError
        Fewer than three points, coordinates that are no finite numbers, no triangle, or one that
        names a point that does not exist.
    """

    points: Points
    triangles: Triangles
    _mesh: _Mesh = field(repr=False)

    def __init__(self, points: ArrayLike, triangles: ArrayLike, name: str = "surface") -> None:
        checked = as_patient_points(points, f"{name} points", minimum=3)
        corners = read_only(as_triangles(triangles, len(checked), f"{name} triangles"))
        self._keep(checked, _Mesh(corners, len(checked)))

    def with_points(self, points: ArrayLike, name: str = "surface points") -> Surface:
        """The same triangles at other places; what follows from them alone is not looked at again.

        Raises
        ------
        InputError
            As many points as before did not come, or they are no finite numbers.
        """
        moved = as_patient_points(points, name)
        if moved.shape != self.points.shape:
            raise InputError(
                f"{name}: expected {len(self.points)} points as before, got {len(moved)}; "
                "give another state of the same surface."
            )
        surface = object.__new__(Surface)
        surface._keep(moved, self._mesh)
        return surface

    @property
    def topology(self) -> Topology:
        """How the triangles hang together; looked at once for all surfaces of these triangles."""
        return self._mesh.topology

    @property
    def known_topology(self) -> Topology | None:
        """The topology if it was looked at already. Only to choose the quicker of equal ways."""
        return self._mesh.__dict__.get("topology")

    @property
    def corners(self) -> Triangles:
        """The first, second and third corners (3, m) of the triangles: rows of three are slow."""
        return self._mesh.corners

    @property
    def neighbors(self) -> VertexNeighbors:
        """The points that share an edge with each; looked at once as the topology is."""
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
        """Unit normals (n, 3) of the points, the faces' weighted with their areas."""
        return read_only(vertex_normals(self.points, self.triangles))

    @property
    def closing(self) -> Closing:
        """How every part of it is closed; looked at once as the topology is."""
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
        points = np.vstack([self.points, known.middles(self.points)])
        triangles = np.vstack([known.triangles, known.fans(len(self.points))])
        return Inside(points, triangles, np.r_[known.part, known.hole_part[known.hole]])

    def _keep(self, points: Points, mesh: _Mesh) -> None:
        object.__setattr__(self, "points", read_only(points))
        object.__setattr__(self, "triangles", mesh.triangles)
        object.__setattr__(self, "_mesh", mesh)


def as_surface(value: Any, name: str = "surface") -> Surface:
    """The surface that it is; `InputError` for anything else, such as an array of points."""
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
    if after.triangles.shape != surface.triangles.shape or (
        (after.triangles != surface.triangles).any()
    ):
        raise InputError(
            f"{name}: expected the triangles of the surface before, got others; "
            "give another state of the same surface."
        )
    return surface.with_points(after.points, name)


_SAID = 3
"""So many parts are named one by one; of more the rest is counted."""


@dataclass(frozen=True, eq=False)
class NamedFaces:
    """To which part of the model every triangle belongs, as SimVascular marks its caps and walls.

    Parameters
    ----------
    ids : array_like of int, shape (m,)
        Of the triangles.
    names : mapping of int to str
        Of the parts that have one.

    Raises
    ------
    InputError
        Ids that are no row of integers.
    """

    ids: Indices
    names: Mapping[int, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        ids = np.asarray(self.ids)
        if ids.ndim != 1 or not np.issubdtype(ids.dtype, np.integer):
            raise InputError(
                f"face ids: expected one whole number for every triangle, got {ids.dtype} of shape "
                f"{ids.shape}."
            )
        object.__setattr__(self, "ids", read_only(ids.astype(np.int64)))
        names = {number: one_line(name) for number, name in self.names.items()}
        object.__setattr__(self, "names", names)

    def most(self, triangles: ArrayLike) -> int:
        """The part to which most of some triangles (k,) belong."""
        kinds, counts = np.unique(self.ids[np.asarray(triangles)], return_counts=True)
        return int(kinds[np.argmax(counts)])

    def branch_name(self, ids: Sequence[int]) -> str:
        """What a branch is called that leads to some parts."""
        if len(ids) == 1 and ids[0] in self.names:
            return self.said(ids)
        return f"branch to {self.said(ids)}"

    def said(self, ids: Sequence[int]) -> str:
        """Some parts in words, such as "face 3" or "right pulmonary artery"."""
        words = [self.names.get(number, f"face {number}") for number in ids]
        if len(words) > _SAID:
            words = [*words[:_SAID], f"{len(words) - _SAID} more"]
        return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)


def checked_faces(faces: NamedFaces | None, triangle_count: int) -> NamedFaces | None:
    """The same; `InputError` where they are of another surface."""
    if faces is not None and len(faces.ids) != triangle_count:
        raise InputError(
            f"face ids: expected one for each of {triangle_count} triangles, got {len(faces.ids)}; "
            "take them from the same file as the surface."
        )
    return faces
