"""Losses in a stretch of vessel: friction, inertia, turns, and the jet behind a narrowing.

Formulas and their sources: docs/flow.md.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from ..validation import Floats
from .channels import OBLONG, Channel, Widths, meeting_of, outlets_of
from .profiles import ChannelStations, deans_of, layers_of, profile_of, swept_of, way_of
from .sharp_bends import NONE, SharpBends

PASCAL_PER_MMHG = 133.322
PER_ML = 1e-6
"""Cubic meters in a milliliter."""


class Blood(NamedTuple):
    """Blood of an adult at the shear of large vessels, the values of the SimVascular examples."""

    density: float = 1060.0
    """kg/m^3."""
    viscosity: float = 0.004
    """Pa s."""


ADULT = Blood()

PARTS = -0.09
"""Thwaites: a laminar layer of momentum thickness d parts from a wall along which the core of speed
u slows by more than so many viscosities over d^2."""

SETTLES = 26.4
"""Sparrow et al.: a profile settles as exp(-SETTLES nu x / (u r^2)), the square of the first root
of the Bessel function J2. So does blood that goes into a branch, along the wall there."""

STANDS = math.sqrt(8) / 3
"""Constant of a jet: parted from the wall it goes on as a parabola of area a among blood that
stands. By the balances of momentum and energy in a vessel of area A it widens as (2 / a - 4 / (3
A)) da = 8 pi nu / Q dx. Its speed over the flow is sqrt(2) / a; with that 2 a / (3 A) is STANDS /
(A speed)."""

SETTLED = math.sqrt(2) / STANDS
"""Times `STANDS` over the area, the speed over the flow of a settled jet."""

TURNS = 0.75
"""Hager, Mynard: part of the angle of a branch by which blood that goes into it is turned."""


class Method(NamedTuple):
    """Assumptions of the equations; how far they may be wrong is in `seen.UNCERTAIN`."""

    blood: Blood = Blood()
    loss: float = 1.0
    """Factor of the loss of a jet that mixes."""
    power: float = 7 / 3
    """Exponent of an outlet's diameter to which its flow is proportional, where nothing tells
    more."""
    wider: float = 0.0
    """The length by which all diameters are larger, mm."""
    divided: float = 1.0
    """Factor of the loss of blood that a branch takes over faster than it flows there."""
    turned: float = 0.5
    """Part of the speed's energy across a branch that is lost: all at sharp corners."""
    bent: float = 0.0
    """Factor of what sharp bends may lose beside friction."""

    def toward(self, other: Method, part: float) -> Method:
        """A part of the way to another method."""
        (*_, viscosity), *own = self
        (*_, to), *others = other
        thick = self.blood._replace(viscosity=viscosity + part * (to - viscosity))
        return Method(thick, *(a + part * (b - a) for a, b in zip(own, others, strict=True)))


class Block(NamedTuple):
    """The shape of one vessel of the network, in SI units; the arrays (n,) are along its stations.

    By a method it loses `resistance * Q + stenosis * Q * abs(Q)` of the total pressure, and
    `inertance * dQ/dt` comes to it (`Network`).
    """

    friction: Floats
    """Resistance from its start to each station, over the viscosity, 1/m^3."""
    mixing: Floats
    """Loss of jets from its start to each station, over density and loss of a method, 1/m^4."""
    dividing: Floats
    """Loss of what it takes over from the vessel above, over density and `Method.divided`,
    1/m^4."""
    taken: Floats
    """Share of what it took over in what is faster than blood at the wall; 1 where it begins."""
    turning: float
    """Loss of the motion across where it begins, over density and `Method.turned`, 1/m^4."""
    bending: Floats
    """Loss of sharp bends from its start to each station, over density and `Method.bent`, 1/m^4."""
    jet: Floats
    """Even speed that would carry as much energy, over the flow, 1/m^2."""
    area: Floats
    """Area of the lumen, m^2."""
    beyond: float
    """Loss of the jet where it leaves an outlet, or meets others, as `mixing`."""
    slenderness: float
    """Inertance over the density, 1/m."""
    length: float
    """Length of the vessel, m."""


def outlet_diameter(channel: Channel, widths: Widths) -> float:
    """Equivalent diameter of the outlet at which a channel ends, or of its last section, mm."""
    known = np.flatnonzero(np.isfinite(channel.section))
    last = known[-1] if len(known) else -1
    tip = channel.tips[1]
    diameter = tip if np.isfinite(tip) else channel.section[last]
    # What is wider is the section of other vessels, too.
    return float(np.fmin(diameter, OBLONG * widths.narrow[last]))


def turns_of(channels: Sequence[Channel], widths: Sequence[Widths]) -> Floats:
    """Angles (n,) of channels to the one above, each over a diameter of that, radians."""
    angles = np.zeros(len(channels))
    for number, channel in enumerate(channels):
        if channel.above >= 0:
            angles[number] = _turn(channels, widths, channel.above, channel)
    return angles


