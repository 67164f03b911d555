"""The axis of a stent, which follows from the stent and its place."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from ..cautions import Caution
from ..centerline import Centerline, CenterlinePath, JunctionChoice, Location
from ..geometry import Line, tightest_bend
from ..validation import (
    Floats,
    InputError,
    Points,
    as_place,
    check_is_a,
    coordinates,
    place_words,
    plain,
    read_only,
)
from .placement import (
    AlongAxis,
    AtCenter,
    AtDistalEnd,
    AtProximalEnd,
    BetweenPoints,
    OfStent,
    OfVessel,
    Placement,
)
from .shape import DiametersAlong
from .stent import Stent

FAR = 0.5
"""Distance to the centerline from which on a caution is given, in local inscribed radii."""

FAR_UNKNOWN = 2.0
"""The same where the radius is unknown, mm."""


def placement_points(placement: Placement | None) -> list[tuple[str, Floats]]:
    """The points of a placement with their names; those by none have none, as along a curve."""
    if isinstance(placement, BetweenPoints):
        return [("stent start", placement.start), ("stent end", placement.end)]
    if placement is None or isinstance(placement, AlongAxis | OfStent | OfVessel):
        return []
    if isinstance(placement, AtCenter):
        return [("center", placement.point)]
    name = "distal end" if isinstance(placement, AtDistalEnd) else "proximal end"
    return [(name, placement.point)]


def beside(placement: Placement | None, centerline: Centerline) -> Iterator[Caution]:
    """Caution for every point that is noticeably away from where the stent is put."""
    for name, point in placement_points(placement):
        place = centerline.project(point)
        radius = place.inscribed_radius
        if place.distance <= (FAR * radius if np.isfinite(radius) else FAR_UNKNOWN):
            continue
        if isinstance(placement, BetweenPoints):
            # The two ends are those of the part where one is measured.
            kind, which = "end-beside", {"end": name.removeprefix("stent ")}
        else:
            kind, which = "point-beside", {"point": name}
        yield Caution(kind, {**which, "distance_mm": place.distance}, as_place(place.point))


FARTHEST_PLACEMENT = 2.0
"""Largest distance of a placement from the centerline, in local inscribed radii."""

FARTHEST_PLACEMENT_UNKNOWN = 20.0
"""The same where the radius is unknown, mm."""

LEAST_PART = 0.5
"""Part of a stent that has to lie on the vessel, unless it may be shortened: with less it is at the
wrong place, not short of a few millimeters."""

LONGEST_AXIS = 1000.0
"""Longest axis of a stent, or of a measured part, mm: no way through vessels is longer."""

LENGTH_TOLERANCE = 1e-6
"""Lengths that differ by less than this are the same, mm."""

NOTICEABLE = 0.1
"""Least loss of length with a caution, mm: lengths are given to a tenth, so that whatever is lost
beyond it can be read from them."""


@dataclass(frozen=True, eq=False)
class StentAxis:
    """The part of a centerline, or the curve, that the expanded stent occupies.

    Parameters
    ----------
    line : Line
        Proximal to distal, no repeats, mm.
    inscribed_radius : array, shape (n,)
        Radius of the vessel along the axis, mm; NaN where unknown.
    nominal_length, prescribed_length : float
        Lengths before and after foreshortening, mm.
    warnings : tuple of Caution
    profile : DiametersAlong, optional
        Diameters of the stent that lies there, if it is no cylinder.
    """

    line: Line
    inscribed_radius: Floats
    nominal_length: float
    prescribed_length: float
    warnings: tuple[Caution, ...] = ()
    profile: DiametersAlong | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "inscribed_radius", read_only(self.inscribed_radius))

    @property
    def points(self) -> Points:
        """(n, 3) mm."""
        return self.line.points

    @property
    def deployed_length(self) -> float:
        """Length of the axis, mm; less than prescribed where the centerline ends."""
        return self.line.length

    @property
    def chord(self) -> float:
        """Distance of the two ends, mm."""
        return float(np.linalg.norm(self.points[-1] - self.points[0]))

    def minimum_bend_radius(self, stent_radius: float) -> float:
        """Radius of the axis's tightest bend, as a stent of that radius feels it, mm; infinity if
        straight.

        Measured over windows of the stent's radius, which smaller wiggles do not bend. A corner
        counts as tighter than the stent's radius above 60 degrees.
        """
        return tightest_bend(self.line, window=stent_radius).radius


def stent_axis(
    stent: Stent,
    centerline: Centerline | None = None,
    *,
    lies_on: StentAxis | None = None,
) -> StentAxis:
    """The axis of an expanded stent.

    Parameters
    ----------
    stent : Stent
        Size and placement.
    centerline : Centerline, optional
        Needed for every placement but `AlongAxis`, which does not look at it.
    lies_on : StentAxis, optional
        Axis of the earlier stent, for one that is placed by `OfStent`.

    Returns
    -------
    StentAxis
        At the density of the centerline. Its warnings say where the stent was shortened, which
        branch was followed, and whether it bends more than it can.

    Raises
    ------
    InputError
        No centerline, a point too far from it, or too little of it left for the stent.
    """
    check_is_a(stent, Stent, "stent")
    if isinstance(stent.placement, AlongAxis):
        found = _along_axis(stent.placement)
    elif isinstance(stent.placement, OfStent):
        found = _along_stent(stent.placement, lies_on)
    else:
        found = _along_centerline(stent, centerline)
    nominal = stent.length if stent.length is not None else found.length
    prescribed = nominal * (1.0 - stent.foreshortening)
    if not isinstance(stent.placement, AtDistalEnd | AtProximalEnd):
        found = _kept(found, prescribed, stent.keeps)
    _require_length(found.line)
    axis = StentAxis(found.line, found.inscribed_radius, nominal, prescribed)
    if not stent.may_be_shortened and not isinstance(stent.placement, OfStent):
        _require_part(axis)
    warnings = [*_shortened(axis, lies_on), *(_choice(choice) for choice in found.choices)]
    warnings += stent.device_cautions()
    if centerline is not None:
        warnings += beside(stent.placement, centerline)
    return replace(axis, warnings=(*warnings, *_bend(axis, stent.radius)))


def moved_axis(axis: StentAxis, line: Line, stent_radius: float) -> StentAxis:
    """An axis that runs along another line, point for point, its bend judged anew."""
    moved = replace(axis, line=line)
    others = (one for one in axis.warnings if one.kind != "tight-bend")
    return replace(moved, warnings=(*others, *_bend(moved, stent_radius)))


def _along_axis(placement: AlongAxis) -> CenterlinePath:
    return CenterlinePath(Line(placement.points), np.full(len(placement.points), np.nan))


def _along_stent(placement: OfStent, lies_on: StentAxis | None) -> CenterlinePath:
    if lies_on is None:
        raise InputError(
            f"redilation: expected stent {placement.number} to lie in the vessel, got no axis of "
            "it; deploy it before, in the same treatment."
        )
    return CenterlinePath(lies_on.line, lies_on.inscribed_radius)


def _along_centerline(stent: Stent, centerline: Centerline | None) -> CenterlinePath:
    if centerline is None:
        raise InputError(
            "stent placement: expected a centerline for a placement by points, got none; "
            "give a centerline, or a curve as the stent's axis."
        )
    placement = stent.placement
    if placement is None:
        raise InputError("stent placement: expected a place, got none; place it.")
    if isinstance(placement, OfVessel):
        raise InputError(
            "stent placement: expected a point, which the vessel has for a place at a lesion or on "
            "a branch, got none; ask `Vessel.placed` first."
        )
    if isinstance(placement, BetweenPoints):
        start = _placed(centerline, placement.start, "stent start")
        end = _placed(centerline, placement.end, "stent end")
        # Proximal is the end nearer to the root, whichever was given first.
        if end.arc_length < start.arc_length:
            return centerline.path(placement.end, placement.start)
        return centerline.path(placement.start, placement.end)
    assert stent.length is not None  # Stent refuses these placements without one
    wanted = stent.length * (1.0 - stent.foreshortening)
    if isinstance(placement, AtCenter):
        # As it is packed, when it shortens toward one end.
        wanted = wanted if stent.keeps == "center" else max(wanted, stent.length)
        _placed(centerline, placement.point, "center")
        return centerline.path_around(placement.point, wanted)
    if isinstance(placement, AtDistalEnd):
        _placed(centerline, placement.point, "distal end")
        return centerline.path_from_distal(placement.point, wanted)
    assert isinstance(placement, AtProximalEnd)
    _placed(centerline, placement.point, "proximal end")
    return centerline.path_from_proximal(placement.point, wanted)


def _placed(centerline: Centerline, point: Floats, name: str) -> Location:
    """The point's projection, refused when it is too far to be meant."""
    place = centerline.project(point)
    known = np.isfinite(place.inscribed_radius)
    limit = FARTHEST_PLACEMENT * place.inscribed_radius if known else FARTHEST_PLACEMENT_UNKNOWN
    if place.distance > limit:
        raise InputError(
            f"{name}: expected a point within {plain(limit, '.3g')} mm of the centerline, got "
            f"{place_words(point)}",
            place=as_place(point),
            end=f", {plain(place.distance, '.3g')} mm away; check the point, its unit (mm, cm) "
            "and its frame (RAS, LPS).",
        )
    return place


