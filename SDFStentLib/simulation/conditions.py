"""What flows through the ends of a segment: from the network of the whole tree."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np

from ..flow import (
    ADULT,
    PASCAL_PER_MMHG,
    PER_ML,
    Channel,
    FlowAnswer,
    Network,
    Outlets,
    State,
    Wave,
    Ways,
    drop_over,
    lost_to,
    steady,
)
from ..segment import Segment, SegmentFace
from ..validation import Floats, InputError

CGS_RESISTANCE = 1e-5
"""dyn s/cm^5 in one Pa s/m^3."""

LEAST_RESISTANCE = 1e-3
"""dyn s/cm^5, where the tree beyond an outlet costs nothing."""


CGS_PRESSURE = 10.0
"""dyn/cm^2 in one Pa."""


class Outlet(NamedTuple):
    """What is set at an outlet."""

    name: str
    """Of the face."""
    kind: Literal["resistance", "flow", "pressure"]
    value: float
    """dyn s/cm^5, mL/s out of the vessel, or dyn/cm^2."""
    flow: float
    """That the network has there, mL/s."""


class _Solved(NamedTuple):
    """Steady states of a network, and the share of time (t,) of each."""

    states: list[State]
    weights: Floats

    def mean(self, values: Sequence[float]) -> float:
        """Of values of the states."""
        return float(self.weights @ np.array(values))


class Conditions(NamedTuple):
    """At the ends of a segment in one state of its vessel."""

    inflow: float
    """mL/s, the mean."""
    wave: Wave | None
    """Through the inlet."""
    outlets: tuple[Outlet, ...]
    """Those with a negative flow are inlets, too."""
    wedge: float = 0.0
    """Pressure beyond the tree, dyn/cm^2, above which outlets resist; 0 where it is not known."""

    @property
    def entering(self) -> float:
        """mL/s through all inlets, the mean."""
        return self.inflow - sum(one.flow for one in self.outlets if one.flow < 0)

    @property
    def distal(self) -> float:
        """What the solver takes beyond the outlets of a wave, which have a place for it."""
        return 0.0 if self.wave is None else self.wedge

    @property
    def offset(self) -> float:
        """By how much pressures are above those that the solver has, dyn/cm^2."""
        return self.wedge - self.distal


def conditions_of(
    answer: FlowAnswer, channels: Sequence[Channel], before: Segment, after: Segment
) -> tuple[Conditions, Conditions]:
    """Flow into a segment and what its outlets resist, before and after.

    With known pressures an outlet resists as all that lies beyond it in the tree does before
    treatment, at pressures above those beyond the tree; this is kept for after. Without, the flows
    of the network are set at every outlet but the widest, whose pressure is zero.

    Parameters
    ----------
    answer : FlowAnswer
        Of the vessel before and after.
    channels : sequence of Channel
        Of the vessel before.
    before, after : Segment
        With ends of the same names.
    """
    if answer.known.is_uneven:
        raise InputError(
            "inlets: expected one wave for all of them in 3D, got waves of their own; give flows "
            "and one wave."
        )
    ways = Ways(channels)
    is_plain = answer.networks[0].tree.is_plain

    def leaving(face: SegmentFace, solved: _Solved) -> float:
        return _leaving(face, solved, ways, is_plain)

    flows, weights = answer.known.spread()
    solved = [
        _Solved([steady(network, answer.outlets, PER_ML * q) for q in flows.tolist()], weights)
        for network in answer.networks
    ]
    resistances: dict[str, float] = {}
    if answer.known.has_pressures:
        network, outlets = answer.networks[0], answer.outlets
        resistances = {
            face.name: _beyond(face, (network, outlets), solved[0], ways)
            for face in _outlets(before)
            if leaving(face, solved[0]) > 0
        }
    first, second = (
        _of_state(
            segment,
            {face.name: leaving(face, one) for face in segment.faces if face.kind != "wall"},
            resistances,
            answer,
        )
        for segment, one in zip((before, after), solved, strict=True)
    )
    return first, second


def _of_state(
    segment: Segment,
    flows: dict[str, float],
    resistances: dict[str, float],
    answer: FlowAnswer,
) -> Conditions:
    """By what leaves through the ends, mL/s."""
    (inlet,) = (face for face in segment.faces if face.kind == "inlet")
    inflow = -flows[inlet.name]
    if inflow <= 0 or max(flows.values()) <= 0:
        raise InputError(
            f"segment: expected blood to come in at its proximal end, got {-inflow:.3g} mL/s that "
            "leave there; take an end of the vessel that is an inlet for its root",
            "root",
            end=".",
        )
    wave = answer.known.wave
    found = []
    widest = max(
        (face for face in _outlets(segment) if flows[face.name] > 0), key=lambda face: face.area
    )
    for face in _outlets(segment):
        flow = flows[face.name]
        # Another inlet, or one that has become one.
        if flow <= 0:
            found.append(Outlet(face.name, "flow", flow, flow))
        elif face.name in resistances:
            found.append(Outlet(face.name, "resistance", resistances[face.name], flow))
        elif face.name == widest.name:
            found.append(Outlet(face.name, "pressure", 0.0, flow))
        else:
            found.append(Outlet(face.name, "flow", flow, flow))
    wedge = PASCAL_PER_MMHG * CGS_PRESSURE * (answer.known.wedge or 0.0)
    return Conditions(inflow, None if wave is None else wave.scaled(inflow), tuple(found), wedge)


def _outlets(segment: Segment) -> list[SegmentFace]:
    return [face for face in segment.faces if face.kind == "outlet"]


def _beyond(face: SegmentFace, tree: tuple[Network, Outlets], solved: _Solved, ways: Ways) -> float:
    """Resistance of all that lies beyond a face, dyn s/cm^5: of the mean pressure there."""
    network, outlets = tree
    pieces = ways.pieces_to(face.center)
    flow = solved.mean([state.flow[pieces[-1].block] for state in solved.states])
    static = []
    for state in solved.states:
        total = state.inlet - drop_over(pieces, network, state.flow).recovered
        # The way may begin at another inlet than the first one.
        if pieces[0].block != network.tree.inlets[0]:
            total -= float(lost_to(network, state.flow)[pieces[0].block])
        speed = float(state.flow[pieces[-1].block]) / (1e-6 * face.area)
        static.append(total - ADULT.density / 2 * speed**2)
    resistance = CGS_RESISTANCE * (solved.mean(static) - outlets.pressure) / flow
    return max(resistance, LEAST_RESISTANCE)


def _leaving(face: SegmentFace, solved: _Solved, ways: Ways, is_plain: bool) -> float:
    """What flows out of a segment there, the mean, mL/s."""
    last = ways.pieces_to(face.center)[-1]
    flow = solved.mean([state.flow[last.block] for state in solved.states]) / PER_ML
    if is_plain:
        return -flow if face.kind == "inlet" else flow
    return flow if float(ways.direction_at(last) @ face.normal) >= 0 else -flow
