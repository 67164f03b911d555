"""A segment that was cut out of a vessel, in documents and words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..measure import Segment
from ..treatment import ExtractedSegment
from ..units import MILLIMETERS
from .report import RESEARCH_USE

UNITS = "cm"
"""Of lengths in the document, as in the files beside it."""

_SCALE = MILLIMETERS[UNITS]


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
                "origin": (plane.origin / _SCALE).tolist(),
                "normal": plane.normal.tolist(),
                "closed": plane.is_closed,
            }
            for plane in found.planes
        ],
        "before": _section(found.before),
        "after": None if found.after is None else _section(found.after),
    }


def segment_sentences(segment: Segment) -> list[str]:
    """What the shell says of a segment."""
    caps = [face for face in segment.faces if face.kind != "wall"]
    ends = ", ".join(f"{face.name} {face.area / _SCALE**2:.3f} cm2" for face in caps)
    return [
        f"{segment.volume / _SCALE**3:.2f} cm3 of lumen; {ends}.",
        f"{len(segment.surface.points)} points, {len(segment.surface.triangles)} triangles; "
        "watertight, no self-intersection.",
    ]


def _section(segment: Segment) -> dict[str, Any]:
    return {
        "volume": segment.volume / _SCALE**3,
        "points": len(segment.surface.points),
        "triangles": len(segment.surface.triangles),
        "faces": [
            {
                "id": face.number,
                "name": face.name,
                "kind": face.kind,
                "file": f"mesh-surfaces/{face.name}.vtp",
                "area": face.area / _SCALE**2,
                "center": (face.center / _SCALE).tolist(),
                "normal": face.normal.tolist(),
            }
            for face in segment.faces
        ],
    }
