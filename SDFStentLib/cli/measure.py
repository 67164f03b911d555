"""The commands `measure` and `check`."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from ..cautions import Caution
from ..files import SurfaceFile, check_same_space
from ..plan import InputFiles, read_input_files
from ..report import (
    MeasuredLine,
    diameter_section,
    diameter_table,
    filed_point,
    lesion_list,
    lesion_section,
    lesions_csv,
)
from ..stent import Stent, stent_axis
from ..validation import InputError, Points, as_number, one_line
from .console import Console
from .outputs import Outputs
from .place import check_place, inputs_of, place_of

NOT_SOUND = 3

_PROBE_DIAMETER = 1.0
"""Of the stent that stands for the place to be measured, mm; it only has to be some number."""


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
    outputs = Outputs([options.surface, options.centerline, options.axis])
    if options.csv is not None:
        outputs.add(options.csv, lambda path: _write_text(path, table))
    spacing = as_number(options.spacing, "--spacing", unit="mm", above=0)
    inputs = inputs_of(options)
    ways, warnings = _ways(options, way, inputs)
    vessel, units = inputs.vessel, inputs.surface.units
    lines = [
        MeasuredLine(title, points, vessel.diameters(points, spacing)) for title, points in ways
    ]
    warnings += [gap.labeled(f"{line.title}: ") for line in lines for gap in line.profile.gaps]
    table = lesions_csv(vessel.lesions or (), units)
    outputs.write()
    if options.json:
        document = _document(inputs, lines, warnings)
        print(json.dumps(document, indent=2, allow_nan=False))
        return 0
    console.warn(warnings, thing="part", units=units)
    if vessel.lesions is not None and vessel.root is not None:
        filed = filed_point(vessel.root, units)
        print(f"Proximal is the end at {filed} {units}; --root X Y Z names another one.")
        print("\n".join(lesion_list(vessel.lesions, units)))
    for line in lines:
        print(diameter_table(line, units))
    return 0


def check_command(options: argparse.Namespace, _console: Console) -> int:
    """Say whether a surface is sound; 3 when it is not."""
    inputs = read_input_files(options.surface, units=options.units)
    surface = inputs.surface
    check = inputs.vessel.check(surface.precision)
    document = {
        **_surface_document(surface),
        "passed": check.passed,
        "sentence": check.sentence(),
        **check.as_dict(),
        "warnings": [caution.sentence() for caution in surface.warnings],
    }
    if options.json:
        print(json.dumps(document, indent=2, allow_nan=False))
    elif not options.quiet:
        _print_check(document)
    return 0 if check.passed else NOT_SOUND


def _ways(
    options: argparse.Namespace, way: str | None, inputs: InputFiles
) -> tuple[list[tuple[str, Points]], list[Caution]]:
    """The lines to be measured with their titles, and warnings."""
    warnings = list(inputs.warnings)
    if way is None:
        branches = inputs.vessel.branches if options.tables else {}
        names = inputs.vessel.branch_names
        titles = {n: names[n - 1][:1].upper() + names[n - 1][1:] for n in branches}
        return [(titles[n], line) for n, line in branches.items()], warnings
    place = place_of(options, way, inputs.surface.frame)
    stent = Stent(
        _PROBE_DIAMETER,
        placement=place.placement,
        length=options.length,
        foreshortening_fraction=0.0,
    )
    axis = stent_axis(stent, inputs.vessel.centerline)
    if way == "axis":
        surface = inputs.surface
        warnings += check_same_space(
            surface.surface,
            axis.points,
            surface_name=str(surface.path),
            centerline_name=options.axis,
        )
    # Of what is said about a stent, the junctions and the length hold for a part to measure.
    told = [caution for caution in axis.warnings if caution.kind != "tight-bend"]
    return [("Part", axis.points)], [*warnings, *place.warnings, *told]


def _write_text(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8")


def _document(
    inputs: InputFiles, lines: list[MeasuredLine], warnings: list[Caution]
) -> dict[str, Any]:
    units, vessel = inputs.surface.units, inputs.vessel
    return {
        "schema": "sdfstent-diameters",
        "version": 1,
        **_surface_document(inputs.surface),
        "root_mm": None if vessel.root is None else vessel.root.tolist(),
        "lesions": None
        if vessel.lesions is None
        else [lesion_section(n, one, units) for n, one in enumerate(vessel.lesions, start=1)],
        "lines": [diameter_section(line) for line in lines],
        "warnings": [caution.sentence("part", units=units) for caution in warnings],
    }


def _surface_document(surface: SurfaceFile) -> dict[str, Any]:
    return {
        "file": str(surface.path),
        "sha256": surface.sha256,
        "points": len(surface.points),
        "triangles": len(surface.triangles),
        "units": surface.units,
    }


def _print_check(document: dict[str, Any]) -> None:
    print(document["sentence"])
    print(
        f"{document['points']} points, {document['triangles']} triangles, "
        f"{document['components']} connected part(s), {document['boundary_edges']} boundary edges."
    )
    for key, words in (
        ("self_intersecting_triangles", "intersect another one"),
        ("inverted_triangles", "are turned over"),
        ("flipped_triangles", "are wound against their neighbors"),
        ("degenerate_triangles", "have no area"),
        ("sliver_triangles", "have an angle below 1 degree"),
    ):
        if document[key]:
            shown = ", ".join(map(str, document[key][:10]))
            more = ", ..." if len(document[key]) > 10 else ""
            print(f"{len(document[key])} triangles {words}: {shown}{more}")
    for sentence in document["warnings"]:
        print(one_line(f"warning: {sentence}"))
