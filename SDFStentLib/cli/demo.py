"""The command `demo`: a synthetic patient, treated and reported."""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from time import perf_counter

from ..cautions import Caution
from ..files import (
    add_arrays,
    encode_vtp,
    polydata_from_arrays,
    polydata_from_lines,
    set_face_names,
    set_frame_of_polydata,
)
from ..phantoms import Phantom, branching_pulmonary_artery
from ..plan import (
    InputFiles,
    Plan,
    PlanResult,
    input_file,
    read_input_files,
    save_plan,
    treatment_of,
)
from ..report import (
    before_after_picture,
    plan_report,
    write_report,
)
from ..stent import BetweenPoints, Stent
from ..validation import DeploymentError
from .console import Console, tell
from .outputs import Outputs

BALLOON_DIAMETER = 7.5
"""Balloon diameter of the demo, mm: after recoil it leaves the 7 mm of the healthy branch, as
`suggest` proposes."""

STENT_ENDS = (26.0, 37.0)
"""Arc lengths of the stent's ends on the main and left pulmonary artery, mm: the stent covers the
whole lesion and hardly the other branch, whose junction is at 24."""

NOT_CERTIFIED = 3


def demo_command(options: argparse.Namespace, console: Console) -> int:
    """Make a patient, treat it, and write all files into a folder."""
    start = perf_counter()
    folder = Path(options.output)
    outputs = Outputs(folder=folder)
    phantom = branching_pulmonary_artery()
    with tempfile.TemporaryDirectory(prefix="sdfstent-") as workshop:
        originals = _written_patient(phantom, Path(workshop))
        inputs = _placed_in(folder, read_input_files(originals[0], originals[1]))
        plan = _plan(phantom, inputs)
        treatment = treatment_of(plan, inputs)
        with console.progress("Deploying") as show:
            for state in treatment:
                show(state.fraction)
        result = PlanResult(plan, inputs, treatment.result)
        for original in originals:
            outputs.add(folder / original.name, _writing(original.read_bytes()))
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


def _placed_in(folder: Path, inputs: InputFiles) -> InputFiles:
    """The inputs with the paths of their final places: plan and report outlive the temporary
    folder."""
    surface, line_file = inputs.surface, inputs.line_file
    assert line_file is not None
    return replace(
        inputs,
        surface=replace(surface, path=folder / surface.path.name),
        line_file=replace(line_file, path=folder / line_file.path.name),
    )


def _plan(phantom: Phantom, inputs: InputFiles) -> Plan:
    ends = phantom.axis_at(STENT_ENDS)
    place = BetweenPoints(*ends)
    stent = Stent(BALLOON_DIAMETER, placement=place, name="left pulmonary artery")
    stent = inputs.vessel.inflated(stent, BALLOON_DIAMETER)
    assert inputs.line_file is not None
    return Plan(
        stents=(stent,),
        surface=input_file(inputs.surface),
        centerline=input_file(inputs.line_file),
        frame=inputs.surface.frame,
    )


def _written_patient(phantom: Phantom, folder: Path) -> list[Path]:
    """Write the surface with SimVascular's face ids, and the centerline as VMTK would give it."""
    surface = polydata_from_arrays(
        phantom.points, phantom.triangles, cell_arrays={"ModelFaceID": phantom.face_ids}
    )
    set_face_names(surface, phantom.faces.names)
    tree = phantom.centerline
    lines = polydata_from_lines(tree.points, [tree.ancestry(int(leaf)) for leaf in tree.leaves])
    add_arrays(lines, {"MaximumInscribedSphereRadius": tree.inscribed_radius}, {})
    paths = []
    for name, polydata in (("surface.vtp", surface), ("centerline.vtp", lines)):
        set_frame_of_polydata(polydata, "RAS")
        paths.append(folder / name)
        paths[-1].write_bytes(encode_vtp(polydata))
    return paths


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
    for name in ("report.json", "report.html"):
        outputs.add(folder / name, lambda path: write_report(report, path))
    outputs.add(folder / "before_after.png", _writing(picture), may_be_missing=True)
    return missing


def _writing(data: bytes | None) -> Callable[[Path], None]:
    def write(path: Path) -> None:
        if data is not None:
            path.write_bytes(data)

    return write
