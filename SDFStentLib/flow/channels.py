"""How wide a tree of lumens is along its stretches between junctions, before and after."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..centerline import Centerline, Stretch, joined_lumens
from ..geometry import Surface, arc_lengths, tangents
from ..lumen import equivalent_diameters, inscribed_spheres, moved_wall
from ..validation import Flags, Floats, Indices, InputError, Points
from ..vessel import branch_lumens

OBLONG = 1.5
"""Times the inscribed diameter up to which the circle of a section's area may be wide: what is
wider is the section of other vessels, too."""

BESIDE = 1.0
"""Diameters along a vessel within which the least oblong section tells the shape: branches that
leave, and lines that go aslant, only make sections larger."""

FINE = 0.2
"""Diameters by which stations are apart at most: the throat of a short narrowing is missed by less
than a percent of its diameter."""

_NEW = -1.0
"""Stands for a diameter that is still to be measured."""


class Channel(NamedTuple):
    """Stations along a lumen from one junction, or the root, to the next one, or an outlet."""

    points: Points
    """(n, 3) mm."""
    along: Floats
    """(n,) arc length from the root, mm."""
    inscribed: Floats
    """(n,) diameter of the inscribed sphere, mm; NaN where it is not known."""
    section: Floats
    """(n,) diameter of the circle with the area of the section, mm; NaN where there is none."""
    branch: Indices
    """(n,) index into `Centerline.branches`."""
    branch_along: Floats
    """(n,) arc length from the start of that branch, mm."""
    above: int
    """The channel at whose end it begins; -1 at the root."""


def channels_of(surface: Surface, centerline: Centerline) -> tuple[Channel, ...]:
    """The channels of a tree, every one after that above it.

    Raises
    ------
    InputError
        A centerline outside of the surface, or one with more than one root.
    """
    if len(centerline.roots) > 1:
        raise InputError(
            f"flow: expected a centerline with one inlet, got {len(centerline.roots)}; give that "
            "of one tree."
        )
    lumens = joined_lumens(branch_lumens(surface, centerline))
    found = [_refined(one) for one in lumens.stretches]
    lines = [one.points for one in found]
    places, ways = np.concatenate(lines), np.concatenate([tangents(line) for line in lines])
    sections = equivalent_diameters(surface.points, surface.triangles, places, ways)
    inscribed = np.concatenate([one.inscribed for one in found])
    new = np.flatnonzero(inscribed == _NEW)
    inscribed[new] = (
        2 * inscribed_spheres(surface.points, surface.triangles, places[new], ways[new]).radii
    )
    ends = np.cumsum([len(line) for line in lines])[:-1]
    columns = zip(found, np.split(inscribed, ends), np.split(sections, ends), strict=True)
    return tuple(one._replace(inscribed=d, section=area) for one, d, area in columns)


def channels_after(
    channels: Sequence[Channel],
    centerlines: tuple[Centerline, Centerline],
    surfaces: tuple[Surface, Surface],
) -> tuple[Channel, ...]:
    """The same stations on the moved centerline in the treated vessel.

    What no moved wall is near to stays as it was, to the bit.

    Parameters
    ----------
    channels : sequence of Channel
        Before.
    centerlines, surfaces : pairs
        Before and after.
    """
    lines = [_carried(one, *centerlines) for one in channels]
    moved = moved_wall(*surfaces)
    points, places = np.concatenate([one.points for one in channels]), np.concatenate(lines)
    inscribed = np.concatenate([one.inscribed for one in channels])
    sections = np.concatenate([one.section for one in channels])
    ways = np.concatenate([tangents(line) for line in lines])
    has_moved: Flags = (points != places).any(axis=1)
    # Twice a diameter holds the sphere and the wall round it that plays a part.
    reach = np.fmax(inscribed, sections)
    changed = has_moved | moved.comes_near(places, reach)
    seen, cut = np.flatnonzero(changed & np.isfinite(inscribed)), np.flatnonzero(changed)
    wall = surfaces[1].points, surfaces[1].triangles
    inscribed[seen] = 2 * inscribed_spheres(*wall, places[seen], ways[seen]).radii
    sections[cut] = equivalent_diameters(*wall, places[cut], ways[cut])
    ends = np.cumsum([len(line) for line in lines])[:-1]
    columns = zip(channels, lines, np.split(inscribed, ends), np.split(sections, ends), strict=True)
    return tuple(
        one._replace(points=line, along=_along(line, one), inscribed=inner, section=area)
        for one, line, inner, area in columns
    )


class Widths(NamedTuple):
    """Sections (n,) along a channel as ellipses, mm."""

    narrow: Floats
    """Their short axes, the inscribed diameters."""
    wide: Floats
    """Their long axes."""

    @property
    def area(self) -> Floats:
        """(n,) mm^2."""
        return np.pi / 4 * self.narrow * self.wide

    def widened(self, by: float) -> Widths:
        """All diameters larger by so many mm, halved at most."""
        return Widths(*(np.maximum(axis + by, axis / 2) for axis in self))


def widths_of(channels: Sequence[Channel]) -> tuple[Widths, ...]:
    """The sections of a tree's channels, those of other vessels beside them left out.

    Raises
    ------
    InputError
        An outlet near which nothing is known of the lumen.
    """
    is_outlet = np.ones(len(channels), dtype=bool)
    is_outlet[[one.above for one in channels if one.above >= 0]] = False
    inner: list[Floats] = []
    for number, one in enumerate(channels):
        inner.append(_known(one, inner, is_outlet[number]))
    oblong = _oblong(channels, inner)
    return tuple(Widths(d, d * ratio**2) for d, ratio in zip(inner, oblong, strict=True))


def _known(channel: Channel, before: Sequence[Floats], is_outlet: bool) -> Floats:
    """Inscribed diameters (n,), where they are not known those of sections or of stations near."""
    diameter = np.where(np.isfinite(channel.inscribed), channel.inscribed, channel.section)
    known = np.isfinite(diameter) & (diameter > 0)
    if known.any():
        return np.interp(channel.along, channel.along[known], diameter[known])
    if is_outlet:
        x, y, z = channel.points[-1]
        raise InputError(
            f"flow: expected a lumen at the outlet near ({x:.1f}, {y:.1f}, {z:.1f}) mm, got a "
            "centerline that ends outside of the surface; extract the centerline anew."
        )
    return np.full(len(channel.along), before[channel.above][-1])


def _oblong(channels: Sequence[Channel], inner: Sequence[Floats]) -> list[Floats]:
    """Equivalent over inscribed diameters (n,): the least within `BESIDE`, beyond junctions too."""
    own = [
        np.clip(np.where(np.isfinite(one.section), one.section / d, OBLONG), 1.0, OBLONG)
        for one, d in zip(channels, inner, strict=True)
    ]
    found = []
    for number, one in enumerate(channels):
        near = [k for k, other in enumerate(channels) if number in (k, other.above)]
        near += [one.above] if one.above >= 0 else []
        at = np.concatenate([channels[k].along for k in near])
        ratios = np.concatenate([own[k] for k in near])
        apart = np.abs(one.along[:, None] - at)
        is_near = apart <= BESIDE * inner[number][:, None]
        found.append(np.where(is_near, ratios, OBLONG).min(axis=1))
    return found


def _refined(lumen: Stretch) -> Channel:
    """A channel with more stations where it is narrow, so that no throat lies between two."""
    size = np.fmin(lumen.diameter[1:], lumen.diameter[:-1])
    known = np.isfinite(lumen.diameter[1:]) & np.isfinite(lumen.diameter[:-1])
    counts = np.where(known, np.ceil(np.diff(lumen.along) / (FINE * size)), 1.0)
    # Between two branches there is nothing.
    counts[np.diff(lumen.branch) != 0] = 1.0
    steps = [np.arange(count) / count for count in counts.tolist()]
    at = np.concatenate([*(k + step for k, step in enumerate(steps)), [float(len(counts))]])
    index = np.arange(len(lumen.along))
    is_old = at == np.floor(at)

    def between(values: Floats) -> Floats:
        return np.interp(at, index, values)

    return Channel(
        points=np.column_stack([between(column) for column in lumen.points.T]),
        along=between(lumen.along),
        inscribed=np.where(is_old, lumen.diameter[np.floor(at).astype(np.int64)], _NEW),
        section=np.full(len(at), np.nan),
        branch=lumen.branch[np.ceil(at).astype(np.int64)],
        branch_along=between(lumen.branch_along),
        above=lumen.above,
    )


def _carried(channel: Channel, before: Centerline, after: Centerline) -> Points:
    """Where the stations (n, 3) of a channel are on the moved centerline."""
    places = channel.points.copy()
    for number in np.unique(channel.branch):
        nodes = before.branches[number]
        line, moved = before.points[nodes], after.points[nodes]
        if np.array_equal(line, moved):
            continue
        own = channel.branch == number
        at = arc_lengths(line)
        places[own] += np.column_stack(
            [np.interp(channel.branch_along[own], at, shift) for shift in (moved - line).T]
        )
    return places


def _along(line: Points, channel: Channel) -> Floats:
    """Arc lengths (n,) along stations that may have moved, from where the channel began."""
    if np.array_equal(line, channel.points):
        return channel.along
    return np.asarray(channel.along[0] + arc_lengths(line))
