"""The commands `flow` and `simulate`: flow before and after, by a network and in 3D."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from ..files import check_suffix
from ..flow import Known, has_svzerod, solved_by_svzerod
from ..plan import (
    InputFiles,
    Marks,
    Plan,
    flow_answer,
    flow_model,
    load_names,
    load_plan,
    read_input_files,
    read_plan_inputs,
    treatment_of,
)
from ..report import (
    RESEARCH_USE,
    document_json,
    flow_document,
    flow_page,
    flow_sentences,
    mesh_sentences,
    simulation_document,
    simulation_page,
    simulation_sentences,
)
from ..simulation import (
    DOCUMENT,
    FILES,
    GET_IT,
    Cut,
    Origin,
    Prepared,
    Wishes,
    has_solver,
    prepare,
    read_results,
    solve_cases,
    write_cases,
)
from ..stent import InputFile
from ..treatment import TreatmentResult
from ..validation import InputError, as_number
from .console import Console
from .flow_options import add_networks, known_of, no_flow
from .outputs import Outputs
from .place import ends_of, names_of, root_of, treated_of

LISTED = 3
"""Number of narrowings that are listed on the screen."""


def flow_command(options: argparse.Namespace, console: Console) -> int:
    """Report pressures and flows before and after a plan."""
    plan = _plan(options)
    if plan is not None:
        console.units = plan.units
    known = known_of(options, console)
    if known is None:
        raise no_flow()
    read = [options.surface, options.centerline, options.plan, options.wave, options.names]
    outputs = Outputs(read)
    if options.json:
        outputs.add(options.json, lambda path: _write(path, document))
    for path in options.report:
        check_suffix(path, "a report", (".json", ".html"))
        outputs.add(path, lambda made: _write(made, document))
    add_networks(outputs, options.export_0d, lambda: answer)
    inputs = _read(options, plan)
    # Values that do not fit this vessel are refused before anything is deployed.
    model = flow_model(inputs.vessel, known, inputs.surface.frame)
    result = None if plan is None else _deployed(plan, inputs, console)
    cautions = inputs.warnings if result is None else (*inputs.warnings, *result.warnings)
    console.warn_shortly(cautions, LISTED, console.units)
    answer = flow_answer(model, inputs.vessel, result)
    files = {"surface": options.surface, "centerline": options.centerline, "plan": options.plan}
    document = flow_document(answer, {name: str(file) for name, file in files.items() if file})
    outputs.write()
    for sentence in flow_sentences(document, None if options.verbose else LISTED):
        console.say(sentence)
    if outputs.names():
        console.say(f"Wrote {', '.join(outputs.names())}.")
    return 0


def _plan(options: argparse.Namespace) -> Plan | None:
    """The plan, with the files that the options name."""
    if options.plan is None:
        return None
    plan = load_plan(options.plan, accept_changed_inputs=options.accept_changed_inputs)
    # The files may lie elsewhere than when the plan was made.
    surface, centerline = (
        InputFile(path, None if file is None else file.sha256)
        for path, file in (
            (options.surface, plan.surface),
            (options.centerline, plan.centerline),
        )
    )
    names = plan.names if options.names is None else load_names(options.names, plan.units)
    return replace(plan, surface=surface, centerline=centerline, names=names)


def _read(options: argparse.Namespace, plan: Plan | None) -> InputFiles:
    """The input files, by the options or by the plan."""
    if plan is None:
        marks = Marks(root_of(options), names=names_of(options))
        return read_input_files(options.surface, options.centerline, options.units, marks)
    return read_plan_inputs(plan, accept_changed_inputs=options.accept_changed_inputs)


def _deployed(plan: Plan, inputs: InputFiles, console: Console) -> TreatmentResult:
    treatment = treatment_of(plan, inputs)
    with console.progress("Deploying") as show:
        for state in treatment:
            show(state.fraction, f"diameter {2 * state.deployment.radius:.1f} mm")
    return treatment.result


def _write(
    path: Path,
    document: dict[str, Any],
    made_page: Callable[[dict[str, Any]], str] = flow_page,
) -> None:
    if path.suffix.lower() == ".html":
        path.write_text(made_page(document), encoding="utf-8")
        return
    path.write_text(document_json(document), encoding="utf-8")


def simulate_command(options: argparse.Namespace, console: Console) -> int:
    """Cut, mesh and solve a vessel before and after, or report the results of a solver."""
    _check_simulate(options)
    document: dict[str, Any] = {}
    if options.read is not None:
        results = _results([Path(options.read) / DOCUMENT], options, document)
        return _tell_results(Path(options.read), results, document, console)
    known = known_of(options, console)
    if known is None:
        raise no_flow()
    read = [options.surface, options.after, options.centerline, options.wave, options.names]
    results, outputs, folder = _results(read, options, document), Outputs(read), options.output
    if any(Path(folder).glob("**/results/result_*.vtu")):
        raise InputError(
            f"{folder}: expected a new folder, got one with results of a solver, which would be "
            "lost; name another one, or read it with --read."
        )
    outputs.add_folder(
        folder,
        lambda made: write_cases(made, prepared, origin, options.processes),
        FILES.__contains__,
    )
    prepared, origin = _prepared(options, known, console)
    outputs.write()
    for sentence in mesh_sentences(prepared):
        console.say(sentence)
    console.say(f"Wrote {folder}.")
    if options.no_run or not has_solver():
        if not options.no_run:
            console.say(GET_IT)
        console.say(f"When it is solved: sdfstent simulate --read {folder}")
        return 0
    with console.progress("Solving") as show:
        solve_cases(Path(folder), show)
    return _tell_results(Path(folder), results, document, console)


def _check_simulate(options: argparse.Namespace) -> None:
    """Refuse missing options, and options that do not go together."""
    needed = {
        "SURFACE": options.surface,
        "--after": options.after,
        "--centerline": options.centerline,
        "-o": options.output,
    }
    missing = [name for name, value in needed.items() if value is None]
    if options.read is not None and len(missing) < len(needed):
        name = next(name for name in needed if name not in missing)
        raise InputError(f"--read: expected a folder and nothing else, got {name}, too; leave it.")
    if options.read is None and missing:
        raise InputError(
            f"expected {', '.join(needed)}, or --read DIR, got no {missing[0]}; name it."
        )
    if (options.from_point is None) != (options.to is None):
        raise InputError("expected --from and --to, or none of them, got one; name both ends.")
    as_number(options.processes, "--processes", minimum=1, maximum=4096)
    as_number(options.edges_round, "--edges-round", minimum=8, maximum=200)
    as_number(options.coarser, "--coarser", minimum=1, maximum=5)


def _prepared(
    options: argparse.Namespace, known: Known, console: Console
) -> tuple[Prepared, Origin]:
    """The vessel, cut and meshed, and its origin."""
    marks = Marks(root_of(options), names=names_of(options))
    read = read_input_files(options.surface, options.centerline, options.units, marks)
    after, frame = treated_of(options, read), read.surface.frame
    console.warn([*read.warnings, *after.warnings], units=options.units)
    ends = None if options.to is None else ends_of(options)
    model = flow_model(read.vessel, known, frame)
    with console.progress("Meshing") as show:
        prepared = prepare(
            (read.vessel, after.vessel),
            model,
            Cut(ends, options.close_branches, options.units),
            Wishes(options.edges_round, options.coarser),
            show,
            solve=solved_by_svzerod if has_svzerod() else None,
        )
    console.warn(prepared.warnings, units=options.units)
    files = {"surface": options.surface, "after": options.after, "centerline": options.centerline}
    return prepared, Origin(files, RESEARCH_USE, frame)


def _results(
    inputs: Sequence[Any], options: argparse.Namespace, document: dict[str, Any]
) -> Outputs:
    """The files of results, checked before anything is solved; the document is filled in later."""
    outputs = Outputs(inputs)
    for path in [*([options.json] if options.json else []), *options.report]:
        check_suffix(path, "results", (".json", ".html"))
        outputs.add(path, lambda made: _write(made, document, simulation_page))
    return outputs


def _tell_results(
    folder: Path, results: Outputs, document: dict[str, Any], console: Console
) -> int:
    """Report the results of a solver, on the screen and in files."""
    document.update(simulation_document(read_results(folder)))
    results.write()
    for sentence in simulation_sentences(document):
        console.say(sentence)
    if results.names():
        console.say(f"Wrote {', '.join(results.names())}.")
    return 0