def other_turns(
    channels: Sequence[Channel], widths: Sequence[Widths]
) -> dict[int, tuple[float, ...]]:
    """Angles to the other channels that bring blood, for channels that have some, radians."""
    return {
        number: tuple(_turn(channels, widths, other, channel) for other in channel.also)
        for number, channel in enumerate(channels)
        if channel.also
    }


def _turn(
    channels: Sequence[Channel], widths: Sequence[Widths], above: int, channel: Channel
) -> float:
    line, along = channels[above].points, channels[above].along
    reach = float(np.sqrt(4 / np.pi * widths[above].area[-1]))
    before = min(int(np.searchsorted(along, along[-1] - reach)), len(along) - 2)
    behind = max(int(np.searchsorted(channel.along, channel.along[0] + reach)), 1)
    first = line[-1] - line[before]
    second = channel.points[min(behind, len(channel.points) - 1)] - channel.points[0]
    both = np.sqrt((first @ first) * (second @ second))
    return float(np.arccos(np.clip((first @ second) / both, -1, 1)))


class Stream(NamedTuple):
    """The usual flow through a tree, which shapes the profiles in it."""

    flow: Floats
    """(n,) through the channels, m^3/s."""
    turns: Floats
    """(n,) as of `turns_of`."""
    bends: Floats
    """(m,) as of `bends_of`."""
    others: Mapping[int, Sequence[float]] = MappingProxyType({})
    """Angles as of `other_turns`."""
    sharp: SharpBends = NONE
    """Sharp bends as of `sharp_bends`."""


def blocks_of(
    channels: Sequence[Channel], widths: Sequence[Widths], stream: Stream, wider: float = 0.0
) -> tuple[Block, ...]:
    """The blocks of a tree.

    Parameters
    ----------
    channels, widths : sequences
    stream : Stream
    wider : float
        Length by which all diameters are larger, mm.
    """
    size = Widths(*(np.concatenate(axis) for axis in zip(*widths, strict=True))).widened(wider)
    b, a = 0.5e-3 * size.narrow, 0.5e-3 * size.wide
    area = np.pi * a * b
    radius = np.sqrt(area / np.pi)
    way = way_of(channels, stream.flow)
    # The kinematic viscosity over the flow, 1/m.
    spread = np.repeat(ADULT.viscosity / ADULT.density / stream.flow, np.diff(way.starts))
    dean = deans_of(area, spread, stream.bends)
    layer = layers_of(way, area, spread, dean)
    profile = profile_of(layer)
    attached = np.sqrt(profile.energy) / area
    # Blood parts from the inner wall of a bend, to which that sweeps the layer of the outer one.
    inner = layers_of(way, area, spread)
    momentum = (4 / 15 - inner / 10) * inner / 2 * radius
    slowing = np.diff(profile.core / area, append=0.0)
    clings = _clings(momentum**2 * slowing, PARTS * spread * way.step)
    jets = _jets(way, (attached, clings, np.pi * spread * way.step, STANDS / area), stream)
    jet = jets.jet
    turning = _across(way, jet, radius, stream, meeting_of(channels)).tolist()
    station, part, behind = stream.sharp
    at_each = np.bincount(behind, part * jet[station] ** 2 / 2, len(jet))
    bent = np.cumsum(at_each, dtype=np.float64)
    # The wall rubs against what moves along it: not against the dead water round a jet.
    friction = 4 * (a**2 + b**2) / (np.pi * (a * b) ** 3) * profile.friction * attached / jet
    swept = swept_of(way, area, layer, dean) * attached / jet
    swept = np.append(0.0, np.cumsum(swept[:-1]))
    resisted, slender = (_summed(way.step, values) for values in (friction, 1 / area))
    resisted, bent, swept = (_from_starts(way, values) for values in (resisted, bent, swept))
    ends = {*outlets_of(channels), *meeting_of(channels)}
    return tuple(
        Block(
            friction=resisted[start:end],
            mixing=jets.mixing[start:end] + swept[start:end],
            dividing=jets.dividing[start:end],
            taken=jets.taken[start:end],
            turning=turning[number],
            bending=bent[start:end],
            jet=jet[start:end],
            area=area[start:end],
            beyond=max(jet[end - 1] - math.sqrt(2) / area[end - 1], 0.0) ** 2 / 2
            if number in ends
            else 0.0,
            slenderness=float(slender[end - 1] - slender[start]),
            length=float(way.step[start : end - 1].sum()),
        )
        for number, (start, end) in enumerate(pairwise(way.starts))
    )