def _kept(path: CenterlinePath, wanted: float, keeps: str) -> CenterlinePath:
    """The part of the given length that keeps an end or the middle; the whole if not longer."""
    spare = path.length - wanted
    if spare <= LENGTH_TOLERANCE:
        return path
    start = {"center": spare / 2.0, "proximal": 0.0, "distal": spare}[keeps]
    line = path.line.cut(start, path.length - (spare - start))
    at = start + line.arc_lengths
    radius = np.interp(at, path.line.arc_lengths, path.inscribed_radius)
    return CenterlinePath(line, radius, path.choices)


def _require_length(line: Line) -> None:
    along = line.length
    if along > LONGEST_AXIS:
        raise InputError(
            f"stent axis: expected a way of at most {LONGEST_AXIS:g} mm, got {along:,.0f} mm; give "
            "the length of the stent, or check the unit of the files",
            "units",
            end=".",
        )
    if along <= LENGTH_TOLERANCE:
        place = line.points[0]
        raise InputError(
            "stent axis: expected some length of centerline for the stent, got none at "
            f"{coordinates(place)}; move the point away from the end "
            "of the centerline, or the two points apart."
        )


def _require_part(axis: StentAxis) -> None:
    if axis.deployed_length < LEAST_PART * axis.prescribed_length - NOTICEABLE:
        raise InputError(
            f"stent: expected a place where at least half of its {axis.prescribed_length:.1f} mm "
            f"can lie on the vessel, got {axis.deployed_length:.1f} mm of centerline or curve "
            "there; move it, or make it shorter",
            "shortened",
            end=".",
        )


def _shortened(axis: StentAxis, lies_on: StentAxis | None) -> Iterator[Caution]:
    if (
        lies_on is not None
        and axis.prescribed_length < lies_on.prescribed_length + LENGTH_TOLERANCE
    ):
        return  # No loss of its own: said of the earlier stent.
    if axis.deployed_length < axis.prescribed_length - NOTICEABLE:
        lengths = {"prescribed_mm": axis.prescribed_length, "available_mm": axis.deployed_length}
        yield Caution("shortened", lengths)


def _choice(choice: JunctionChoice) -> Caution:
    return Caution("branch-chosen", {"rule": choice.rule}, as_place(choice.point))


def _bend(axis: StentAxis, stent_radius: float) -> Iterator[Caution]:
    bend = tightest_bend(axis.line, window=stent_radius)
    if bend.radius < stent_radius:
        radii = {"bend_radius_mm": bend.radius, "stent_radius_mm": stent_radius}
        yield Caution("tight-bend", radii, as_place(bend.point))
