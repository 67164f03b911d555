"""The commands `extract`, for a segment of a vessel, `centerline`, for the lines of a surface, and
`prepare`, for both of a segmentation."""

from __future__ import annotations

import argparse
from hashlib import sha256
from pathlib import Path
from typing import Any

from ..files import (
    SurfaceFile,
    check_line_output,
    check_vmtk,
    extract_lines,
    write_extracted_lines,
    write_new_surface,
)
from ..line_formats import VTK_LINE_SUFFIXES
from ..plan import InputFiles, Marks, read_input_files
from ..report import (
    PREPARED_FILES,
    SEGMENT_FILES,
    document_json,
    filed_point,
    prepared_document,
    prepared_page,
    prepared_picture,
    prepared_sentences,
    segment_sentences,
    write_segment,
)
from ..scan import PreparedVessel, Segmentation, prepared_vessel, read_segmentation
from ..treatment import ExtractedSegment, SegmentWishes, extract_segment
from ..units import Frame
from ..validation import DeploymentError
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
    outputs.add(
        options.output,
        lambda path: write_extracted_lines(path, lines, options.units, inputs.surface.frame),
    )
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
            found = inputs.vessel.extracted(inlet, outlets, show)
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


FRAME: Frame = "LPS"
"""Frame of segmentations as read, and of the vessels made of them."""


def prepare_command(options: argparse.Namespace, console: Console) -> int:
    """Write surface, centerline, picture and page of the vessel in a segmentation."""
    outputs = Outputs([options.segmentation])
    outputs.add_folder(
        options.output,
        lambda folder: _write_prepared(folder, read, made, image),
        PREPARED_FILES.__contains__,
    )
    inlet = None if options.inlet is None else in_mm(options.inlet, "mm", "--inlet")
    read = read_segmentation(options.segmentation, options.label)
    with console.progress("Surface and centerline") as show:
        show(0.0)
        made = prepared_vessel(read.labelmap, inlet, show)
    console.warn(made.warnings)
    image = _image(made, console)
    outputs.write()
    for sentence in prepared_sentences(made):
        console.say(sentence)
    console.say(f"Wrote {options.output}: surface.vtp, centerline.vtp, prepared.html.")
    return 0


def _image(made: PreparedVessel, console: Console) -> bytes | str:
    """The picture, or why there is none."""
    try:
        return prepared_picture(made, FRAME)
    except DeploymentError as error:
        console.complain(str(error))
        return str(error)


def _write_prepared(
    folder: Path, read: Segmentation, made: PreparedVessel, image: bytes | str
) -> None:
    folder.mkdir()
    surface, line = folder / "surface.vtp", folder / "centerline.vtp"
    write_new_surface(surface, made.surface, made.faces, FRAME, made.voxels)
    write_extracted_lines(line, made.lines, "mm", FRAME)
    if isinstance(image, bytes):
        (folder / "prepared.png").write_bytes(image)
    inputs = {
        "segmentation": {"file": str(read.path), "sha256": _sha256(read.path)},
        "label": {"value": read.segment.value, "name": read.segment.name or None},
    }
    document = prepared_document(made, inputs, {one.name: _sha256(one) for one in (surface, line)})
    (folder / "prepared.json").write_text(document_json(document), encoding="utf-8")
    (folder / "prepared.html").write_text(prepared_page(document, image), encoding="utf-8")


def _sha256(path: Path) -> str:
    return sha256(path.read_bytes()).hexdigest()
