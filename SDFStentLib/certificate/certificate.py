"""Proof that a surface is sound, and that a deployment left it so.

`check_surface` judges one surface; `certify` compares a surface before and after, only where it
moved, in the numbers that the written file will hold. It has to come last, after everything that
moves a point.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..geometry import Precision, Surface, Topology, as_surface, signed_volume, state_of
from ..validation import Indices, InputError, read_only
from .face_quality import (
    Comparison,
    Place,
    Verdict,
    count_in_words,
    degenerate_triangles,
    faults_in_words,
    inverted_triangles,
    places,
    sliver_triangles,
    winding_in_words,
)
from .intersections import intersecting_pairs
from .promises import LumenCheck, MotionCheck

AS_FLOAT32 = Precision(np.float32)
"""What most files hold."""

AS_PRESCRIBED = "its lumen is nowhere narrower than prescribed, and wider only where it was"


@dataclass(frozen=True)
class SurfaceCheck:
    """What `check_surface` found.

    Attributes
    ----------
    topology : Topology
        Closed, manifold, consistently wound, boundary edges, connected parts.
    is_outward : bool
        Closed, consistently wound, and its volume is positive.
    inverted_triangles, degenerate_triangles, sliver_triangles, self_intersecting_triangles
        Ascending indices: turned over against the neighbourhood; without area; with an angle
        below 1 degree; crossing, touching or covering another triangle.
    places : tuple of Place
        Where triangles of the first, second and last kind gather, most of them first.
    flipped_triangles : array
        Ascending indices of those wound against their neighbors, the fewer of each part.
    """

    topology: Topology
    is_outward: bool
    inverted_triangles: Indices
    degenerate_triangles: Indices
    sliver_triangles: Indices
    self_intersecting_triangles: Indices
    places: tuple[Place, ...]
    flipped_triangles: Indices

    @property
    def is_watertight(self) -> bool:
        """Closed and manifold."""
        return self.topology.is_watertight

    @property
    def is_manifold(self) -> bool:
        """At most two faces at every edge, one fan at every vertex."""
        return self.topology.is_manifold

    @property
    def passed(self) -> bool:
        """Manifold, outward where closed, no fault of any kind; an open surface passes."""
        faults = self.places or self.flipped_triangles.size or self.is_inside_out
        return self.is_manifold and not faults

    @property
    def is_inside_out(self) -> bool:
        """Closed and consistently wound, with its faces to the inside."""
        return self.topology.is_oriented and not self.is_outward

    def sentence(self) -> str:
        """The finding in one sentence."""
        faults = "no self-intersection"
        if self.places:
            faults = faults_in_words(
                self.places,
                (len(self.self_intersecting_triangles), "intersecting"),
                (len(self.inverted_triangles), "turned over"),
                (len(self.degenerate_triangles), "without area"),
            )
        faults += winding_in_words(len(self.flipped_triangles), self.is_inside_out)
        return f"The surface is {self.topology.in_words()} and has {faults}."

    def as_dict(self) -> dict[str, Any]:
        """The finding as it stands in a report."""
        return {
            "watertight": self.is_watertight,
            "manifold": self.is_manifold,
            "outward": self.is_outward,
            "boundary_edges": self.topology.boundary_edge_count,
            "components": self.topology.component_count,
            "inside_out": self.is_inside_out,
            "flipped_triangles": self.flipped_triangles.tolist(),
            "inverted_triangles": self.inverted_triangles.tolist(),
            "degenerate_triangles": self.degenerate_triangles.tolist(),
            "sliver_triangles": self.sliver_triangles.tolist(),
            "self_intersecting_triangles": self.self_intersecting_triangles.tolist(),
            "places": [place.center for place in self.places],
        }


@dataclass(frozen=True)
class Certificate:
    """What `certify` found.

    Attributes
    ----------
    topology : Topology
        That of the input, which a deployment cannot change.
    moved_points : int
        Number of points whose stored coordinates changed.
    self_intersecting_before, self_intersecting_after, new_self_intersecting
        Ascending indices of triangles that intersect another where one of the two moved; new are
        those that did not do so before.
    new_inverted, new_degenerate
        Triangles turned over, or without area, that were not before.
    places : tuple of Place
        Where new faults gather, most triangles first.
    motion, lumen : tuples of MotionCheck and LumenCheck
        For every stent; empty where surfaces were compared without one, and the latter where the
        settings promise no lumen: without `finish` or `facet_compensation`, as published.
    """

    topology: Topology
    moved_points: int
    self_intersecting_before: Indices
    self_intersecting_after: Indices
    new_self_intersecting: Indices
    new_inverted: Indices
    new_degenerate: Indices
    places: tuple[Place, ...]
    motion: tuple[MotionCheck, ...] = ()
    lumen: tuple[LumenCheck, ...] = ()

    @property
    def passed(self) -> bool:
        """No new fault of any kind; an open or faulty input passes when nothing got worse."""
        return not self.places and all(check.passed for check in self._checks)

    @property
    def is_watertight(self) -> bool:
        """Closed and manifold."""
        return self.topology.is_watertight

    @property
    def is_manifold(self) -> bool:
        """At most two faces at every edge, one fan at every vertex."""
        return self.topology.is_manifold

    def sentence(self) -> str:
        """The finding in one sentence for the person who will use the surface."""
        if not self.passed:
            return f"Not certified: the surface has {'; '.join(self._faults())}."
        shape = self.topology.in_words()
        old = len(self.self_intersecting_after)
        kept = f"; {count_in_words(old)} intersected already in the input" if old else ""
        wide = f"; {AS_PRESCRIBED}" if self.lumen else ""
        return f"Certified: the surface is {shape}, as it was, and has no new fault{kept}{wide}."

    @property
    def _checks(self) -> tuple[LumenCheck | MotionCheck, ...]:
        return (*self.lumen, *self.motion)

    def _faults(self) -> list[str]:
        """What is wrong, each with a number and a place."""
        faults = [check.fault() for check in self._checks if not check.passed]
        if not self.places:
            return faults
        triangles = faults_in_words(
            self.places,
            (len(self.new_self_intersecting), "that newly intersect"),
            (len(self.new_inverted), "newly turned over"),
            (len(self.new_degenerate), "newly without area"),
        )
        return [triangles, *faults]

    def as_dict(self) -> dict[str, Any]:
        """The `certificate` part of a report; what is known to the writer only is added there."""
        return {
            "passed": self.passed,
            "sentence": self.sentence(),
            "watertight": self.is_watertight,
            "manifold": self.is_manifold,
            "boundary_edges": self.topology.boundary_edge_count,
            "inverted_triangles": self.new_inverted.tolist(),
            "degenerate_triangles": self.new_degenerate.tolist(),
            "self_intersections": {
                "before": len(self.self_intersecting_before),
                "after": len(self.self_intersecting_after),
                "new": len(self.new_self_intersecting),
                "triangle_ids": self.new_self_intersecting.tolist(),
            },
            "places": [place.center for place in self.places],
            "moved_points": self.moved_points,
            "motion": [check.as_dict() for check in self.motion],
            "lumen": [check.as_dict() for check in self.lumen],
        }


def check_surface(surface: Surface, *, precision: Precision | None = None) -> SurfaceCheck:
    """Whether a surface is closed, manifold, oriented and free of faulty triangles.

    Parameters
    ----------
    surface : Surface
    precision : Precision, optional
        Type and unit of the stored coordinates; the check is on these. By default as they are.

    Raises
    ------
    InputError
        No surface, or coordinates that are too large for the type.
    """
    points, triangles = as_surface(surface).points, surface.triangles
    wound, stored = surface.wound_triangles, (precision or Precision()).stored(points)
    topology = surface.topology

    pairs = intersecting_pairs(stored, triangles)
    intersecting = np.unique(pairs)
    inverted = inverted_triangles(stored, wound)
    degenerate = degenerate_triangles(stored, triangles)
    faults = np.r_[intersecting, inverted, degenerate]
    return SurfaceCheck(
        topology=topology,
        is_outward=topology.is_oriented and signed_volume(stored, triangles) > 0,
        inverted_triangles=read_only(inverted),
        degenerate_triangles=read_only(degenerate),
        sliver_triangles=read_only(sliver_triangles(stored, triangles)),
        self_intersecting_triangles=read_only(intersecting),
        places=tuple(places(points, triangles, faults, pairs)),
        flipped_triangles=read_only(np.flatnonzero((wound != triangles).any(axis=1))),
    )


def certify(
    before: Surface,
    after: Surface | ArrayLike,
    moved: ArrayLike | None = None,
    *,
    precision: Precision = AS_FLOAT32,
    check: SurfaceCheck | None = None,
) -> Certificate:
    """Whether a surface is as sound after its points moved as it was before.

    Parameters
    ----------
    before : Surface
        The input.
    after : Surface, or array_like of shape (n, 3)
        The result: with the same triangles, or its points, mm.
    moved : array_like, optional
        Indices, or a mask (n,), of the points that may have moved; found by comparison when left
        out. Those whose stored coordinates are unchanged are dropped.
    precision : Precision
        Type and unit of the stored coordinates; the judgement is on these.
    check : SurfaceCheck, optional
        `check_surface` of the input: when it found no intersection, that spares the search in the
        input. Without it the input is searched only at the faces that intersect in the result.

    Raises
    ------
    InputError
        No surface, a result that is not one of it, or coordinates too large for the type.
    """
    after = state_of(as_surface(before, "before"), after)
    comparison = Comparison(
        before.points,
        before.wound_triangles,
        precision,
        None if check is None else check.self_intersecting_triangles,
    )
    may_move = _mask(moved, len(before.points))
    return certificate_of(comparison.verdict(after.points, may_move=may_move), before.topology)


def certificate_of(
    verdict: Verdict,
    topology: Topology,
    motion: tuple[MotionCheck, ...] = (),
    lumen: tuple[LumenCheck, ...] = (),
) -> Certificate:
    """The certificate of a result that was compared with its input."""
    return Certificate(
        topology=topology,
        moved_points=int(np.count_nonzero(verdict.has_moved)),
        self_intersecting_before=read_only(np.unique(verdict.pairs_before)),
        self_intersecting_after=read_only(np.unique(verdict.pairs)),
        new_self_intersecting=read_only(verdict.new_self_intersecting),
        new_inverted=read_only(verdict.new_inverted),
        new_degenerate=read_only(verdict.new_degenerate),
        places=verdict.places,
        motion=motion,
        lumen=lumen,
    )


def _mask(moved: ArrayLike | None, count: int) -> NDArray[np.bool_] | None:
    """The points that may have moved as a mask (n,); None for all."""
    if moved is None:
        return None
    chosen = np.asarray(moved)
    may_move = np.zeros(count, dtype=bool)
    if chosen.size:
        try:
            may_move[chosen] = True
        except IndexError as error:
            raise InputError(
                f"moved: expected indices or a mask of {count} points, got {chosen.dtype} "
                f"{chosen.shape} ({error})."
            ) from error
    return may_move
