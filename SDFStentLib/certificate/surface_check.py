"""Check of a single surface."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..cautions import Caution
from ..geometry import Precision, Surface, as_surface
from ..validation import Indices, read_only
from .face_quality import Slivers, degenerate_triangles, slivers_among
from .fitness import Fitness, JudgedSurface, fitness_of
from .spots import FaultSpot


@dataclass(frozen=True)
class SurfaceCheck(JudgedSurface):
    """The findings of `check_surface`.

    Attributes
    ----------
    fitness : Fitness
        Topology and faulty faces of the surface.
    slivers : Slivers
        Other triangles with an angle below 1 degree, which is no fault.
    """

    fitness: Fitness
    slivers: Slivers

    @property
    def is_outward(self) -> bool:
        """Whether it is closed, consistently wound, and its volume is positive."""
        return self.topology.is_oriented and not self.is_inside_out

    @property
    def is_inside_out(self) -> bool:
        """Whether it is closed and consistently wound, but with its faces to the inside."""
        return self.fitness.is_inside_out

    @property
    def inverted_triangles(self) -> Indices:
        """Indices (k,) of triangles turned over against their neighborhood, ascending."""
        return read_only(self.fitness.faults.inverted)

    @property
    def degenerate_triangles(self) -> Indices:
        """Indices (k,) of triangles without height, ascending."""
        return read_only(self.fitness.faults.degenerate)

    @property
    def self_intersecting_triangles(self) -> Indices:
        """Indices (k,) of triangles that cross, touch or cover another one, ascending."""
        return read_only(self.fitness.faults.intersecting)

    @property
    def places(self) -> tuple[FaultSpot, ...]:
        """Places at which triangles of these three kinds gather, most of them first."""
        return self.fitness.places

    @property
    def flipped_triangles(self) -> Indices:
        """Indices (k,) of triangles wound against their neighbors, ascending: the fewer of each
        part."""
        return read_only(self.fitness.flipped_triangles)

    @property
    def passed(self) -> bool:
        """Whether it is manifold, two-sided, outward where closed, and without a fault.

        A surface that is open or has slivers can pass.
        """
        return self.fitness.is_sound

    def sentence(self, units: str = "mm") -> str:
        """The finding in one sentence; places are given in the unit of the file, too."""
        return f"The surface {self.fitness.in_words(units)}."

    def cautions(self) -> tuple[Caution, ...]:
        """Cautions on what is no fault but matters for meshing."""
        return self.slivers.cautions()

    def as_dict(self) -> dict[str, Any]:
        """The finding as a part of a report."""
        return {
            "watertight": self.is_watertight,
            "manifold": self.is_manifold,
            "outward": self.is_outward,
            "orientable": self.topology.is_orientable,
            "boundary_edges": self.topology.boundary_edge_count,
            "components": self.topology.component_count,
            "unshared_points": self.topology.unshared_points,
            "inside_out": self.is_inside_out,
            "flipped_triangles": self.flipped_triangles.tolist(),
            "inverted_triangles": self.inverted_triangles.tolist(),
            "degenerate_triangles": self.degenerate_triangles.tolist(),
            "sliver_triangles": self.slivers.triangles.tolist(),
            "self_intersecting_triangles": self.self_intersecting_triangles.tolist(),
            "places": [place.center for place in self.places],
        }


def check_surface(surface: Surface, *, precision: Precision | None = None) -> SurfaceCheck:
    """Whether a surface is closed, manifold, oriented and free of faulty triangles.

    Parameters
    ----------
    surface : Surface
        The surface; all that is `whole` of it is examined.
    precision : Precision, optional
        Type and unit of the stored coordinates, which are checked. By default those of the surface.

    Raises
    ------
    InputError
        No surface, or coordinates that are too large for the type.
    """
    surface, precision = as_surface(surface).whole, precision or Precision()
    points, triangles = precision.stored(surface.points), surface.triangles
    others = np.delete(np.arange(len(triangles)), degenerate_triangles(points, triangles))
    slivers = slivers_among(points / precision.scale, triangles, others)
    fitness = fitness_of(surface, precision)
    given = surface.given_numbers(slivers.triangles)
    return SurfaceCheck(fitness, slivers._replace(triangles=given))
