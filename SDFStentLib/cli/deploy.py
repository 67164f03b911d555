"""The commands `deploy` and `run`."""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from time import perf_counter

from ..cautions import Caution
from ..files import (
    SurfaceFile,
    check_line_output,
    check_suffix,
    check_surface_output,
    read_surface,
)
from ..flow import FlowAnswer
from ..line_formats import LINE_SUFFIXES
from ..plan import (
    InputFiles,
    Plan,
    PlanResult,
    StepFiles,
    as_read,
    carried_out,
    case_of,
    load_plan,
    read_plan_inputs,
    save_plan,
    write_device,
)
from ..report import (
    FIGURE_SUFFIXES,
    PlannedViews,
    Report,
    plan_report,
    planned_views,
    voxel_facts,
    write_report,
    write_report_figure,
)
from ..scan import VoxelRange, treated_voxel_range
from ..surface_formats import written_suffix
from ..treatment import TreatmentState
from ..validation import DeploymentError, InputError, as_number
from .console import Console, tell
from .flow_options import add_networks, known_of, no_flow
from .option_table import method_of
from .outputs import Outputs
from .place import check_frame, check_place, frame_of, half_voxel_of, inputs_of, plan_of
from .stent_options import check_sizes, device_of, stents_of

NOT_CERTIFIED = 3


def deploy_command(options: argparse.Namespace, console: Console) -> int:
    """Deploy one stent; return 0, or 3 if the certificate fails."""
    start = perf_counter()
    check_sizes(options)
    device = device_of(options)
    has_length = options.length is not None or (device and device.nominal_length) is not None
    way = check_place(options, needed=True, has_length=has_length)
    assert way is not None
    read = [options.surface, options.centerline, options.axis, options.names]
    outputs = Outputs([*read, options.device_mesh, options.wave])
    job = _PlanJob(options, console, outputs)
    check_surface_output(options.output)
    outputs.add(options.output, job.write_surface)
    if options.output_centerline:
        if not options.centerline:
            raise InputError(
                "expected --centerline FILE with --output-centerline, got none; add it."
            )
        check_line_output(options.output_centerline)
        outputs.add(options.output_centerline, job.write_centerline)
    for path in options.report:
        check_suffix(path, "a report", (".json", ".html"))
        job.add_report(path)
    if options.save_plan:
        outputs.add(options.save_plan, lambda path: job.write_plan(path, options.save_plan))
    job.add_common()

    method = replace(method_of(options), flow=known_of(options, console))
    if options.export_0d and method.flow is None:
        raise no_flow()
    inputs = inputs_of(options)
    job.plan = plan_of(options, method, stents_of(options, way, inputs, device), inputs)
    return job.done(inputs, start)


def run_command(options: argparse.Namespace, console: Console) -> int:
    """Carry out a plan; return 0, or 3 if the certificate fails."""
    start = perf_counter()
    plan = load_plan(options.plan, accept_changed_inputs=options.accept_changed_inputs)
    console.units = plan.units
    named = frame_of(options)
    check_frame(named, plan.frame, options.plan)
    plan = replace(plan, frame=named or plan.frame)
    files = [plan.surface, plan.centerline, *(stent.axis_file for stent in plan.stents)]
    inputs = [options.plan, options.device_mesh, *(file.path for file in files if file)]
    if options.export_0d and plan.flow is None:
        raise InputError(
            f"{options.plan}: expected a plan with a flow for --export-0d, got one without; add "
            "its mean flow, see docs/plan.md, or leave --export-0d out."
        )
    outputs = Outputs(inputs, options.output)
    job = _PlanJob(options, console, outputs)
    job.plan = plan
    folder = Path(options.output)
    if plan.surface is not None:
        surface = Path(plan.surface.path)
        outputs.add(
            folder / f"{surface.stem}_stented{written_suffix(surface.suffix)}", job.write_surface
        )
    if plan.centerline is not None:
        name = Path(plan.centerline.path).name
        suffix = ".mrk.json" if name.lower().endswith(".mrk.json") else Path(name).suffix
        stem = name[: len(name) - len(suffix)]
        suffix = suffix if suffix.lower() in LINE_SUFFIXES else LINE_SUFFIXES[0]
        outputs.add(folder / f"{stem}_stented{suffix}", job.write_centerline)
    for name in ("report.json", "report.html"):
        job.add_report(folder / name)
    if os.path.realpath(folder / "plan.json") != os.path.realpath(options.plan):
        outputs.add(folder / "plan.json", lambda path: job.write_plan(path, folder / "plan.json"))
    job.add_common()

    accept = options.accept_changed_inputs
    return job.done(read_plan_inputs(plan, accept_changed_inputs=accept), start)


