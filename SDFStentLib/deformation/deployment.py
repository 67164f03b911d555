"""Deploy a stent: an iterable with one state per radius step, and a one-call form.

>>> deployment = Deployment(surface, chain, radius=3.0)              # doctest: +SKIP
>>> for state in deployment:                                        # stop iterating to cancel
...     show(state.indices, state.coordinates)
>>> deployment.result.certificate.passed
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from ..certificate import Comparison, Verdict, certificate_of, fitness_after, known_faults
from ..field import CapsuleChain
from ..geometry import Surface
from ..threads import ahead
from .attempt import GAP_RAMP, Attempt
from .settings import DeploymentSettings
from .untangle import relaxed
from .values import DeploymentResult, DeploymentState, DeploymentTask

__all__ = ["Deployment", "DeploymentResult", "DeploymentState", "deploy"]

RETRIES = (((-1.0, 1.0), 1.0), (GAP_RAMP, 2.0), (GAP_RAMP, 0.5), (GAP_RAMP, 3.0))
"""Ramps and multiples of the tissue gap that are tried in turn when a fold remains."""

HOPELESS_FOLD = 10.0
"""Length, mm, of a remaining fold from which on only the first other tissue gap is tried.

In 450 random stents, up to four times as wide as the vessel, those that a later gap saved had at
most 3.6 mm left; of 10 mm and more only the first saved one.
"""


class Deployment(DeploymentTask):
    """A stent that expands in a vessel. Iterating runs it; the states of all steps are kept.

    Parameters
    ----------
    surface : Surface
        Surface of the vessel; open or closed, any winding.
    chain : CapsuleChain
        The stent: `CapsuleChain.along(axis)`, or `settings.chain(axis)`.
    radius : float
        Prescribed radius of the lumen, mm.
    settings : DeploymentSettings, optional
        Capsule length and smoothing width are those of the chain.
    companions : array_like, shape (c, 3), optional
        Points that are dragged along but never touched, such as the centerline. Those inside the
        expanded stent stay.
    precision : Precision, optional
        Precision of the stored result; the certificate is about the stored numbers.

    Raises
    ------
    InputError
        No surface, no chain, or a radius or companions that cannot be used.
    DeploymentError
        While iterating: a surface of which no point is near the stent.
    """

    def __post_init__(self) -> None:
        super().__post_init__()
        self.states: list[DeploymentState] = []
        self._result: DeploymentResult | None = None
        self._judged: Callable[[], None] | None = None

    def __iter__(self) -> Iterator[DeploymentState]:
        """Yield a state per radius step with motion, then the finished state."""
        self.states = []
        if self.settings.certify:
            self._judged = ahead(partial(known_faults, self.surface, self.precision))
        attempt = Attempt(self, GAP_RAMP, self.settings.tissue_gap)
        for radius in attempt.steps():
            self.states.append(attempt.state(radius))
            yield self.states[-1]
        self._result = self._finish(attempt)
        self.states.append(self._result.state)
        yield self._result.state

    @property
    def result(self) -> DeploymentResult:
        """The finished deployment; runs it to the end if that has not happened yet."""
        if self._result is None:
            for _ in self:
                pass
        assert self._result is not None
        return self._result

    def _finish(self, attempt: Attempt) -> DeploymentResult:
        """Finish the lumen and certify it; untangle, or retry with other gaps, when that fails."""
        attempt.finish()
        verdict, rounds = None, 0
        if self.settings.certify or self.settings.untangle:
            comparison = self._comparison()
            verdict = self._certificate(comparison, attempt)
            if self.settings.untangle and not verdict.passed:
                attempt, verdict, rounds = self._untangled(comparison, attempt, verdict)
        state = attempt.state(self.target_level)._replace(fraction=1.0)
        after = self.surface.with_points(state.applied_to(self.surface.points))
        whole = self.surface.whole
        if verdict is not None and whole is not self.surface:
            comparison = Comparison(whole.points, whole.wound_triangles, self.precision)
            after, verdict = self._with_outer_side(comparison, after)
            moved = np.flatnonzero((after.points != self.surface.points).any(axis=1))
            state = state._replace(indices=moved, coordinates=after.points[moved])
        motion, certificate = attempt.motion_check(), None
        if self.settings.certify and verdict is not None:
            lumen = self.lumen_checks(self.surface, after)
            slivers = comparison.new_slivers(verdict)
            if self._judged is not None:
                self._judged()
            fitness = fitness_after(self.surface, after, verdict, self.precision)
            certificate = certificate_of(verdict, slivers, whole, fitness, (motion,), lumen)
        return DeploymentResult(
            state=state,
            surface=after,
            certificate=certificate,
            untangling_rounds=rounds,
            relief=attempt.relief,
            estimated_error=attempt.motion.estimated_error,
            motion=motion,
        )

    def _with_outer_side(self, comparison: Comparison, after: Surface) -> tuple[Surface, Verdict]:
        """The surface with everything that follows its wall, taken apart where that folds."""
        verdict = comparison.verdict(after.points)
        if verdict.passed or not self.settings.untangle:
            return after, verdict
        end = relaxed(self.surface, after.points, comparison, verdict)
        return after.with_points(end.points), end.verdict

    def _untangled(
        self, comparison: Comparison, attempt: Attempt, verdict: Verdict
    ) -> tuple[Attempt, Verdict, int]:
        """First attempt without a fault, else the one with the fewest."""
        rounds = attempt.untangle(verdict.failing)
        best = (attempt, self._certificate(comparison, attempt, verdict), rounds)
        is_hopeless = self._longest_fold(best[1]) >= HOPELESS_FOLD
        retries = RETRIES[: 1 if is_hopeless else None] if self.settings.tissue_gap > 0 else ()
        for ramp, factor in retries:
            if best[1].passed:
                break
            attempt = Attempt(self, ramp, factor * self.settings.tissue_gap)
            for _ in attempt.steps():
                pass
            attempt.finish()
            verdict = self._certificate(comparison, attempt, verdict)
            rounds = attempt.untangle(verdict.failing)
            verdict = self._certificate(comparison, attempt, verdict)
            if len(verdict.failing) < len(best[1].failing):
                best = (attempt, verdict, rounds)
        return best

    def _longest_fold(self, verdict: Verdict) -> float:
        """Largest extent along a coordinate axis, mm, of a place where faces fail; 0 where none
        fails."""
        extents = (
            np.ptp(
                verdict.stored[self.surface.triangles[list(place.triangles)].ravel()], axis=0
            ).max()
            for place in verdict.places
        )
        return float(max(extents, default=0.0)) / self.precision.scale

    def _comparison(self) -> Comparison:
        return Comparison(self.surface.points, self.wound_triangles, self.precision)

    def _certificate(
        self, comparison: Comparison, attempt: Attempt, earlier: Verdict | None = None
    ) -> Verdict:
        """The verdict that the certificate of an attempt will be made of."""
        state = attempt.state(self.target_level)
        return comparison.verdict(state.applied_to(self.surface.points), earlier)


def deploy(
    surface: Surface,
    chain: CapsuleChain,
    radius: float,
    settings: DeploymentSettings | None = None,
) -> DeploymentResult:
    """Run a deployment to its end; parameters and errors as for `Deployment`."""
    return Deployment(surface, chain, radius, settings or DeploymentSettings()).result
