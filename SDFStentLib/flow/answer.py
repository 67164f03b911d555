"""Pressures and flows before and after treatment, each as a value with a band."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ..validation import Floats, InputError, Place, as_place
from .blocks import PER_ML, Block, Method, Stream, blocks_of, other_turns, turns_of
from .channels import Channel, widths_of
from .course import LEAST, course_of, nodes_of, rough_flow, tip_diameters, tips_of
from .inlets import FROM_ROOT, Inlets
from .known import Known
from .network import Network, Outlets, SteadyFlow, steady, steady_states
from .outlets import (
    NOTHING_KNOWN,
    SideClues,
    Sides,
    fitted_outlets,
    outlet_shares,
    sides_of,
)
from .profiles import bends_of
from .seen import (
    UNCERTAIN,
    USUAL,
    Band,
    InletLoss,
    Moment,
    PossibleFlow,
    SeenFlow,
    SpanDrop,
    reach_of,
)
from .sharp_bends import sharp_bends
from .spans import Part, Ways
from .svzerod import NO_LEVEL, svzerod_document
from .tree import tree_between

HALVINGS = 6
"""Steps of the search in a range of which the known pressures allow a part."""

ROUNDS = 20
"""Rounds in which shares of limbs that meet again are found; five are enough, mostly."""

AGREES = 1e-6
"""The part of the flow by which the last round may change them."""

Solve = Callable[[Network, Outlets, Known], "tuple[Floats, Floats]"]
"""Inlet pressures (t,), Pa, and flows (t, n), m^3/s, through the blocks over a cycle."""


class FlowAnswer(NamedTuple):
    """Pressures and flows of a vessel before treatment, and after it if it was treated."""

    known: Known
    sides: Sides | None
    parts: tuple[str, ...]
    flows: dict[str, float]
    """mL/s by moment: `mean`, and `peak` where it is known."""
    before: dict[str, Moment]
    after: dict[str, Moment] | None
    networks: tuple[Network, ...]
    """Networks before, and after."""
    outlets: Outlets
    """Outlets, their resistances fitted before treatment and kept after it."""
    inlets: Inlets
    inflow: dict[str, tuple[float, ...]]
    """mL/s at each of several inlets, by moment."""
    limbs: tuple[Channel, ...]
    """Channels that part and meet again."""
    is_quasi_steady: bool
    """Whether a wave was taken as a row of steady flows."""

    def documents(self) -> list[dict[str, Any]]:
        """Networks as SimVascular's 0D solver reads them, before and after."""
        notice = "" if self.known.has_pressures else NO_LEVEL
        return [svzerod_document(one, self.outlets, self.known, notice) for one in self.networks]

    @property
    def right_place(self) -> Place | None:
        """A place in the right main branch, mm; None where it is not known."""
        if self.sides is None or not self.sides.is_known:
            return None
        return as_place(self.sides.places[1])


