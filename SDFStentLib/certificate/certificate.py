"""Proof that a deployment left a surface sound.

`certify` compares a surface before and after, where it moved, in the numbers that the written file
will hold: it is no worse. What never was fit for a mesher is not certified either. It has to come
last, after everything that moves a point.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..cautions import Caution
from ..geometry import Precision, Surface, as_surface, state_of
from ..validation import Indices, InputError, read_only
from .comparison import Comparison, Verdict
from .face_quality import Slivers
from .fitness import Fitness, JudgedSurface, fitness_after
from .promises import LumenCheck, MotionCheck, lumen_in_words
from .spots import FaultSpot, faults_in_words

AS_FLOAT32 = Precision(np.float32)
"""The precision of most files."""

CERTIFIED = "certified for meshing"
CERTIFIED_OPEN = "certified for meshing once its openings are closed"
CERTIFIED_IN_PIECES = "certified for meshing once its points are merged"
NOT_READY = "no worse than before, not ready for a mesher"
NOT_CERTIFIED = "not certified for meshing"
"""Words for a surface wherever its certificate is reported; they say nothing of the treatment."""


def said_of(word: str) -> str:
    """The beginning of a certificate's sentence, from its word."""
    return f"Surface {word}"


@dataclass(frozen=True)
class Certificate(JudgedSurface):
    """The findings of `certify`.

    Attributes
    ----------
    fitness : Fitness
        Fitness of the result, whoever made it so; a deployment cannot change its topology.
    moved_points : int
        Number of points whose stored coordinates changed.
    self_intersecting_before, self_intersecting_after, new_self_intersecting
        Ascending indices of triangles that intersect another one where one of the two moved; new
        are those that did not before.
    new_inverted, new_degenerate
        Triangles turned over, or without height, that were not so before.
    new_slivers : Slivers
        Other triangles that became much worse than they were, which is no fault.
    places : tuple of FaultSpot
        Places at which new faults gather, most triangles first.
    motion, lumen : tuples of MotionCheck and LumenCheck
        Checks of every stent. Both are empty where surfaces were compared without one; `lumen` is
        also empty where the settings promise none, without `finish` or `facet_compensation`.
    """

    fitness: Fitness
    moved_points: int
    self_intersecting_before: Indices
    self_intersecting_after: Indices
    new_self_intersecting: Indices
    new_inverted: Indices
    new_degenerate: Indices
    new_slivers: Slivers
    places: tuple[FaultSpot, ...]
    motion: tuple[MotionCheck, ...] = ()
    lumen: tuple[LumenCheck, ...] = ()

    @property
    def passed(self) -> bool:
        """Whether it is certified: no new fault of any kind, nor one of the input;
        it may be open."""
        return self.is_no_worse and self.fitness.is_fit

    @property
    def is_no_worse(self) -> bool:
        """Whether there is no new fault of any kind; a faulty input may have left its own."""
        return not self.places and all(check.passed for check in self._checks)

    @property
    def word(self) -> str:
        """The word for the surface: one of those above."""
        if not self.is_no_worse:
            return NOT_CERTIFIED
        if not self.passed:
            return NOT_READY
        if not self.topology.is_closed:
            return CERTIFIED_OPEN
        return CERTIFIED_IN_PIECES if self.topology.unshared_points else CERTIFIED

    def sentence(self, units: str = "mm") -> str:
        """The finding in one sentence for the person who will use the surface.

        Places are given in mm and in the unit of its file.
        """
        if not self.is_no_worse:
            faults = [*self._faults(units), *self.fitness.lasting_in_words()]
            return f"{said_of(self.word)}: it has {'; '.join(faults)}."
        wide = f"; {lumen_in_words(self.lumen, units)}" if self.lumen else ""
        if not self.passed:
            found = f"it {self.fitness.in_words(units)}, as before"
            return f"{said_of(self.word)}: {found}; repair the input before meshing{wide}."
        shape = self.topology.in_words()
        inward = "; its triangles face inward, as they did" if self.fitness.is_inside_out else ""
        return (
            f"{said_of(self.word)}: it is {shape}, as it was, and has no new fault{inward}{wide}."
        )

    def cautions(self) -> tuple[Caution, ...]:
        """Cautions on what is no fault but matters for meshing."""
        return self.new_slivers.cautions()

    @property
    def _checks(self) -> tuple[LumenCheck | MotionCheck, ...]:
        return (*self.lumen, *self.motion)

    def _faults(self, units: str) -> list[str]:
        """The faults in words, each with a number and a place."""
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
        """The `certificate` part of a report; the writer adds what only it knows."""
        return {
            "passed": self.passed,
            "word": self.word,
            "sentence": self.sentence(units),
            "no_worse_than_before": self.is_no_worse,
            "ready_for_meshing": not self.fitness.missing,
            "missing_for_meshing": self.fitness.missing,
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
        The input; its `whole` surface is looked at.
    after : Surface, or array_like of shape (n, 3)
        The result: a surface with the same triangles, or its points, mm.
    moved : array_like, optional
        Indices, or a mask (n,), of the points that may have moved; found by comparison when left
        out. Those whose stored coordinates are unchanged are dropped.
    precision : Precision
        Type and unit of the stored coordinates; these are judged.

    Raises
    ------
    InputError
        No surface, a result with other triangles or points, or coordinates too large for the type.
    """
    after = state_of(as_surface(before, "before"), after)
    whole = before.whole
    comparison = Comparison(whole.points, whole.wound_triangles, precision)
    may_move = _mask(moved, len(before.points))
    verdict = comparison.verdict(after.points, may_move=may_move)
    fitness = fitness_after(before, after, verdict, precision)
    return certificate_of(verdict, comparison.new_slivers(verdict), whole, fitness)


def certificate_of(
    verdict: Verdict,
    new_slivers: Slivers,
    surface: Surface,
    fitness: Fitness,
    motion: tuple[MotionCheck, ...] = (),
    lumen: tuple[LumenCheck, ...] = (),
) -> Certificate:
    """The certificate of a result from its comparison with the input surface."""
    given = surface.given_numbers
    return Certificate(
        fitness=fitness,
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
