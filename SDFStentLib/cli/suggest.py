"""The commands `suggest` and `devices`."""

from __future__ import annotations

import argparse
import os
import shlex
from pathlib import Path

from ..plan import InputFiles, Plan, device_named, device_table, save_plan, to_document
from ..report import (
    device_rows,
    device_sentence,
    document_json,
    suggestion_facts,
)
from ..treatment import SizingWishes
from ..validation import one_line
from .console import Console
from .outputs import Outputs
from .place import check_lesion_number, inputs_of, plan_of
from .stent_options import device_of


def suggest_command(options: argparse.Namespace, console: Console) -> int:
    """Propose a stent for each lesion asked for, and write the plan."""
    wishes = SizingWishes(options.ratio, options.margin, device_of(options), options.foreshortening)
    outputs = Outputs([options.surface, options.centerline, options.names])
    plan, name = Plan(), options.output or f"{Path(options.surface).stem}_plan.json"
    folder = os.path.dirname(os.path.abspath(name))
    outputs.add(name, lambda path: save_plan(plan, path, relative_to=folder))
    inputs = inputs_of(options)
    suggestions = [inputs.vessel.suggestion(number, wishes) for number in _numbers(options, inputs)]
    plan = plan_of(options, Plan(), tuple(one.stent for one in suggestions), inputs)
    outputs.write()
    devices = device_table(options.device_table)
    facts = [suggestion_facts(one, devices) for one in suggestions]
    cautions = [*inputs.warnings, *inputs.vessel.lesion_cautions]
    if options.json:
        warnings = [caution.sentence(units=options.units) for caution in cautions]
        print(document_json({"suggestions": facts, "warnings": warnings}), end="")
        return 0
    console.warn(cautions, units=options.units)
    for one, told in zip(suggestions, facts, strict=True):
        for sentence in told.sentences:
            console.say(sentence)
        console.warn(caution.labeled(f"Lesion {one.number}: ") for caution in one.cautions())
    console.say(f"Wrote {name}; to carry it out: sdfstent run {shlex.quote(name)} -o DIR")
    return 0


def _numbers(options: argparse.Namespace, inputs: InputFiles) -> list[int]:
    """Numbers of the lesions to be treated, each once; by default the first one."""
    numbers = list(dict.fromkeys(options.lesion or [1]))
    for number in numbers:
        check_lesion_number(number, inputs, "--lesion", "there is nothing to treat")
    return numbers


def devices_command(options: argparse.Namespace, _console: Console) -> int:
    """List the known devices, or report all known facts about one."""
    if options.name is None:
        devices = device_table(options.device_table)
    else:
        devices = (device_named(options.name, options.device_table),)
    if options.json:
        listed = [to_document(device) for device in devices]
        print(document_json({"devices": listed}), end="")
    elif options.name is None:
        for device in devices:
            print(one_line(device_sentence(device)))
    else:
        for name, text in device_rows(devices[0]):
            print(one_line(f"{name}: {text}"))
    return 0
