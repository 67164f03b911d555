"""What flows through the ends of a segment: from the network of the whole tree."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Literal, NamedTuple

import numpy as np

from ..flow import (
    ADULT,
    PER_ML,
    Channel,
    FlowAnswer,
    Network,
    Outlets,
    Piece,
    State,
    Wave,
    Ways,
    drop_over,
    steady,
)
from ..segment import Segment, SegmentFace
from ..validation import Points

CGS_RESISTANCE = 1e-5
"""dyn s/cm^5 in one Pa s/m^3."""

LEAST_RESISTANCE = 1e-3
"""dyn s/cm^5, where the tree beyond an outlet costs nothing."""


_Way = Callable[[Points], Sequence[Piece]]
"""From the root to a place (3,)."""


class Outlet(NamedTuple):
    """What is set at an outlet."""

    name: str
    """Of the face."""
    kind: Literal["resistance", "flow", "pressure"]
    value: float
    """dyn s/cm^5, mL/s out of the vessel, or dyn/cm^2."""
    flow: float
    """That the network has there, mL/s."""


class Conditions(NamedTuple):
    """At the ends of a segment in one state of its vessel."""

    inflow: float
    """mL/s, the mean."""
    wave: Wave | None
    """Through the inlet."""
    outlets: tuple[Outlet, ...]


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
    ways, root = Ways(channels), channels[0].points[0]

    def way_to(place: Points) -> Sequence[Piece]:
        return ways.pieces_along(np.array([root, place]))

    states = [
        steady(network, answer.outlets, PER_ML * answer.known.mean) for network in answer.networks
    ]
    resistances: dict[str, float] = {}
    if answer.known.has_pressures:
        network, outlets = answer.networks[0], answer.outlets
        resistances = {
            face.name: _beyond(face, (network, outlets, states[0]), way_to)
            for face in _outlets(before)
        }
    first, second = (
        _of_state(segment, state, way_to, resistances, answer)
        for segment, state in zip((before, after), states, strict=True)
    )
    return first, second


def _of_state(
    segment: Segment,
    state: State,
    way_to: _Way,
    resistances: dict[str, float],
    answer: FlowAnswer,
) -> Conditions:
    (inlet,) = (face for face in segment.faces if face.kind == "inlet")
    inflow = _flow_at(inlet, state, way_to)
    wave = answer.known.wave
    found = []
    widest = max(_outlets(segment), key=lambda face: face.area)
    for face in _outlets(segment):
        flow = _flow_at(face, state, way_to)
        if resistances:
            found.append(Outlet(face.name, "resistance", resistances[face.name], flow))
        elif face.name == widest.name:
            found.append(Outlet(face.name, "pressure", 0.0, flow))
        else:
            found.append(Outlet(face.name, "flow", flow, flow))
    return Conditions(inflow, None if wave is None else wave.scaled(inflow), tuple(found))


def _outlets(segment: Segment) -> list[SegmentFace]:
    return [face for face in segment.faces if face.kind == "outlet"]


def _beyond(face: SegmentFace, solved: tuple[Network, Outlets, State], way_to: _Way) -> float:
    """Resistance of all that lies beyond a face, dyn s/cm^5."""
    network, outlets, state = solved
    pieces = way_to(face.center)
    flow = float(state.flow[pieces[-1].block])
    total = state.inlet - drop_over(pieces, network, state.flow).recovered
    moving = ADULT.density / 2 * (flow / (1e-6 * face.area)) ** 2
    resistance = CGS_RESISTANCE * (total - moving - outlets.pressure) / flow
    return max(float(resistance), LEAST_RESISTANCE)


def _flow_at(face: SegmentFace, state: State, way_to: _Way) -> float:
    """mL/s."""
    block = way_to(face.center)[-1].block
    return float(state.flow[block]) / PER_ML
