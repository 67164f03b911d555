"""Pressure drop over a part of a tree, such as that along a lesion or a stent."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..geometry import closest_on_segments
from ..validation import Flags, Floats, Points
from .channels import Channel
from .network import Network


class BlockPart(NamedTuple):
    """A part of one block, by its stations and what lies between two of them."""

    block: int
    start: float
    """Station, counted from 0."""
    end: float


class Drop(NamedTuple):
    """A drop of pressure over a part of a vessel, Pa."""

    recovered: float
    """The drop of the total pressure, with what the jet that leaves the part will still lose. What
    a jet that comes in would lose anyway is of the narrowing before; a part that spares some of
    that costs nothing."""
    maximal: float
    """The drop of the static pressure from where blood comes in to its lowest place, no less than
    the recovered one: a fast stream at the start, as in front of an ostium, has a lower pressure
    there already."""


class Part(NamedTuple):
    """A part of a vessel whose drop is wanted."""

    name: str
    line: Points
    """(n, 3) along it, in either direction, mm; where its ends are on different branches, to the
    farther one."""
    before: float = 0.0
    """The length by which it begins earlier, mm: a narrowing at an ostium begins in the vessel
    above."""


class Ways:
    """The lines of a tree's channels, prepared for questions about parts of it."""

    def __init__(self, channels: Sequence[Channel]) -> None:
        self._channels = channels
        counts = [len(one.points) - 1 for one in channels]
        self._starts = np.concatenate([one.points[:-1] for one in channels])
        self._ends = np.concatenate([one.points[1:] for one in channels])
        self._channel = np.repeat(np.arange(len(channels)), counts)
        self._station = np.concatenate([np.arange(count) for count in counts])
        self._known: dict[tuple[bytes, float], tuple[BlockPart, ...]] = {}

    def pieces_along(self, line: Points, before: float = 0.0) -> tuple[BlockPart, ...]:
        """The way in the tree between the places that are nearest to both ends of a line.

        From the root's side on, and from `before` mm earlier, as of `Part`.
        """
        ends = line[[0, -1]]
        key = ends.tobytes(), before
        if key not in self._known:
            self._known[key] = self._pieces(ends, before)
        return self._known[key]

    def pieces_to(self, place: Points) -> tuple[BlockPart, ...]:
        """Way of the blood from an inlet to the place nearest to a point (3,)."""
        ((last, stop),) = self._nearest(slice(None), place[None])
        *way, _ = self._way(last, last)
        whole = (BlockPart(one, 0.0, len(self._channels[one].points) - 1.0) for one in way)
        return (*whole, BlockPart(last, 0.0, stop))

    def direction_at(self, piece: BlockPart) -> Points:
        """Direction (3,) of the channel at the end of a piece; unit length."""
        line = self._channels[piece.block].points
        number = min(int(piece.end), len(line) - 2)
        step = line[number + 1] - line[number]
        return np.asarray(step / np.linalg.norm(step))

    def _pieces(self, ends: Points, before: float) -> tuple[BlockPart, ...]:
        found = self._nearest(slice(None), ends)
        if self._is_behind(*found):
            ends, found = ends[::-1], found[::-1]
        last, stop = found[1]
        way = self._way(found[0][0], last)
        ((first, start),) = self._nearest(np.isin(self._channel, way), ends[:1])
        root = float(self._channels[way[0]].along[0])
        at = max(self._from_root((first, start)) - before, root)
        # Ends: at the root at the latest.
        while self._channels[first].along[0] > at and first != way[0]:
            first = way[way.index(first) - 1]
            start = len(self._channels[first].points) - 1.0
        along = self._channels[first].along
        start = min(start, float(np.interp(at, along, np.arange(len(along)))))
        way = way[way.index(first) :]
        return tuple(
            BlockPart(
                number,
                start if number == first else 0.0,
                stop if number == last else len(self._channels[number].points) - 1.0,
            )
            for number in way
        )

    def _is_behind(self, one: tuple[int, float], other: tuple[int, float]) -> bool:
        """Whether blood comes to the second of two places before it comes to the first."""
        if one[0] != other[0]:
            if one[0] in self._before(other[0]):
                return False
            if other[0] in self._before(one[0]):
                return True
        return self._from_root(one) > self._from_root(other)

    def _before(self, number: int) -> dict[int, int]:
        """Next channel on the way to one, by the number of each that brings it blood."""
        onward = {number: number}
        waiting = [number]
        # Ends: every channel waits once.
        while waiting:
            one = waiting.pop(0)
            channel = self._channels[one]
            for feeder in (channel.above, *channel.also):
                if feeder >= 0 and feeder not in onward:
                    onward[feeder] = one
                    waiting.append(feeder)
        return onward

    def _way(self, first: int, last: int) -> list[int]:
        """Channels from an inlet to the last one, through the first where that brings it blood."""
        onward = self._before(last)
        way = [first if first in onward else last]
        # Ends: at the last channel.
        while way[-1] != last:
            way.append(onward[way[-1]])
        # Ends: at an inlet.
        while (above := self._channels[way[0]].above) >= 0:
            way.insert(0, above)
        return way

    def _nearest(self, among: slice | Flags, places: Points) -> list[tuple[int, float]]:
        """The channels that come nearest to some places, and at which station."""
        at = closest_on_segments(self._starts[among], self._ends[among], places)
        channel, station = self._channel[among][at.segments], self._station[among][at.segments]
        return list(zip(channel.tolist(), (station + at.fractions).tolist(), strict=True))

    def _from_root(self, place: tuple[int, float]) -> float:
        number, station = place
        along = self._channels[number].along
        return float(np.interp(station, np.arange(len(along)), along))


