"""Widths of a tree of lumens along its stretches between junctions, before and after."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..centerline import Centerline, LumenStretch, joined_lumens
from ..geometry import Line, Surface, norm
from ..lumen import FINEST, equivalent_diameters, inscribed_spheres, wall_of
from ..validation import Floats, Indices, InputError, Points, as_place, place_words
from ..vessel import BESIDE_TIP, VesselEnd, branch_lumens, vessel_ends
from .limbs import joined_limbs

OBLONG = 1.5
"""Times the inscribed diameter up to which the circle of a section's area may be wide: what is
wider is the section of other vessels, too."""

BESIDE = 1.0
"""Diameters along a vessel within which the least oblong section gives the shape: branches that
leave, and lines that go aslant, only make sections larger."""

FINE, COARSE = 0.1, 0.4
"""Largest distance of stations in diameters, beside the narrowest of three and elsewhere: the
throat of a short narrowing costs what it costs with twice as many to a percent."""

LOST = 2.0
"""Diameters before an outlet in which nothing is known: next to a cap it is one, and more in a
vessel that is narrower than its stations are apart."""

CLEAR = 1.2
"""Radii from an outlet from which on a sphere does not touch its cap, though that may lean."""

_NEW = -1.0
"""Mark of a diameter that is still to be measured."""


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
    """The channel at whose end it begins, -1 at an end of the vessel; of several the one that
    brings most blood."""
    also: tuple[int, ...] = ()
    """The other channels that bring blood there."""
    joins: int = -1
    """The channel at whose end it ends, too, where limbs meet again; else -1."""
    tips: tuple[float, float] = (math.nan, math.nan)
    """Diameters of circles with the areas of the vessel's ends, open or capped, at which it begins
    and ends, mm; NaN where there is none."""

    def turned(self) -> Channel:
        """Channel from its end on; what is above is not known."""
        return Channel(
            points=self.points[::-1],
            along=self.along[-1] - self.along[::-1],
            inscribed=self.inscribed[::-1],
            section=self.section[::-1],
            branch=self.branch[::-1],
            branch_along=self.branch_along[::-1],
            above=-1,
            tips=self.tips[::-1],
        )


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
    stretches, joins = joined_limbs(lumens.stretches, centerline)
    found = [_refined(one)._replace(joins=joins.get(k, -1)) for k, one in enumerate(stretches)]
    lines = [one.points for one in found]
    places, ways = np.concatenate(lines), np.concatenate([Line(line).directions for line in lines])
    sections = equivalent_diameters(surface.points, wall_of(surface), places, ways)
    inscribed = np.concatenate([one.inscribed for one in found])
    new = np.flatnonzero(inscribed == _NEW)
    inscribed[new] = (
        2 * inscribed_spheres(surface.points, surface.triangles, places[new], ways[new]).radii
    )
    ends = np.cumsum([len(line) for line in lines])[:-1]
    columns = zip(found, np.split(inscribed, ends), np.split(sections, ends), strict=True)
    told = tuple(one._replace(inscribed=d, section=area) for one, d, area in columns)
    return _with_tips(told, vessel_ends(surface))


def _with_tips(channels: Sequence[Channel], ends: Sequence[VesselEnd]) -> tuple[Channel, ...]:
    """The channels with the areas of their ends as seen along the last diameter before."""
    found = list(channels)
    last = outlets_of(channels)
    tips = np.array([channels[0].points[0], *(channels[number].points[-1] for number in last)])
    for end in ends:
        away = norm(tips - end.center)
        nearest = int(away.argmin())
        if away[nearest] > BESIDE_TIP * end.radius:
            continue
        number = 0 if nearest == 0 else last[nearest - 1]
        line = found[number].points[:: 1 if nearest == 0 else -1]
        inner = int(np.searchsorted(Line(line).arc_lengths, 2 * end.radius))
        way = end.center - line[min(max(inner, 1), len(line) - 1)]
        seen = abs(float(end.across @ way)) / np.linalg.norm(way)
        start, stop = found[number].tips
        diameter = float(2 * end.radius * np.sqrt(seen))
        both = (diameter, stop) if nearest == 0 else (start, diameter)
        found[number] = found[number]._replace(tips=both)
    return tuple(found)


def outlets_of(channels: Sequence[Channel]) -> list[int]:
    """The channels that end where the vessel does."""
    inner = {number for one in channels for number in (one.above, *one.also)}
    return [k for k, one in enumerate(channels) if k not in inner and one.joins < 0]


def meeting_of(channels: Sequence[Channel]) -> set[int]:
    """The channels at whose ends their blood meets that of others."""
    return {number for one in channels if one.also for number in (one.above, *one.also)}


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

    def turned(self) -> Widths:
        """The channel from its end on."""
        return Widths(*(axis[::-1] for axis in self))

    def widened(self, by: float) -> Widths:
        """The widths with all diameters larger by so many mm, halved at most."""
        return Widths(*(np.maximum(axis + by, axis / 2) for axis in self))


def widths_of(
    channels: Sequence[Channel],
    before: tuple[Sequence[Channel], Sequence[Widths]] | None = None,
) -> tuple[Widths, ...]:
    """The sections of a tree's channels, those of other vessels beside them left out.

    Of channels before treatment with their widths, those that are the same values after it keep
    theirs, unless one that they meet has changed.

    Raises
    ------
    InputError
        An outlet near which nothing is known of the lumen.
    """
    below: list[list[int]] = [[] for _ in channels]
    for number, one in enumerate(channels):
        if one.above >= 0:
            below[one.above].append(number)
    known = () if before is None else before[1]
    inner: list[Floats] = []
    for number, one in enumerate(channels):
        if before is not None and one is before[0][number]:
            inner.append(known[number].narrow)
        else:
            is_outlet = not below[number] and one.joins < 0
            inner.append(_known(one, inner, is_outlet=is_outlet))
    found = []
    for number, one in enumerate(channels):
        near = [number, *below[number], *(k for k in (one.above, one.joins) if k >= 0)]
        if before is not None and all(channels[k] is before[0][k] for k in near):
            found.append(known[number])
            continue
        narrow = inner[number]
        oblong = _oblong(one, narrow, [(channels[k], inner[k]) for k in near])
        widths = Widths(narrow, narrow * oblong**2)
        is_old = (
            before is not None
            and one is before[0][number]
            and np.array_equal(widths, known[number])
        )
        found.append(known[number] if is_old else widths)
    return tuple(found)


def _known(channel: Channel, before: Sequence[Floats], is_outlet: bool) -> Floats:
    """Inscribed diameters (n,), where they are not known those of sections or of stations near.

    At the inlet and at outlets those of stations near: caps cut their sections.
    """
    diameter = channel.inscribed
    is_inner = channel.above >= 0 and not is_outlet
    if is_inner or not np.isfinite(diameter).any():
        diameter = np.where(np.isfinite(diameter), diameter, channel.section)
    known = np.isfinite(diameter) & (diameter > 0)
    if is_outlet:
        clear = known & (norm(channel.points - channel.points[-1]) >= CLEAR / 2 * diameter)
        known = clear if clear.any() else known
    away = channel.along[-1] - channel.along[known].max(initial=-np.inf)
    is_outside = is_outlet and np.isnan(channel.section[-1])
    is_lost = is_outside and not away <= LOST * diameter[known][-1:].sum()
    if known.any() and not is_lost:
        return np.interp(channel.along, channel.along[known], diameter[known])
    if is_outlet:
        end = channel.points[-1]
        raise InputError(
            f"flow: expected a lumen at the outlet near {place_words(end)}",
            place=as_place(end),
            end=", got a centerline that goes on outside of the surface; extract the centerline "
            "anew.",
        )
    return np.full(len(channel.along), before[channel.above][-1])


def _oblong(channel: Channel, inner: Floats, near: Sequence[tuple[Channel, Floats]]) -> Floats:
    """Equivalent over inscribed diameters (n,): the least within `BESIDE`, of channels near."""
    ratios = np.concatenate([one.section / d for one, d in near])
    ratios = np.clip(np.where(np.isfinite(ratios), ratios, OBLONG), 1.0, OBLONG)
    apart = np.abs(channel.along[:, None] - np.concatenate([one.along for one, _ in near]))
    is_near = apart <= BESIDE * inner[:, None]
    return np.where(is_near, ratios, OBLONG).min(axis=1)


def _refined(lumen: LumenStretch) -> Channel:
    """A channel with more stations where it is narrow, so that no throat lies between two."""
    size = np.fmax(np.fmin(lumen.diameter[1:], lumen.diameter[:-1]), FINEST)
    known = np.isfinite(lumen.diameter[1:]) & np.isfinite(lumen.diameter[:-1])
    is_throat = np.zeros(len(lumen.diameter), dtype=bool)
    is_throat[1:-1] = (lumen.diameter[1:-1] <= lumen.diameter[:-2]) & (
        lumen.diameter[1:-1] <= lumen.diameter[2:]
    )
    apart = np.where(is_throat[1:] | is_throat[:-1], FINE, COARSE) * size
    counts = np.where(known, np.ceil(np.diff(lumen.along) / apart), 1.0)
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
