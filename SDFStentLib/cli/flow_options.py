"""The options of the command `flow`, those that others have left out."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..flow import (
    FlowAnswer,
    Inflow,
    Known,
    Wave,
    flow_value,
    known_flow,
    read_wave,
    time_value,
)
from ..line_formats import LINES_IN_WORDS
from ..report import document_json
from ..surface_formats import FORMATS_IN_WORDS
from ..validation import InputError, as_place
from .console import Console
from .option_table import (
    ACCEPTANCE,
    CENTERLINE,
    NAMES,
    ROOT,
    SURFACE,
    TALK,
    UNITS,
    VERBOSE,
    WORK,
    add_table,
)
from .outputs import Outputs
from .place import in_mm

NETWORKS = ("before.json", "after.json")
"""Names of the files in the folder of `--export-0d`."""


def add_flow(command: argparse.ArgumentParser) -> None:
    """Add description and options: the vessel, flow data of the patient, and outputs."""
    command.description = (
        "Pressures and flows in a vessel tree before a plan and after it: the pressure at the "
        "inlet, the drop over each narrowing and the flow to each main branch, with their ranges, "
        "by a network of the vessels. Methods, sources and limits: docs/flow.md."
    )
    add_table(command, SURFACE)
    add_table(command, CENTERLINE, required=True)
    add_table(
        command,
        f"""\
--plan PLAN  what is done to the vessel; without it only what is before is told
--root X Y Z  the end of the centerline near this point is proximal; a plan has its own
{NAMES}""",
    )
    add_known(command)
    add_table(
        command.add_argument_group("output"),
        """\
--json F  all numbers
--report F ...  .json or .html; may be repeated
--export-0d DIR  the networks as before.json and after.json for svZeroDSolver
""",
    )
    add_table(command, ACCEPTANCE + UNITS + VERBOSE + WORK)


def add_known(command: argparse.ArgumentParser) -> None:
    """Add options for flow and pressures before treatment."""
    add_table(
        command.add_argument_group("what is known of flow before treatment"),
        """\
--mean-flow Q  with its unit, such as 41.7mL/s or 2.5L/min
--inlet NAME=Q ...  the same at one of several inlets, by the name of its end, or NAME=F, a wave
--bsa A  body surface area, m2, to index the power loss with several inlets
--peak-flow Q  told apart from the mean
--wave F  CSV of a cycle, rows of time and flow under a header with units; scaled to --mean-flow
--cycle T  its length, such as 0.8s, where the rows of a wave do not tell that
--unusual-flow  a heart rate or a mean flow beyond the usual ones is meant so
--inlet-pressure P  mean in the main artery, mmHg
--wedge W  mean pressure beyond the lungs, mmHg
--split-right S  share of the flow to the right, such as 0.8
--right X Y Z  a place in the right main branch, where the frame of the file does not tell
""",
    )


def add_simulate(command: argparse.ArgumentParser) -> None:
    """Add description and options: the segment and its mesh, flow data, and results to read."""
    command.description = (
        "Flow in three dimensions before a stent and after it: the segment round the stent is cut, "
        "meshed (MMG, TetGen) and solved by svMultiPhysics where that is installed; pressures, "
        "flows and wall shear are told beside those of the network. docs/flow.md says how."
    )
    add_table(command, f"surface SURFACE  before; {FORMATS_IN_WORDS}", nargs="?")
    add_table(
        command,
        f"""\
--after SURFACE2  the same vessel with its stents, as `deploy` writes it
--centerline FILE  of the vessel before, any form; {LINES_IN_WORDS}
-o, --output DIR  folder to write: meshes, solver.xml, run.sh and job.sbatch
--read DIR  in place of all these: tell what the solver has found in a folder
--from X Y Z  one end of the segment (default: beyond the wall that moved)
--to X Y Z  the other end
--close-branches  close side branches; else they are cut off and become outlets
--edges-round N = 20  so many edges go round the vessel at least (default 20)
--coarser X = 1  edges so many times as long, for a quick look (default 1)
--processes N = 2  of the solver (default 2)
--no-run  only write the folder
{ROOT}{NAMES}{UNITS}""",
    )
    add_known(command)
    add_table(
        command.add_argument_group("output"),
        f"""\
