"""Which stent was deployed, and what a report's page tells of it: plain text, nothing escaped."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ..plan import to_document
from ..stent import OfStent, Stent
from ..treatment import TreatedStent
from .devices import section_device_rows
from .sizing import balloon_rows
from .words import millimeters, number_text, plain_text, point_words, size_words

_PLACEMENTS = {
    "AtCenter": "by its middle",
    "AtDistalEnd": "by its distal end",
    "AtProximalEnd": "by its proximal end",
    "BetweenPoints": "between two points on the centerline",
    "AlongAxis": "along a given curve",
    "OfStent": "where the earlier one lies",
}


def stent_titles(stents: Sequence[Mapping[str, Any]]) -> list[str]:
    """Such as "Stent 1 of 2: main"; one stent alone has no number.

    Stents of the plan that are switched off are not in a report: the numbers are then those of
    the plan, as in the warnings.
    """
    numbers = [stent["number"] for stent in stents]
    if numbers != [*range(1, len(stents) + 1)]:
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
    """Size and placement in one sentence."""
    size, length = size_words(stent["lumen_diameter_mm"]), stent["deployed_length_mm"]
    words = (
        f"Stent of {size} x {millimeters(length, 1)}{_packed_words(stent)}, placed {_placed(stent)}"
    )
    again = stent.get("dilated_again_as")
    return f"{words}, dilated again as stent {again}." if again else f"{words}."


def _placed(stent: Mapping[str, Any]) -> str:
    return _PLACEMENTS[stent["placement"]]


def _packed_words(stent: Mapping[str, Any]) -> str:
    """How long it was before it shortened, and why it did; empty where it did not."""
    share = stent["foreshortening_fraction"]
    if not share:
        return ""
    change = f"{number_text(100 * abs(share), 0)} % {'shorter' if share > 0 else 'longer'}"
    packed = millimeters(stent["nominal_length_mm"], 1)
    return f" (packed {packed}, {change} once expanded: {stent['foreshortening_reason']})"


def stent_rows(stent: Mapping[str, Any], surface: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Name and value of everything about a stent but its diameters.

    Points are in the frame and the unit of the surface's file, an entry of the inputs.
    """
    reason = stent["foreshortening_reason"]
    share = f"{number_text(100 * stent['foreshortening_fraction'], 0)} % of nominal length"
    return [
        *section_device_rows(stent["device"]),
        *balloon_rows(stent),
        *shape_rows(stent["shape"]),
        ("Nominal length", millimeters(stent["nominal_length_mm"], 1)),
        ("Deployed length along the axis", millimeters(stent["deployed_length_mm"], 1)),
        ("Foreshortening on expansion", f"{share}, {reason}" if reason else share),
        ("Placed", _placed(stent)),
        *_axis_rows(stent, surface),
        ("Surface points that it moved", plain_text("", stent["moved_points"])),
    ]


def _axis_rows(stent: Mapping[str, Any], surface: Mapping[str, Any]) -> list[tuple[str, str]]:
    axis, frame = stent["axis"], surface["frame"]
    where = f"x, y, z{f', {frame}' if frame else ''}"
    ends = (("start_mm", "Proximal end"), ("end_mm", "Distal end"))
    return [
        *((f"{words} ({where})", point_words(axis[key], axis["units"])) for key, words in ends),
        ("Straight distance of its ends", millimeters(axis["chord_mm"], 1)),
        ("Tightest bend of its axis", _bend_text(stent)),
    ]


def _bend_text(stent: Mapping[str, Any]) -> str:
    """The radius, and over which length of the axis it was found: it depends on that."""
    radius, diameter = stent["axis"]["min_bend_radius_mm"], stent["lumen_diameter_mm"]
    if radius is None:
        return "none, the axis is straight"
    window = min(diameter, stent["axis"]["length_mm"]) / 2
    return (
        f"radius {millimeters(radius, 1)}, of the circle through three points of the axis that are "
        f"{millimeters(window, 1)} apart "
        f"({'the stent radius' if window == diameter / 2 else 'half of its length'})"
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
        told.append(f"balloon {round(stent.balloon.diameter, 2):g} mm")
    reason = shortening_reason(stent)
    if reason is not None and stent.foreshortening:
        percent = 100 * stent.foreshortening
        change = f"{abs(percent):.3g} % {'shorter' if percent > 0 else 'longer'}"
        packed = round(axis.nominal_length, 2)
        told.append(f"{packed:g} mm as packed, {change} once expanded: {reason}")
        if axis.deployed_length < axis.prescribed_length - CUT:
            told.append(f"of {axis.prescribed_length:.1f} mm the rest lies beyond the centerline")
    return f"{words} ({'; '.join(told)})" if told else words