class FlowModel:
    """Vessel before treatment with fitted outlets; kept while stents are tried.

    Parameters
    ----------
    channels : sequence of Channel
    known : Known
    clues : SideClues
        Clues to the main branches; a place in the right one that is known comes first.
    inlets : Inlets

    Raises
    ------
    InputError
        Values that contradict each other, a split without two main branches, or an outlet without
        vessel.
    """

    def __init__(
        self,
        channels: Sequence[Channel],
        known: Known,
        clues: SideClues = NOTHING_KNOWN,
        inlets: Inlets = FROM_ROOT,
    ) -> None:
        if known.right is not None:
            clues = clues._replace(right=np.array(known.right))
        self.known, self._tree_channels, self._inlets = known, tuple(channels), inlets
        self._flows, self._weights = _flows(known, len(inlets.fractions))
        self._tree_widths = widths_of(channels)
        shares = self._usual_shares(clues)
        fractions = inlets.fractions
        flow = rough_flow(channels, self._tree_widths, fractions, PER_ML * known.mean, shares)
        self._blocks: dict[float, tuple[Block, ...]] = {}
        # Limbs that meet again share the flow by what they cost, and profiles by their shares.
        for _ in range(ROUNDS):
            self._follow(flow, clues)
            if not len(self._tree.chords):
                break
            usual = self._usual
            found = self._course.away(steady(*usual, PER_ML * known.mean).flow)
            if np.abs(found - flow).max() <= AGREES * PER_ML * known.mean:
                break
            flow = found
        self._wave_before: SeenFlow | None = None

    def _usual_shares(self, clues: SideClues) -> Floats:
        """The outlets' shares (k,) of the flow, in the order of the centerline's tree."""
        channels, widths = self._tree_channels, self._tree_widths
        if self._inlets.fractions.keys() >= {*tips_of(channels)}:
            raise InputError(
                "inlets: expected an end at which blood leaves, got none: all ends of the vessel "
                "are inlets or closed; leave one out."
            )
        tree = tree_between(nodes_of(channels), self._inlets.fractions)
        weights = tip_diameters(channels, widths, tree) ** USUAL.power
        sides = sides_of(channels, tree, weights, clues)
        if self.known.split_right is not None and not (sides and sides.is_known):
            raise InputError(
                "split to the right: expected a vessel of which the right branch is known, got one "
                "that tells no sides; name a place in the right branch",
                "right",
                end=", or leave the split out.",
            )
        return outlet_shares(weights, sides, self.known)

    def _follow(self, flow: Floats, clues: SideClues) -> None:
        """Channels along usual flows (n,) through those of the centerline, m^3/s."""
        self._course = course_of(self._tree_channels, flow, self._inlets.fractions)
        self._tree = self._course.tree
        self.channels, self._widths = self._course.along(self._tree_channels, self._tree_widths)
        self._ways = Ways(self.channels)
        self._diameters = tip_diameters(self.channels, self._widths, self._tree)
        self._sides = sides_of(self.channels, self._tree, self._diameters**USUAL.power, clues)
        # Profiles, and how a jet divides where vessels do, are those of the usual shares.
        least = LEAST * PER_ML * self.known.mean
        self._stream = Stream(
            np.maximum(np.abs(flow[list(self._course.order)]), least),
            turns_of(self.channels, self._widths),
            bends_of(self.channels, self._widths),
            other_turns(self.channels, self._widths),
            sharp_bends(self.channels, self._widths),
        )
        self._limbs = self._tree.limbs
        self._blocks.clear()
        self._usual = self._case(USUAL)

    @cached_property
    def _others(self) -> list[tuple[PossibleFlow, PossibleFlow]]:
        """Cases to both sides of the usual one."""
        return [(self._possible(low), self._possible(high)) for _, (low, high) in UNCERTAIN]

    def _possible(self, method: Method) -> PossibleFlow:
        """The case of a method, or of the farthest on the way to it that the known pressures allow.

        Where all of a range would cost more than they leave, the patient tells that not all of it
        is true.
        """
        try:
            return self._case(method)
        except InputError:
            found, near, far = self._usual, 0.0, 1.0
        for _ in range(HALVINGS):
            part = (near + far) / 2
            try:
                found, near = self._case(USUAL.toward(method, part)), part
            except InputError:
                far = part
        return found

    def _case(self, method: Method) -> PossibleFlow:
        weights, wider = self._diameters**method.power, method.wider
        if wider not in self._blocks:
            self._blocks[wider] = blocks_of(self.channels, self._widths, self._stream, wider)
        network = Network(self._blocks[wider], self._tree, method)
        outlets = fitted_outlets(network, weights, self._sides, self.known)
        return PossibleFlow(network, outlets)

    @cached_property
    def _cases(self) -> list[PossibleFlow]:
        """Possible flows of the model, the usual one first."""
        return [self._usual, *(case for pair in self._others for case in pair)]

    @cached_property
    def _before(self) -> SeenFlow:
        """Flow before treatment: the same for every stent that is tried."""
        return self._seen([case.network for case in self._cases])

    def _after(self, channels: Sequence[Channel]) -> SeenFlow:
        widths = widths_of(channels, (self._tree_channels, self._tree_widths))
        channels, widths = self._course.along(channels, widths)
        each = [case.network for case in self._cases]
        wider = dict.fromkeys(one.method.wider for one in each)
        known = self.channels, self._widths, self._stream.sharp
        stream = self._stream._replace(sharp=sharp_bends(channels, widths, known))
        blocks = {one: blocks_of(channels, widths, stream, one) for one in wider}
        return self._seen([one._replace(blocks=blocks[one.method.wider]) for one in each])

    def _seen(self, networks: Sequence[Network]) -> SeenFlow:
        """Networks by case at all flows into them, which are solved at once."""
        flows = [*(PER_ML * self._flows)]
        both = zip(self._cases, networks, strict=True)
        questions = [(one, case.outlets, q) for case, one in both for q in flows]
        return self._as_seen(networks, steady_states(questions))

    def _as_seen(self, networks: Sequence[Network], states: Sequence[SteadyFlow]) -> SeenFlow:
        return SeenFlow(self._sides, self._limbs, len(self._inlets.names), networks, states)

    def answer(
        self,
        after: Sequence[Channel] | None = None,
        parts: Sequence[Part] = (),
        solve: Solve | None = None,
    ) -> FlowAnswer:
        """Pressures and flows before treatment, and after it.

        Parameters
        ----------
        after : sequence of Channel, optional
            The channels in the treated vessel.
        parts : sequence of Part
        solve : callable, optional
            Solver of the network over a wave; without one its flows are taken as steady ones.
        """
        known, usual = self.known, self._usual
        solve = None if known.wave is None else solve
        ways = [self._ways.pieces_along(part.line, part.before) for part in parts]
        seen = [self._before] if after is None else [self._before, self._after(after)]
        told = np.stack([one.moments(known, ways, self._weights) for one in seen], axis=1)
        value = told[0]
        low, high = reach_of(told)
        networks = tuple(one.usual for one in seen)
        if solve is not None:
            solved = [self._solved(solve, one) for one in networks]
            value = np.concatenate([one.moments(known, ways) for one in solved])
        lowest = value - low
        # No part of a vessel gives back what is lost, unless blood runs back so much that it does
        # by one of the methods.
        floor = np.minimum(np.minimum(told.min(axis=0), value), 0.0)
        drops = 4 + len(self._limbs)
        lowest[..., drops:] = np.maximum(lowest[..., drops:], floor[..., drops:])
        spread = np.stack([value, lowest, value + high], axis=-1)
        names = {"mean": known.mean} | ({} if known.most is None else {"peak": known.most})
        moments = [dict(zip(names, map(self._moment, state), strict=True)) for state in spread]
        return FlowAnswer(
            known,
            self._sides,
            tuple(part.name for part in parts),
            names,
            moments[0],
            moments[1] if len(moments) > 1 else None,
            networks,
            usual.outlets,
            self._inlets,
            {name: self._inflow(name) for name in names},
            tuple(self.channels[number] for number in self._limbs),
            known.wave is not None and solve is None,
        )

    def _inflow(self, moment: str) -> tuple[float, ...]:
        """The flow at the inlets that have any, mL/s."""
        fractions = np.array([one for one in self._inlets.fractions.values() if one])
        if moment == "mean" or self._flows.ndim == 1:
            flow = self.known.mean if moment == "mean" else self._flows[-1]
            return tuple((flow * fractions).tolist())
        return tuple(self._flows[-1][: len(fractions)].tolist())

    def _solved(self, solve: Solve, network: Network) -> SeenFlow:
        """The solution over the wave; that before treatment is the same for every stent."""
        is_before = network is self._usual.network
        if is_before and self._wave_before is not None:
            return self._wave_before
        inlets, through = solve(network, self._usual.outlets, self.known)
        states = [SteadyFlow(*one) for one in zip(through, inlets.tolist(), strict=True)]
        solved = self._as_seen([network], states)
        if is_before:
            self._wave_before = solved
        return solved

    def _moment(self, row: Floats) -> Moment:
        """The moment of a row of values with their bands (q, 3)."""
        bands = [Band(*one) for one in row.tolist()]
        sides, count = bands[1:4], len(self._inlets.names)
        if self._sides is not None and not self._sides.leave_out:
            sides = sides[:2]
        losses, power = [], None
        if count > 1:
            *bands, power = bands
            bands, losses = bands[: -2 * count], bands[-2 * count :]
        first = 4 + len(self._limbs)
        return Moment(
            bands[0] if self.known.has_pressures else None,
            None if self._sides is None else tuple(sides),
            tuple(SpanDrop(*bands[k : k + 2]) for k in range(first, len(bands), 2)),
            tuple(map(InletLoss, losses[:count], losses[count:])),
            power,
            tuple(bands[4:first]),
        )


def _flows(known: Known, inlets: int) -> tuple[Floats, Floats | None]:
    """Flows (t,) at which a vessel is solved, mL/s, and weights of those of a wave but the last.

    They are the mean and the peak; of a wave those that stand for its cycle, and the peak. Where
    waves of inlets differ, flows (t, i) through all of them.
    """
    flows, weights = known.spread(inlets)
    most = [] if known.most is None else [known.at_peak(inlets)]
    return np.array([*flows, *most]), None if known.wave is None else weights
