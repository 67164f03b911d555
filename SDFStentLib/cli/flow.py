"""The command `flow`."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import Any

from ..files import check_suffix
from ..plan import (
    InputFiles,
    Marks,
    flow_answer,
    flow_model,
    load_names,
    load_plan,
    read_input_files,
    run_plan,
)
from ..report import document_json, flow_document, flow_page, flow_sentences
from ..stent import InputFile
from ..treatment import TreatmentResult
from .console import Console
from .flow_options import add_networks, known_of, no_flow
from .outputs import Outputs
from .place import names_of, root_of

LISTED = 3
"""Narrowings that are told on the screen."""


def flow_command(options: argparse.Namespace, console: Console) -> int:
    """Tell pressures and flows before and after a plan."""
    known = known_of(options)
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
    inputs, result = _read(options, console)
    answer = flow_answer(
        flow_model(inputs.vessel, known, inputs.surface.frame), inputs.vessel, result
    )
    files = {"surface": options.surface, "centerline": options.centerline, "plan": options.plan}
    document = flow_document(answer, {name: str(file) for name, file in files.items() if file})
    outputs.write()
    for sentence in flow_sentences(document, None if options.verbose else LISTED):
        console.say(sentence)
    if outputs.names():
        console.say(f"Wrote {', '.join(outputs.names())}.")
    return 0


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


def _write(path: Path, document: dict[str, Any]) -> None:
    """A document as JSON, or as a page."""
    if path.suffix.lower() == ".html":
        path.write_text(flow_page(document), encoding="utf-8")
        return
    path.write_text(document_json(document), encoding="utf-8")
