"""What a part of a tree costs, such as that along a lesion or a stent."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from ..geometry import closest_points
from ..validation import Floats, Points
from .blocks import Method
from .channels import Channel
from .network import Network


class Piece(NamedTuple):
    """A part of one block, by its stations and what lies between two of them."""

    block: int
    start: float
    """Station, counted from 0."""
    end: float


class Drop(NamedTuple):
    """Of pressure over a part of a vessel, Pa."""

    recovered: float
    """Of the total pressure, with what the jet that leaves the part will still lose."""
    maximal: float
    """Of the static pressure from its start to its lowest place."""


def pieces_along(channels: Sequence[Channel], line: Points) -> tuple[Piece, ...]:
    """The way in the tree between the places that are nearest to both ends of a line.

    Parameters
    ----------
    channels : sequence of Channel
    line : (n, 3) array
        Along a vessel, in either direction, mm.

    Returns
    -------
    tuple of Piece
        From the root's side on. Where the ends are on different branches, to the farther one.
    """
    ends = [_nearest(channels, range(len(channels)), end) for end in (line[0], line[-1])]
    if _from_root(channels, ends[0]) > _from_root(channels, ends[1]):
        line, ends = line[::-1], ends[::-1]
    last, stop = ends[1]
    way = [last]
    # Ends: at the root.
    while channels[way[0]].above >= 0:
        way.insert(0, channels[way[0]].above)
    first, start = _nearest(channels, way, line[0])
    way = way[way.index(first) :]
    return tuple(
        Piece(
            number,
            start if number == first else 0.0,
            stop if number == last else len(channels[number].points) - 1.0,
        )
        for number in way
    )


def drop_over(pieces: Sequence[Piece], network: Network, flow: Floats, method: Method) -> Drop:
    """The drop over a part of a vessel at some flows (n,) through the blocks, m^3/s."""
    density = method.blood.density
    total, static = 0.0, []
    for block_number, start, end in pieces:
        block, q = network.blocks[block_number], float(flow[block_number])
        inner = np.arange(np.floor(start) + 1, np.ceil(end))
        at = np.concatenate([[start], inner, [end]])
        friction, mixing, jet = (
            np.interp(at, np.arange(len(values)), values)
            for values in (block.friction, block.mixing, block.jet)
        )
        lost = (friction - friction[0] + (mixing - mixing[0]) * abs(q)) * q
        static.append(total + lost + density / 2 * (q * jet) ** 2)
        total += float(lost[-1])
    below = np.concatenate(static)
    left = [_left_in_jet(pieces[end], end, network, flow, method) for end in (0, -1)]
    return Drop(total + left[1] - left[0], float((below - below[0]).max()))


def _left_in_jet(piece: Piece, end: int, network: Network, flow: Floats, method: Method) -> float:
    """What a jet at one end of a part will lose where the vessel goes on as wide, Pa."""
    block, station = network.blocks[piece.block], piece[1 if end == 0 else 2]
    jet, area = (
        float(np.interp(station, np.arange(len(values)), values))
        for values in (block.jet, block.area)
    )
    q = float(flow[piece.block])
    return method.loss * method.blood.density / 2 * (q * (jet - 1 / area)) ** 2


def _nearest(channels: Sequence[Channel], among: Iterable[int], place: Floats) -> tuple[int, float]:
    """The channel that comes nearest to a place, and at which station."""
    found = [(number, closest_points(channels[number].points, place[None])) for number in among]
    number, at = min(found, key=lambda one: float(one[1].distances[0]))
    return number, float(at.segments[0] + at.fractions[0])


def _from_root(channels: Sequence[Channel], place: tuple[int, float]) -> float:
    number, station = place
    along = channels[number].along
    return float(np.interp(station, np.arange(len(along)), along))
