"""A segment that was cut out of a vessel, in documents and words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..files import MeshComplete
from ..segment import Segment
from ..treatment import ExtractedSegment
from ..units import MILLIMETERS, Frame
from .facts import LINES, Fact, Facts
from .words import RESEARCH_USE, document_json

SUMMARY = "segment.json"
SEGMENT_FILES = frozenset({SUMMARY, "before", "after"})
"""What is in the folder of a segment."""

UNITS = "cm"
"""Of lengths in the document, as in the files beside it."""

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
        Which exists and is empty.
    found : ExtractedSegment
    inputs : mapping
        For the document: what it was cut from.
    frames : sequence of "RAS", "LPS" or None
        Of the points before and after.

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
    """What the shell and the panel say of a segment, before and after."""
    closed = [plane.name for plane in found.planes if plane.is_closed]
    said = [f"Closed {len(closed)} of its branches: {'; '.join(closed)}."] if closed else []
    for name, segment in (("Before", found.before), ("After", found.after)):
        if segment is not None:
            said += [f"{name}: {sentence}" for sentence in segment_facts(segment).sentences]
    return said


def segment_facts(segment: Segment) -> Facts:
    """What is known of a segment in one state, with two sentences on it."""
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
