"""The command `flow`."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import Any

from ..files import check_suffix
from ..flow import (
    FlowAnswer,
    Known,
    SideClues,
    channels_after,
    channels_of,
    flow_answer,
    flow_value,
    has_svzerod,
    known_flow,
    read_wave,
    solved_by_svzerod,
    svzerod_document,
    vessels_of,
)
from ..plan import InputFiles, Marks, load_names, load_plan, read_input_files, run_plan
from ..report import document_json, flow_document, flow_page, flow_sentences, lesions_by_size
from ..stent import InputFile
from ..treatment import TreatmentResult
from ..validation import InputError, Points
from ..vessel import SMALL_VESSEL
from .console import Console
from .outputs import Outputs
from .place import in_mm, names_of, root_of

LISTED = 3
"""Narrowings that are told on the screen."""

NETWORKS = ("before.json", "after.json")


def flow_command(options: argparse.Namespace, console: Console) -> int:
    """Tell pressures and flows before and after a plan."""
    known = _known(options)
    read = [options.surface, options.centerline, options.plan, options.wave, options.names]
    outputs = Outputs(read)
    if options.json:
        outputs.add(options.json, lambda path: _write(path, document))
    for path in options.report:
        check_suffix(path, "a report", (".json", ".html"))
        outputs.add(path, lambda made: _write(made, document))
    if options.export_0d:
        outputs.add_folder(
            options.export_0d, lambda folder: _write_networks(folder, answer), NETWORKS.__contains__
        )
    inputs, result = _read(options, console)
    solve = solved_by_svzerod if known.wave is not None and has_svzerod() else None
    answer = _answer(options, known, inputs, result, solve)
    document = flow_document(
        answer,
        {"surface": str(options.surface), "centerline": str(options.centerline)}
        | ({"plan": str(options.plan)} if options.plan else {}),
        is_quasi_steady=known.wave is not None and solve is None,
    )
    outputs.write()
    for sentence in flow_sentences(document, None if options.verbose else LISTED):
        console.say(sentence)
    if outputs.names():
        console.say(f"Wrote {', '.join(outputs.names())}.")
    return 0


def _known(options: argparse.Namespace) -> Known:
    """What the options tell of the patient."""
    mean, peak = (
        None if text is None else flow_value(text, name)
        for text, name in ((options.mean_flow, "--mean-flow"), (options.peak_flow, "--peak-flow"))
    )
    wave = None if options.wave is None else read_wave(options.wave, needs_unit=mean is None)
    if mean is None and wave is None:
        raise InputError(
            "expected --mean-flow Q, such as 2.5L/min, or --wave F, got neither; give one."
        )
    return known_flow(
        mean,
        peak=peak,
        wave=wave,
        pressures=(options.inlet_pressure, options.wedge),
        split_right=options.split_right,
    )


def _read(
    options: argparse.Namespace, console: Console
) -> tuple[InputFiles, TreatmentResult | None]:
    """The vessel, and what the plan makes of it."""
    if options.plan is None:
        marks = Marks(root_of(options), names=names_of(options))
        inputs = read_input_files(options.surface, options.centerline, options.units, marks)
        console.warn(inputs.warnings, units=options.units)
        return inputs, None
    accept = options.accept_changed_inputs
    plan = load_plan(options.plan, accept_changed_inputs=accept)
    # The files may lie elsewhere than when the plan was made.
    surface, centerline = (
        InputFile(path, None if file is None else file.sha256)
        for path, file in (
            (options.surface, plan.surface),
            (options.centerline, plan.centerline),
        )
    )
    names = plan.names if options.names is None else load_names(options.names, plan.units)
    plan = replace(plan, surface=surface, centerline=centerline, names=names)
    with console.progress("Deploying") as show:
        done = run_plan(
            plan,
            accept_changed_inputs=accept,
            progress=lambda state: show(
                state.fraction, f"diameter {2 * state.deployment.radius:.1f} mm"
            ),
        )
    inputs, result = done.inputs, done.treatment
    console.warn_shortly([*inputs.warnings, *result.warnings], LISTED, options.units)
    return inputs, result


def _answer(
    options: argparse.Namespace,
    known: Known,
    inputs: InputFiles,
    result: TreatmentResult | None,
    solve: Any,
) -> FlowAnswer:
    vessel = inputs.vessel
    assert vessel.centerline is not None
    before, after = channels_of(vessel.surface, vessel.centerline), None
    lines: list[tuple[str, Points]] = []
    if result is not None:
        assert result.centerline is not None
        states = (vessel.centerline, result.centerline), (vessel.surface, result.surface)
        after = channels_after(before, *states)
        lines = [(f"stent {one.number}", one.axis.points) for one in result.final_stents]
    lesions = vessel.lesions or ()
    for number in lesions_by_size(lesions, SMALL_VESSEL)[0]:
        one = lesions[number - 1]
        lines.append((f"lesion {number}, {one.branch_name}", one.line))
    right = None if options.right is None else in_mm(options.right, options.units, "--right")
    sides = SideClues(inputs.surface.frame, right, vessel.given_names)
    return flow_answer(vessels_of(before, after, lines, sides), known, solve)


def _write(path: Path, document: dict[str, Any]) -> None:
    """A document as JSON, or as a page."""
    if path.suffix.lower() == ".html":
        path.write_text(flow_page(document), encoding="utf-8")
        return
    path.write_text(document_json(document), encoding="utf-8")


def _write_networks(folder: Path, answer: FlowAnswer) -> None:
    folder.mkdir()
    notice = (
        ""
        if answer.known.has_pressures
        else (
            "no pressures are known: outlets resist so much that they share the flow whatever the "
            "vessel costs; differences of pressure within the vessel are right, its level is not"
        )
    )
    for name, network in zip(NETWORKS, answer.networks, strict=False):
        _write(folder / name, svzerod_document(network, answer.outlets, answer.known, notice))
