"""The command `centerline`: the lines of a bare surface, by VMTK."""

from __future__ import annotations

import argparse

from ..files import (
    VTK_LINE_SUFFIXES,
    check_line_output,
    check_vmtk,
    extract_lines,
    write_extracted_lines,
)
from ..plan import read_input_files
from ..report import filed_point
from .console import Console
from .outputs import Outputs
from .place import in_mm


def centerline_command(options: argparse.Namespace, console: Console) -> int:
    """Write the centerlines from the inlet to every outlet."""
    check_vmtk()
    check_line_output(options.output, VTK_LINE_SUFFIXES)
    outputs = Outputs([options.surface])
    outputs.add(options.output, lambda path: write_extracted_lines(path, lines, inputs.surface))
    inputs = read_input_files(options.surface, units=options.units)
    inlet = None if options.inlet is None else in_mm(options.inlet, options.units, "--inlet")
    seeds = inputs.vessel.seeds(
        inlet, [in_mm(end, options.units, "--outlet") for end in options.outlet]
    )
    console.warn(inputs.warnings)
    with console.progress("VMTK") as show:
        show(0.0)
        lines = extract_lines(seeds.surface, seeds.inlet, seeds.outlets)
    outputs.write()
    units, ends = options.units, seeds.surface.points
    console.say(
        f"Proximal is the end at {filed_point(ends[seeds.inlet], units)} {units}"
        + (", the largest; --inlet X Y Z names another one." if inlet is None else ".")
    )
    count = len(seeds.outlets)
    console.say(f"{count} line{'s' * (count > 1)} to {options.output}, ending at")
    for outlet in seeds.outlets:
        console.say(f"  {filed_point(ends[outlet], units)} {units}")
    return 0