--json F  all numbers of the results
--report F ...  the same as a page, .html; may be repeated
{TALK}""",
    )


def known_of(options: argparse.Namespace, console: Console) -> Known | None:
    """Flow data of the patient in the options; None where they have none.

    A place is in the units of the console. How the rows of a wave were taken is said.

    Raises
    ------
    InputError
        Values that contradict each other, or something else than a flow without a flow.
    """
    values: dict[str, Any] = {
        "bsa": options.bsa,
        "inlet": options.inlet_pressure,
        "wedge": options.wedge,
        "split_right": options.split_right,
    }
    mean, peak = (
        None if text is None else flow_value(text, name)
        for text, name in ((options.mean_flow, "--mean-flow"), (options.peak_flow, "--peak-flow"))
    )
    cycle = None if options.cycle is None else time_value(options.cycle, "--cycle")
    wave = None
    if options.wave is not None:
        needs_unit = mean is None and not options.inlet
        wave = _wave(options.wave, console, cycle, needs_unit=needs_unit)
    inlets = tuple(_inflow(text, console, cycle) for text in options.inlet)
    has_own = any(one.wave is not None for one in inlets)
    if cycle is not None and wave is None and not has_own:
        raise InputError("--cycle: expected a wave beside it, got none; give one.")
    if wave is not None and has_own:
        raise InputError(
            "--wave: expected one wave for all inlets, or files of their own at --inlet, got both; "
            "leave one out."
        )
    if mean is None and wave is None and not inlets:
        if any(value is not None for value in (peak, options.right, *values.values())):
            raise no_flow()
        return None
    right = None
    if options.right is not None:
        right = as_place(in_mm(options.right, console.units, "--right"))
    unusual = options.unusual_flow
    return known_flow(mean, wave, inlets, peak=peak, right=right, unusual=unusual, **values)


def _wave(file: str, console: Console, cycle: float | None, *, needs_unit: bool = True) -> Wave:
    """Wave of a file; says how its rows were taken."""
    wave, cautions = read_wave(file, needs_unit=needs_unit, cycle=cycle)
    console.warn([one.labeled(f"{file}: ") for one in cautions])
    return wave


def _inflow(text: str, console: Console, cycle: float | None) -> Inflow:
    """Flow at one inlet from an option: NAME=Q, or NAME=F with the file of a wave."""
    name, sign, told = (part.strip() for part in text.rpartition("="))
    if not (name and sign and told):
        raise InputError(
            "--inlet: expected the name of an end and the flow there, such as SVC=20mL/s, got "
            f"{text!r}; write both."
        )
    if Path(told).suffix.lower() == ".csv" or Path(told).is_file():
        wave = _wave(told, console, cycle)
        return Inflow(name, wave.mean, wave)
    return Inflow(name, flow_value(told, f"--inlet {name}", may_be_zero=True))


def no_flow() -> InputError:
    """The error for what needs a flow and got none."""
    return InputError(
        "expected --mean-flow Q, such as 2.5L/min, --wave F, or --inlet NAME=Q for every inlet, "
        "got none; give one."
    )


def add_networks(outputs: Outputs, folder: str | None, answer: Callable[[], FlowAnswer]) -> None:
    """The folder of `--export-0d`, where it is wanted."""

    def write(made: Path) -> None:
        made.mkdir()
        for name, document in zip(NETWORKS, answer().documents(), strict=False):
            (made / name).write_text(document_json(document), encoding="utf-8")

    if folder:
        outputs.add_folder(folder, write, NETWORKS.__contains__)
