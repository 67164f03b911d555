"""The commands `measure` and `check`."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from ..cautions import Caution
from ..files import check_same_space
from ..plan import InputFiles, read_input_files
from ..report import (
    Facts,
    MeasuredLine,
    check_facts,
    diameter_table,
    document_json,
    file_facts,
    filed_point,
    lesion_facts,
    lesion_lines,
    lesions_by_size,
    lesions_csv,
    line_facts,
    output_facts,
    voxel_facts,
)
from ..scan import voxel_range
from ..stent import Stent, stent_axis
from ..validation import InputError, as_number, one_line
from ..vessel import SMALL_VESSEL
from .console import Console
from .outputs import Outputs
from .place import check_place, half_voxel_of, inputs_of, place_of

NOT_SOUND = 3

LINES = 8
"""Lines about a vessel on the screen, apart from requested tables, unless all of it
is asked for."""

HOW = (
    "; --smallest-vessel 0 lists them",
    "--verbose tells more, and what each is measured against; --json and --csv F have them all.",
)
"""Options that list lesions in small vessels, and all."""

_PROBE_DIAMETER = 1.0
"""Diameter of the stent by which the place is measured, mm; any number will do."""


def measure_command(options: argparse.Namespace, console: Console) -> int:
    """Print the diameters along a vessel."""
    way = check_place(options, needed=False)
    if way is None and options.centerline is None:
        raise InputError("expected --axis FILE or --centerline FILE, got neither; give one.")
    if way is None and options.length is not None:
        raise InputError(
            "expected a place with --length, such as --center X Y Z, got none; add it."
        )
    if options.centerline is None and options.csv is not None:
        raise InputError("expected --centerline FILE with --csv, got none; give one.")
    outputs = Outputs([options.surface, options.centerline, options.axis, options.names])
    if options.csv is not None:
        outputs.add(options.csv, lambda path: _write_lesions(path, inputs))
    spacing = as_number(options.spacing, "--spacing", unit="mm", above=0)
    smallest = SMALL_VESSEL if options.smallest_vessel is None else options.smallest_vessel
    smallest = as_number(smallest, "--smallest-vessel", unit="mm", minimum=0)
    inputs = inputs_of(options)
    lines, warnings = _lines(options, way, inputs, spacing)
    vessel, units = inputs.vessel, inputs.surface.units
    half = half_voxel_of(options, inputs)
    voxels = None if half is None else voxel_facts(voxel_range(vessel, half))
    warnings += [gap.labeled(f"{line.title}: ") for line in lines for gap in line.profile.gaps]
    outputs.write()
    if options.json:
        document = _document(inputs, lines, warnings, smallest)
        if voxels:
            document["voxel_range"] = voxels
        print(document_json(document), end="")
        return 0
    said: list[str] = []
    if vessel.lesions is not None and vessel.root is not None:
        filed = filed_point(vessel.root, units)
        said.append(f"Proximal is the end at {filed} {units}; --root X Y Z names another one.")
        most = None if options.verbose else LINES
        said += lesion_lines(vessel.lesions, units, smallest, HOW, most)
        said += voxels.sentences if voxels else []
    console.warn_shortly(warnings, max(LINES - len(said), 1), units, thing="part")
    print("\n".join(said), end="\n" if said else "")
    for line in lines:
        print(diameter_table(line_facts(line, units)))
    return 0


def check_command(options: argparse.Namespace, _console: Console) -> int:
    """Report whether a surface is sound, or a report fits its files; return 3 if not."""
    if options.surface.lower().endswith(".json"):
        facts = output_facts(Path(options.surface))
    else:
        facts = _surface_checked(options)
    if options.json:
        print(document_json(facts.as_dict()), end="")
    elif not options.quiet:
        print(*map(one_line, facts.sentences), sep="\n")
    return 0 if facts.value("passed") else NOT_SOUND


def _surface_checked(options: argparse.Namespace) -> Facts:
    inputs = read_input_files(options.surface, units=options.units)
    check = inputs.vessel.check(inputs.surface.precision)
    return check_facts(inputs.surface, check)


def _lines(
    options: argparse.Namespace, way: str | None, inputs: InputFiles, spacing: float
) -> tuple[list[MeasuredLine], list[Caution]]:
    """The requested lines, measured, and warnings."""
    vessel, warnings = inputs.vessel, list(inputs.warnings)
    if way is None:
        warnings += vessel.lesion_cautions
        if not options.tables:
            return [], warnings
        names = [name[:1].upper() + name[1:] for name in vessel.branch_names]
        return [
            MeasuredLine(names[number - 1], line, vessel.diameters(line, spacing))
            for number, line in vessel.branches.items()
        ], warnings
    place = place_of(options, way, inputs)
    stent = Stent(
        _PROBE_DIAMETER,
        placement=place.placement,
        length=options.length,
        foreshortening_fraction=0.0,
        may_be_shortened=True,
    )
    axis = stent_axis(stent, vessel.centerline)
    if way == "axis":
        surface = inputs.surface
        warnings += check_same_space(
            surface.surface,
            axis.points,
            surface_name=str(surface.path),
            centerline_name=options.axis,
        )
    # Cautions about a stent hold for a part to measure, too, except that about a tight bend.
    found = [caution for caution in axis.warnings if caution.kind != "tight-bend"]
    part = MeasuredLine("Part", axis.line, vessel.diameters(axis.line, spacing))
    return [part], [*warnings, *place.warnings, *found]


def _write_lesions(path: Path, inputs: InputFiles) -> None:
    table = lesions_csv(inputs.vessel.lesions or (), inputs.surface.units)
    path.write_text(table, encoding="utf-8")


def _document(
    inputs: InputFiles, lines: list[MeasuredLine], warnings: list[Caution], smallest: float
) -> dict[str, Any]:
    units, vessel = inputs.surface.units, inputs.vessel
    large, small = lesions_by_size(vessel.lesions or (), smallest)

    def sections(numbers: list[int]) -> list[Facts] | None:
        if vessel.lesions is None:
            return None
        return [lesion_facts(n, vessel.lesions[n - 1], units) for n in numbers]

    return {
        "schema": "sdfstent-diameters",
        "version": 1,
        **file_facts(inputs.surface).as_dict(),
        "root_mm": vessel.root,
        "lesions": sections(large),
        "smallest_vessel_mm": smallest,
        "lesions_of_small_vessels": sections(small),
        "lines": [line_facts(line, units) for line in lines],
        "warnings": [caution.sentence("part", units=units) for caution in warnings],
    }
