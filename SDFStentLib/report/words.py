"""What a report's fields are called and how their values read; plain text, nothing escaped."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from ..units import MILLIMETERS

UNKNOWN = "not known"

_PLACEMENTS = {
    "AtCenter": "by its middle",
    "AtDistalEnd": "by its distal end",
    "AtProximalEnd": "by its proximal end",
    "BetweenPoints": "between two points on the centerline",
    "AlongAxis": "along a given curve",
    "OfStent": "where the earlier one lies",
}

DIAMETERS = {
    "balloon_diameter_mm": "Balloon diameter",
    "lumen_diameter_mm": "Prescribed lumen diameter",
    "reference_diameter_mm": "Reference diameter of the lesion",
}
"""The three of a stent, as its section has them."""

_INPUT_WORDS = {
    "file": "File",
    "sha256": "SHA-256",
    "points": "Points",
    "triangles": "Triangles",
    "lines": "Lines",
    "units": "Unit of the file",
    "frame": "Frame",
    "root_mm": "Root, its proximal end (x, y, z)",
}

_TOLD_ELSEWHERE = ("pressure", "number", "name", "diameters", "lesions", "dilated_again_as")
"""Of a stent: in its heading, and in the tables before."""


def stent_titles(stents: Sequence[Mapping[str, Any]]) -> list[str]:
    """Such as "Stent 1 of 2: main"; one stent alone has no number.

    Stents of the plan that are switched off are not in a report: the numbers are then those of
    the plan, as in the warnings.
    """
    places = range(1, len(stents) + 1)
    numbers = [stent.get("number", place) for place, stent in zip(places, stents, strict=True)]
    if numbers != list(places):
        titles = [f"Stent {number} of the plan" for number in numbers]
    elif len(stents) > 1:
        titles = [f"Stent {number} of {len(stents)}" for number in numbers]
    else:
        titles = ["Stent"] * len(stents)
    return [
        f"{title}: {stent['name']}" if stent.get("name") else title
        for title, stent in zip(titles, stents, strict=True)
    ]


def stent_words(stent: Mapping[str, Any]) -> str:
    """Size and placement in one sentence; empty where neither is told."""
    sizes = [stent.get("lumen_diameter_mm"), stent.get("deployed_length_mm")]
    size = " x ".join(millimeters(value, 1) for value in sizes if value is not None)
    size += _packed_words(stent)
    way = str(stent.get("placement", ""))
    said = [size and f"Stent of {size}", way and f"placed {_PLACEMENTS.get(way, way)}"]
    if "dilated_again_as" in stent:
        said.append(f"dilated again as stent {stent['dilated_again_as']}")
    words = ", ".join(part for part in said if part)
    return words and f"{words[0].upper()}{words[1:]}."


def _packed_words(stent: Mapping[str, Any]) -> str:
    """How long it was before it shortened, and why it did; empty where it did not."""
    share, nominal = stent.get("foreshortening_fraction"), stent.get("nominal_length_mm")
    if not share or nominal is None:
        return ""
    reason = stent.get("foreshortening_reason")
    change = f"{number_text(100 * abs(share), 0)} % {'shorter' if share > 0 else 'longer'}"
    said = f" (packed {millimeters(nominal, 1)}, {change} once expanded"
    return f"{said}: {reason})" if reason else f"{said})"


def stent_rows(stent: Mapping[str, Any], surface: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Name and value of everything about a stent but its diameters.

    Points are in the frame and the unit of the surface's file, an entry of the inputs.
    """
    told = {key: value for key, value in stent.items() if key not in _TOLD_ELSEWHERE}
    axis = dict(told.pop("axis", {}))
    rows = [*_device_rows(told.pop("device", None)), *_balloon_rows(told)]
    rows += shape_rows(told.pop("shape", None))
    for key, words in (
        ("nominal_length_mm", "Nominal length"),
        ("deployed_length_mm", "Deployed length along the axis"),
    ):
        if key in told:
            rows.append((words, millimeters(told.pop(key), 1)))
    if "foreshortening_fraction" in told:
        share, reason = told.pop("foreshortening_fraction"), told.pop("foreshortening_reason", None)
        text = UNKNOWN if share is None else f"{number_text(100 * share, 0)} % of nominal length"
        text += f", {reason}" if reason else ""
        rows.append(("Foreshortening on expansion", text))
    if "placement" in told:
        name = str(told.pop("placement"))
        rows.append(("Placed", _PLACEMENTS.get(name, name)))
    moved = told.pop("moved_points", None)
    rows += _axis_rows(axis, stent, surface)
    if moved is not None:
        rows.append(("Surface points that it moved", plain_text("", moved)))
    return rows + [(plain_label(key), plain_text(key, value)) for key, value in _flat(told)]