def drop_over(pieces: Sequence[BlockPart], network: Network, flow: Floats) -> Drop:
    """The drop over a part of a vessel at some flows (n,) through the blocks, m^3/s."""
    return Drop(*drops_over(pieces, [network], flow[None])[0].tolist())


def drops_over(pieces: Sequence[BlockPart], networks: Sequence[Network], flows: Floats) -> Floats:
    """The fields of `Drop` (c, 2) in networks of one tree at flows (c, n) through their blocks.

    Flow that runs back costs what the same flow forward does, with the other sign, as it does in
    the network.
    """
    # Which way most of it runs in the part.
    sense = np.where(flows[:, [one.block for one in pieces]].sum(axis=1) < 0, -1.0, 1.0)[:, None]
    flows = sense * flows
    methods = [one.method for one in networks]
    given = [(*one.blood, one.loss, one.divided, one.turned, one.bent) for one in methods]
    density, viscosity, loss, divided, turned, bent = np.array(given).T[..., None]
    total, static, left = np.zeros((len(networks), 1)), [], []
    for number, start, end in pieces:
        blocks, q = [one.blocks[number] for one in networks], flows[:, [number]]
        friction, mixing, dividing, bending, taken, jet, area = (
            np.stack([getattr(one, name) for one in blocks])
            for name in ("friction", "mixing", "dividing", "bending", "taken", "jet", "area")
        )
        # What moves across is lost behind the first station.
        turning = np.array([[one.turning] for one in blocks]) * (friction > 0)
        mixing = loss * mixing + divided * dividing + turned * turning + bent * bending
        friction, mixing, taken, jet, area = (
            _between(values, start, end) for values in (friction, mixing, taken, jet, area)
        )
        resisted = viscosity * (friction - friction[:, :1])
        mixed = density * (mixing - mixing[:, :1]) * np.abs(q)
        lost = (resisted + mixed) * q
        static.append(total + lost + density / 2 * (q * jet) ** 2)
        total = total + lost[:, -1:]
        of_jets = density * (loss + (divided - loss) * taken[:, [0, -1]])
        left.append(_left_in_jets(jet[:, [0, -1]], area[:, [0, -1]], q, density, of_jets))
        if number != pieces[-1].block:  # what a jet loses where its blood meets other
            beyond = np.array([[one.beyond] for one in blocks])
            total = total + of_jets[:, 1:] * beyond * np.abs(q) * q
    below = np.hstack(static)
    at_ends = left[-1][:, 1:] - left[0][:, :1]
    recovered = np.maximum(total + at_ends, np.minimum(total, 0.0))
    lowest = (below - below[:, :1]).max(axis=1, keepdims=True)
    return sense * np.hstack([recovered, np.maximum(lowest, recovered)])


def _between(values: Floats, start: float, end: float) -> Floats:
    """Values (c, n) at a start, at the stations between it and an end, and there."""
    inner = values[:, int(start) + 1 : math.ceil(end)]
    return np.column_stack([_at(values, start), inner, _at(values, end)])


def _at(values: Floats, station: float) -> Floats:
    number = min(int(station), values.shape[1] - 2)
    share = station - number
    return np.asarray((1 - share) * values[:, number] + share * values[:, number + 1])


def _left_in_jets(jet: Floats, area: Floats, flow: Floats, density: Floats, lost: Floats) -> Floats:
    """Pressure (c, 2) that jets at two stations will lose where the vessel goes on as wide, Pa.

    Less what the dead water round it spares of the friction there.
    """
    settled = np.minimum(math.sqrt(2) / area, jet)
    # Poiseuille's friction on what stands, 1 - a / A, while the jet widens (`blocks.STANDS`).
    share = settled / jet
    widening = 2 / 3 * (1 - share**2) - 10 / 3 * (1 - share) - 2 * np.log(share)
    spared = density * (np.abs(flow) / area) * (flow / area) * widening
    excess = flow * (jet - settled)
    return np.asarray(lost / 2 * (excess * np.abs(excess)) - spared)
