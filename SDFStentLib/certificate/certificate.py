"""Proof that a deployment left a surface as sound as it was.

`certify` compares a surface before and after, only where it moved, in the numbers that the written
file will hold. It has to come last, after everything that moves a point.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..cautions import Caution
from ..geometry import Precision, Surface, Topology, as_surface, state_of
from ..validation import Indices, InputError, read_only
from .comparison import Comparison, Verdict
from .face_quality import Slivers
from .promises import LumenCheck, MotionCheck, lumen_in_words
from .spots import Spot, count_in_words, faults_in_words

AS_FLOAT32 = Precision(np.float32)
"""What most files hold."""

CERTIFIED = "Surface certified for meshing"
NOT_CERTIFIED = "Surface not certified for meshing"
"""What a certificate is called wherever it is told: it says nothing of the treatment."""


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
        Triangles turned over, or without height, that were not before.
    new_slivers : Slivers
        Others that became much worse than they were, which is no fault.
    places : tuple of Spot
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
    new_slivers: Slivers
    places: tuple[Spot, ...]
    motion: tuple[MotionCheck, ...] = ()
    lumen: tuple[LumenCheck, ...] = ()

    @property
    def passed(self) -> bool:
        """No new fault of any kind; an open or faulty input passes when nothing got worse."""
        return not self.places and all(check.passed for check in self._checks)

    @property
    def is_watertight(self) -> bool:
        """Closed and manifold, and no points have to be merged for that."""
        return self.topology.is_watertight and not self.topology.unshared_points

    @property
    def is_manifold(self) -> bool:
        """At most two faces at every edge, one fan at every vertex."""
        return self.topology.is_manifold

    def sentence(self, units: str = "mm") -> str:
        """The finding in one sentence for the person who will use the surface.

        Places are told in mm and in the unit of its file.
        """
        if not self.passed:
            return f"{NOT_CERTIFIED}: it has {'; '.join(self._faults(units))}."
        shape = self.topology.in_words()
        old = len(self.self_intersecting_after)
        kept = f"; {count_in_words(old)} intersected already in the input" if old else ""
        if self.topology.is_orientable and not self.topology.is_consistently_wound:
            kept += "; triangles are wound against their neighbors, as they were"
        wide = f"; {lumen_in_words(self.lumen, units)}" if self.lumen else ""
        return f"{CERTIFIED}: it is {shape}, as it was, and has no new fault{kept}{wide}."

    def cautions(self) -> tuple[Caution, ...]:
        """What is no fault, but has to be known before meshing."""
        return self.new_slivers.cautions()

    @property
    def _checks(self) -> tuple[LumenCheck | MotionCheck, ...]:
        return (*self.lumen, *self.motion)

    def _faults(self, units: str) -> list[str]:
        """What is wrong, each with a number and a place."""
        faults = [check.fault(units) for check in self._checks if not check.passed]
        if not self.places:
            return faults
        triangles = faults_in_words(
            self.places,
            units,
            (len(self.new_self_intersecting), "that newly intersect"),
            (len(self.new_inverted), "newly turned over"),
            (len(self.new_degenerate), "newly without height"),
        )
        return [triangles, *faults]

    def as_dict(self, units: str = "mm") -> dict[str, Any]:
        """The `certificate` part of a report; what is known to the writer only is added there."""
        return {
            "passed": self.passed,
            "sentence": self.sentence(units),
            "watertight": self.is_watertight,
            "manifold": self.is_manifold,
            "orientable": self.topology.is_orientable,
            "consistently_wound": self.topology.is_consistently_wound,
            "boundary_edges": self.topology.boundary_edge_count,
            "inverted_triangles": self.new_inverted.tolist(),
            "degenerate_triangles": self.new_degenerate.tolist(),
            "new_slivers": self.new_slivers.as_dict(),
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


def certify(
    before: Surface,
    after: Surface | ArrayLike,
    moved: ArrayLike | None = None,
    *,
    precision: Precision = AS_FLOAT32,
) -> Certificate:
    """Whether a surface is as sound after its points moved as it was before.

    Parameters
    ----------
    before : Surface
        The input, of which all that is `whole` is looked at.
    after : Surface, or array_like of shape (n, 3)
        The result: with the same triangles, or its points, mm.
    moved : array_like, optional
        Indices, or a mask (n,), of the points that may have moved; found by comparison when left
        out. Those whose stored coordinates are unchanged are dropped.
    precision : Precision
        Type and unit of the stored coordinates; the judgement is on these.

    Raises
    ------
    InputError
        No surface, a result that is not one of it, or coordinates too large for the type.
    """
    after = state_of(as_surface(before, "before"), after)
    whole = before.whole
    comparison = Comparison(whole.points, whole.wound_triangles, precision)
    may_move = _mask(moved, len(before.points))
    verdict = comparison.verdict(after.points, may_move=may_move)
    return certificate_of(verdict, comparison.new_slivers(verdict), whole)


def certificate_of(
    verdict: Verdict,
    new_slivers: Slivers,
    surface: Surface,
    motion: tuple[MotionCheck, ...] = (),
    lumen: tuple[LumenCheck, ...] = (),
) -> Certificate:
    """The certificate of a result that was compared with its input, a surface."""
    given = surface.given_numbers
    return Certificate(
        topology=surface.topology,
        moved_points=int(np.count_nonzero(verdict.has_moved)),
        self_intersecting_before=read_only(given(np.unique(verdict.pairs_before))),
        self_intersecting_after=read_only(given(np.unique(verdict.pairs))),
        new_self_intersecting=read_only(given(verdict.new_self_intersecting)),
        new_inverted=read_only(given(verdict.new_inverted)),
        new_degenerate=read_only(given(verdict.new_degenerate)),
        new_slivers=new_slivers._replace(triangles=given(new_slivers.triangles)),
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