class _PlanJob:
    """A plan on its way from the options to the outputs."""

    def __init__(self, options: argparse.Namespace, console: Console, outputs: Outputs) -> None:
        self.options, self.console, self.outputs = options, console, outputs
        self.plan = Plan()
        self.result: PlanResult | None = None
        self.lost: tuple[Caution, ...] = ()
        self.write_start = 0.0
        self.steps: StepFiles | None = None
        self.mesh: SurfaceFile | None = None
        self.half_voxel: float | None = None
        self._picture: bytes | str = ""

    def add_common(self) -> None:
        """Add the outputs that `deploy` and `run` share."""
        figure, picture = self.options.figure, self.options.picture
        if figure:
            check_suffix(figure, "a figure", FIGURE_SUFFIXES)
            self.outputs.add(figure, self.write_figure)
        if picture:
            check_suffix(picture, "a picture", (".png",))
            self.outputs.add(picture, self.write_picture)
        if self.options.angiogram:
            check_suffix(self.options.angiogram, "an angiogram", FIGURE_SUFFIXES)
            self.outputs.add(self.options.angiogram, self.write_angiogram)
        add_networks(self.outputs, self.options.export_0d, self.flow)
        self.add_device()
        drawn = (figure, self.options.angiogram)
        if picture or any(one and one.lower().endswith(".png") for one in drawn):
            # Late, as below: most deployments draw nothing.
            from ..report import check_rendering

            check_rendering()
        if self.options.steps:
            every = self.options.every
            if every is not None:
                as_number(every, "--every", unit="mm", above=0)
            self.steps = StepFiles(every or 0.0)
            self.outputs.add_folder(self.options.steps, self.steps.write, StepFiles.is_own)
        elif self.options.every is not None:
            raise InputError("expected --steps DIR with --every, got none; add it.")

    def add_device(self) -> None:
        """Add the struts of the stents, or the user's mesh instead, to the outputs."""
        path = self.options.export_device
        if path:
            check_suffix(path, "a device", (".vtp",))
            self.outputs.add(path, lambda made: write_device(made, self._result, self.mesh))
        elif self.options.device_mesh:
            raise InputError("expected --export-device F with --device-mesh, got none; add it.")

    def done(self, inputs: InputFiles, start: float) -> int:
        """Deploy, write, and report; return the exit code."""
        self.plan = as_read(self.plan, inputs)
        if self.options.angiogram:
            from ..report import known_frame

            known_frame(inputs.frame)
        self.half_voxel = half_voxel_of(self.options, inputs)
        if self.options.device_mesh:
            self.mesh = read_surface(self.options.device_mesh, inputs.surface.units)
            self.console.warn(self.mesh.warnings)
        with self.console.progress("Deploying") as show:

            def shown(state: TreatmentState) -> None:
                show(state.fraction, f"diameter {2 * state.deployment.radius:.1f} mm")
                if self.steps is not None:
                    self.steps.take(inputs.surface, state)

            self.result = carried_out(self.plan, inputs, shown)
        if self.options.whole_tree:
            _ = self.result.lesions  # first: what is told of is then taken from these
        self.write_start = perf_counter()
        lost = self.outputs.write()
        cautions = [*self.result.warnings, *self.result.size_warnings, *lost]
        tell(self.result, cautions, self.console)
        for sentence in voxel_facts(self._voxels).sentences if self._voxels else ():
            self.console.say(sentence)
        written = ", ".join(self.outputs.names())
        self.console.say(f"Wrote {written} in {perf_counter() - start:.1f} s.")
        certificate = self.result.treatment.certificate
        return 0 if certificate is None or certificate.passed else NOT_CERTIFIED

    def write_surface(self, path: Path) -> Sequence[Caution]:
        """Write the treated surface, as the first file, so that the report has what was lost."""
        self.lost = self._result.write_surface(path, arrays=self.options.arrays)
        return self.lost

    def write_centerline(self, path: Path) -> Sequence[Caution]:
        """Write the moved centerline."""
        return self._result.write_centerline(path)

    def add_report(self, path: str | os.PathLike[str]) -> None:
        """Add a report; the document comes last, with the hashes of all other files."""
        is_last = Path(path).suffix.lower() == ".json"
        self.outputs.add(path, lambda made: self._write_report(made, path), is_last=is_last)

    def _write_report(self, path: Path, final: str | os.PathLike[str]) -> Sequence[Caution]:
        """Write JSON or HTML; a page without its picture is better than none."""
        if path.suffix.lower() == ".json":
            write_report(self._report().with_outputs(self.outputs.beside(final)), path)
            return []
        picture = self.picture
        write_report(self._report(picture), path)
        return [Caution("picture-missing", {"reason": picture})] if isinstance(picture, str) else []

    def write_figure(self, path: Path) -> None:
        """Write the figure of the diameters along the stents."""
        write_report_figure(self._report(), path)

    def flow(self) -> FlowAnswer:
        """The flow of a plan that has one."""
        answer = self._result.flow
        assert answer is not None
        return answer

    def write_angiogram(self, path: Path) -> None:
        """Write what an X-ray shows of the stents."""
        from ..report import write_angiogram

        write_angiogram(self._result, path, hides_device=self.options.hide_device)

    def write_picture(self, path: Path) -> None:
        """Write the picture of the vessel before and after."""
        if isinstance(self.picture, str):
            raise DeploymentError(self.picture)
        path.write_bytes(self.picture)

    @property
    def picture(self) -> bytes | str:
        """The picture of the vessel before and after, drawn once, or the reason why it could not
        be."""
        if not self._picture:
            from ..report import before_after_picture

            try:
                self._picture = before_after_picture(
                    self._result, hides_device=self.options.hide_device
                )
            except DeploymentError as error:
                self._picture = str(error)
        return self._picture

    def write_plan(self, path: Path, final: str | os.PathLike[str]) -> None:
        """Write the plan, with its files relative to the folder where it will be."""
        save_plan(self.plan, path, relative_to=os.path.dirname(os.path.abspath(final)))

    @cached_property
    def _views(self) -> PlannedViews:
        """Views of the stents, worked out once for all reports."""
        return planned_views(self._result, hides_device=self.options.hide_device)

    @cached_property
    def _voxels(self) -> VoxelRange | None:
        """Ranges of numbers within half a voxel, where these were asked for."""
        if self.half_voxel is None:
            return None
        with self.console.progress("Deploying half a voxel in and out") as show:
            show(0.0)
            result, half = self._result, self.half_voxel
            case = case_of(result.plan, result.inputs)
            return treated_voxel_range(case, result, half, result.flow)

    @property
    def _result(self) -> PlanResult:
        assert self.result is not None
        return self.result

    def _report(self, picture: bytes | str | None = None) -> Report:
        seconds = perf_counter() - self.write_start
        # The file does not have its final name yet.
        lost = tuple(replace(caution, label="") for caution in self.lost)
        return plan_report(
            self._result,
            lost=lost,
            timings={"write": seconds},
            picture=picture,
            views=self._views,
            voxels=self._voxels,
            whole_tree=self.options.whole_tree,
        )
