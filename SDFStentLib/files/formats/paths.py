"""Lines of other programs: SimVascular's paths, `.pth`, and Slicer's lists of points, `.fcsv`."""

from __future__ import annotations

import csv
import re
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np

from ...units import Frame, as_frame
from ...validation import InputError, Points, as_patient_points
from ..content import FileContent

_FRAMES = {"0": "RAS", "1": "LPS", "RAS": "RAS", "LPS": "LPS"}
"""Frames by what Slicer writes for them: a number in old lists, a name in new ones."""

_PLACED = {"2", ""}
"""Values of the field `status` of placed points; old lists lack that field."""


class PlainLine(NamedTuple):
    """The only line of a file, in its unit."""

    points: Points
    """(n, 3) points."""
    frame: Frame | None


def decode_pth(content: FileContent) -> PlainLine:
    """The points of a path of SimVascular, at its first time step.

    The file has two top elements, `format` and `path`: it is no XML document, but each of them is.

    Raises
    ------
    InputError
        Not such a file, cut short, without points, or with coordinates that are no numbers.
    """
    name = str(content.path)
    text = re.sub(r"<\?xml.*?\?>", "", content.data.decode("utf-8-sig", "replace"))
    if "<!DOCTYPE" in text or "<!ENTITY" in text:
        raise InputError(f"{name}: expected a path of SimVascular, got XML with a DTD; remove it.")
    try:
        root = ElementTree.fromstring(f"<file>{text}</file>")
    except ElementTree.ParseError as error:
        raise InputError(
            f"{name}: expected a path of SimVascular (XML), it is none or cut short ({error}); "
            "save it again."
        ) from error
    element = root.find(".//path_points")
    element = root.find(".//control_points") if element is None else element
    places = [] if element is None else element.findall(".//pos") or element.findall(".//point")
    try:
        found = [[float(place.attrib[axis]) for axis in "xyz"] for place in places]
    except (KeyError, ValueError) as error:
        raise InputError(
            f"{name}: expected points with numbers as x, y and z, got others ({error}); save the "
            "path again."
        ) from error
    return PlainLine(_several(found, name), None)


def decode_fcsv(content: FileContent) -> PlainLine:
    """The placed points of a point list of Slicer, in their order.

    Raises
    ------
    InputError
        Not such a file, less than two placed points, or coordinates that are no numbers.
    """
    name = str(content.path)
    lines = content.data.decode("utf-8-sig", "replace").splitlines()
    head = dict(re.findall(r"#\s*(\w+)\s*=\s*(.*)", "\n".join(lines)))
    columns = [one.strip() for one in head.get("columns", "").split(",")]
    frame = _FRAMES.get(head.get("CoordinateSystem", "").strip())
    if not {"x", "y", "z"} <= set(columns) or frame is None:
        raise InputError(
            f"{name}: expected a list of points as Slicer writes it, with its columns and "
            "coordinate system, got another file; save it again with Slicer."
        )
    found = []
    for row in csv.reader(line for line in lines if line.strip() and not line.startswith("#")):
        fields = dict(zip([*columns, "status"], row, strict=False))
        if fields.get("status", "").strip() not in _PLACED:
            continue
        try:
            found.append([float(fields[axis]) for axis in "xyz"])
        except (KeyError, ValueError) as error:
            raise InputError(
                f"{name}: expected numbers as x, y and z of every point, got {row!r}; save it "
                "again."
            ) from error
    return PlainLine(_several(found, name), as_frame(frame))


def _several(found: list[list[float]], name: str) -> Points:
    points = as_patient_points(np.reshape(found, (-1, 3)), name)
    if len(points) < 2:
        raise InputError(
            f"{name}: expected a line of two points or more, got {len(points)}; place more."
        )
    return points
