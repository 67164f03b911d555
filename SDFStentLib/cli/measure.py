"""The commands `measure` and `check`."""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..cautions import Caution
from ..certificate import check_surface
from ..files import SurfaceFile, check_same_space, read_surface
from ..geometry import length
from ..measure import DiameterProfile, Lesion, diameter_profile
from ..plan import InputFiles, read_input_files
from ..report import NO_LESION, lesion_section, lesion_sentences, lesions_csv
from ..stent import Stent, stent_axis
from ..units import millimeters_per
from ..validation import InputError, Points, as_number, printable
from .console import Console
from .outputs import Outputs
from .place import check_place, place_of, reference_of, root_of

NOT_SOUND = 3

_PROBE_DIAMETER = 1.0
"""Of the stent that stands for the place to be measured, mm; it only has to be some number."""


@dataclass(frozen=True)
class _Line:
    """A line along which diameters are measured."""

    title: str
    points: Points
    profile: DiameterProfile


def measure_command(options: argparse.Namespace, console: Console) -> int:
    """Print the diameters along a vessel."""
    way = check_place(options, needed=False)
    if way is None and options.centerline is None:
        raise InputError("expected --axis FILE or --centerline FILE, got neither; give one.")
    if way is None and options.length is not None:
        raise InputError("expected a place with --length, such as --center X Y Z, got none.")
    if options.centerline is None and options.csv is not None:
        raise InputError("expected --centerline FILE with --csv, got none; give one.")
    outputs = Outputs([options.surface, options.centerline, options.axis])
    if options.csv is not None:
        outputs.add(options.csv, lambda path: _write_text(path, table))
    spacing = as_number(options.spacing, "--spacing", unit="mm", above=0)
    inputs = read_input_files(
        options.surface,
        options.centerline,
        options.units,
        root_of(options),
        reference=reference_of(options),
    )
    ways, warnings = _ways(options, way, inputs)
    surface = inputs.surface
    lesions = inputs.lesions
    lines = [
        _Line(title, points, diameter_profile(surface.surface, points, spacing))
        for title, points in ways
    ]
    warnings += [gap.labeled(f"{line.title}: ") for line in lines for gap in line.profile.gaps]
    table = lesions_csv(lesions or (), surface.units)
    outputs.write()
    if options.json:
        document = _document(inputs, lesions, lines, warnings)
        print(json.dumps(document, indent=2, allow_nan=False))
        return 0
    console.warn(warnings, thing="part")
    if lesions is not None and inputs.centerline is not None:
        root = inputs.centerline.points[inputs.centerline.roots[0]]
        filed = _point(root / millimeters_per(surface.units))
        print(f"Proximal is the end at {filed} {surface.units}; --root X Y Z names another one.")
        _print_lesions(lesions, surface.units)
    for line in lines:
        _print_table(line, millimeters_per(surface.units), surface.units)
    return 0


def check_command(options: argparse.Namespace, _console: Console) -> int:
    """Say whether a surface is sound; 3 when it is not."""
    surface = read_surface(options.surface, options.units)
    check = check_surface(surface.surface, precision=surface.precision)
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
    tree = inputs.centerline
    if way is None:
        assert tree is not None
        branches = [tree.points[branch] for branch in tree.branches] if options.tables else []
        named = [(f"Branch {n}", points) for n, points in enumerate(branches, start=1)]
        return [(name, points) for name, points in named if length(points) > 0], warnings
    place = place_of(options, way, inputs.surface.frame)
    stent = Stent(
        _PROBE_DIAMETER,
        placement=place.placement,
        length=options.length,
        foreshortening_fraction=0.0,
    )
    axis = stent_axis(stent, tree)
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


def _print_lesions(lesions: Sequence[Lesion], units: str) -> None:
    if not lesions:
        print(NO_LESION)
    for number, lesion in enumerate(lesions, start=1):
        first, second = lesion_sentences(number, lesion, units)
        print(f"{first}\n  {second}")


def _print_table(line: _Line, factor: float, units: str) -> None:
    profile = line.profile
    ends = " to ".join(_point(line.points[end] / factor) for end in (0, -1))
    print(f"{line.title}: {length(line.points):.1f} mm, from {ends} {units}")
    print("  at (mm)  inscribed (mm)  equivalent (mm)")
    for row in zip(
        profile.arc_length, profile.inscribed_diameter, profile.equivalent_diameter, strict=True
    ):
        print(f"{row[0]:9.1f}  {_cell(row[1]):>14}  {_cell(row[2]):>15}")
    if math.isfinite(profile.minimum):
        print(
            f"  inscribed: narrowest {profile.minimum:.2f} mm at {profile.minimum_arc_length:.1f} "
            f"mm, mean {profile.mean:.2f} mm, widest {profile.maximum:.2f} mm"
        )
    print()


def _document(
    inputs: InputFiles,
    lesions: Sequence[Lesion] | None,
    lines: list[_Line],
    warnings: list[Caution],
) -> dict[str, Any]:
    units = inputs.surface.units
    return {
        "schema": "sdfstent-diameters",
        "version": 1,
        **_surface_document(inputs.surface),
        "root_mm": None
        if inputs.centerline is None
        else inputs.centerline.points[inputs.centerline.roots[0]].tolist(),
        "lesions": None
        if lesions is None
        else [lesion_section(n, one, units) for n, one in enumerate(lesions, start=1)],
        "lines": [
            {
                "title": line.title,
                "start_mm": line.points[0].tolist(),
                "end_mm": line.points[-1].tolist(),
                "length_mm": length(line.points),
                "arc_length_mm": line.profile.arc_length.tolist(),
                "inscribed_mm": [_known(value) for value in line.profile.inscribed_diameter],
                "equivalent_mm": [_known(value) for value in line.profile.equivalent_diameter],
                "minimum_mm": _known(line.profile.minimum),
                "mean_mm": _known(line.profile.mean),
                "maximum_mm": _known(line.profile.maximum),
            }
            for line in lines
        ],
        "warnings": [caution.sentence("part") for caution in warnings],
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
        print(printable(f"warning: {sentence}"))


def _point(point: Points) -> str:
    return "(" + ", ".join(f"{value:.4g}" for value in point) + ")"


def _cell(value: float) -> str:
    return f"{value:.2f}" if math.isfinite(value) else "-"


def _known(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
