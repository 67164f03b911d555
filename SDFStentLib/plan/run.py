"""Run of a plan: deploy, measure, write, and the flow through the vessel."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np

from ..cautions import Caution
from ..files import (
    SurfaceFile,
    write_centerline,
    write_surface,
)
from ..flow import (
    FlowAnswer,
    FlowModel,
    Known,
    Part,
    SideClues,
    has_svzerod,
    inlets_of,
    solved_by_svzerod,
)
from ..stent import AlongAxis, OfStent, Stent
from ..threads import ahead
from ..treatment import (
    TreatedLesion,
    Treatment,
    TreatmentResult,
    TreatmentState,
    Vessel,
    label_of,
    told_first,
    treated_lesions,
)
from ..units import Frame
from ..validation import InputError, check_is_a
from ..vessel import SMALL_VESSEL, Lesion
from .case import Case, CaseOutcome
from .inputs import InputFiles, in_same_space, input_file, read_plan_inputs
from .plan import Plan


def flow_model(vessel: Vessel, known: Known, frame: Frame | None = None) -> FlowModel:
    """A vessel before treatment as a network; `frame`, of the vessel, may define the right side.

    Raises
    ------
    InputError
        No centerline, or as `FlowModel`.
    """
    if vessel.centerline is None:
        raise InputError(
            "flow: expected a centerline of the vessel tree, got none: an axis does not tell where "
            "the flow divides, nor where it goes on; name one (extract makes it), or leave the "
            "flow out."
        )
    clues = SideClues(frame, names=vessel.given_names)
    inlets = inlets_of(vessel.channels, known, vessel.ends)
    return FlowModel(vessel.channels, known, clues, inlets)


def flow_of_plan(plan: Plan, vessel: Vessel, frame: Frame | None) -> FlowModel | None:
    """`flow_model` for what a plan knows, in its frame; None where it knows nothing."""
    known = plan.in_frame(frame).flow
    return None if known is None else flow_model(vessel, known, frame)


def flow_answer(
    model: FlowModel,
    vessel: Vessel,
    treated: TreatmentResult | None = None,
    lesions: Sequence[Lesion] | None = None,
) -> FlowAnswer:
    """Pressures and flows before treatment and after it, over its stents and the lesions.

    Where there are none, over the whole way to the farthest end. Lesions are those of the vessel
    unless others are given.

    A wave is solved by `svzerod` where that is installed. `DeploymentError` where that fails.
    """
    assert vessel.centerline is not None
    after, parts = None, list[Part]()
    if treated is not None:
        assert treated.centerline is not None
        after = vessel.followed.after(treated.centerline, treated.surface)
        parts = [Part(f"stent {one.row}", one.axis.points) for one in treated.final_stents]
    found = vessel.lesions or () if lesions is None else lesions
    for number, lesion in enumerate(found, start=1):
        if lesion.reference_diameter >= SMALL_VESSEL:
            name, before = f"lesion {number}, {lesion.branch_name}", lesion.reference_diameter
            parts.append(Part(name, lesion.line.points, before))
    parts = parts or [_whole_way(vessel)]
    return model.answer(after, parts, solved_by_svzerod if has_svzerod() else None)


def _whole_way(vessel: Vessel) -> Part:
    """Way from the inlet to the farthest end."""
    tree = vessel.centerline
    assert tree is not None
    end = max(tree.leaves, key=lambda leaf: tree.arc_length[leaf])
    way = f"{tree.arc_length[end]:.0f} mm of vessel from the inlet to the farthest end"
    return Part(way, tree.points[tree.ancestry(end)])


@dataclass(frozen=True)
class PlanResult(CaseOutcome):
    """A plan that was carried out, its input files and its result."""

    plan: Plan
    inputs: InputFiles
    treatment: TreatmentResult

    @property
    def vessel(self) -> Vessel:  # type: ignore[override]
        """The vessel that was read."""
        return self.inputs.vessel

    @property
    def found(self) -> tuple[Lesion, ...] | None:  # type: ignore[override]
        """The lesions of the vessel before treatment; None without a centerline."""
        return self.vessel.lesions

    @cached_property
    def told_lesions(self) -> tuple[TreatedLesion, ...] | None:
        """Those of `lesions` on which a treatment tells; the others are not measured for them where
        they come after."""
        vessel, result = self.vessel, self.treatment
        told, tree = None, None if vessel.reference else vessel.tree_lesions
        if tree is not None and "lesions" not in vars(self):
            told = told_first(tree, result.stents, result.surface, vessel.surface)
        return super().told_lesions if told is None else told

    @cached_property
    def warnings(self) -> tuple[Caution, ...]:
        """The warnings of reading, of the axes in the vessel and of the treatment."""
        axes = _axes_in_space(case_of(self.plan, self.inputs).stents, self.inputs.surface)
        return (*self.inputs.warnings, *axes, *self.treatment.warnings)

    @cached_property
    def flow(self) -> FlowAnswer | None:
        """Pressures and flows before and after; None where the plan knows of none.

        `DeploymentError` where a solver fails.
        """
        model = flow_of_plan(self.plan, self.inputs.vessel, self.inputs.frame)
        if model is None:
            return None
        return flow_answer(model, self.inputs.vessel, self.treatment)

    @cached_property
    def today(self) -> Today | None:
        """The result before a stent is dilated again; None for a plan without a redilation."""
        return today_of(self.inputs.vessel, self.treatment)

    @cached_property
    def size_warnings(self) -> tuple[Caution, ...]:
        """Cautions on the lesions of the vessel, and on the sizes of stents against them."""
        label = partial(label_of, self.plan.stents)
        return (*self.vessel.lesion_cautions, *self.size_cautions(label))

    def write_surface(
        self, path: str | os.PathLike[str], *, arrays: bool = False
    ) -> tuple[Caution, ...]:
        """Write the surface in unit, precision and with the arrays of the one that was read.

        With `arrays` also `Displacement` (mm, new minus old), `AreaStretch` and
        `PrincipalStretchMax`, `PrincipalStretchMin`. Returns what the format cannot
        keep; `InputError` for a file that cannot be written.
        """
        surface, result = self.inputs.surface, self.treatment
        point_arrays, cell_arrays = {}, {}
        if arrays:
            point_arrays["Displacement"] = result.points - surface.points
            cell_arrays = {
                "AreaStretch": result.stretch.area,
                "PrincipalStretchMax": result.stretch.largest,
                "PrincipalStretchMin": result.stretch.smallest,
            }
        return write_surface(path, surface, result.points, point_arrays, cell_arrays)

    def write_centerline(self, path: str | os.PathLike[str]) -> tuple[Caution, ...]:
        """Write the moved centerline in the form of its file; `InputError` without one."""
        if self.inputs.line_file is None:
            raise InputError(
                f"{path}: expected a centerline to write, the plan has none; leave this output out."
            )
        return write_centerline(path, self.inputs.line_file, self.treatment.companions)


def run_plan(
    plan: Plan,
    *,
    accept_changed_inputs: bool = False,
    progress: Callable[[TreatmentState], None] | None = None,
) -> PlanResult:
    """Read the files of a plan and carry it out; `progress` is called with every state.

    Raises
    ------
    InputError
        Files that cannot be read, that changed since the plan was made, or that do not belong
        together; a stent that cannot be placed.
    DeploymentError
        A stent away from the surface.
    """
    check_is_a(plan, Plan, "plan")
    inputs = read_plan_inputs(plan, accept_changed_inputs=accept_changed_inputs)
    return carried_out(plan, inputs, progress)


def carried_out(
    plan: Plan, inputs: InputFiles, progress: Callable[[TreatmentState], None] | None = None
) -> PlanResult:
    """Carry out a plan in what was read for it; as `run_plan`."""
    treatment = treatment_of(plan, inputs)
    look = ahead(lambda: (tree := inputs.vessel.tree_lesions) and tree.first)
    for state in treatment:
        if progress is not None:
            progress(state)
    result = PlanResult(plan, inputs, treatment.result)
    look()
    return result


def treatment_of(plan: Plan, inputs: InputFiles) -> Treatment:
    """The treatment that a plan prescribes for what was read; iterate it, or ask its `result`.

    Raises
    ------
    InputError
        A stent that cannot be placed, or an axis outside of the surface.
    """
    case = case_of(plan, inputs)
    stents = case.stents
    if inputs.vessel.reference:
        # A reference that cannot be one fails here rather than in the end.
        _ = inputs.vessel.lesions
    flow_of_plan(plan, inputs.vessel, inputs.frame)  # likewise
    _axes_in_space(stents, inputs.surface)  # likewise
    return case.treatment()


def case_of(plan: Plan, inputs: InputFiles) -> Case:
    """A plan in the vessel that was read for it."""
    surface, lines = inputs.surface, inputs.line_file
    return Case(
        inputs.vessel,
        plan,
        inputs.frame,
        surface.precision,
        np.empty((0, 3)) if lines is None else lines.points,
    )


def _axes_in_space(stents: Sequence[Stent], surface: SurfaceFile) -> tuple[Caution, ...]:
    """Cautions for curves of which a part is outside; `InputError` for most of one."""
    found: list[Caution] = []
    for number, stent in enumerate(stents, start=1):
        if stent.enabled and isinstance(stent.placement, AlongAxis):
            file = stent.placement.file
            name = f"axis of stent {number}" if file is None else file.path
            found += in_same_space(surface, stent.placement.points, name)
    return tuple(found)


def as_read(plan: Plan, inputs: InputFiles) -> Plan:
    """The plan with the hashes of the files that were read for it."""
    line_file = inputs.line_file
    return replace(
        plan,
        surface=input_file(inputs.surface),
        centerline=None if line_file is None else input_file(line_file),
    )


_SPACING = 1.0
"""The distance of the stations along the stents, mm."""


class Today(NamedTuple):
    """Lumens and lesions after the stents before the first redilation."""

    redilation: int
    """Number of the first stent that dilates an earlier one again."""
    minimum_lumen: Mapping[int, float]
    """Smallest inscribed diameter of each stent by its number then, mm; NaN where not known."""
    lesions: tuple[TreatedLesion, ...] | None
    """Lesions before any stent and by then; None without a centerline."""


def today_of(vessel: Vessel, result: TreatmentResult) -> Today | None:
    """The result in a vessel before any stent is dilated again; None where none is."""
    stents = result.stents
    again = [place for place, one in enumerate(stents) if isinstance(one.stent.placement, OfStent)]
    if not again:
        return None
    done = stents[: again[0]]
    surface = done[-1].result.surface
    by_then = Vessel(surface)
    lumen = {one.number: by_then.diameters(one.axis.line, _SPACING).minimum for one in done}
    lesions = None
    if vessel.lesions is not None:
        lesions = treated_lesions(vessel.lesions, done, surface, vessel.surface)
    return Today(stents[again[0]].number, lumen, lesions)
