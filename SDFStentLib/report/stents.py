"""Which stent was deployed, and what a report's page tells of it: plain text, nothing escaped."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ..plan import to_document
from ..stent import OfStent, Stent
from ..treatment import TreatedStent
from .devices import section_device_rows
from .sizing import balloon_rows
from .words import (
    UNKNOWN,
    flat,
    millimeters,
    number_text,
    plain_label,
    plain_text,
    point_words,
)

_PLACEMENTS = {
    "AtCenter": "by its middle",
    "AtDistalEnd": "by its distal end",
    "AtProximalEnd": "by its proximal end",
    "BetweenPoints": "between two points on the centerline",
    "AlongAxis": "along a given curve",
    "OfStent": "where the earlier one lies",
}

_TOLD_ELSEWHERE = ("number", "name", "diameters", "lesions", "dilated_again_as")
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
    rows = [*section_device_rows(told.pop("device", None)), *balloon_rows(told)]
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
    return rows + [(plain_label(key), plain_text(key, value)) for key, value in flat(told)]


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
    return rows + [(plain_label(key), plain_text(key, value)) for key, value in flat(axis)]


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


def shape_section(treated: TreatedStent) -> dict[str, Any] | None:
    """What makes a stent no cylinder, with the profile that came of it; None for a cylinder."""
    shape, profile = treated.stent.shape, treated.axis.profile
    if shape is None or profile is None:
        return None
    return {
        "cap_height": shape.cap_height,
        **to_document(shape),
        "fractions": profile.fractions,
        "diameters_mm": profile.diameters,
    }


def prescribed_words(treated: TreatedStent) -> str:
    """The prescribed diameter, or the smallest and the largest one."""
    profile = treated.axis.profile
    if profile is None or profile.diameters.min() == profile.widest:
        return f"{round(treated.stent.diameter, 2):g} mm"
    return f"{profile.diameters.min():.2f} to {profile.widest:.2f} mm"


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
    if shape["cap_height"] != 1:
        rows.append(
            ("Caps beyond its ends", f"{number_text(shape['cap_height'], 2)} of the radius")
        )
    return rows


CUT = 0.1
"""By so much less than prescribed, mm, a stent is told to be cut; as its warning has it."""


def shortening_reason(stent: Stent) -> str | None:
    """Why so much is taken off the length of a stent; None where no length was given."""
    if stent.length is None and stent.foreshortening_fraction is None:
        return None
    if isinstance(stent.placement, OfStent) and not stent.foreshortening:
        return None
    if stent.foreshortening_fraction is not None:
        return "as given"
    if stent.device is None:
        return "the usual share, assumed without a device"
    return f"as known of {stent.device.name}"


def deployed_words(treated: TreatedStent) -> str:
    """A stent by its sizes, as deployed and as packed."""
    stent, axis = treated.stent, treated.axis
    name = "stent of" if stent.device is None else f"{stent.device.name},"
    size = prescribed_words(treated).replace(" mm", "")
    words = f"{name} {size} x {axis.deployed_length:.1f} mm"
    told = []
    if stent.balloon is not None:
        told.append(f"balloon {stent.balloon.diameter:g} mm")
    reason = shortening_reason(stent)
    if reason is not None and stent.foreshortening:
        percent = 100 * stent.foreshortening
        change = f"{abs(percent):.3g} % {'shorter' if percent > 0 else 'longer'}"
        told.append(f"{axis.nominal_length:g} mm as packed, {change} once expanded: {reason}")
        if axis.deployed_length < axis.prescribed_length - CUT:
            told.append(f"of {axis.prescribed_length:.1f} mm the rest lies beyond the centerline")
    return f"{words} ({'; '.join(told)})" if told else words
