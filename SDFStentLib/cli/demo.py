"""The command `demo`: a synthetic patient, treated and reported."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from time import perf_counter

import numpy as np

from ..cautions import Caution
from ..plan import (
    InputFiles,
    Plan,
    PlanResult,
    carried_out,
    input_file,
    read_input_files,
    save_plan,
)
from ..report import (
    before_after_picture,
    plan_report,
    write_report,
)
from ..samples import Sample, sample
from ..stent import BetweenPoints, Stent
from ..validation import DeploymentError
from .console import Console, tell
from .outputs import Outputs

BALLOON_DIAMETER = 7.5
"""Balloon diameter of the demo, mm: after recoil it leaves the 7 mm of the healthy branch, as
`suggest` proposes."""

STENT_ENDS = (
    (-1.7487059515398227, 0.0, 25.739214543510403),
    (-9.130601228128125, 0.0, 33.663133959253415),
)
"""Places of the stent's ends on the main and left pulmonary artery, mm, 26 and 37 mm from the
inlet: the stent covers the throat and hardly the other branch, whose junction is at 24. There the
lesion begins, of which 2 mm count as not covered. docs/flow.md was computed with this stent."""

NOT_CERTIFIED = 3


def demo_command(options: argparse.Namespace, console: Console) -> int:
    """Make a patient, treat it, and write all files into a folder."""
    start = perf_counter()
    folder = Path(options.output)
    outputs = Outputs(folder=folder)
    patient = sample("branching_pulmonary_artery")
    copies = Sample(folder / "surface.vtp", folder / "centerline.vtp")
    inputs = _placed_at(copies, read_input_files(*patient))
    plan = _plan(inputs)
    with console.progress("Deploying") as show:
        result = carried_out(plan, inputs, lambda state: show(state.fraction))
    for original, copy in zip(patient, copies, strict=True):
        outputs.add(copy, _writing(original.read_bytes()))
    missing = _add_results(outputs, folder, result)
    outputs.write()
    tell(result, (*result.warnings, *result.size_warnings, *missing), console)
    console.say(
        f"Wrote {folder} in {perf_counter() - start:.1f} s: report.html to read, "
        "surface_stented.vtp to mesh, plan.json to change and carry out with sdfstent run."
    )
    certificate = result.treatment.certificate
    assert certificate is not None
    return 0 if certificate.passed else NOT_CERTIFIED


def _placed_at(files: Sample, inputs: InputFiles) -> InputFiles:
    """The inputs with the paths of their copies, to which plan and report refer."""
    assert inputs.line_file is not None
    return replace(
        inputs,
        surface=replace(inputs.surface, path=files.surface),
        line_file=replace(inputs.line_file, path=files.centerline),
    )


def _plan(inputs: InputFiles) -> Plan:
    place = BetweenPoints(*np.array(STENT_ENDS))
    stent = Stent(BALLOON_DIAMETER, placement=place, name="left pulmonary artery")
    stent = inputs.vessel.inflated(stent, BALLOON_DIAMETER)
    assert inputs.line_file is not None
    return Plan(
        stents=(stent,),
        surface=input_file(inputs.surface),
        centerline=input_file(inputs.line_file),
        frame=inputs.surface.frame,
    )


def _add_results(outputs: Outputs, folder: Path, result: PlanResult) -> list[Caution]:
    """Add all results of the treatment to the outputs; return cautions about what is missing."""
    missing: list[Caution] = []
    picture = None
    try:
        picture = before_after_picture(result, "Synthetic pulmonary artery of a child")
    except DeploymentError as error:
        # A machine without an OpenGL library can do everything else.
        missing.append(Caution("picture-missing", {"reason": str(error)}))
    report = plan_report(result, picture=picture or missing[0].sentence())
    outputs.add(folder / "surface_stented.vtp", lambda path: result.write_surface(path))
    outputs.add(folder / "centerline_stented.vtp", lambda path: result.write_centerline(path))
    outputs.add(folder / "plan.json", lambda path: save_plan(result.plan, path, relative_to=folder))
    outputs.add(folder / "report.html", lambda path: write_report(report, path))
    outputs.add(folder / "before_after.png", _writing(picture), may_be_missing=True)

    def write_document(path: Path) -> None:
        write_report(report.with_outputs(outputs.beside(folder / path.name)), path)

    outputs.add(folder / "report.json", write_document, is_last=True)
    return missing


def _writing(data: bytes | None) -> Callable[[Path], None]:
    def write(path: Path) -> None:
        if data is not None:
            path.write_bytes(data)

    return write
