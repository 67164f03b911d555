"""Slicer's markups curves, `.mrk.json`, to polylines and back."""

from __future__ import annotations

import json
from typing import Any, NamedTuple

import numpy as np

from ...geometry import Line
from ...units import Frame, as_frame
from ...validation import InputError, Points, as_patient_points
from ..content import FileContent

POINTS_PER_INTERVAL = 10
"""Number of points of a curve from one control point to the next, as Slicer shows it."""

_CURVES = ("Curve", "Line")
_SCHEMA = (
    "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/Resources/"
    "Schema/markups-schema-v1.0.3.json#"
)


class MarkupsCurves(NamedTuple):
    """The curves of a file, in the unit and frame that it names."""

    curves: list[Points]
    frame: Frame | None
    units: str


def decode_markups(content: FileContent) -> MarkupsCurves:
    """Curves and lines of a markups file as polylines.

    A curve is the cubic spline through its control points with ten points from one to the next
    and no speed at its ends: what Slicer shows after loading the file. Control points that are
    not placed (`positionStatus`) are skipped. Radii among the measurements are not used:
    Slicer's centerline tools may shift them by one point, and the surface has them anyway.

    Raises
    ------
    InputError
        Not such a file, a markup other than an open curve or line, less than two points,
        coordinates that are no numbers, or curves in different frames or units.
    """
    name = str(content.path)
    document = _document(content)
    curves, frames, units = [], set(), set()
    for markup in document["markups"]:
        if not isinstance(markup, dict) or markup.get("type") not in _CURVES:
            kind = markup.get("type") if isinstance(markup, dict) else markup
            raise InputError(f"{name}: expected an open curve or a line, got {kind!r}; draw one.")
        curves.append(_spline(_control_points(markup, name), name))
        frames.add(as_frame(str(markup.get("coordinateSystem", "LPS"))))
        units.add(_unit(markup))
    if len(frames) != 1 or None in frames or len(units) != 1:
        raise InputError(
            f"{name}: expected one coordinate system, RAS or LPS, and one unit for all curves, "
            "got others; save them again with Slicer."
        )
    return MarkupsCurves(curves, frames.pop(), units.pop())


def encode_markups(curves: list[Points], original: bytes) -> bytes:
    """The original file with its curves moved; each has the points of `decode_markups`."""
    document = json.loads(original.decode("utf-8-sig"))
    for markup, curve in zip(document["markups"], curves, strict=True):
        placed = [point for point in markup["controlPoints"] if _is_placed(point)]
        positions = curve if len(curve) == len(placed) else curve[::POINTS_PER_INTERVAL]
        for point, position in zip(placed, positions.tolist(), strict=True):
            point["position"] = position
    return _as_bytes(document)


def new_markups(curve: Points, frame: Frame | None, units: str) -> bytes:
    """A markups file with one curve through some points."""
    points = [
        {"id": str(number), "position": position, "positionStatus": "defined"}
        for number, position in enumerate(curve.tolist(), start=1)
    ]
    markup = {
        "type": "Curve",
        "coordinateSystem": frame or "LPS",
        "coordinateUnits": units,
        "controlPoints": points,
    }
    return _as_bytes({"@schema": _SCHEMA, "markups": [markup]})


def _document(content: FileContent) -> dict[str, Any]:
    name = content.path
    try:
        document = json.loads(content.data.decode("utf-8-sig"))
    except (ValueError, RecursionError) as error:
        raise InputError(
            f"{name}: expected a markups file (JSON), it is none or cut short; save it again."
        ) from error
    markups = document.get("markups") if isinstance(document, dict) else None
    if not isinstance(markups, list) or not markups:
        raise InputError(f"{name}: expected a markups file with a curve, got none; save a curve.")
    return document


def _control_points(markup: dict[str, Any], name: str) -> Points:
    points = markup.get("controlPoints")
    if not isinstance(points, list):
        raise InputError(f"{name}: expected control points in its curve, got none.")
    for number, point in enumerate(points, start=1):
        if not isinstance(point, dict) or (_is_placed(point) and not _is_place(point)):
            raise InputError(
                f"{name}: expected control points with a position of three numbers, the one of "
                f"number {number} is none; save the curve again."
            )
    positions = [point["position"] for point in points if _is_placed(point)]
    control_points = as_patient_points(positions, name)
    if len(control_points) < 2:
        raise InputError(
            f"{name}: expected a curve of at least two control points, got {len(control_points)}; "
            "place more."
        )
    return control_points


def _is_place(point: dict[str, Any]) -> bool:
    position = point.get("position")
    return (
        isinstance(position, list)
        and len(position) == 3
        and all(
            isinstance(value, int | float) and not isinstance(value, bool) for value in position
        )
    )


def _is_placed(point: Any) -> bool:
    """Whether a point was placed; positions of others are empty texts, or outdated ones."""
    if not isinstance(point, dict) or point.get("position") in ("", None, []):
        return False
    return bool(point.get("positionStatus", "defined") == "defined")


def _unit(markup: dict[str, Any]) -> str:
    """The unit as a word; a coded entry has it first: `["mm", "UCUM", "millimeter"]`."""
    unit = markup.get("coordinateUnits", "mm")
    return str(unit[0] if isinstance(unit, list) and unit else unit)


def _spline(control_points: Points, name: str) -> Points:
    if len(Line(control_points).without_repeats()) < 2:
        raise InputError(f"{name}: expected a curve, got one place only; place more points.")
    if len(control_points) == 2:
        return control_points
    # Imported here: scipy takes longer to import than most files take to read.
    from scipy.interpolate import CubicSpline

    count = len(control_points)
    positions = np.linspace(0, count - 1, POINTS_PER_INTERVAL * (count - 1) + 1)
    curve = CubicSpline(np.arange(count), control_points, bc_type="clamped")(positions)
    curve[::POINTS_PER_INTERVAL] = control_points
    return curve


def _as_bytes(document: dict[str, Any]) -> bytes:
    try:
        return (json.dumps(document, indent=2, ensure_ascii=False) + "\n").encode()
    except UnicodeEncodeError:  # a label holds half of a character; escaped, it comes back
        return (json.dumps(document, indent=2) + "\n").encode()
