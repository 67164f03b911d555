"""Facts on surfaces: their files, whether they are sound, the settings by which a result was made
of them, and the change of their triangles."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from ..cautions import Caution
from ..certificate import SurfaceCheck
from ..files import SurfaceFile, read_text, unfinished
from ..geometry import NamedFaces, faces_at
from ..lumen import face_stretches, triangle_sizes
from ..plan import PlanResult, method_parameters
from ..validation import Floats, Indices, InputError
from .facts import LINES, Fact, Facts
from .words import UNKNOWN, number_text, plain_label, plain_text, point_words

SHOWN = 10
"""The most numbers of triangles that are listed in a line."""

_TRIANGLES = {
    "self_intersecting_triangles": "intersect another one",
    "inverted_triangles": "are turned over",
    "flipped_triangles": "are wound against their neighbors",
    "degenerate_triangles": "have no height",
    "sliver_triangles": "have an angle below 1 degree, which is no fault",
}
"""Words for faulty triangles by their keys, in the order of a report."""


def input_facts(result: PlanResult) -> list[Facts]:
    """Facts on every input file: its kind, and its identity."""
    surface, line_file = result.inputs.surface, result.inputs.line_file
    found = [
        Facts(
            (
                *_file("surface", os.fspath(surface.path), surface.sha256),
                _counted("points", len(surface.points)),
                _counted("triangles", surface.surface.made_of),
                *_space(surface.units, surface.frame),
            )
        )
    ]
    if line_file is not None:
        root = result.inputs.vessel.root
        words = UNKNOWN if root is None else point_words(root.tolist(), line_file.units)
        label = "Root, its proximal end (x, y, z)"
        found.append(
            Facts(
                (
                    *_file("centerline", os.fspath(line_file.path), line_file.sha256),
                    _counted("points", len(line_file.points)),
                    _counted("lines", len(line_file.lines)),
                    *_space(line_file.units, line_file.file_frame),
                    Fact("root_mm", label, after=root, words=words),
                )
            )
        )
    axes = [one.axis_file for one in result.plan.stents if one.axis_file is not None]
    return [*found, *(Facts(_file("axis", one.path, one.sha256)) for one in axes)]


def _file(role: str, path: str, sha256: str | None) -> Iterator[Fact]:
    yield Fact("role", after=role)
    yield Fact("file", "File", after=path, words=path)
    yield Fact("sha256", "SHA-256", after=sha256, words=sha256 or UNKNOWN)


def _counted(key: str, count: int) -> Fact:
    return Fact(key, plain_label(key), after=count, words=plain_text("", count))


def _space(units: str, frame: str | None) -> Iterator[Fact]:
    yield Fact("units", "Unit of the file", after=units, words=units)
    yield Fact("frame", "Frame", after=frame, words=frame or "not said by the file")


def setting_facts(result: PlanResult) -> Facts:
    """The parameters of the method, lengths with unit; a function by its name."""
    parameters = method_parameters()
    return Facts(
        _setting(name, parameters[name].unit, value) for name, value in result.plan.method.items()
    )


def _setting(name: str, unit: str, value: Any) -> Fact:
    value = getattr(value, "__name__", "a function") if callable(value) else value
    key = f"{name}_{unit}" if unit else name
    words = "chosen by the rule" if value is None else plain_text(key, value)
    if isinstance(value, float):
        words = f"{value:g}{' mm' if unit == 'mm' else ''}"
    return Fact(key, plain_label(key), after=value, words=words)


def change_facts(result: PlanResult) -> Facts:
    """Facts on what moved, and on the size of its triangles before and after."""
    return Facts(_changes(result))


def _changes(result: PlanResult) -> Iterator[Fact]:
    before, after = result.inputs.surface.surface, result.treatment.surface
    has_moved = np.zeros(len(before.points), dtype=bool)
    has_moved[result.treatment.indices] = True
    faces = np.flatnonzero(faces_at(has_moved, before.triangles))
    for key, label, moved, whole in (
        ("points", "Points", int(has_moved.sum()), len(before.points)),
        ("triangles", "Triangles with a corner", len(faces), len(before.triangles)),
    ):
        words = f"{plain_text('', moved)} of {plain_text('', whole)}"
        yield Fact(f"moved_{key}", f"{label} that moved", after=moved, words=words)
        yield Fact(key, after=whole)
    old, new = (triangle_sizes(one.points, one.triangles[faces]) for one in (before, after))
    for key, name, label, unit, digits in (
        ("edge_length_mm", "edge_length", "Their edges", " mm", 2),
        ("smallest_angle_deg", "smallest_angle", "Their smallest angles", "\N{DEGREE SIGN}", 1),
    ):
        was, is_now = (_spread(getattr(one, name)) for one in (old, new))
        words = f"{_range(was, unit, digits)} before; {_range(is_now, unit, digits)} after"
        yield Fact(f"{key}.{{}}", label, was, is_now, words=words)
    ratio = _spread(face_stretches(before, after, faces).area)
    label = "Their area, after over before"
    yield Fact("area_ratio", label, after=ratio, words=_range(ratio, "", 2))
    parts = _changed_faces(result.inputs.surface.faces, faces)
    words = "" if parts is None else "; ".join(map(_face, parts)) or "none"
    yield Fact("faces", "Face ids of which something moved", after=parts, words=words)


def _changed_faces(parts: NamedFaces | None, moved: Indices) -> list[dict[str, Any]] | None:
    """The parts of the model, by the ids of its file, that have triangles that moved."""
    if parts is None:
        return None
    ids, counts = np.unique(parts.ids[moved], return_counts=True)
    return [
        {
            "id": int(number),
            "name": parts.names.get(int(number)),
            "moved_triangles": int(count),
            "triangles": int((parts.ids == number).sum()),
        }
        for number, count in zip(ids, counts, strict=True)
    ]


def _face(face: Mapping[str, Any]) -> str:
    name = f" ({face['name']})" if face["name"] else ""
    moved, whole = (plain_text("", face[key]) for key in ("moved_triangles", "triangles"))
    return f"{face['id']}{name}: {moved} of {whole} triangles"


def _spread(values: Floats) -> dict[str, float | None]:
    known = values[np.isfinite(values)]
    names = ("smallest", "median", "largest")
    if not len(known):
        return dict.fromkeys(names)
    return dict(zip(names, np.percentile(known, [0, 50, 100]).tolist(), strict=True))


def _range(spread: Mapping[str, float | None], unit: str, digits: int) -> str:
    if spread["median"] is None:
        return UNKNOWN
    low, middle, high = (
        number_text(spread[key], digits) for key in ("smallest", "median", "largest")
    )
    return f"{low} to {high}{unit}, median {middle}{unit}"


def file_facts(surface: SurfaceFile) -> Facts:
    """Facts on a file: its name and hash, and the size of its surface."""
    return Facts(
        (
            Fact("file", after=os.fspath(surface.path)),
            Fact("sha256", after=surface.sha256),
            Fact("points", after=len(surface.points)),
            Fact("triangles", after=surface.surface.made_of),
            Fact("units", after=surface.units),
        )
    )


AS_WRITTEN = "as written"


def check_facts(surface: SurfaceFile, check: SurfaceCheck) -> Facts:
    """Facts on the soundness of a surface, its faults, and whether the files beside it are of one
    run with it."""
    found, verdict = check.as_dict(), check.sentence(surface.units)
    size = (
        f"{len(surface.points)} points, {surface.surface.made_of} triangles, "
        f"{found['components']} connected part(s), {found['boundary_edges']} boundary edges."
    )
    cautions = (*surface.warnings, *check.cautions(), *_cautions_beside(surface))
    warnings = [one.sentence(units=surface.units) for one in cautions]
    faults = [
        Fact(words=_numbered(f"{len(found[key])} triangles {words}", found[key]), level=LINES)
        for key, words in _TRIANGLES.items()
        if found[key]
    ]
    return Facts(
        (
            *file_facts(surface),
            Fact("passed", after=check.passed),
            Fact("sentence", after=verdict, words=verdict, level=LINES),
            *(Fact(key, after=value) for key, value in found.items()),
            Fact(words=size, level=LINES),
            *faults,
            Fact("warnings", after=warnings),
            *(Fact(words=f"warning: {one}", level=LINES) for one in warnings),
        )
    )


def _numbered(words: str, numbers: list[int]) -> str:
    more = ", ..." if len(numbers) > SHOWN else ""
    return f"{words}: {', '.join(map(str, numbers[:SHOWN]))}{more}"


DOCUMENTS = ("sdfstent-report", "sdfstent-comparison")
"""Schemas of documents that have the hashes of the files that were written with them."""


def output_list(files: Mapping[str, str]) -> list[dict[str, str]]:
    """Files as seen from the folder of a document, and their SHA-256."""
    return [{"file": name, "sha256": found} for name, found in files.items()]


def output_facts(path: Path) -> Facts:
    """Facts on the files of a report, or of a comparison: whether they are the written ones.

    Raises
    ------
    InputError
        No such document, or as of `read_text`.
    """
    read_text(path, "a report")
    known = _outputs_of(path)
    if known is None:
        raise InputError(
            f"{path}: expected a report with the hashes of its outputs, got another file; name the "
            "report that was written with them, or a surface."
        )
    states = {name: _state(path.parent / name, found) for name, found in known.items()}
    others = [f"{name} is {state}" for name, state in states.items() if state != AS_WRITTEN]
    which = (
        f"all {len(states)} files are as they were" if len(states) > 1 else "its file is as it was"
    )
    words = f"{path.name}: {which} written with it."
    if others:
        words = (
            f"{path.name}: {'; '.join(others)}: the run was cut off, or something was changed "
            "since; carry it out again."
        )
    warnings = [one.sentence() for one in _cut_off(path)]
    return Facts(
        (
            Fact("file", after=os.fspath(path)),
            Fact("passed", after=not others),
            Fact("sentence", after=words, words=words, level=LINES),
            Fact("outputs", after=[{"file": n, "state": one} for n, one in states.items()]),
            Fact("warnings", after=warnings),
            *(Fact(words=f"warning: {one}", level=LINES) for one in warnings),
        )
    )


def _state(path: Path, known: str) -> str:
    if not path.is_file():
        return "missing"
    return AS_WRITTEN if sha256(path.read_bytes()).hexdigest() == known else "another one"


def _outputs_of(path: Path) -> dict[str, str] | None:
    """The hashes of files in a document, by their names seen from its folder; None without."""
    try:
        with path.open("rb") as file:
            if b"sdfstent-" not in file.read(200):
                return None
        found = json.loads(path.read_text(encoding="utf-8"))
        if found["schema"] in DOCUMENTS and found["outputs"]:
            return {str(one["file"]): str(one["sha256"]) for one in found["outputs"]}
    except (OSError, ValueError, KeyError, TypeError):
        pass
    return None


def _cautions_beside(surface: SurfaceFile) -> Iterator[Caution]:
    """Whether a file is of one run with the reports beside it."""
    path = Path(surface.path)
    yield from _cut_off(path)
    for other in sorted(path.parent.glob("*.json")):
        known = (_outputs_of(other) or {}).get(path.name, surface.sha256)
        if known != surface.sha256:
            yield Caution("of-another-run", {"name": path.name, "report": other.name})


def _cut_off(path: Path) -> Iterator[Caution]:
    if names := unfinished(path.parent):
        yield Caution("cut-off", {"names": ", ".join(names)})
