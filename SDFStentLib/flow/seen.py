"""States of a network at all the flows at which it is looked at, and what they are in the mean."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..validation import Floats
from .blocks import PASCAL_PER_MMHG
from .known import Known
from .network import Network, Outlets, State
from .outlets import Sides
from .spans import Piece, drops_over


class Case(NamedTuple):
    """A vessel's network and outlets by one method, before treatment."""

    network: Network
    outlets: Outlets


class Seen:
    """The networks of some cases at some flows into them; their states follow case by case."""

    def __init__(
        self, sides: Sides | None, networks: Sequence[Network], states: Sequence[State]
    ) -> None:
        self.usual = networks[0]
        self._shape = len(networks), len(states) // len(networks)
        self._networks = [one for one in networks for _ in range(self._shape[1])]
        self._flows = np.array([one.flow for one in states])
        self._drops: dict[tuple[Piece, ...], Floats] = {}
        into = self._flows[:, 0]
        # No shares yet: those of a moment at which blood stands still are none.
        aside = np.zeros((len(states), 2)) if sides is None else self._flows[:, sides.blocks]
        inlets = np.array([one.inlet for one in states]) / PASCAL_PER_MMHG
        self._head = np.column_stack([inlets, aside])
        self._into = into.reshape(self._shape)

    def _drop(self, pieces: tuple[Piece, ...]) -> Floats:
        """Over a part, of all states (c * t, 2), mmHg."""
        known = self._drops.get(pieces)
        if known is None:
            known = drops_over(pieces, self._networks, self._flows) / PASCAL_PER_MMHG
        return known

    def moments(
        self, known: Known, parts: Sequence[tuple[Piece, ...]], weights: Floats | None = None
    ) -> Floats:
        """By case, moment and quantity: inlet, both shares, and two drops for every part.

        Of a wave the first states, with weights (t,), make up the mean; without weights the states
        are those of even times of a cycle.
        """
        # Those of this answer are kept: lesions are asked for again, a stent elsewhere is not.
        self._drops = {pieces: self._drop(pieces) for pieces in parts}
        every = np.hstack([self._head, *map(self._drop, parts)]).reshape(*self._shape, -1)
        into = self._into
        if known.wave is not None:
            count = self._shape[1]
            weights = np.full(count, 1 / count) if weights is None else weights
            peak, cycle = int(np.argmax(into[0])), slice(len(weights))
            into = np.stack([into[:, cycle] @ weights, into[:, peak]], axis=1)
            averaged = np.einsum("ctq,t->cq", every[:, cycle], weights)
            every = np.stack([averaged, every[:, peak]], axis=1)
        # Of the flow to a side counts how much goes there in a cycle; the mean flow is positive.
        every[..., 1:3] /= into[..., None]
        return every
