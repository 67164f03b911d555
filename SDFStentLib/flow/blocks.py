"""What a stretch of vessel costs: friction, inertia, and the jet that a narrowing leaves behind.

Formulas and their sources: docs/flow.md.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..validation import Floats
from .blood import Blood
from .channels import Channel, Widths
from .integral import integral_to

MIXING = 8.0
"""Diameters of the vessel within which a jet loses all but 1/e of what it is faster than the mean:
the jets of steady laminar flow behind two narrowings of known shape mix so (docs/flow.md)."""


class Method(NamedTuple):
    """What is taken for given in the equations, how far to be wrong in `answer.UNCERTAIN`."""

    blood: Blood = Blood()
    loss: float = 1.0
    """Times the loss of a jet that mixes, by Borda and Carnot."""
    power: float = 7 / 3
    """Flow to an outlet goes with its diameter to this power, where nothing tells more."""
    wider: float = 0.0
    """By so much all diameters are larger, mm."""


class Block(NamedTuple):
    """The shape of one vessel of the network, in SI units; the arrays (n,) are along its stations.

    By a method it loses `resistance * Q + stenosis * Q * abs(Q)` of the total pressure, and
    `inertance * dQ/dt` comes to it (`Network`).
    """

    friction: Floats
    """Resistance from its start to each station, over the viscosity, 1/m^3."""
    mixing: Floats
    """Loss of jets from its start to each station, over density and loss of a method, 1/m^4."""
    jet: Floats
    """Speed of the fastest blood over the flow, 1/m^2; 1 / area where there is no jet."""
    area: Floats
    """m^2."""
    slenderness: float
    """Inertance over the density, 1/m."""
    length: float
    """m."""


def outlets_of(channels: Sequence[Channel]) -> list[int]:
    """The channels that end at an outlet."""
    inner = {one.above for one in channels}
    return [number for number in range(len(channels)) if number not in inner]


def outlet_diameters(channels: Sequence[Channel], widths: Sequence[Widths]) -> Floats:
    """Equivalent diameters (k,) of the last sections before the outlets, mm."""
    found = []
    for number in outlets_of(channels):
        known = np.flatnonzero(np.isfinite(channels[number].section))
        last = known[-1] if len(known) else -1
        found.append(2 * float(np.sqrt(widths[number].area[last] / np.pi)))
    return np.array(found)


def shares_of(channels: Sequence[Channel], weights: Floats) -> Floats:
    """By channel (n,) the share of the outlets' weights (k,) to which it leads."""
    shares = np.zeros(len(channels))
    shares[outlets_of(channels)] = weights / weights.sum()
    # Those above come before those below.
    for number in reversed(range(len(channels))):
        if channels[number].above >= 0:
            shares[channels[number].above] += shares[number]
    return shares


class Blocks(NamedTuple):
    """The blocks of a tree, and what they were made of."""

    blocks: tuple[Block, ...]
    widths: tuple[Widths, ...]


def blocks_of(
    channels: Sequence[Channel],
    widths: tuple[Widths, ...],
    shares: Floats,
    wider: float = 0.0,
    before: Blocks | None = None,
) -> Blocks:
    """The blocks of a tree.

    Parameters
    ----------
    channels, widths : sequences
    shares : (n,) array
        Of the flow, which a jet needs to be known by where it comes into a branch.
    wider : float
        By which all diameters are larger, mm.
    before : Blocks, optional
        Those of other widths, all else alike: where a channel has the same and the same jet comes
        in, its block is the same value.
    """
    found: list[Block] = []
    for number, (channel, size) in enumerate(zip(channels, widths, strict=True)):
        above = channel.above
        share = float(shares[number] / shares[above]) if above >= 0 else 1.0
        excess = _excess(found, above, share)
        if (
            before is not None
            and size is before.widths[number]
            and excess == _excess(before.blocks, above, share)
        ):
            found.append(before.blocks[number])
            continue
        x = 1e-3 * (channel.along - channel.along[0])
        found.append(_block(x, size.widened(wider) if wider else size, excess))
    return Blocks(tuple(found), widths)


def _excess(blocks: Sequence[Block], above: int, share: float) -> float:
    """By how much a jet that comes in is faster than the mean, 1/m^2.

    Blood that turns into branches slows down without loss; a jet goes on as it is.
    """
    return 0.0 if above < 0 else float(blocks[above].jet[-1] - 1 / blocks[above].area[-1]) / share


def _block(x: Floats, size: Widths, excess: float) -> Block:
    """Of ellipses at places (n,), m; a jet comes in that is faster than the mean, 1/m^2."""
    b, a = 0.5e-3 * size.narrow, 0.5e-3 * size.wide
    area = np.pi * a * b
    jets = _jets(x, area, excess)
    # Over a step the excess over the mean changes from one end's to the other's.
    faster, slowed = jets - 1 / area, np.maximum(jets[:-1] - jets[1:], 0.0)
    mixed = np.zeros(len(x))
    np.cumsum(slowed * (faster[1:] + faster[:-1]) / 2, out=mixed[1:])
    friction = 4 * (a**2 + b**2) / (np.pi * (a * b) ** 3)
    return Block(
        friction=integral_to(friction, x),
        mixing=mixed,
        jet=jets,
        area=area,
        slenderness=float(integral_to(1 / area, x)[-1]),
        length=float(x[-1] - x[0]),
    )


def _jets(x: Floats, area: Floats, excess: float) -> Floats:
    """Speed of a jet over the flow (n,): as fast as the mean at least, and slowing to it."""
    mean = 1 / area
    kept = np.exp(-np.diff(x) / (MIXING * np.sqrt(4 * area[1:] / np.pi))).tolist()
    # As plain numbers: a few stations at a time.
    means = mean.tolist()
    jet = means[0] + excess
    jets = [jet]
    for k, share in enumerate(kept):
        jet = means[k + 1] + max(jet - means[k + 1], 0.0) * share
        jets.append(jet)
    return np.array(jets)