def input_rows(entry: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Name and value of everything about an input file but its role."""
    rows = []
    for key, value in _flat({key: value for key, value in entry.items() if key != "role"}):
        text = plain_text(key, value)
        if key == "root_mm" and value is not None:
            text = point_words(value, entry.get("units", "mm"))
        if key == "frame" and value is None:
            text = "not said by the file"
        rows.append((_INPUT_WORDS.get(key, plain_label(key)), text))
    return rows


def plain_label(key: str) -> str:
    """A field's name without unit and underscores."""
    for suffix in ("_mm2", "_mm", "_s"):
        key = key.removesuffix(suffix)
    words = key.replace("_", " ")
    return words[:1].upper() + words[1:]


def plain_text(key: str, value: Any) -> str:
    """A value with the unit that its key names."""
    unit = " mm" if key.endswith("_mm") else ""
    if value is None:
        return UNKNOWN
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return number_text(value, 2) + unit
    if isinstance(value, int):
        return f"{value:,}".replace(",", "\N{THIN SPACE}") + unit
    if isinstance(value, Sequence) and not isinstance(value, str):
        return ", ".join(plain_text("", item) for item in value) + unit
    return str(value)


def number_text(value: float | None, digits: int) -> str:
    """A number with a true minus sign, which zero has not, or that it is not known."""
    if value is None:
        return UNKNOWN
    return f"{_rounded(value, digits):.{digits}f}".replace("-", "\N{MINUS SIGN}")


def millimeters(value: float | None, digits: int = 2, *, signed: bool = False) -> str:
    """A length with its unit."""
    if value is None:
        return UNKNOWN
    sign = "+" if signed and _rounded(value, digits) > 0 else ""
    return f"{sign}{number_text(value, digits)} mm"


def degree_text(percent: float | None, sizes: str = "") -> str:
    """Percent stenosis in words, below 0 there is none; what it follows from stands in brackets."""
    degree, above = UNKNOWN, ""
    if percent is not None and math.isfinite(percent):
        degree = f"{max(percent, 0.0):.0f} %"
        if round(percent) < 0:
            degree, above = "none", f"{-percent:.0f} % above reference"
    details = ", ".join(part for part in (above, sizes) if part)
    return f"{degree} ({details})" if details else degree


def _rounded(value: float, digits: int) -> float:
    return round(value, digits) + 0.0  # no negative zero


def point_text(position: Sequence[float | None]) -> str:
    """Coordinates to a tenth."""
    return ", ".join(number_text(value, 1) for value in position)


def point_words(position_mm: Sequence[float | None], units: str) -> str:
    """Coordinates in mm and, where that is another one, in the unit of the file."""
    text = f"{point_text(position_mm)} mm"
    if units == "mm":
        return text
    factor = MILLIMETERS[units]
    digits = 1 + round(math.log10(factor))
    stored = (None if value is None else value / factor for value in position_mm)
    filed = ", ".join(number_text(value, digits) for value in stored)
    return f"{text}; in the file {filed} {units}"


def _device_rows(device: Mapping[str, Any] | None) -> list[tuple[str, str]]:
    """Which device it is and where its numbers are from; nothing where none was named."""
    if device is None:
        return []
    rows = [("Device", device_words(device))]
    if device.get("source"):
        date = f" ({device['source_date']})" if device.get("source_date") else ""
        state = "verified" if device.get("verified") else "unverified"
        rows.append(("Source of its numbers", f"{device['source']}{date}; {state}"))
    if device.get("note"):
        rows.append(("About it", str(device["note"])))
    return rows


def device_words(device: Mapping[str, Any]) -> str:
    """Its name, and whose it is."""
    names = (device.get("manufacturer"), device.get("family"))
    who = " ".join(str(name) for name in names if name)
    return f"{device['name']} ({who})" if who else str(device["name"])


def _balloon_rows(told: dict[str, Any]) -> list[tuple[str, str]]:
    """Name and value of balloon, lumen and reference; takes them out of a stent's fields."""
    rows = []
    if "redilates" in told:
        rows.append(("Redilation", f"of stent {told.pop('redilates')}"))
    balloon, share = told.pop("balloon_diameter_mm", None), told.pop("recoil_fraction", None)
    reason = told.pop("recoil_reason", None)
    if balloon is not None:
        rows.append((DIAMETERS["balloon_diameter_mm"], millimeters(balloon)))
    if share is not None:
        rows.append(("Recoil", f"{100 * share:g} % of the balloon: {reason}"))
    if "lumen_diameter_mm" in told:
        digits = 1 if balloon is None else 2
        lumen = millimeters(told.pop("lumen_diameter_mm"), digits)
        rows.append((DIAMETERS["lumen_diameter_mm"], lumen))
    if "reference_diameter_mm" in told:
        reference = told.pop("reference_diameter_mm")
        if reference is not None:
            rows.append((DIAMETERS["reference_diameter_mm"], millimeters(reference)))
    for key, words in (
        ("stent_to_adjacent", "Lumen : healthy vessel where it is narrowest"),
        ("stent_to_proximal", "Lumen : healthy vessel at the proximal end"),
        ("stent_to_distal", "Lumen : healthy vessel at the distal end"),
        ("balloon_to_stenosis", "Balloon : stenosis"),
    ):
        ratio = told.pop(key, None)
        if ratio is not None:
            rows.append((words, number_text(ratio, 2)))
    return rows


def shape_rows(shape: Mapping[str, Any] | None) -> list[tuple[str, str]]:
    """Name and value of what makes a stent no cylinder."""
    if shape is None:
        return []
    rows = []
    waist = shape.get("waist")
    if waist:
        rows.append(("Waist", millimeters(waist["diameter"])))
    for key, words in (("start", "Proximal end"), ("end", "Distal end")):
        end = shape.get(key)
        if end:
            sizes = f"{millimeters(end['diameter'])} at the end, over {millimeters(end['length'])}"
            rows.append((f"{words} of the stent", sizes))
    if shape.get("table"):
        rows.append(("Profile", f"a table of {len(shape['table'])} diameters"))
    diameters = shape["diameters_mm"]
    rows.append(("Prescribed along it", f"{min(diameters):.2f} to {max(diameters):.2f} mm"))
    if shape.get("cap_height", 1) != 1:
        rows.append(
            ("Caps beyond its ends", f"{number_text(shape['cap_height'], 2)} of the radius")
        )
    return rows


def _axis_rows(
    axis: dict[str, Any], stent: Mapping[str, Any], surface: Mapping[str, Any]
) -> list[tuple[str, str]]:
    rows = []
    axis = {key: value for key, value in axis.items() if key not in ("start", "end", "units")}
    units, frame = surface.get("units", "mm"), surface.get("frame")
    where = f"x, y, z{f', {frame}' if frame else ''}"
    for key, words in (("start_mm", "Proximal end"), ("end_mm", "Distal end")):
        if key in axis:
            rows.append((f"{words} ({where})", point_words(axis.pop(key), units)))
    length = axis.pop("length_mm", None)
    if length is not None and length != stent.get("deployed_length_mm"):
        rows.append(("Length of its axis", millimeters(length, 1)))
    if "chord_mm" in axis:
        rows.append(("Straight distance of its ends", millimeters(axis.pop("chord_mm"), 1)))
    if "min_bend_radius_mm" in axis:
        radius = axis.pop("min_bend_radius_mm")
        rows.append(("Tightest bend of its axis", _bend_text(radius, length, stent)))
    return rows + [(plain_label(key), plain_text(key, value)) for key, value in _flat(axis)]


def _bend_text(radius: float | None, length: float | None, stent: Mapping[str, Any]) -> str:
    """The radius, and over which length of the axis it was found: it depends on that."""
    if radius is None:
        return "none, the axis is straight"
    text = f"radius {millimeters(radius, 1)}"
    diameter = stent.get("lumen_diameter_mm")
    if diameter is None:
        return text
    window = diameter / 2 if length is None else min(diameter, length) / 2
    return (
        f"{text}, of the circle through three points of the axis that are {millimeters(window, 1)} "
        f"apart ({'the stent radius' if window == diameter / 2 else 'half of its length'})"
    )


def _flat(values: Mapping[str, Any], prefix: str = "") -> Iterable[tuple[str, Any]]:
    for key, value in values.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{prefix}{key} ")
        else:
            yield f"{prefix}{key}", value
