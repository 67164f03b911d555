"""Vessels that were made, in documents and words: segments, and vessels from segmentations with the
exactness of their numbers."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from datetime import datetime, timezone
from functools import partial
from pathlib import Path
from typing import Any

from ..files import MeshComplete
from ..geometry import Line, signed_volume
from ..scan import PreparedVessel, Ranged, Span, VoxelRange
from ..segment import Segment
from ..treatment import ExtractedSegment
from ..units import MILLIMETERS, Frame
from ..validation import coordinates, plain
from ..version import VERSION
from .facts import LINES, Fact, Facts, listed
from .html import file_part
from .markup import beginning, heading, page, paragraph, picture, table
from .words import (
    RESEARCH_USE,
    UNKNOWN,
    degree_word,
    document_json,
    millimeters,
    number_text,
)

SUMMARY = "segment.json"
SEGMENT_FILES = frozenset({SUMMARY, "before", "after"})
"""Names of the files and folders of a segment."""

UNITS = "cm"
"""The unit of lengths in the document, as in the files beside it."""

_SCALE = MILLIMETERS[UNITS]


def write_segment(
    folder: Path,
    found: ExtractedSegment,
    inputs: Mapping[str, Any],
    frames: Sequence[Frame | None] = (None, None),
) -> None:
    """Write a segment, before and after, as flow solvers read it, and its document.

    Parameters
    ----------
    folder : Path
        Existing, empty folder.
    found : ExtractedSegment
    inputs : mapping
        For the document: what it was cut from.
    frames : sequence of "RAS", "LPS" or None
        Patient frames of the points before and after.

    Raises
    ------
    OSError
        A file that cannot be written.
    """
    states = (("before", found.before), ("after", found.after))
    for (name, segment), frame in zip(states, frames, strict=False):
        if segment is not None:
            faces = segment.named_faces
            MeshComplete(segment.surface, faces, segment.walls, frame).write(folder / name)
    text = document_json(segment_document(found, inputs))
    (folder / SUMMARY).write_text(text, encoding="utf-8")


def segment_document(found: ExtractedSegment, inputs: Mapping[str, Any]) -> dict[str, Any]:
    """The planes and the faces of a segment, for a program that prescribes flow at them."""
    return {
        "schema": "sdfstent-segment",
        "version": 1,
        "notice": RESEARCH_USE,
        "units": UNITS,
        "inputs": dict(inputs),
        "planes": [
            {
                "branch": plane.name,
                "origin": plane.origin / _SCALE,
                "normal": plane.normal,
                "closed": plane.is_closed,
            }
            for plane in found.planes
        ],
        "before": segment_facts(found.before),
        "after": found.after and segment_facts(found.after),
    }


def segment_sentences(found: ExtractedSegment) -> list[str]:
    """Sentences of shell and panel on a segment, before and after."""
    closed = [plane.name for plane in found.planes if plane.is_closed]
    said = [f"Closed {len(closed)} of its branches: {'; '.join(closed)}."] if closed else []
    for name, segment in (("Before", found.before), ("After", found.after)):
        if segment is not None:
            said += [f"{name}: {sentence}" for sentence in segment_facts(segment).sentences]
    return said


def segment_facts(segment: Segment) -> Facts:
    """Facts on a segment in one state, with two sentences on it."""
    caps = [face for face in segment.faces if face.kind != "wall"]
    ends = ", ".join(f"{face.name} {face.area / _SCALE**2:.3f} cm2" for face in caps)
    volume = segment.volume / _SCALE**3
    points, triangles = len(segment.surface.points), len(segment.surface.triangles)
    sound = f"{points} points, {triangles} triangles; watertight, no self-intersection."
    faces = [
        {
            "id": face.number,
            "name": face.name,
            "kind": face.kind,
            "file": f"mesh-surfaces/{face.name}.vtp",
            "area": face.area / _SCALE**2,
            "center": face.center / _SCALE,
            "normal": face.normal,
        }
        for face in segment.faces
    ]
    return Facts(
        (
            Fact("volume", after=volume),
            Fact("points", after=points),
            Fact("triangles", after=triangles),
            Fact("faces", after=faces),
            Fact(words=f"{volume:.2f} cm3 of lumen; {ends}.", level=LINES),
            Fact(words=sound, level=LINES),
        )
    )


PREPARED_FILES = frozenset(
    {"surface.vtp", "centerline.vtp", "prepared.png", "prepared.json", "prepared.html"}
)
"""Names of the files of a prepared vessel."""

STEPS = (
    "The largest part of the label was kept, hollows in it filled.",
    "Its wall is where a distance from the border of the voxels is zero, smoothed by half of the "
    "vessel's radius beside it.",
    "Ends were found by how far the lumen reaches, and cut flat across its line; where the image "
    "ends, along its border.",
    "Lines are those of the largest spheres from the inlet to every other end.",
)


def prepared_document(
    made: PreparedVessel, inputs: Mapping[str, Any], outputs: Mapping[str, str]
) -> dict[str, Any]:
    """Document of a prepared vessel, for a program.

    Parameters
    ----------
    made : PreparedVessel
    inputs : mapping
        The file, and the label in it.
    outputs : mapping of str to str
        SHA-256 of the files written beside the document.
    """
    return {
        "schema": "sdfstent-prepared",
        "version": 1,
        "sdfstent_version": VERSION,
        "created": datetime.now(timezone.utc).isoformat(timespec="seconds"),
        "notice": RESEARCH_USE,
        "units": "mm",
        "frame": "LPS",
        "inputs": dict(inputs),
        "outputs": dict(outputs),
        "steps": list(STEPS),
        **_prepared_facts(made).as_dict(),
        "sentences": prepared_sentences(made),
        "warnings": [one.sentence() for one in made.warnings],
    }


def prepared_sentences(made: PreparedVessel) -> list[str]:
    """Sentences of the shell on a prepared vessel."""
    return list(_prepared_facts(made).sentences)


def prepared_page(document: Mapping[str, Any], image: bytes | str) -> str:
    """The page made from such a document; `image` is a PNG, or why there is none."""
    title = "Vessel from a segmentation"
    head = ("end", "face", "diameter", "center, mm (LPS)", "")
    rows = [
        (
            end["name"],
            str(end["face"]),
            millimeters(end["diameter_mm"]),
            coordinates(end["center_mm"]),
            "the image ends here" if end["is_at_border"] else "",
        )
        for end in document["ends"]
    ]
    shown = picture(image, title) if isinstance(image, bytes) else paragraph(image, "small")
    named = document["inputs"]
    label = named["label"]
    files = {
        "segmentation": named["segmentation"]["file"],
        "label": f"{label['value']} {label['name'] or ''}".strip(),
        **{name: "written beside this page" for name in document["outputs"]},
    }
    parts = [
        *beginning(title, document, named["segmentation"]["file"].split("/")[-1]),
        *(paragraph(one, "warn") for one in document["warnings"]),
        *map(paragraph, document["sentences"]),
        shown,
        heading("Ends"),
        table(rows, head, ("", "n", "n", "n", "")),
        heading("What was done"),
        *(paragraph(step, "small") for step in document["steps"]),
        *file_part(files),
    ]
    return page(title, parts)


def _prepared_facts(made: PreparedVessel) -> Facts:
    sides = [plain(side, ".3g") for side in made.voxels.tolist()]
    size = f"{sides[0]} mm" if len(set(sides)) == 1 else f"{' x '.join(sides)} mm"
    error = made.diameter_error
    count, triangles = len(made.ends), len(made.surface.triangles)
    volume = signed_volume(made.surface.points, made.surface.triangles) / 1000
    ends = [
        {
            "name": end.name,
            "face": end.number,
            "diameter_mm": end.diameter,
            "center_mm": end.center,
            "is_at_border": end.is_at_border,
        }
        for end in made.ends
    ]
    length = sum(Line(made.lines.points[line]).length for line in made.lines.lines[:1])
    return Facts(
        (
            Fact("voxel_spacing_mm", after=made.voxels),
            Fact("diameter_error_mm", after=error),
            Fact("volume_cm3", after=volume),
            Fact("triangles", after=triangles),
            Fact("first_line_mm", after=length),
            Fact("ends", after=ends),
            Fact(
                words=f"Voxels of {size}: diameters +-{error:.2g} mm on the average, and more in "
                "vessels less than 6 voxels wide.",
                level=LINES,
            ),
            Fact(
                words=f"Inlet of {millimeters(made.ends[0].diameter)} at "
                f"{coordinates(made.ends[0].center)} mm (LPS), {count - 1} "
                f"outlet{'s' * (count != 2)}.",
                level=LINES,
            ),
            Fact(
                words=f"{volume:.3g} cm3 of lumen, {triangles} triangles; closed, no "
                "self-intersection.",
                level=LINES,
            ),
        )
    )


KINDS: tuple[tuple[str, str, str, Callable[[float], str]], ...] = (
    ("minimum_diameters_mm", "minimum diameter", " mm", partial(number_text, digits=2)),
    ("diameter_stenoses_percent", "stenosis by diameter", "", degree_word),
    ("minimum_lumens_mm", "narrowest lumen", " mm", partial(number_text, digits=2)),
    ("pressure_drops_mmhg", "recovered pressure drop", " mmHg", partial(number_text, digits=1)),
)
"""Key, words, the unit behind them, and the word for a number of the quantities with a range, as
`VoxelRange` has them."""


def voxel_facts(found: VoxelRange) -> Facts:
    """Ranges as a document has them, and a sentence for each kind."""
    where = f"With the wall half a voxel ({number_text(found.half, 2)} mm) in or out"
    told = [
        f"{where}, {words}: {_told(ranges, unit, word)}."
        for (_, words, unit, word), ranges in zip(KINDS, found[1:], strict=True)
        if ranges
    ]
    return Facts(
        (
            Fact("half_voxel_mm", after=found.half),
            *(
                Fact(key, after=_ranges(ranges))
                for (key, *_), ranges in zip(KINDS, found[1:], strict=True)
            ),
            Fact("sentences", after=told),
            *(Fact(words=sentence, level=LINES) for sentence in told),
        )
    )


def _ranges(ranges: Sequence[Ranged]) -> list[dict[str, Any]]:
    return [
        {"name": one.name, "before": list(one.before), "after": one.after and list(one.after)}
        for one in ranges
    ]


def _told(ranges: Sequence[Ranged], unit: str, word: Callable[[float], str]) -> str:
    if all(math.isnan(one.before[0]) for one in ranges):
        return f"{UNKNOWN}, as that closes a vessel"
    return listed([_words(one, unit, word) for one in ranges], "; ")


def _words(one: Ranged, unit: str, word: Callable[[float], str]) -> str:
    states = [_span(state, word) for state in (one.before, one.after) if state is not None]
    return f"{one.name} {' -> '.join(states)}" + unit * (states[-1] != UNKNOWN)


def _span(state: Span, word: Callable[[float], str]) -> str:
    if math.isnan(state[0]):
        return UNKNOWN
    return " to ".join(dict.fromkeys(map(word, state)))
