"""Development of the velocity profile along a tree: an even core, and a layer at the wall.

Formulas and their sources: docs/flow.md.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..geometry import dot, norm
from ..validation import Floats
from .channels import Channel, Widths

THIN = 0.05
"""The least part of the radius: layers are taken for as thick at least, for the friction of thinner
ones has no bounds."""

BENT = 11.6
"""White (1929): from this Dean number on a bend costs more than a straight tube."""


_DEAN = np.log([BENT, 20, 50, 100, 200, 400, 800, 1600])
_COILED = np.array([2.0, 1.969, 1.813, 1.690, 1.597, 1.526, 1.475, 1.421])
"""Energy of the developed profile in a coil over that of an even one, by the logarithm of Dean's
number: Dean's equations solved by finite elements (docs/flow.md)."""


class ChannelStations(NamedTuple):
    """The stations of all channels one after the other."""

    starts: list[int]
    """(n + 1,) where those of each channel begin, and the end."""
    feeds: list[list[tuple[int, float]]]
    """Channels at whose ends each begins, with the shares of the blood that comes there."""
    step: Floats
    """(m,) from each station to the next one, m; 0 at the end of a channel."""


def way_of(channels: Sequence[Channel], flow: Floats) -> ChannelStations:
    """Stations of channels, in an order in which each follows those that bring its blood; flows
    (n,) through them."""
    along = 1e-3 * np.concatenate([one.along for one in channels])
    starts = np.cumsum([0, *(len(one.along) for one in channels)])
    last = starts[1:] - 1
    step = np.diff(along, append=0.0)
    step[last] = 0.0
    return ChannelStations(starts.tolist(), list(_feeds(channels, flow.tolist())), step)


def _feeds(channels: Sequence[Channel], flow: Sequence[float]) -> Iterator[list[tuple[int, float]]]:
    """The feeding channels, as `ChannelStations` has them."""
    for one in channels:
        if one.also:
            which = (one.above, *one.also)
            coming = sum(flow[number] for number in which)
            yield [(number, flow[number] / coming) for number in which]
        else:
            yield [(one.above, 1.0)] if one.above >= 0 else []


def bends_of(channels: Sequence[Channel], widths: Sequence[Widths]) -> Floats:
    """Curvature (m,) at all stations of the way that blood has come there, 1/m.

    Between the last diameter of it and the one before: blood turns over in a bend within about so
    much. Less of the way is known near the root, which is taken for straight.
    """
    # By channel, arc lengths and points from the root to its end.
    ways: list[tuple[Floats, Floats]] = []
    found = []
    for channel, size in zip(channels, widths, strict=True):
        along, points = channel.along, channel.points
        if channel.above >= 0:
            before, at = ways[channel.above]
            along = np.concatenate([before[:-1], along])
            points = np.concatenate([at[:-1], points])
        diameter = 2 * np.sqrt(size.area / np.pi)
        middle, start = (
            np.column_stack([np.interp(channel.along - k * diameter, along, x) for x in points.T])
            for k in (1, 2)
        )
        last, first = channel.points - middle, middle - start
        both = norm(last) * norm(first)
        is_known = (channel.along - 2 * diameter >= along[0]) & (both > 0)
        cosine = dot(last, first) / np.where(is_known, both, 1.0)
        angle = np.where(is_known, np.arccos(np.clip(cosine, -1, 1)), 0.0)
        found.append(1e3 * angle / diameter)
        ways.append((along, points))
    return np.concatenate(found)


class Profile(NamedTuple):
    """A profile of a core and a parabola in the layer at the wall, as Schiller has it."""

    core: Floats
    """Speed of the core over the mean one."""
    energy: Floats
    """Flow of energy over that of an even profile."""
    friction: Floats
    """Friction over that of a developed profile."""


def profile_of(layer: Floats) -> Profile:
    """The profile by the thickness of the layer over the radius (n,)."""
    core = 1 / (1 - 2 / 3 * layer + layer**2 / 6)
    energy = (1 - 38 / 35 * layer + 47 / 140 * layer**2) * core**3
    thick = np.maximum(layer, THIN)
    return Profile(core, energy, core**2 * (4 - thick) / (12 * thick))


