"""The commands `extract`, for a segment of a vessel, and `centerline`, for the lines
of a surface."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from ..files import (
    SurfaceFile,
    check_line_output,
    check_vmtk,
    extract_lines,
    write_extracted_lines,
)
from ..line_formats import VTK_LINE_SUFFIXES
from ..plan import InputFiles, Marks, read_input_files
from ..report import SEGMENT_FILES, filed_point, segment_sentences, write_segment
from ..treatment import ExtractedSegment, SegmentWishes, extract_segment
from .console import Console
from .outputs import Outputs
from .place import ends_of, in_mm, names_of, root_of, treated_of


def extract_command(options: argparse.Namespace, console: Console) -> int:
    """Write the segment between two places, before and after treatment."""
    ends = ends_of(options)
    outputs = Outputs([options.surface, options.centerline, options.after, options.names])
    outputs.add_folder(
        options.output, lambda folder: _write(folder, found, read), SEGMENT_FILES.__contains__
    )
    units = options.units
    marks = Marks(root_of(options), names=names_of(options))
    read = [read_input_files(options.surface, options.centerline, units, marks)]
    if options.after is not None:
        read.append(treated_of(options, read[0]))
    for one in read:
        console.warn(one.warnings, units=units)
    found = extract_segment(
        read[0].vessel,
        *ends,
        SegmentWishes(options.close_branches, units=units),
        after=read[1].vessel if len(read) > 1 else None,
    )
    console.warn(found.warnings, units=units)
    outputs.write()
    for sentence in segment_sentences(found):
        console.say(sentence)
    console.say(f"Wrote {options.output}, in cm; mesh its exterior with the surface kept.")
    return 0


def _write(folder: Path, found: ExtractedSegment, read: list[InputFiles]) -> None:
    folder.mkdir()
    write_segment(folder, found, _inputs(read), [one.surface.frame for one in read])


def _inputs(read: list[InputFiles]) -> dict[str, Any]:
    line = read[0].line_file
    assert line is not None
    return {
        "surface": _file(read[0].surface),
        "centerline": {"file": str(line.path), "sha256": line.sha256},
        "after": _file(read[1].surface) if len(read) > 1 else None,
    }


def _file(read: SurfaceFile) -> dict[str, Any]:
    return {"file": str(read.path), "sha256": read.sha256}


def centerline_command(options: argparse.Namespace, console: Console) -> int:
    """Write the centerlines from the inlet to every outlet."""
    if options.method == "vmtk":
        check_vmtk()
    check_line_output(options.output, VTK_LINE_SUFFIXES)
    outputs = Outputs([options.surface])
    outputs.add(options.output, lambda path: write_extracted_lines(path, lines, inputs.surface))
    inputs = read_input_files(options.surface, units=options.units)
    inlet = None if options.inlet is None else in_mm(options.inlet, options.units, "--inlet")
    outlets = [in_mm(end, options.units, "--outlet") for end in options.outlet]
    console.warn(inputs.warnings)
    with console.progress("Centerline") as show:
        show(0.0)
        if options.method == "vmtk":
            seeds = inputs.vessel.seeds(inlet, outlets)
            lines = extract_lines(*seeds)
            ends = seeds.surface.points[[seeds.inlet, *seeds.outlets]]
        else:
            found = inputs.vessel.extracted(inlet, outlets)
            lines = found.lines
            ends = lines.points[[lines.lines[0][0], *(line[-1] for line in lines.lines)]]
            console.warn(found.warnings)
    outputs.write()
    units = options.units
    console.say(
        f"Proximal is the end at {filed_point(ends[0], units)} {units}"
        + (", the largest; --inlet X Y Z names another one." if inlet is None else ".")
    )
    count = len(lines.lines)
    console.say(f"{count} line{'s' * (count > 1)} to {options.output}, ending at")
    for end in ends[1:]:
        console.say(f"  {filed_point(end, units)} {units}")
    return 0