def _from_starts(way: ChannelStations, values: Floats) -> Floats:
    """Values (m,) less those where their channels begin."""
    return np.asarray(values - np.repeat(values[way.starts[:-1]], np.diff(way.starts)))


def _summed(step: Floats, values: Floats) -> Floats:
    """Integral of values (n,) to each place, by trapezoids."""
    return np.append(0.0, np.cumsum(step[:-1] * (values[1:] + values[:-1]) / 2))


def _clings(slowing: Floats, parts: Floats) -> Floats:
    """The share (m,) of the way to the next station over which blood stays at the wall.

    It parts where `slowing` over `parts` passes 1. That goes evenly from one station to the next
    one, or a jet would be as wide as the next station is, wherever that lies.
    """
    over = np.divide(slowing, parts, out=np.zeros_like(parts), where=parts < 0)
    rise = np.maximum(np.append(over[1:], 0.0) - over, 1e-9)
    return np.clip((1 - over) / rise, 0.0, 1.0)


class _Jets(NamedTuple):
    """Jets at all stations (m,), as `Block` has them."""

    jet: Floats
    mixing: Floats
    dividing: Floats
    taken: Floats


def _jets(
    way: ChannelStations, parts: tuple[Floats, Floats, Floats, Floats], stream: Stream
) -> _Jets:
    """Jets along all channels.

    `parts` are the speed (m,) attached to the wall, over which share of the way to the next station
    it stays so, `pi nu / Q` times that way, and `STANDS` over the area.
    """
    even, clings, spread, stands = (column.tolist() for column in parts)
    flow, turns = stream.flow.tolist(), (TURNS * stream.turns).tolist()
    rows: list[tuple[float, float, float, float]] = []
    for number, (start, end) in enumerate(pairwise(way.starts)):
        ahead = 0.0
        angles = [turns[number], *(TURNS * one for one in stream.others.get(number, ()))]
        for (above, share), turn in zip(way.feeds[number], angles, strict=False):
            last = way.starts[above + 1] - 1
            jet = rows[last][0] if len(angles) == 1 else min(rows[last][0], SETTLED * stands[last])
            speed = jet * flow[above] / flow[number]
            ahead += share * (speed * math.cos(turn))
        # Faster than the wall's blood are what comes from above, and what has parted from the wall.
        brought, parted = max(ahead - even[start], 0.0), 0.0
        mixed = divided = 0.0
        rows.append((even[start] + brought, mixed, divided, 1.0))
        for k in range(start, end - 1):
            to = even[k + 1]
            slower = even[k] - to
            if slower > 0:
                # Where blood stands round a jet, as in this share of the section, none clings.
                parted += slower * (1 - clings[k] * even[k] / (even[k] + brought + parted))
            elif brought + parted > 0:  # the wall's blood overtakes both
                left = max(1 + slower / (brought + parted), 0.0)
                brought, parted = left * brought, left * parted
            excess = brought + parted
            taken = brought / excess if excess > 0 else 0.0
            if parted > 0:
                jet = to + parted
                jet *= math.exp(-4 * spread[k] / (1 - stands[k + 1] / jet))
                parted = max(jet - to, 0.0)
            brought *= math.exp(-SETTLES * spread[k])
            lost = (excess**2 - (brought + parted) ** 2) / 2
            mixed += (1 - taken) * lost
            divided += taken * lost
            rows.append((to + brought + parted, mixed, divided, taken))
    return _Jets(*np.array(rows).T)


def _across(
    way: ChannelStations, jet: Floats, radius: Floats, stream: Stream, meeting: Iterable[int]
) -> Floats:
    """Losses (n,) of the motion across where channels begin, as `Block.turning`.

    It is as fast as blood a radius before the end of the vessel above, if that is slower: nearer
    to it spheres may be as narrow as the ostium of another branch.
    """
    speeds = []
    for start, end in pairwise(way.starts):
        to_end = np.cumsum(way.step[start:end][::-1])[::-1]
        before = start + max(np.count_nonzero(to_end >= radius[end - 1]) - 1, 0)
        speeds.append(min(jet[before], jet[end - 1]))
    for number in meeting:
        last = way.starts[number + 1] - 1
        speeds[number] = min(speeds[number], math.sqrt(2) / (np.pi * radius[last] ** 2))
    above = [feeds[0][0] if feeds else -1 for feeds in way.feeds]
    share = stream.flow[above] / stream.flow
    found = (np.array(speeds)[above] * share * np.sin(TURNS * stream.turns)) ** 2 / 2
    for number, angles in stream.others.items():
        (_, most), *others = way.feeds[number]
        found[number] *= most
        for (other, part), turn in zip(others, angles, strict=True):
            speed = speeds[other] * stream.flow[other] / stream.flow[number]
            found[number] += part * (speed * math.sin(TURNS * turn)) ** 2 / 2
    return np.asarray(found)