def _rates() -> tuple[list[float], list[float]]:
    """Growth of the square of a layer, by thousandths of the radius.

    With the core's speed c over the mean one, and the flow of momentum m over that of an even
    profile, the balance of momentum over a section is
    (c c' - m') dt = 4 pi spread c / t dx + (c^2 - m) d(log area):
    a factor for 4 pi spread dx, and a power of the area.
    """
    t = np.maximum(np.linspace(0, 1, 1001), 1e-3)
    c = 1 / (1 - 2 / 3 * t + t**2 / 6)
    even = 1 - 14 / 15 * t + 4 / 15 * t**2
    steeper = (2 / 3 - t / 3) * c**2
    left = c * steeper - (8 / 15 * t - 14 / 15) * c**2 - 2 * even * c * steeper
    return (2 * c / left).tolist(), (2 * c**2 * (1 - even) / (t * left)).tolist()


_GROWS, _WIDENS = _rates()


def deans_of(area: Floats, spread: Floats, bends: Floats) -> Floats:
    """Dean's numbers (m,); `area` and `spread` as of `layers_of`, `bends` as of `bends_of`."""
    radius = np.sqrt(area / np.pi)
    return np.asarray(2 / (np.pi * radius * spread) * np.sqrt(radius * bends))


def swept_of(way: ChannelStations, area: Floats, layer: Floats, dean: Floats) -> Floats:
    """Energy of profiles (m,) that is lost in bends from each station to the next one.

    Over the density and the square of the flow, 1/m^4. Blood that is swept across the vessel loses
    what its profile has more than a developed one in such a bend.
    """
    at, to = slice(None, -1), slice(1, None)
    # A vessel that narrows thins the layer without a loss.
    power = np.take(_WIDENS, (1000 * layer[at]).astype(int)) * np.diff(np.log(area))
    widened = np.minimum(layer[at] * np.exp(power / 2), 1.0)
    least = np.interp(np.log(np.maximum(dean[at], BENT)), _DEAN, _COILED)
    energy = (profile_of(one).energy for one in (widened, layer[to]))
    before, after = (np.maximum(one, least) for one in energy)
    lost = np.where(way.step[at] > 0, np.maximum(before - after, 0.0), 0.0)
    return np.append(lost / (2 * area[to] ** 2), 0.0)


def layers_of(
    way: ChannelStations, area: Floats, spread: Floats, dean: Floats | float = 0.0
) -> Floats:
    """Thickness of the layer over the radius (m,); into the tree blood comes developed.

    Parameters
    ----------
    way : ChannelStations
    area : ndarray (m,)
        m^2.
    spread : ndarray (m,)
        The kinematic viscosity over the flow, 1/m.
    dean : ndarray (m,), optional
        As of `deans_of`; straight vessels without.
    """
    # As plain numbers: one station after the other.
    swept = (np.broadcast_to(dean, area.shape) / BENT).tolist()
    steps = (4 * np.pi * spread * way.step).tolist()
    growth = np.diff(np.log(area), append=0.0).tolist()
    found: list[float] = []
    for (start, end), feeds in zip(pairwise(way.starts), way.feeds, strict=True):
        each = [share * found[way.starts[above + 1] - 1] for above, share in feeds]
        found.append(sum(each) if each else 1.0)
        square = found[-1] ** 2
        for k in range(start, end - 1):
            at = int(1000 * found[k])
            # It grows while the vessel widens it and a bend sweeps it away, over the whole step.
            grown = steps[k] * _GROWS[at]
            power = _WIDENS[at] * growth[k] - grown * swept[k]
            during = math.expm1(power) / power if power else 1.0
            square = square * math.exp(power) + grown * during
            if square > 1.0:
                square = 1.0
            found.append(math.sqrt(square))
    return np.array(found)
