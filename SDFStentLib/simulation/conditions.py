"""Boundary conditions at the ends of a segment, from the network of the whole tree."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal, NamedTuple

import numpy as np

from ..flow import (
    ADULT,
    PASCAL_PER_MMHG,
    PER_ML,
    Channel,
    FlowAnswer,
    SteadyFlow,
    Ways,
    drop_over,
    lost_to,
    steady_states,
)
from ..segment import Segment, SegmentFace
from ..validation import Floats, InputError

CGS_RESISTANCE = 1e-5
"""dyn s/cm^5 in one Pa s/m^3."""

LEAST_RESISTANCE = 1e-3
"""dyn s/cm^5, where the tree beyond an outlet costs nothing."""

CGS_PRESSURE = 10.0
"""dyn/cm^2 in one Pa."""


class End(NamedTuple):
    """Boundary condition at an end of a segment."""

    name: str
    """The name of the face."""
    kind: Literal["resistance", "flow", "pressure"]
    value: float
    """dyn s/cm^5, mL/s out of the vessel, or dyn/cm^2."""
    flow: float
    """The flow that the network has there, out of the vessel, the mean, mL/s."""


class Cycle(NamedTuple):
    """Flow through the ends of a segment over a wave."""

    time: Floats
    """(t,) s, from 0 to the begin of the next cycle."""
    flow: Floats
    """(e, t) out of the vessel, mL/s; the last one is the first."""
    steps: int
    """Even ones, on which all these times lie."""


class Conditions(NamedTuple):
    """Conditions at the ends of a segment in one state of its vessel."""

    ends: tuple[End, ...]
    """The first is that which is called the inlet, and its flow is known."""
    cycle: Cycle | None = None
    """The cycle of a wave; None for steady flow."""
    wedge: float = 0.0
    """Pressure beyond the tree, dyn/cm^2, above which outlets resist; 0 where it is not known."""

    @property
    def most(self) -> float:
        """mL/s that come in at all inlets together, or run back there, at the peak."""
        into = [number for number, one in enumerate(self.ends) if one.flow < 0]
        if self.cycle is None:
            return -sum(self.ends[number].flow for number in into)
        return float(np.abs(self.cycle.flow[into]).sum(axis=0).max())

    @property
    def distal(self) -> float:
        """Pressure beyond the outlets of a wave, dyn/cm^2; the solver takes none for steady
        flow."""
        return 0.0 if self.cycle is None else self.wedge

    @property
    def offset(self) -> float:
        """Amount to add to the pressures of the solver, dyn/cm^2."""
        return self.wedge - self.distal


class EndFlows:
    """Flows through the ends of segments, by the network of a vessel in one state.

    Parameters
    ----------
    answer : FlowAnswer
    number : int
        Number of the state: 0 before, 1 after.
    channels : sequence of Channel
        Channels of the vessel before.
    """

    def __init__(self, answer: FlowAnswer, number: int, channels: Sequence[Channel]) -> None:
        self._known, self._outlets, self._ways = answer.known, answer.outlets, Ways(channels)
        self._network = answer.networks[number]
        flows, self._weights = self._known.spread(len(self._network.tree.inlets))
        self._states = self._solved(flows)

    def _solved(self, flows: Floats) -> list[SteadyFlow]:
        return steady_states([(self._network, self._outlets, PER_ML * one) for one in flows])

    def _mean(self, values: Sequence[float]) -> float:
        return float(self._weights @ np.array(values))

    def out_of(self, segment: Segment) -> dict[str, float]:
        """Flow out of a segment through each of its ends, by name, the mean, mL/s."""
        return {
            face.name: self._mean(self._through(face, self._states)) for face in ends_of(segment)
        }

    def over_cycle(self, segment: Segment, means: Mapping[str, float]) -> Cycle | None:
        """Flow through each end over a wave, at its rows.

        One wave of all inlets has the same shape at every end; where inlets have waves of their
        own, each moment is taken as steady flow.
        """
        wave = self._known.wave
        if wave is None:
            return None
        time = np.array(wave.time)
        if not self._known.is_uneven:
            inflow = -next(iter(means.values())) or wave.mean
            flow = inflow / wave.mean * np.array(wave.flow)
            each = np.array([one / inflow * flow for one in means.values()])
            return Cycle(time, each, wave.steps)
        states = self._solved(self._known.through(time, len(self._network.tree.inlets)))
        each = np.array([self._through(face, states) for face in ends_of(segment)])
        each[:, -1] = each[:, 0]
        return Cycle(time, each, wave.steps)

    def _through(self, face: SegmentFace, states: Sequence[SteadyFlow]) -> list[float]:
        """Out of a segment at one of its ends in some states, mL/s."""
        last = self._ways.pieces_to(face.center)[-1]
        sign = 1 if float(self._ways.direction_at(last) @ face.normal) >= 0 else -1
        return [sign * float(state.flow[last.block]) / PER_ML for state in states]

    def beyond(self, face: SegmentFace) -> float:
        """Resistance of all that lies beyond an end, dyn s/cm^5: of the mean pressure there."""
        network, pieces = self._network, self._ways.pieces_to(face.center)
        static = []
        for state in self._states:
            total = state.inlet - drop_over(pieces, network, state.flow).recovered
            # The way may begin at another inlet than the first one.
            if pieces[0].block != network.tree.inlets[0]:
                total -= float(lost_to(network, state.flow)[pieces[0].block])
            speed = float(state.flow[pieces[-1].block]) / (1e-6 * face.area)
            static.append(total - ADULT.density / 2 * speed**2)
        flow = self._mean(self._through(face, self._states)) * PER_ML
        resistance = CGS_RESISTANCE * (self._mean(static) - self._outlets.pressure) / flow
        return max(resistance, LEAST_RESISTANCE)


def ends_of(segment: Segment) -> list[SegmentFace]:
    """Inlets and outlets of a segment."""
    return [face for face in segment.faces if face.kind != "wall"]


def conditions_of(
    answer: FlowAnswer, channels: Sequence[Channel], before: Segment, after: Segment
) -> tuple[Conditions, Conditions]:
    """Flow into a segment and what its outlets resist, before and after.

    With known pressures an outlet resists as all that lies beyond it in the tree does before
    treatment, at pressures above those beyond the tree; this is kept for after. Without, the flows
    of the network are set at every outlet but the widest, whose pressure is zero. At inlets flow is
    set, whichever way it runs.

    Parameters
    ----------
    answer : FlowAnswer
        Flow of the vessel before and after.
    channels : sequence of Channel
        Channels of the vessel before.
    before, after : Segment
        Segments with ends of the same names, of which the first one is an inlet.

    Raises
    ------
    InputError
        No end at which pressure could be set: blood leaves nowhere in one of the states.
    """
    flows = [EndFlows(answer, number, channels) for number in (0, 1)]
    segments = before, after
    means = [one.out_of(segment) for one, segment in zip(flows, segments, strict=True)]
    resistances: dict[str, float] = {}
    if answer.known.has_pressures:
        own = [face for face in ends_of(before) if means[0][face.name] > 0]
        resistances = {face.name: flows[0].beyond(face) for face in own}
    wedge = PASCAL_PER_MMHG * CGS_PRESSURE * (answer.known.wedge or 0.0)
    first, second = (
        Conditions(_ends(segment, mean, resistances), one.over_cycle(segment, mean), wedge)
        for segment, one, mean in zip(segments, flows, means, strict=True)
    )
    return first, second


def _ends(
    segment: Segment, means: Mapping[str, float], resistances: Mapping[str, float]
) -> tuple[End, ...]:
    """The ends by what leaves through them, mL/s, and resists beyond them."""
    _, *others = ends_of(segment)
    areas = {face.name: face.area for face in others if means[face.name] > 0}
    if resistances:
        areas = {name: area for name, area in areas.items() if name in resistances}
    if not areas:
        raise InputError(
            "segment: expected an end at which blood leaves before treatment and after it, got "
            "none; name other ends of the segment."
        )
    widest = max(areas, key=lambda name: areas[name])

    def end(name: str, flow: float) -> End:
        if name in areas and resistances:
            return End(name, "resistance", resistances[name], flow)
        if name == widest:
            return End(name, "pressure", 0.0, flow)
        return End(name, "flow", flow, flow)

    return tuple(end(name, flow) for name, flow in means.items())
