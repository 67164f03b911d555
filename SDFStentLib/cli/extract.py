"""The command `extract`: a segment of a vessel for a flow solver."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from ..files import SurfaceFile
from ..plan import InputFiles, read_input_files
from ..report import SEGMENT_FILES, segment_sentences, write_segment
from ..treatment import ExtractedSegment, extract_segment
from ..validation import InputError
from .console import Console
from .outputs import Outputs
from .place import in_mm, root_of


def extract_command(options: argparse.Namespace, console: Console) -> int:
    """Write the segment between two places, before treatment and after."""
    ends = (
        in_mm(options.from_point, options.units, "--from"),
        in_mm(options.to, options.units, "--to"),
    )
    outputs = Outputs([options.surface, options.centerline, options.after])
    outputs.add_folder(
        options.output, lambda folder: _write(folder, found, read), SEGMENT_FILES.__contains__
    )
    units = options.units
    read = [read_input_files(options.surface, options.centerline, units, root_of(options))]
    if options.after is not None:
        read.append(_treated(options, read[0]))
    for one in read:
        console.warn(one.warnings, units=units)
    found = extract_segment(
        read[0].vessel,
        *ends,
        close_branches=options.close_branches,
        after=read[1].vessel if len(read) > 1 else None,
        units=units,
    )
    console.warn(found.warnings, units=units)
    outputs.write()
    for sentence in segment_sentences(found):
        console.say(sentence)
    console.say(f"Wrote {options.output}, in cm; mesh its exterior with the surface kept.")
    return 0


def _treated(options: argparse.Namespace, before: InputFiles) -> InputFiles:
    """The vessel after treatment; `InputError` where it is in another frame."""
    after = read_input_files(options.after, units=options.units)
    frames = [one.surface.frame for one in (before, after)]
    if None not in frames and frames[0] != frames[1]:
        raise InputError(
            f"{options.after}: expected the frame of {options.surface}, {frames[0]}, got "
            f"{frames[1]}; write both in one frame."
        )
    return after


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
