"""The part of a surface that a deployment can move, numbered by itself.

Everything after culling works on this patch, so that the cost follows the stent, not the vessel.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..geometry import Surface, component_labels, dot, vertex_normals
from ..validation import Points, Triangles, read_only


@dataclass(frozen=True)
class Patch:
    """Faces with at least one active vertex. Immutable.

    Attributes
    ----------
    faces : (m,) array
        Numbers of the faces in the whole surface.
    triangles : (m, 3) array
        Corners of these faces in patch numbers: first the active vertices, then the rim.
    vertices : (n,) array
        Numbers of the patch's vertices in the whole surface.
    active_count : int
        Active vertices are `0 .. active_count - 1`; the others never move.
    """

    faces: NDArray[np.int64]
    triangles: Triangles
    vertices: NDArray[np.int64]
    active_count: int

    @classmethod
    def around(cls, surface: Surface, active: NDArray[np.int64]) -> Patch:
        """The patch of the given active vertices of a surface."""
        points, triangles = surface.points, surface.triangles
        number = np.full(len(points), -1, dtype=np.int64)
        number[active] = np.arange(len(active))
        is_active = number >= 0
        # Column by column: a reduction over rows of three takes five times as long.
        first, second, third = triangles.T
        faces = np.flatnonzero(is_active[first] | is_active[second] | is_active[third])
        corners = triangles[faces]
        rim = np.unique(corners[number[corners] < 0])
        number[rim] = len(active) + np.arange(len(rim))
        vertices = np.concatenate([active, rim])
        return cls(
            read_only(faces),
            read_only(number[corners]),
            read_only(vertices),
            len(active),
        )

    def points(self, whole: Points, active: Points) -> Points:
        """Vertices (v, 3) of the patch: the active ones as given, the rim as in the whole
        surface."""
        return np.concatenate([active, whole[self.vertices[self.active_count :]]])

    def outward_normals(
        self,
        points: Points,
        direction: Points,
        distance: NDArray[np.float64],
        is_consistently_wound: bool = False,
    ) -> Points | None:
        """Unit normals of the active vertices that point out of the lumen, or None.

        The wall nearest to the stent axis is that of the stented lumen: its outward normal points
        away from the axis, in open surfaces too. This tells whether the triangles are wound
        outward or inward, for all walls alike. None when their winding is mixed, as it is in
        some files; then the whole surface has to be oriented first.

        Parameters
        ----------
        points : (n, 3) array
            The patch's vertices, mm.
        direction : (active_count, 3) array
            Unit directions away from the axis.
        distance : (active_count,) array
            Distance to the axis, mm.
        is_consistently_wound : bool
            Whether that is known already; otherwise it is checked.
        """
        if not (is_consistently_wound or self._is_consistently_wound()):
            return None
        normals = vertex_normals(points, self.triangles)[: self.active_count]
        count = max(1, len(distance) // 20)
        nearest = np.argpartition(distance, count - 1)[:count]
        facing = dot(normals[nearest], direction[nearest]).sum()
        return normals if facing >= 0 else -normals

    @property
    def has_several_parts(self) -> bool:
        """Whether the patch has several parts; they may be joined outside of it."""
        start, end = self.triangles[:, :2].T, self.triangles[:, 1:].T
        label = component_labels(len(self.vertices), start.ravel(), end.ravel())
        return bool(label[self.triangles[:, 0]].any())

    def _is_consistently_wound(self) -> bool:
        """Whether no side is run along twice in the same direction."""
        start, end = self.triangles.ravel(), self.triangles[:, [1, 2, 0]].ravel()
        keys = np.sort(start * (len(self.vertices) + 1) + end)
        return not (keys[1:] == keys[:-1]).any()
