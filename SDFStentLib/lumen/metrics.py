"""Diameters along a vessel.

Two diameters, because neither says all. The *inscribed* diameter is that of the largest sphere
that fits into the lumen, its center free in the plane across the axis: what a stent or a balloon
feels. The *equivalent* diameter is that of the circle with the area of the lumen's cross-section:
what the flow feels. They agree in a round tube; elsewhere the inscribed one is the smaller.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..cautions import Caution
from ..geometry import (
    Line,
    Surface,
    as_line,
    as_surface,
    frames,
    nearest_distances,
    segment_count,
)
from ..validation import Flags, Floats, InputError, Points, Triangles, read_only
from .caps import in_caps
from .expected_wall import LEAVES, across_alone, expected_wall, far_reach, section_radius
from .openings import FAR, labels_round
from .rounded_ends import past_rounded_ends
from .spheres import LocalSurface, StationSearch, Until, with_own_spheres
from .stations import CLOSELY, FINE_STATIONS, MOST, NEARLY, SPACING, Stations, measured_at
from .tolerances import ALIKE, ROUNDING
from .wall_map import RAYS, near_wall, rays_from

SUSPECT = 1.2
"""Equivalent over inscribed diameter that may come of another lumen; openings are looked for."""


def cut_at_ostia(
    surface: Surface, stations: Points, centers: Points, inscribed: Floats, equivalent: Floats
) -> tuple[Floats, Flags]:
    """Equivalent diameters (n,), and at which stations an ostium cuts them.

    Parameters
    ----------
    surface : Surface
        mm.
    stations, centers : (n, 3) arrays
        Equally spaced axis points, in order, and the centers of the spheres there, mm.
    inscribed, equivalent : (n,) arrays
        Diameters there, mm; NaN where unknown. A section that opens into another lumen has the
        area of both.
    """
    with np.errstate(invalid="ignore"):
        suspect = equivalent > SUSPECT * inscribed
    if not suspect.any():
        return equivalent, suspect
    middles = np.where(np.isfinite(centers), centers, stations)
    if surface.wall is not surface:
        # Past an island a ray would seem to go on into another lumen, and so would one to the far
        # wall from a sphere that the island has pushed aside.
        islands = surface.points[np.unique(surface.wall.islands)]
        is_beside = nearest_distances(stations, islands) < equivalent
        middles = np.where(is_beside[:, None], stations, middles)
        surface = surface.wall
    near = near_wall(surface, stations, far_reach(surface, stations))
    line = Line(stations)
    wall = rays_from(near, line.arc_lengths, middles, frames(line))
    # A path may end in a junction: its vessel goes on as the section there is without openings.
    ends = across_alone(wall.distance[[0, -1]])
    expected = expected_wall(wall, section_radius(wall.distance), ends)
    leaves = wall.distance > LEAVES * expected
    label = labels_round(leaves)
    far = np.unique(label[leaves & (wall.distance > FAR * expected)])
    leaves &= np.isin(label, far)
    is_cut = suspect & leaves.any(axis=1)
    rays = np.where(leaves, expected, wall.distance)
    # Of the polygon with a corner on every ray.
    area = (rays * np.roll(rays, -1, axis=1)).sum(axis=1) * np.sin(2 * np.pi / RAYS) / 2
    whole = 2 * np.sqrt(area / np.pi)
    is_cut &= np.isfinite(whole)
    return np.where(is_cut, np.fmin(whole, equivalent), equivalent), is_cut


_FINE = np.delete(np.linspace(-1, 1, FINE_STATIONS), [0, FINE_STATIONS // 2, -1])
"""Places between stations that are looked at, as parts of the way to the neighbors."""

_COLUMNS = ("arc_length", "centers", "inscribed_diameter", "equivalent_diameter", "is_cut")


@dataclass(frozen=True)
class DiameterProfile:
    """Diameters at stations along an axis, ordered as the axis (proximal to distal).

    NaN where a diameter could not be measured; `gaps` says where and why.
    """

    arc_length: Floats
    """(n,) position along the axis, mm."""
    centers: Points
    """(n, 3) centers of the inscribed spheres, mm."""
    inscribed_diameter: Floats
    """(n,) mm."""
    equivalent_diameter: Floats
    """(n,) mm."""
    is_cut: NDArray[np.bool_] = ()  # type: ignore[assignment]
    """(n,) whether the section opens into another vessel, and is cut at its ostium."""
    throats: Floats = ()  # type: ignore[assignment]
    """(k, 2) position and inscribed diameter between stations where that is smaller, mm."""
    known: tuple[float, float] | None = None
    """Position and inscribed diameter of the narrowest place, mm, where that is known otherwise."""

    def __post_init__(self) -> None:
        if not len(self.is_cut):
            object.__setattr__(self, "is_cut", np.zeros(len(self.arc_length), dtype=bool))
        object.__setattr__(self, "throats", np.reshape(self.throats, (-1, 2)))
        for name in (*_COLUMNS, "throats"):
            object.__setattr__(self, name, read_only(getattr(self, name)))

    @property
    def minimum(self) -> float:
        """Smallest inscribed diameter, also between stations, mm; NaN when there is none."""
        if self.known is not None:
            return self.known[1]
        return _statistic(np.min, np.append(self.inscribed_diameter, self.throats[:, 1]))

    @property
    def maximum(self) -> float:
        """Largest inscribed diameter, mm."""
        return _statistic(np.max, self.inscribed_diameter)

    @property
    def mean(self) -> float:
        """Mean inscribed diameter of the stations, mm."""
        return _statistic(np.mean, self.inscribed_diameter)

    @property
    def sd(self) -> float:
        """Standard deviation of the inscribed diameters (of all stations: divided by n), mm."""
        return _statistic(np.std, self.inscribed_diameter)

    @property
    def minimum_arc_length(self) -> float:
        """Position of the smallest inscribed diameter, mm; the first of equals."""
        if self.known is not None:
            return self.known[0]
        at = np.append(self.arc_length, self.throats[:, 0])
        diameters = np.append(self.inscribed_diameter, self.throats[:, 1])
        if not np.isfinite(diameters).any():
            return float("nan")
        return float(at[np.nanargmin(diameters)])

    @property
    def gaps(self) -> tuple[Caution, ...]:
        """Cautions for each kind of diameter that is missing somewhere."""
        return (
            *self._gap("no-inscribed-diameter", np.isnan(self.inscribed_diameter)),
            *self._gap("no-equivalent-diameter", np.isnan(self.equivalent_diameter)),
        )

    def _gap(self, kind: str, is_missing: Flags) -> Iterator[Caution]:
        if is_missing.any():
            count = {"missing": int(is_missing.sum()), "stations": len(is_missing)}
            yield Caution(kind, {**count, "ranges_mm": _ranges(self.arc_length, is_missing)})

    def over(self, start: float, end: float) -> DiameterProfile:
        """The stations from `start` to `end` (mm of arc length, both included).

        Raises
        ------
        InputError
            No station lies there.
        """
        # Stations are computed positions: one that is meant to be at the end may round beyond.
        chosen = (self.arc_length >= start - ROUNDING) & (self.arc_length <= end + ROUNDING)
        if not chosen.any():
            raise InputError(
                f"over: expected a part of 0 to {self.arc_length[-1]:g} mm that holds a station, "
                f"got {start:g} to {end:g} mm."
            )
        return self.taken(chosen)

    def taken(self, which: slice | Flags) -> DiameterProfile:
        """Profile at some of the stations, with what lies between neighbors among them."""
        chosen = np.zeros(len(self.arc_length), dtype=bool)
        chosen[which] = True
        after = np.searchsorted(self.arc_length, self.throats[:, 0])
        throats = self.throats[chosen[after - 1] & chosen[after]]
        taken = DiameterProfile(*(getattr(self, name)[which] for name in _COLUMNS))
        return replace(taken, throats=throats)


def diameter_profile(
    surface: Surface, axis: Line | ArrayLike, spacing: float = SPACING
) -> DiameterProfile:
    """Inscribed and equivalent diameter at stations along an axis.

    Parameters
    ----------
    surface : Surface
        Open or closed.
    axis : Line or array_like, shape (n, 3)
        Inside the lumen, mm. It gives the stations and the planes across; it need not
        be in the middle.
    spacing : float
        Distance of the stations, mm; changed a little so that both ends are stations.

    Returns
    -------
    DiameterProfile
        NaN at a station outside the surface. Closed ends of the vessel count as open for the
        inscribed diameter; the equivalent one is NaN where a flat cap cuts the section. A section
        that opens into another vessel is cut at its ostium, at the wall that would be there.

    Raises
    ------
    InputError
        No surface, fewer than two axis points, or a spacing that is not above 0.
    """
    surface = as_surface(surface)
    line = as_line(axis)
    count = segment_count(line.length, spacing)
    # Farther apart they would cut the bends of the axis, and look across its chords.
    between = max(1, round(min(line.length, MOST * SPACING) / count / SPACING))
    stations = line.resampled_to(count * between + 1)
    caps = in_caps(surface)
    measured = measured_at(surface, stations.points, stations.directions, caps)
    profile = profile_of(surface, stations.arc_lengths, measured, caps)
    return replace(profile.taken(slice(None, None, between)), throats=profile.throats)


def profile_of(
    surface: Surface,
    arc_length: Floats,
    measured: Stations,
    caps: Flags,
    parts: Sequence[slice] = (slice(None),),
) -> DiameterProfile:
    """`diameter_profile` of stations along an axis that are measured, in their order.

    Parameters
    ----------
    surface : Surface
        mm.
    arc_length : (n,) array
        Positions of the stations, mm, from wherever they count.
    measured : Stations
        About equally far apart. The vessel may end at the first and the last one only.
    caps : (m,) bool array
        The triangles that were in flat caps before any stent.
    parts : sequence of slice
        Stations among which openings are looked for together; what the last one says counts.
    """
    points, wall = surface.points, surface.triangles.compress(~caps, axis=0)
    # Sections are cut round spheres: those that have left the vessel are a branch's.
    lines = [np.arange(len(measured.points))]
    own = with_own_spheres(LocalSurface(points, wall, measured.points), *measured[:3], lines)
    measured = measured._replace(spheres=own)
    stations, equivalent = measured.points, measured.equivalent.copy()
    is_cut = np.zeros(len(stations), dtype=bool)
    for part in parts:
        centers, radii = measured.spheres.at(part)
        equivalent[part], is_cut[part] = cut_at_ostia(
            surface, stations[part], centers, 2 * radii, measured.equivalent[part]
        )
    measured = measured._replace(equivalent=equivalent)
    spheres = past_rounded_ends(points, wall, measured)

    # A closed section round the station proves that it is inside; the few others are looked at.
    outside = np.flatnonzero(np.isnan(equivalent))
    outside = outside[~surface.contains(stations[outside])]
    centers, inscribed = spheres.centers.copy(), 2 * spheres.radii
    # A sphere at a station on the surface tells nothing.
    outside = np.union1d(outside, np.flatnonzero(inscribed <= 0))
    centers[outside], inscribed[outside] = np.nan, np.nan
    lowest = [at for at in _lowest(inscribed, parts[-1]) if own.radii[at] == spheres.radii[at]]
    throats = _throats((points, wall), measured, arc_length, inscribed, lowest)
    return DiameterProfile(arc_length, centers, inscribed, equivalent, is_cut, throats)


def _lowest(diameters: Floats, part: slice) -> list[int]:
    """The narrowest stations of a part between which and the next ones a throat may lie."""
    own, first = diameters[part], part.indices(len(diameters))[0]
    beside = np.stack([own[:-2], own[2:]])
    is_low = (own[1:-1] <= beside.min(axis=0)) & (own[1:-1] * ALIKE < beside.max(axis=0))
    is_low &= own[1:-1] <= NEARLY * np.nanmin(np.append(own, np.inf))
    low = 1 + np.flatnonzero(is_low)
    return (first + low[np.argsort(own[low], kind="stable")][:CLOSELY]).tolist()


def _throats(
    surface: tuple[Points, Triangles],
    measured: Stations,
    arc_length: Floats,
    diameters: Floats,
    lowest: Sequence[int],
) -> Floats:
    """Throats (k, 2) between some stations and their neighbors, as `throats`."""
    if not lowest:
        return np.empty((0, 2))
    at = np.concatenate([number + _FINE for number in lowest])
    index = np.arange(len(arc_length))
    places, ways = (
        np.column_stack([np.interp(at, index, column) for column in columns.T])
        for columns in (measured.points, measured.directions)
    )
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    lines = np.split(np.arange(len(at)), len(lowest))
    wall = LocalSurface(*surface, places)
    found = StationSearch(wall, places, ways, Until()).exact()
    found = with_own_spheres(wall, places, ways, found, lines)
    narrowest = [line[np.argmin(found.radii[line])] for line in lines]
    told = np.column_stack(
        [np.interp(at[narrowest], index, arc_length), 2 * found.radii[narrowest]]
    )
    return told[told[:, 1] < diameters[lowest]]


def _statistic(function: object, values: Floats) -> float:
    known = values[np.isfinite(values)]
    return float(function(known)) if len(known) else float("nan")  # type: ignore[operator]


def _ranges(positions: Floats, chosen: NDArray[np.bool_]) -> str:
    """The runs of chosen positions in words: "0.0 to 3.0 and 9.0"."""
    edges = np.flatnonzero(np.diff(np.r_[0, chosen.astype(np.int8), 0])).reshape(-1, 2)
    runs = [(positions[first], positions[after - 1]) for first, after in edges]
    return " and ".join(
        f"{low:.1f}" + (f" to {high:.1f}" if high > low else "") for low, high in runs
    )
