"""Several stents in order: later ones see the vessel as earlier ones left it.

>>> treatment = Treatment(surface, stents, centerline)              # doctest: +SKIP
>>> for state in treatment:                                        # stop iterating to cancel
...     show(state.fraction, state.points())
>>> treatment.result.certificate.passed
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Sequence
from dataclasses import KW_ONLY, dataclass, field, replace
from functools import cached_property
from itertools import combinations, zip_longest
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from ..cautions import Caution
from ..centerline import Centerline
from ..certificate import Certificate, LumenCheck, certify
from ..deformation import Deployment, DeploymentSettings
from ..geometry import NamedFaces, Precision, Surface, as_surface, checked_faces
from ..lumen import bulged_caps, diameter_profile
from ..stent import Stent
from ..threads import ahead
from ..validation import Points, as_number, as_points, read_only
from ..vessel import VesselStates
from .branches import covered_by_all
from .coarseness import coarse_mesh, too_coarse
from .placer import InterimVessel, Placer
from .profile import Stage, named_states
from .straightening import AxisChange
from .surroundings import (
    PROFILE_SPACING,
    Survey,
    TreeNames,
    surroundings,
    surveyed,
    surveyed_once,
)
from .value import (
    PlacedStent,
    TreatedStent,
    TreatmentResult,
    TreatmentState,
    latest_of,
    switched_on,
)
from .warnings import (
    hangs_free,
    narrowed,
    narrowed_neighbors,
    nothing_moved,
    overlap,
)


@dataclass(eq=False, repr=False)
class Treatment:
    """Stents that are deployed one after another. Iterating deploys; `result` also measures.

    Parameters
    ----------
    surface : Surface
        Surface of the vessel.
    stents : sequence of Stent
        Stents in order; those switched off are skipped and named.
    centerline : Centerline, optional
        Needed for every placement but along an axis. It moves along, and later stents are
        placed on it where it is then.
    settings : DeploymentSettings, optional
        Settings; with `certify`, one certificate is made at the end for the whole treatment.
    straightening_fraction : float
        Share of its bends that the axis of every stent loses, its length kept.
    companions : array_like, shape (c, 3), optional
        Further points that are dragged along.
    precision : Precision, optional
        Precision of the stored result.
    faces : NamedFaces, optional
        Faces of the surface; branches are called by them.
    given_names : sequence of str or None
        Names of the branches of the centerline by the user, each in its place, as of `Vessel`.
    rows : sequence of int
        Rows by which messages count the stents; by default their places in `stents`.

    Raises
    ------
    InputError
        No surface, companions that cannot be used, no stent that is switched on, or one that
        cannot be placed.
    DeploymentError
        While iterating: a stent away from the surface.
    """

    surface: Surface
    stents: Sequence[Stent]
    centerline: Centerline | None = None
    settings: DeploymentSettings = field(default_factory=DeploymentSettings)
    _: KW_ONLY
    straightening_fraction: float = 0.0
    companions: Points = field(default_factory=lambda: np.empty((0, 3)))
    precision: Precision = field(default_factory=Precision)
    faces: NamedFaces | None = None
    given_names: Sequence[str | None] = ()
    rows: Sequence[int] = ()

    def __post_init__(self) -> None:
        self.surface = as_surface(self.surface)
        self.faces = checked_faces(self.faces, len(self.surface.triangles))
        self.stents = tuple(self.stents)
        self.rows = tuple(self.rows) or range(1, len(self.stents) + 1)
        self.settings = self.settings or DeploymentSettings()
        self.straightening_fraction = as_number(
            self.straightening_fraction, "straightening fraction", minimum=0, maximum=1
        )
        given = () if self.companions is None else self.companions
        self.companions = as_points(given, "companion points")
        self.precision = self.precision or Precision()
        self._begin()
        self._enabled = switched_on(self.stents)
        # Fails here rather than after the first stent. Later stents lie elsewhere once the earlier
        # ones have moved the centerline.
        placed: dict[int, PlacedStent] = {}
        for number, _stent in self._enabled:
            placed[number] = self._placer.placed(number, placed, self.centerline, self.surface)
        self._first = placed[self._enabled[0][0]]

    def _begin(self) -> None:
        self._result: TreatmentResult | None = None
        self._stages: list[Stage] = []
        self._surveyed_ahead: Callable[[], None] | None = None
        self._seconds = {"setup": 0.0, "deploy": 0.0}
        self._clock = perf_counter()

    def __iter__(self) -> Iterator[TreatmentState]:
        """Yield the states of every stent in turn."""
        self._begin()
        numbers = [number for number, _stent in self._enabled]
        course = InterimVessel(self.surface, self.centerline, self.companions)
        known = {self._first.number: self._first}
        self._final = yield from self._placer.in_turn(numbers, course, self._grown, known)

    def _grown(
        self, placed: PlacedStent, course: InterimVessel
    ) -> Generator[TreatmentState, None, InterimVessel]:
        """Deploy a stent; what it takes to place it counts as its setup."""
        surface, axis, count = as_surface(course.vessel), placed.axis, len(self._enabled)
        deployment = Deployment(
            surface,
            self.settings.chain(axis.line, axis.profile),
            placed.stent.widest_diameter / 2,
            self.settings.with_changes(certify=self.settings.certify and count == 1),
            companions=course.dragged,
            precision=self.precision,
        )
        ready = perf_counter()
        for state in named_states(deployment, self.label(placed.number)):
            if self._surveyed_ahead is None:
                self._surveyed_ahead = ahead(lambda: self.survey)
            fraction = (len(self._stages) + state.fraction) / count
            yield TreatmentState(placed, fraction, state, surface)
        self._stages.append(Stage(placed, course.centerline, deployment))
        self._seconds["setup"] += ready - self._clock
        self._clock = perf_counter()
        self._seconds["deploy"] += self._clock - ready
        result = deployment.result
        return course.after(result.surface, result.state.companions)

    @property
    def result(self) -> TreatmentResult:
        """The finished treatment, measured and certified; runs it when that has not happened."""
        if self._result is None:
            if len(self._stages) < len(self._enabled):
                for _ in self:
                    pass
            self._result = self._measured()
        return self._result

    def label(self, number: int) -> str:
        """Name of a stent in messages; empty when there is only one, without a name."""
        return self._placer.label(number)

    @property
    def _placer(self) -> Placer:
        change = AxisChange.of(self.straightening_fraction, self.settings)
        return Placer(self.surface, self.stents, change, self.rows)

    def _measured(self) -> TreatmentResult:
        vessel, centerline, companions = self._final
        after, clock = as_surface(vessel), perf_counter()
        treated = self._all_treated(after)
        measured = perf_counter()
        indices = np.flatnonzero((after.points != self.surface.points).any(axis=1))
        certificate = self._certificate(after, indices) if self.settings.certify else None
        return TreatmentResult(
            before=self.surface,
            surface=after,
            indices=read_only(indices),
            centerline=centerline,
            companions=read_only(companions),
            stents=treated,
            certificate=certificate,
            warnings=(
                *self._warnings(treated, after, indices, certificate),
                *self._certified_with(certificate),
            ),
            timings={
                **self._seconds,
                "measure": measured - clock,
                "certify": perf_counter() - measured,
            },
        )

    def _all_treated(self, after: Surface) -> tuple[TreatedStent, ...]:
        """Treated stents, measured; one that touches no wall covers no branch."""
        found = [self._treated(stage, after) for stage in self._stages]
        touching = [
            stage
            for stage, one in zip(self._stages, found, strict=True)
            if one.apposition is None or not one.apposition.is_loose
        ]
        return tuple(
            replace(one, branches=covered_by_all(one.branches, one.way, touching)) for one in found
        )

    def _treated(self, stage: Stage, after: Surface) -> TreatedStent:
        """A stent, whose branches are those of its survey."""
        found, left = stage.deployment.surface, stage.result.surface
        is_first = stage is self._stages[0]
        if self._surveyed_ahead is not None:
            self._surveyed_ahead()
        survey = self.survey if is_first else self._surveyed(stage)
        states = VesselStates(self.surface, found, left, after)
        seen = surroundings(survey, states, stage.radius_at)
        again = latest_of(stage.number, {one.number: one.stent for one in self._stages})
        earlier = stage.placed.earlier
        return TreatedStent(
            number=stage.number,
            stent=stage.stent,
            axis=stage.axis,
            row=stage.placed.row,
            before=survey.before.taken(survey.stations.own),
            after=seen.after.taken(survey.stations.own),
            around_before=survey.before,
            around_after=seen.after,
            way=survey.axis,
            branches=survey.branches,
            neighbors=seen.neighbors,
            apposition=seen.apposition if again == stage.number else None,
            again=None if again == stage.number else again,
            again_row=None if again == stage.number else self._rows[again],
            earlier_row=None if earlier is None else self._rows[earlier],
            result=stage.result,
        )

    @property
    def _rows(self) -> dict[int, int]:
        """The rows by which the stents are counted, by their numbers."""
        return {one.number: one.placed.row for one in self._stages}

    @cached_property
    def survey(self) -> Survey:
        """Surroundings of the first stent before treatment; `result` needs them.

        No state takes part in it: another thread may ask for it, once, while this one iterates.
        """
        names = TreeNames(self.centerline, self.faces, self.given_names)
        return surveyed_once(self.surface, self._first.axis.line, names)

    def _surveyed(self, stage: Stage) -> Survey:
        names = TreeNames(stage.centerline, self.faces, self.given_names)
        return surveyed(self.surface, stage.deployment.surface, stage.axis.line, names)

    def _narrowed(self, stage: Stage, treated: TreatedStent) -> Iterator[Caution]:
        """Whether later stents pushed tissue into this one; measured only if it may be."""
        if stage is self._stages[-1] or treated.after.minimum > 0.97 * stage.stent.diameter:
            return
        own = diameter_profile(stage.result.surface, stage.axis.line, PROFILE_SPACING)
        yield from narrowed(own, treated.after)

    def _certificate(self, after: Surface, moved: NDArray[np.int64]) -> Certificate:
        """The certificate of one stent, or of several from the input to the end of the last one."""
        only = self._stages[0].result.certificate
        if len(self._stages) == 1 and only is not None:
            return only
        certificate = certify(self.surface, after, moved, precision=self.precision)
        lumen = [
            check
            for stage in self._stages
            for check in stage.deployment.lumen_checks(
                self.surface, after, (stage.deployment.surface, stage.result.surface)
            )
        ]
        motion = tuple(stage.result.motion for stage in self._stages)
        return replace(certificate, motion=motion, lumen=tuple(lumen))

    def _warnings(
        self,
        treated: Sequence[TreatedStent],
        after: Surface,
        moved: NDArray[np.int64],
        certificate: Certificate | None,
    ) -> Iterator[Caution]:
        for number, stent in enumerate(self.stents, start=1):
            if not stent.enabled:
                yield Caution("switched-off", stent=number, label=self.label(number))
        # Every stent has a check, or none has: that is a matter of the settings.
        checks = certificate.lumen if certificate is not None else ()
        for stage, done, check in zip_longest(self._stages, treated, checks):
            for caution in self._warnings_of(stage, done, after, check):
                yield replace(caution, stent=done.number).labeled(self.label(done.number))
        # One that is dilated again lies in the vessel as it is by then.
        for first, second in combinations([done for done in treated if done.again is None], 2):
            yield from overlap(first, second)
        yield from narrowed_neighbors(treated, self.label)
        for cap in bulged_caps(self.surface, after, moved):
            yield cap.caution()

    def _certified_with(self, certificate: Certificate | None) -> Iterator[Caution]:
        """Cautions of a certificate, and of its lumen checks that passed."""
        if certificate is None:
            return
        for stage, check in zip(self._stages, certificate.lumen, strict=False):
            for caution in check.cautions() if check.passed else ():
                yield replace(caution, stent=stage.number).labeled(self.label(stage.number))
        yield from certificate.cautions()

    def _warnings_of(
        self, stage: Stage, done: TreatedStent, after: Surface, check: LumenCheck | None
    ) -> Iterator[Caution]:
        """The warnings about one stent, which is named later."""
        yield from stage.axis.warnings
        is_first = stage is self._stages[0]
        if check is None:
            coarse = [*coarse_mesh(done)]
        else:
            coarse = [*too_coarse(check, stage.deployment.surface, after)]
        left = None  # by earlier stents, for one that moved nothing
        if not (is_first or done.moved_points):
            left = diameter_profile(stage.deployment.surface, stage.axis.line, PROFILE_SPACING)
        yield from nothing_moved(done, left, coarse)
        yield from hangs_free(done)
        yield from coarse
        yield from self._narrowed(stage, done)
        if stage.result.relief is not None:
            yield stage.result.relief.caution()
        yield from (gap.labeled("Before treatment: ") for gap in done.before.gaps)
        yield from (gap.labeled("After treatment: ") for gap in done.after.gaps)
