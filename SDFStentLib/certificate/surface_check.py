"""Whether one surface is sound as it is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..cautions import Caution
from ..geometry import Precision, Surface, Topology, as_surface, signed_volume
from ..validation import Indices, read_only
from .face_quality import Slivers, degenerate_triangles, inverted_triangles, slivers_among
from .intersections import intersecting_pairs
from .spots import Spot, faults_in_words, spots_of, winding_in_words


@dataclass(frozen=True)
class SurfaceCheck:
    """What `check_surface` found.

    Attributes
    ----------
    topology : Topology
        Closed, manifold, consistently wound, two-sided, boundary edges, connected parts.
    is_outward : bool
        Closed, consistently wound, and its volume is positive.
    inverted_triangles, degenerate_triangles, self_intersecting_triangles
        Ascending indices: turned over against the neighbourhood; without height; crossing,
        touching or covering another triangle.
    slivers : Slivers
        Others with an angle below 1 degree, which is no fault.
    places : tuple of Spot
        Where triangles of the first three kinds gather, most of them first.
    flipped_triangles : array
        Ascending indices of those wound against their neighbors, the fewer of each part.
    """

    topology: Topology
    is_outward: bool
    inverted_triangles: Indices
    degenerate_triangles: Indices
    slivers: Slivers
    self_intersecting_triangles: Indices
    places: tuple[Spot, ...]
    flipped_triangles: Indices

    @property
    def is_watertight(self) -> bool:
        """Closed and manifold, and no points have to be merged for that."""
        return self.topology.is_watertight and not self.topology.unshared_points

    @property
    def is_manifold(self) -> bool:
        """At most two faces at every edge, one fan at every vertex."""
        return self.topology.is_manifold

    @property
    def passed(self) -> bool:
        """Manifold, two-sided, outward where closed, no fault; one open or with slivers passes."""
        faults = self.places or self.flipped_triangles.size or self.is_inside_out
        return self.is_manifold and self.topology.is_orientable and not faults

    @property
    def is_inside_out(self) -> bool:
        """Closed and consistently wound, with its faces to the inside."""
        return self.topology.is_oriented and not self.is_outward

    def sentence(self, units: str = "mm") -> str:
        """The finding in one sentence; places are told in the unit of the file, too."""
        faults = "no self-intersection"
        if self.places:
            faults = faults_in_words(
                self.places,
                units,
                (len(self.self_intersecting_triangles), "intersecting"),
                (len(self.inverted_triangles), "turned over"),
                (len(self.degenerate_triangles), "without height"),
            )
        faults += winding_in_words(len(self.flipped_triangles), self.is_inside_out)
        return f"The surface is {self.topology.in_words()} and has {faults}."

    def cautions(self) -> tuple[Caution, ...]:
        """What is no fault, but has to be known before meshing."""
        return self.slivers.cautions()

    def as_dict(self) -> dict[str, Any]:
        """The finding as it stands in a report."""
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
        All that is `whole` of it is looked at.
    precision : Precision, optional
        Type and unit of the stored coordinates; the check is on these. By default as they are.

    Raises
    ------
    InputError
        No surface, or coordinates that are too large for the type.
    """
    surface = as_surface(surface).whole
    points, triangles, given = surface.points, surface.triangles, surface.given_numbers
    precision = precision or Precision()
    wound, stored = surface.wound_triangles, precision.stored(points)
    topology = surface.topology

    pairs = intersecting_pairs(stored, triangles)
    intersecting = np.unique(pairs)
    inverted = inverted_triangles(stored, wound)
    degenerate = degenerate_triangles(stored, triangles)
    others = np.setdiff1d(np.arange(len(triangles)), degenerate)
    faults = np.r_[intersecting, inverted, degenerate]
    slivers = slivers_among(stored / precision.scale, triangles, others)
    return SurfaceCheck(
        topology=topology,
        is_outward=topology.is_oriented and signed_volume(stored, triangles) > 0,
        inverted_triangles=read_only(given(inverted)),
        degenerate_triangles=read_only(given(degenerate)),
        slivers=slivers._replace(triangles=given(slivers.triangles)),
        self_intersecting_triangles=read_only(given(intersecting)),
        places=tuple(spots_of(points, triangles, faults, pairs)),
        flipped_triangles=read_only(given(np.flatnonzero((wound != triangles).any(axis=1)))),
    )
