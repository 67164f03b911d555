"""How a result was made, and what became of the surface's triangles: in documents and words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..geometry import NamedFaces
from ..lumen import triangle_sizes
from ..plan import PlanResult, method_parameters
from ..validation import Floats, Indices
from .words import UNKNOWN, number_text, plain_label, plain_text

_SIZES = (
    ("edge_length_mm", "Their edges", " mm", 2),
    ("smallest_angle_deg", "Their smallest angles", "\N{DEGREE SIGN}", 1),
)


def settings_section(result: PlanResult) -> dict[str, Any]:
    """The parameters of the method, lengths with unit; a function by its name."""
    section: dict[str, Any] = {}
    parameters = method_parameters()
    for name, value in result.plan.method.items():
        unit = f"_{parameters[name].unit}" * bool(parameters[name].unit)
        section[name + unit] = (
            getattr(value, "__name__", "a function") if callable(value) else value
        )
    return section


def change_section(result: PlanResult) -> dict[str, Any]:
    """What moved, and how large its triangles were and are."""
    before, after = result.inputs.surface.surface, result.treatment.surface
    has_moved = np.zeros(len(before.points), dtype=bool)
    has_moved[result.treatment.indices] = True
    faces = np.flatnonzero(has_moved[before.triangles].any(axis=1))
    old, new = (triangle_sizes(one.points, one.triangles[faces]) for one in (before, after))
    return {
        "moved_points": int(has_moved.sum()),
        "points": len(before.points),
        "moved_triangles": len(faces),
        "triangles": len(before.triangles),
        "edge_length_mm": {"before": _spread(old.edge_length), "after": _spread(new.edge_length)},
        "smallest_angle_deg": {
            "before": _spread(old.smallest_angle),
            "after": _spread(new.smallest_angle),
        },
        "area_ratio": _spread(result.treatment.stretch.area[faces]),
        "faces": _changed_faces(result.inputs.surface.faces, faces),
    }


def setting_rows(settings: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Name and value of every parameter."""
    return [(plain_label(key), _setting(key, value)) for key, value in settings.items()]


def change_rows(changes: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Name and value of what became of the surface."""
    rows = [
        (f"{words} that moved", f"{plain_text('', moved)} of {plain_text('', whole)}")
        for words, moved, whole in (
            ("Points", changes["moved_points"], changes["points"]),
            ("Triangles with a corner", changes["moved_triangles"], changes["triangles"]),
        )
    ]
    for key, words, unit, digits in _SIZES:
        old, new = (_range(changes[key][when], unit, digits) for when in ("before", "after"))
        rows.append((words, f"{old} before; {new} after"))
    rows.append(("Their area, after over before", stretch_words(changes)))
    if changes["faces"] is not None:
        told = "; ".join(map(_face, changes["faces"])) or "none"
        rows.append(("Face ids of which something moved", told))
    return rows


def stretch_words(changes: Mapping[str, Any]) -> str:
    """How much larger the triangles are that moved: area after over before."""
    return _range(changes["area_ratio"], "", 2)


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


def _setting(key: str, value: Any) -> str:
    if isinstance(value, float):
        return f"{value:g}{' mm' if key.endswith('_mm') else ''}"
    return "chosen by the rule" if value is None else plain_text(key, value)
