"""Carry out a plan on its files: read, deploy, measure, write."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from time import perf_counter
from typing import NamedTuple

import numpy as np

from ..cautions import Caution
from ..files import (
    LineFile,
    SurfaceFile,
    check_same_space,
    in_frame_of,
    read_lines,
    read_surface,
    write_centerline,
    write_surface,
)
from ..flow import FlowAnswer
from ..stent import AlongAxis, InputFile, Stent
from ..treatment import (
    Residual,
    TreatedLesion,
    Treatment,
    TreatmentResult,
    TreatmentState,
    Vessel,
    VesselName,
    label_of,
    residual_of,
    size_cautions,
    treated_lesions,
)
from ..units import Frame, flipped
from ..validation import InputError, Points, check_is_a
from ..version import VERSION
from .axis import changed_input, is_changed
from .flow import flow_answer, flow_of_plan
from .plan import Plan, turned
from .today import Today, today_of


@dataclass(frozen=True)
class InputFiles:
    """A surface and a centerline that belong together, read.

    Attributes
    ----------
    surface : SurfaceFile
    line_file : LineFile or None
        The centerline as its file has it, in the frame of the surface.
    vessel : Vessel
        Wall and centerline, mm, in the frame of the surface.
    warnings : tuple of Caution
    seconds : float
        That reading took.
    """

    surface: SurfaceFile
    line_file: LineFile | None
    vessel: Vessel
    warnings: tuple[Caution, ...]
    seconds: float

    def unmeasured(self) -> InputFiles:
        """The same with `Vessel.unmeasured`, for results that no earlier one changes by a bit."""
        vessel = self.vessel.unmeasured()
        return replace(self, surface=replace(self.surface, surface=vessel.surface), vessel=vessel)


@dataclass(frozen=True)
class PlanResult:
    """A plan that was carried out: the plan, what was read, and what came of it."""

    plan: Plan
    inputs: InputFiles
    treatment: TreatmentResult

    @cached_property
    def warnings(self) -> tuple[Caution, ...]:
        """Of reading, of the axes in the vessel and of the treatment."""
        axes = _axes_in_space(_stents(self.plan, self.inputs), self.inputs.surface)
        return (*self.inputs.warnings, *axes, *self.treatment.warnings)

    @cached_property
    def lesions(self) -> tuple[TreatedLesion, ...] | None:
        """Those of the vessel before and after; None without a centerline."""
        vessel, result = self.inputs.vessel, self.treatment
        if vessel.lesions is None:
            return None
        return treated_lesions(vessel.lesions, result.stents, result.surface, vessel.surface)

    @cached_property
    def residual(self) -> Residual | None:
        """What is narrowest in the treated vessels; None where no stent covers a lesion."""
        return residual_of(self.lesions or (), self.treatment.stents)

    @cached_property
    def flow(self) -> FlowAnswer | None:
        """Pressures and flows before and after; None where the plan knows of none.

        `DeploymentError` where a solver fails.
        """
        model = flow_of_plan(self.plan, self.inputs.vessel, self.inputs.surface.frame)
        if model is None:
            return None
        return flow_answer(model, self.inputs.vessel, self.treatment)

    @cached_property
    def today(self) -> Today | None:
        """The result before a stent is dilated again; None for a plan without a redilation."""
        return today_of(self.inputs.vessel, self.treatment)

    @cached_property
    def size_warnings(self) -> tuple[Caution, ...]:
        """Where a stent is too short for its lesion, or its ratio to it beyond what is known."""
        label = partial(label_of, self.plan.stents)
        return tuple(size_cautions(self.treatment.stents, self.lesions, label))

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
        return write_surface(
            path, surface, result.indices, result.coordinates, point_arrays, cell_arrays
        )

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
    treatment = treatment_of(plan, inputs)
    for state in treatment:
        if progress is not None:
            progress(state)
    return PlanResult(plan, inputs, treatment.result)


class Marks(NamedTuple):
    """Places (3,), mm, that the user marked on a vessel."""

    root: Points | None = None
    """The centerline's end nearest to it is its root."""
    reference: tuple[Points, ...] = ()
    """Healthy vessel, against which lesions are measured."""
    names: tuple[VesselName, ...] = ()
    """By which vessels are called, each at a place."""
    frame: Frame | None = None
    """Of all of them; None: the surface's."""

    def in_frame(self, frame: Frame | None) -> Marks:
        """The same places as a file of that frame has them."""
        if None in (frame, self.frame) or frame == self.frame:
            return self
        root = None if self.root is None else flipped(self.root)
        reference = tuple(flipped(place) for place in self.reference)
        return Marks(root, reference, tuple(one.turned() for one in self.names), frame)


