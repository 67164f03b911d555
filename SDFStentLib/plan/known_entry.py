"""Flow data as the entry of a document, as it is edited.

Its values need not fit together yet; beside a wave its peak is kept, too. The other form is
`Known`, which refuses what contradicts itself.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from ..flow import L_PER_MIN, Inflow, Known, Wave, has_svzerod
from ..validation import InputError
from .typed import from_document, to_document

FlowEntry = Mapping[str, Any] | None
"""Fields of a `Known` with their values of JSON; None where nothing is known."""

SHOWN = 0.006 / L_PER_MIN
"""mL/s, half of the last figure of L/min with two decimals, and a little: so far the peak may be
from that of its wave."""


def flow_entry(known: Known | None) -> dict[str, Any] | None:
    """Entry of flow data, but for the place of the right branch, which is found anew."""
    if known is None:
        return None
    found = {**to_document(known), "peak": known.most}
    found.pop("right", None)
    return found


def known_of(entry: FlowEntry) -> Known | None:
    """Flow data of an entry; None without a mean flow.

    A wave counts while mean and peak are its own, pressures with that at the inlet. `InputError`
    for what contradicts itself.
    """
    flow = entry or {}
    mean = flow.get("mean")
    if not mean:
        return None
    wave, has_pressures = wave_of(flow), bool(flow.get("inlet"))
    return Known(
        mean,
        inlets=_inlets(flow, mean, wave is not None),
        bsa=flow.get("bsa"),
        peak=flow.get("peak") if wave is None else None,
        wave=wave,
        inlet=flow.get("inlet") if has_pressures else None,
        wedge=flow.get("wedge") or 0.0 if has_pressures else None,
        split_right=flow.get("split_right"),
        unusual=bool(flow.get("unusual")),
    )


def wave_of(entry: FlowEntry) -> Wave | None:
    """The wave; None where there is none, or where mean and peak are no longer its own."""
    flow = entry or {}
    document, mean = flow.get("wave"), flow.get("mean")
    if not document or not mean:
        return None
    wave = from_document(Wave, document, "wave").scaled(mean)
    away = abs(wave.peak - (flow.get("peak") or 0.0))
    return wave if away <= SHOWN * (1 + wave.peak / wave.mean) else None


def lacks_solver(entry: FlowEntry) -> bool:
    """Whether a wave is given, but the solver for it is not installed."""
    return wave_of(entry) is not None and not has_svzerod()


def inflows(entry: FlowEntry) -> dict[str, float]:
    """The inflow by the name of the inlet, mL/s."""
    flow = entry or {}
    return {one.name: one.mean for one in _inlets(flow, flow.get("mean") or 0.0, False)}


def inlet_named(entry: FlowEntry, names: Sequence[str]) -> str | None:
    """Inlet by one of these names, as it was called first; None for none."""
    own = [name.casefold() for name in names]
    return next((one for one in inflows(entry) if one.casefold() in own), None)


def with_inlet(entry: FlowEntry, names: Sequence[str], flow: float | None) -> FlowEntry:
    """Entry with a flow, mL/s, into the end of these names; with None that is no inlet.

    The first inlet brings the whole flow, whatever is asked for; of several the flow is the sum.

    Raises
    ------
    InputError
        No flow in at any inlet, or what contradicts what else is known.
    """
    known, own = known_of(entry), inlet_named(entry, names)
    assert known is not None
    found = {one.name: one for one in known.inlets}
    if flow is not None:
        name = own or names[0]
        wave = found[name].wave if own else None
        found[name] = Inflow(name, flow if found else known.mean, wave)
    elif own is not None:
        found.pop(own, None)
    mean = sum(one.mean for one in found.values()) if found else known.mean
    if not mean > 0:
        raise InputError(
            "Flow: expected more than 0 L/min at one inlet, got none; leave one of them open."
        )
    inlets, wave = tuple(found.values()), None if known.is_uneven else known.wave
    return flow_entry(replace(known, mean=mean, inlets=inlets, wave=wave))


def _inlets(flow: Mapping[str, Any], mean: float, has_wave: bool) -> tuple[Inflow, ...]:
    """Inlets scaled to a total mean flow, with waves of their own if the total has one."""
    found = flow.get("inlets") or []
    whole = sum(one["mean"] for one in found)
    # Those that bring the flow stay as they are, to the last digit: another one is another plan.
    scale = 1.0 if not found or math.isclose(whole, mean) else mean / whole
    return tuple(
        Inflow(one["name"], one["mean"] * scale, _wave_in(one) if has_wave else None)
        for one in found
    )


def _wave_in(inlet: Mapping[str, Any]) -> Wave | None:
    document = inlet.get("wave")
    return from_document(Wave, document, "wave") if document else None
