"""Fitness of a surface for a mesher, and its faces that were faulty before."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from ..geometry import Precision, Surface, Topology, faces_at, signed_volume
from ..validation import Indices, Points
from .comparison import Verdict
from .face_quality import degenerate_triangles, inverted_triangles
from .intersections import intersecting_pairs
from .spots import FaultSpot, faults_in_words, spots_of, winding_in_words


class FaceFaults(NamedTuple):
    """Faces of a surface that no mesher can use.

    Attributes
    ----------
    pairs : (k, 2) array
        Faces that intersect.
    inverted, degenerate : arrays
        Faces turned over against those around, and faces without height, ascending.
    """

    pairs: Indices
    inverted: Indices
    degenerate: Indices

    @property
    def intersecting(self) -> Indices:
        """Indices (k,) of faces that intersect another, ascending."""
        return np.unique(self.pairs)

    @property
    def faces(self) -> Indices:
        """Indices (k,) of all faulty faces; one with several faults is repeated."""
        return np.concatenate([self.intersecting, self.inverted, self.degenerate])


@dataclass(frozen=True)
class Fitness:
    """Fitness of a surface for meshing, whoever made it so.

    Attributes
    ----------
    topology : Topology
    faults : FaceFaults
    places : tuple of FaultSpot
        Places at which faulty faces gather, most of them first.
    flipped_triangles : array
        Triangles wound against their neighbors, ascending: the fewer of each part.
    is_inside_out : bool
        Whether it is closed and consistently wound, but with its faces to the inside.
    """

    topology: Topology
    faults: FaceFaults
    places: tuple[FaultSpot, ...]
    flipped_triangles: Indices
    is_inside_out: bool

    @property
    def is_fit(self) -> bool:
        """Whether it is manifold, two-sided, wound one way and without a fault.

        A mesher can use it once it is closed and points of seams are merged.
        """
        faults = self.places or len(self.flipped_triangles)
        return self.topology.is_manifold and self.topology.is_orientable and not faults

    @property
    def is_sound(self) -> bool:
        """Whether it is fit, and outward where it is closed."""
        return self.is_fit and not self.is_inside_out

    @property
    def missing(self) -> list[str]:
        """Whatever a volume mesher requires and the surface lacks, in a few words each."""
        shape, faults = self.topology, self.faults
        found = {
            "closed": shape.is_closed,
            "merged at its seams": not shape.unshared_points,
            "manifold": shape.is_manifold,
            "two-sided": shape.is_orientable,
            "wound one way": not len(self.flipped_triangles),
            "free of self-intersections": not len(faults.pairs),
            "free of triangles turned over": not len(faults.inverted),
            "free of triangles without height": not len(faults.degenerate),
        }
        return [name for name, is_so in found.items() if not is_so]

    def in_words(self, units: str = "mm") -> str:
        """The state of the surface and its faults, to follow "it"."""
        text = "no self-intersection"
        if self.places:
            text = faults_in_words(
                self.places,
                units,
                (len(self.faults.intersecting), "intersecting"),
                (len(self.faults.inverted), "turned over"),
                (len(self.faults.degenerate), "without height"),
            )
        text += winding_in_words(len(self.flipped_triangles), self.is_inside_out)
        return f"is {self.topology.in_words()} and has {text}"

    def lasting_in_words(self) -> list[str]:
        """Faults that no motion changes and that prevent meshing, as the last part
        of a sentence."""
        shape, turned = self.topology, len(self.flipped_triangles)
        if shape.is_manifold and shape.is_orientable and not turned:
            return []
        winding = winding_in_words(turned, is_inside_out=False)
        return [f"it is {shape.in_words()}{winding}, as before"]


class JudgedSurface:
    """The topology of a surface whose fitness is known."""

    fitness: Fitness

    @property
    def topology(self) -> Topology:
        """The topology: closed, manifold, consistently wound, two-sided, boundary edges, parts."""
        return self.fitness.topology

    @property
    def is_watertight(self) -> bool:
        """Whether it is closed and manifold without merging any points first."""
        return self.topology.is_watertight and not self.topology.unshared_points

    @property
    def is_manifold(self) -> bool:
        """Whether it has at most two faces at every edge and one fan at every vertex."""
        return self.topology.is_manifold


def fitness_of(surface: Surface, precision: Precision) -> Fitness:
    """Fitness of a surface as it would be stored, with everything that is `whole` of it."""
    surface = surface.whole
    stored = precision.stored(surface.points)
    return _fitness(surface, stored, _faults(surface, stored))


def fitness_after(
    before: Surface, after: Surface, verdict: Verdict, precision: Precision
) -> Fitness:
    """Fitness of a result that a comparison has judged: faults at rest are known from the input.

    Parameters
    ----------
    before, after : Surface
    verdict : Verdict
    precision : Precision
        Precision of the comparison.
    """
    known, whole = known_faults(before, precision), after.whole
    at_rest = ~faces_at(verdict.has_moved, whole.triangles)
    faults = FaceFaults(
        np.concatenate([known.pairs[at_rest[known.pairs].all(axis=1)], verdict.pairs]),
        np.union1d(known.inverted[at_rest[known.inverted]], verdict.inverted),
        np.union1d(known.degenerate[at_rest[known.degenerate]], verdict.degenerate),
    )
    return _fitness(whole, verdict.stored, faults)


_inputs: WeakKeyDictionary[Surface, dict[Precision, FaceFaults]] = WeakKeyDictionary()
"""Known faults of inputs: a vessel that gets one stent after another is judged once."""


def known_faults(surface: Surface, precision: Precision) -> FaceFaults:
    """Faults of an input with everything that is `whole` of it, in the numbers that are stored."""
    known = _inputs.setdefault(surface, {})
    if precision not in known:
        known[precision] = _faults(surface.whole, precision.stored(surface.points))
    return known[precision]


def _faults(surface: Surface, stored: Points) -> FaceFaults:
    return FaceFaults(
        intersecting_pairs(stored, surface.triangles),
        inverted_triangles(stored, surface.wound_triangles),
        degenerate_triangles(stored, surface.triangles),
    )


def _fitness(surface: Surface, stored: Points, faults: FaceFaults) -> Fitness:
    topology, triangles = surface.topology, surface.triangles
    flipped = np.empty(0, dtype=np.int64)
    if not topology.is_consistently_wound:
        flipped = np.flatnonzero((surface.wound_triangles != triangles).any(axis=1))
    is_inside_out = topology.is_oriented and not signed_volume(stored, triangles) > 0
    places = tuple(spots_of(surface.points, triangles, faults.faces, faults.pairs))
    given = surface.given_numbers
    named = FaceFaults(*(given(numbers) for numbers in faults))
    return Fitness(topology, named, places, given(flipped), is_inside_out)