def read_input_files(
    surface: str | os.PathLike[str],
    centerline: str | os.PathLike[str] | None = None,
    units: str = "mm",
    marks: Marks = Marks(),  # noqa: B008
) -> InputFiles:
    """Read a surface and its centerline, and check that they are in the same space.

    Raises
    ------
    InputError
        As the readers, and for a centerline outside of the surface, in another unit or frame;
        names without a centerline, or as of `given_names`.
    """
    start = perf_counter()
    surface_file = read_surface(surface, units)
    line_file, tree = None, None
    warnings = surface_file.warnings
    marks = marks.in_frame(surface_file.frame)
    if centerline is not None:
        line_file = in_frame_of(read_lines(centerline, units), surface_file.frame)
        tree = line_file.centerline(marks.root)
        warnings += line_file.warnings
        warnings += _same_space(surface_file, tree.points, os.fspath(centerline))
    elif marks.names:
        raise InputError(
            "names: expected a centerline, which tells one vessel from another, got none; give "
            "one, or leave the names out."
        )
    vessel = Vessel(surface_file.surface, tree, marks.reference, surface_file.faces, marks.names)
    _ = vessel.given_names  # names that cannot be meant fail here rather than in the end
    return InputFiles(surface_file, line_file, vessel, warnings, perf_counter() - start)


def read_plan_inputs(plan: Plan, *, accept_changed_inputs: bool = False) -> InputFiles:
    """Read the surface and the centerline of a plan.

    Raises
    ------
    InputError
        As `read_input_files`; a plan without a surface file; a file whose hash is another.
    """
    return as_planned(plan, plan_files(plan), accept_changed_inputs=accept_changed_inputs)


def plan_files(plan: Plan) -> InputFiles:
    """The files that a plan names, read whatever they hold; errors as `read_plan_inputs`."""
    if plan.surface is None:
        raise InputError(
            "inputs.surface: expected a file, the plan names none; save the plan with its surface."
        )
    center = plan.centerline
    if plan.reference and center is None:
        raise InputError(
            "inputs.reference: expected a plan with a centerline, got one without; name the "
            "centerline, or leave the reference out."
        )
    return read_input_files(
        plan.surface.path,
        None if center is None else center.path,
        plan.units,
        Marks(
            None if plan.root is None else np.array(plan.root),
            tuple(np.array(place) for place in plan.reference),
            plan.names,
            plan.frame,
        ),
    )


def as_planned(
    plan: Plan, inputs: InputFiles, *, accept_changed_inputs: bool = False
) -> InputFiles:
    """The files that were read for a plan, with what there is to say where they are not its own.

    Raises
    ------
    InputError
        A file whose hash is another than the plan's, unless that is accepted.
    """
    named = ((plan.surface, inputs.surface), (plan.centerline, inputs.line_file))
    warnings = list(inputs.warnings)
    for file, read in named:
        if file is not None and read is not None and is_changed(file, read.sha256):
            if not accept_changed_inputs:
                raise changed_input(file, read.sha256)
            warnings.append(Caution("changed-input", label=f"{file.path}: "))
    if plan.sdfstent_version != VERSION:
        versions = {"version": plan.sdfstent_version, "current": VERSION}
        warnings.append(Caution("other-version", versions))
    return replace(inputs, warnings=tuple(warnings))


def treatment_of(plan: Plan, inputs: InputFiles) -> Treatment:
    """The treatment that a plan prescribes for what was read; iterate it, or ask its `result`.

    Raises
    ------
    InputError
        A stent that cannot be placed, or an axis outside of the surface.
    """
    surface = inputs.surface
    stents = _stents(plan, inputs)
    if inputs.vessel.reference:
        # A reference that cannot be one fails here rather than in the end.
        _ = inputs.vessel.lesions
    flow_of_plan(plan, inputs.vessel, surface.frame)  # likewise
    _axes_in_space(stents, surface)  # likewise
    return Treatment(
        surface.surface,
        stents,
        inputs.vessel.centerline,
        plan.settings,
        straightening_fraction=plan.straightening_fraction,
        companions=np.empty((0, 3)) if inputs.line_file is None else inputs.line_file.points,
        precision=surface.precision,
        faces=surface.faces,
        given_names=inputs.vessel.given_names,
    )


def _stents(plan: Plan, inputs: InputFiles) -> tuple[Stent, ...]:
    """Those of a plan in the frame of the surface."""
    is_turned = plan.frame is not None and inputs.surface.frame not in (None, plan.frame)
    return tuple(map(turned, plan.stents)) if is_turned else plan.stents


def _axes_in_space(stents: Sequence[Stent], surface: SurfaceFile) -> tuple[Caution, ...]:
    """What there is to say of curves of which a part is outside; `InputError` for most of one."""
    found: list[Caution] = []
    for number, stent in enumerate(stents, start=1):
        if stent.enabled and isinstance(stent.placement, AlongAxis):
            file = stent.placement.file
            name = f"axis of stent {number}" if file is None else file.path
            found += _same_space(surface, stent.placement.points, name)
    return tuple(found)


def as_read(plan: Plan, inputs: InputFiles) -> Plan:
    """The plan with the hashes of the files that were read for it."""
    line_file = inputs.line_file
    return replace(
        plan,
        surface=input_file(inputs.surface),
        centerline=None if line_file is None else input_file(line_file),
    )


def input_file(read: SurfaceFile | LineFile) -> InputFile:
    """What a plan keeps of a file that was read."""
    return InputFile(os.fspath(read.path), read.sha256)


def _same_space(surface: SurfaceFile, points: np.ndarray, name: str) -> tuple[Caution, ...]:
    return check_same_space(
        surface.surface,
        points,
        surface_name=os.fspath(surface.path),
        centerline_name=name,
    )
