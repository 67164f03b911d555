"""The channels of a tree after treatment: what moved wall is near to, followed as it moves."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..centerline import Centerline
from ..geometry import Balls, Line, Surface, across
from ..lumen import (
    FollowedWall,
    InscribedSpheres,
    SectionLoops,
    followed_wall,
    moved_wall,
    section_loops,
)
from ..validation import Floats, Indices, Points
from .channels import Channel


class _Round(NamedTuple):
    """Wall and sections round the stations of some channels."""

    which: Indices
    """(n,) indices of the stations whose inscribed diameter is known."""
    wall: FollowedWall
    """Wall round these."""
    loops: SectionLoops
    """Sections of all stations,"""
    areas: Floats
    """(m,) and their areas, mm^2; 0 where there is none."""


class FollowedChannels:
    """The channels of a vessel, followed again and again in the vessel as treated.

    What is round a channel is looked up when a wall moves near it for the first time.

    Parameters
    ----------
    surface, centerline, channels
        Before treatment.
    """

    def __init__(
        self, surface: Surface, centerline: Centerline, channels: Sequence[Channel]
    ) -> None:
        self._surface, self._centerline, self.channels = surface, centerline, tuple(channels)
        self._known: dict[int, _Round] = {}

    @cached_property
    def _wall(self) -> Balls:
        points = self._surface.points
        return Balls(points, np.zeros(len(points)))

    @cached_property
    def _reach(self) -> list[Floats]:
        """Distances (n,) by channel within which wall may matter to its stations, mm.

        Twice a radius holds the sphere and the wall round it that plays a part. Where nothing is
        known, as at a cap, what is known next to it counts.
        """
        return [_filled(np.fmax(one.inscribed, one.section)) for one in self.channels]

    def after(self, centerline: Centerline, surface: Surface) -> tuple[Channel, ...]:
        """Channels at the same stations on the moved centerline in the treated vessel.

        Their diameters grow as spheres among followed points of the wall do, and as the loops of
        their sections do. What no moved wall is near to stays as it was, to the bit; a channel of
        which nothing has changed is the same value.
        """
        moves = _moves(self._centerline, centerline)
        lines = [_carried(one, moves) for one in self.channels]
        places, reach = (
            np.concatenate(column)
            for column in ([one.points for one in self.channels], self._reach)
        )
        is_near = moved_wall(self._surface, surface).comes_near(places, reach)
        ends = np.cumsum([len(line) for line in lines])[:-1]
        which = [
            number
            for number, (near, line) in enumerate(zip(np.split(is_near, ends), lines, strict=True))
            if near.any() or not np.array_equal(line, self.channels[number].points)
        ]
        found = list(self.channels)
        if which:
            rounds = [self._round(number) for number in which]
            own = _joined(rounds, [len(lines[number]) for number in which])
            before = [self.channels[number] for number in which]
            inscribed, section = self._grown(own, before, [lines[k] for k in which], surface)
            ends = np.cumsum([len(one.points) for one in before])[:-1]
            told = zip(which, np.split(inscribed, ends), np.split(section, ends), strict=True)
            for k, inner, area in told:
                one = self.channels[k]._replace(
                    points=lines[k],
                    along=_along(lines[k], self.channels[k]),
                    inscribed=inner,
                    section=area,
                )
                found[k] = self.channels[k] if _is_same(one, self.channels[k]) else one
        return tuple(found)

    def _grown(
        self, own: _Round, before: Sequence[Channel], lines: Sequence[Points], surface: Surface
    ) -> tuple[Floats, Floats]:
        """Inscribed and equivalent diameters (n,) of channels on their moved lines."""
        stations = np.concatenate([one.points for one in before])
        inscribed = np.concatenate([one.inscribed for one in before])
        section = np.concatenate([one.section for one in before])
        places = np.concatenate(lines)
        ways = np.concatenate([Line(line).directions for line in lines])
        states = self._surface.points, surface.points
        shifts = (places - stations)[own.which]
        touched, spheres = own.wall.spheres_after(states, shifts, across(ways[own.which]))
        changed = own.which[touched]
        inscribed[changed] *= spheres.radii / own.wall.spheres.radii[touched]
        # A section that reaches far into other vessels says nothing of this one any more.
        section[changed[own.areas[changed] == 0]] = np.nan
        areas = own.loops.areas(surface.points, places, ways)
        has_loop = np.flatnonzero(own.areas > 0)
        section[has_loop] *= np.sqrt(areas[has_loop] / own.areas[has_loop])
        return inscribed, section

    def _round(self, number: int) -> _Round:
        if number not in self._known:
            one = self.channels[number]
            ways = Line(one.points).directions
            which = np.flatnonzero(np.isfinite(one.inscribed) & (one.inscribed > 0))
            diameters = one.inscribed[which]
            wall = followed_wall(self._wall, one.points[which], ways[which], diameters)
            points = self._surface.points
            loops = section_loops(points, self._surface.triangles, one.points, ways)
            areas = loops.areas(points, one.points, ways)
            self._known[number] = _Round(which, wall, loops, areas)
        return self._known[number]


def _is_same(one: Channel, other: Channel) -> bool:
    columns = ("points", "inscribed", "section")
    return all(
        np.array_equal(getattr(one, name), getattr(other, name), equal_nan=True) for name in columns
    )


def _joined(rounds: Sequence[_Round], counts: Sequence[int]) -> _Round:
    """Wall and sections round all channels, one after the other, of so many stations each."""
    first = np.cumsum([0, *counts])
    spheres = np.cumsum([0, *(len(one.which) for one in rounds)])
    nodes = np.cumsum([0, *(len(one.loops.station) for one in rounds)])
    walls = [one.wall for one in rounds]
    loops = [one.loops for one in rounds]
    return _Round(
        _shifted([one.which for one in rounds], first),
        FollowedWall(
            _shifted([one.station for one in walls], spheres),
            np.concatenate([one.point for one in walls]),
            InscribedSpheres(
                np.concatenate([one.spheres.centers for one in walls]),
                np.concatenate([one.spheres.radii for one in walls]),
            ),
        ),
        SectionLoops(
            _shifted([one.station for one in loops], first),
            np.concatenate([one.ends for one in loops]),
            np.concatenate([one.fraction for one in loops]),
            _shifted([one.following for one in loops], nodes),
        ),
        np.concatenate([one.areas for one in rounds]),
    )


def _shifted(columns: Sequence[Indices], by: Indices) -> Indices:
    return np.concatenate([one + first for one, first in zip(columns, by, strict=False)])


def _filled(values: Floats) -> Floats:
    """Values (n,), where they are NaN those between the next ones; NaN where all are."""
    known = np.flatnonzero(np.isfinite(values))
    return np.interp(np.arange(len(values)), known, values[known]) if len(known) else values


def _moves(before: Centerline, after: Centerline) -> dict[int, tuple[Floats, Points]]:
    """The branches that have moved, and how far each of their points has, by arc lengths (k,)."""
    moved = (before.points != after.points).any(axis=1)
    return {
        number: (
            Line(before.points[nodes]).arc_lengths,
            after.points[nodes] - before.points[nodes],
        )
        for number, nodes in enumerate(before.branches)
        if moved[nodes].any()
    }


def _carried(channel: Channel, moves: dict[int, tuple[Floats, Points]]) -> Points:
    """Stations (n, 3) of a channel on the moved centerline, mm."""
    places = channel.points
    for number in moves.keys() & channel.branch.tolist():
        own, (at, shifts) = channel.branch == number, moves[number]
        shift = [np.interp(channel.branch_along, at, column) for column in shifts.T]
        places = np.where(own[:, None], places + np.column_stack(shift), places)
    return places


def _along(line: Points, channel: Channel) -> Floats:
    """Arc lengths (n,) along stations that may have moved, from where the channel began."""
    if np.array_equal(line, channel.points):
        return channel.along
    return np.asarray(channel.along[0] + Line(line).arc_lengths)
