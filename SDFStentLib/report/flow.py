"""Pressures and flows of a network, before and after, in documents, words and a page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from ..flow import (
    ADULT,
    L_PER_MIN,
    OTHERS,
    UNCERTAIN,
    Band,
    Channel,
    FlowAnswer,
    Inlets,
    Moment,
    Wave,
)
from ..validation import place_words
from .facts import GLANCE, Fact, Facts
from .markup import Moments, moments_table, notes_part
from .words import RESEARCH_USE, band_words, brief

Section = Mapping[str, Any]

ML_PER_L = 1000.0

INLET, DROP = "inlet_pressure_{}_mmhg", "pressure_drop_{}_mmhg"
"""Columns of tables."""

FLOW_NOTE = (
    "A network of the vessel tree: friction of laminar flow in rigid elliptic sections and bends, "
    "and the loss of jets behind narrowings and in branches; blood of 1060 kg/m3 and 4 mPa s. "
    "Pressures at the inlet are total ones. Recovered drops are what is lost for good, maximal "
    "ones reach to the lowest pressure in the narrowing. In brackets the range by uncertain "
    f"{', '.join(name for name, _ in UNCERTAIN)}. No measured gradient, and no adaptation of the "
    "lungs to the new flow."
)

SEVERAL_INLETS = (
    "With several inlets, as in a Fontan circulation, a drop is of the total pressure from that "
    "inlet to the outlets, their mean by flow. Power losses of the inlets add up. "
    "Indexed it is power loss (W) times the square of the body surface area (m2), over density "
    "(kg/m3) and the cube of the flow (L/s), after Dasi et al., J Biomech 2008;41:2246. Streams "
    "that collide are taken as mixed: where caval flows miss each other it is less."
)

STENTED_FONTANS = (
    "Catheters found 2.0 (2 to 3) mmHg over narrowed Fontan pathways of 10.5 mm, and 0 (0 to 1) "
    "over the same with stents, of 18 mm (20 patients; Hagler et al., Congenit Heart Dis "
    "2019;14:571); of 51 narrowed lateral tunnels 18 had a gradient. A small drop does not tell "
    "that a pathway is wide enough, and no limit of the power loss is agreed on."
)

LOOPS = (
    "Limbs of the vessel part and meet again, as at a bypass or a collateral: they are solved as "
    "parallel ones, by friction, bends, narrowings, and the jets that are lost where they meet."
)

FIXED_SPLIT = (
    "Without pressures the split is as given, or as the diameters of the outlets have it, after "
    "treatment, too: give the mean pressure at the inlet and the wedge pressure to know more."
)

QUASI_STEADY = (
    "The wave was taken as a row of steady flows, without inertia: svzerod, which solves it, is "
    "not installed (pip install svzerod)."
)


def flow_document(answer: FlowAnswer, inputs: Mapping[str, Any]) -> dict[str, Any]:
    """Document of the flow, for a program, with the files by name."""
    return {
        "schema": "sdfstent-flow",
        "version": 1,
        "notice": RESEARCH_USE,
        "inputs": dict(inputs),
        **flow_section(answer),
    }


def flow_section(answer: FlowAnswer) -> dict[str, Any]:
    """Pressures and flows as they stand in documents."""
    known = answer.known
    states = {"before": answer.before, "after": answer.after}
    return {
        "notes": _notes(answer),
        "known": {
            "mean_flow_ml_s": known.mean,
            "peak_flow_ml_s": known.most,
            "is_wave": known.wave is not None,
            "wave": known.wave and _wave(known.wave),
            "inlet_pressure_mmhg": known.inlet,
            "wedge_mmhg": known.wedge,
            "split_right": known.split_right,
            "inlets": [{"name": one.name, "flow_ml_s": one.mean} for one in known.inlets],
            "bsa_m2": known.bsa,
        },
        **{
            state: moments and {name: _section(answer, name, one) for name, one in moments.items()}
            for state, moments in states.items()
        },
    }


def _wave(wave: Wave) -> dict[str, float]:
    return {
        "cycle_s": wave.cycle,
        "rate_per_min": wave.rate,
        "regurgitant_fraction": wave.back,
    }


def _section(answer: FlowAnswer, name: str, moment: Moment) -> dict[str, Any]:
    flow = answer.flows[name]
    sides = (*answer.sides.names, OTHERS) if answer.sides else ()
    return {
        "flow_ml_s": flow,
        "inlet_mmhg": _triple(moment.inlet),
        "share": {side: _triple(b) for side, b in zip(sides, moment.sides or (), strict=False)},
        "narrowings": [
            {
                "name": part,
                "recovered_mmhg": _triple(drop.recovered),
                "maximal_mmhg": _triple(drop.maximal),
            }
            for part, drop in zip(answer.parts, moment.drops, strict=True)
        ],
        "limbs": [
            {"name": _limb_name(limb), "share": _triple(band)}
            for limb, band in zip(answer.limbs, moment.limbs, strict=True)
        ],
        "inlets": [
            {
                "name": inlet,
                "flow_ml_s": inflow,
                "drop_mmhg": _triple(one.drop),
                "power_loss_w": _triple(one.power),
            }
            for inlet, inflow, one in zip(
                answer.inlets.names, answer.inflow[name], moment.inlets, strict=False
            )
        ],
        "power_loss_w": _triple(moment.power),
        "indexed_power_loss": _triple(_indexed(moment.power, flow, answer.known.bsa)),
    }


def _limb_name(limb: Channel) -> str:
    """The name of a limb by its least diameter, and a place halfway."""
    place = limb.points[len(limb.points) // 2]
    return f"limb of {np.nanmin(limb.inscribed):.1f} mm at {place_words(place)}"


def _indexed(power: Band | None, flow: float, bsa: float | None) -> Band | None:
    """Power loss over what body surface area and flow, mL/s, let one expect."""
    if power is None or bsa is None:
        return None
    unit = ADULT.density * (flow / ML_PER_L) ** 3 / bsa**2
    return Band(*(one / unit for one in power))


def _triple(band: Band | None) -> dict[str, float] | None:
    return None if band is None else band._asdict()


def flow_moments(section: Section, most: int | None = None) -> Moments:
    """Facts at the mean flow and at its peak, each under a heading.

    Of the narrowings the first ones, `most`.
    """
    return [(_at(name, section), flow_facts(section, name, most)) for name in section["before"]]


def flow_rows(section: Section, most: int | None = None) -> list[str]:
    """Facts as lines, the heading in each of them."""
    return [f"{at}, {one}" for at, facts in flow_moments(section, most) for one in facts]


def flow_sentences(section: Section, most: int | None = None) -> list[str]:
    """Headings, the rows below each as lines, and the notes on them."""
    lines = []
    for at, facts in flow_moments(section, most):
        lines += [f"{at}:", *(f"  {one}" for one in facts)]
    count = len(section["before"]["mean"]["narrowings"])
    if most is not None and count > most:
        more = "1 more narrowing" if count - most == 1 else f"{count - most} more narrowings"
        lines.append(f"{more}; all of them are in the document.")
    return [*lines, *section["notes"]]


def flow_line(section: Section) -> str:
    """Line on a plan's flow at the mean: of narrowings it has the stents."""
    facts = flow_facts(section, "mean", stents_in(section))
    told = "; ".join(f"{one.label} {one.change}" for one in facts)
    return f"{_at('mean', section)}, estimated: {told or 'nothing to tell'}."


def flow_columns(section: Section, number: int) -> dict[str, float]:
    """Columns of a stent's row at the mean flow: all before, then all after treatment.

    NaN for one that lies within a later one.
    """
    own = [one for one in flow_facts(section, "mean") if one.column]
    own = [one for one in own if one.column != DROP or one.key == f"stent {number}"]
    inlet, drop = (Fact(before=np.nan, after=np.nan, column=one) for one in (INLET, DROP))
    shares = (one for one in own if one.unit == "%")
    found = Facts((inlet, *shares, drop, *own)).columns()
    return dict(sorted(found.items(), key=lambda item: "_after_" in item[0]))


def stents_in(section: Section) -> int:
    """Number of the narrowings, the first ones, that are stents."""
    narrowings = section["before"]["mean"]["narrowings"]
    return sum(one["name"].startswith("stent ") for one in narrowings)


def flow_part(section: Section) -> list[str]:
    """A table and its notes for a page."""
    return [moments_table(flow_moments(section)), *notes_part(section)]


def _at(moment: str, section: Section) -> str:
    flow = section["before"][moment]["flow_ml_s"]
    return f"At the {moment} flow of {flow:.3g} mL/s ({flow * L_PER_MIN:.3g} L/min)"


def flow_facts(section: Section, moment: str, most: int | None = None) -> Facts:
    """Facts at the mean flow, or at its peak; of the narrowings the first ones, `most`."""
    return Facts(_facts(section, moment, most))


def _facts(section: Section, moment: str, most: int | None) -> Iterator[Fact]:
    states = [section[name][moment] for name in ("before", "after") if section[name]]
    first, wave = states[0], section["known"]["wave"]
    if wave and moment == "mean":
        yield Fact("wave", "wave", words=_wave_words(wave, section["known"]))
    if first["inlet_mmhg"]:
        which = f" at {first['inlets'][0]['name']}" if first["inlets"] else ""
        yield _banded(f"inlet pressure{which}", _each(states, "inlet_mmhg"), "mmHg", column=INLET)
    yield from _shares([one["share"] for one in states], _held(section["known"]))
    for number, limb in enumerate(first["limbs"]):
        shares = [one["limbs"][number]["share"] for one in states]
        yield _banded(f"flow through the {limb['name']}", shares, "%", 100.0)
    for number, narrowing in enumerate(first["narrowings"][:most]):
        yield _drop(narrowing["name"], [one["narrowings"][number] for one in states])
    yield from _of_inlets(states)


def _held(known: Section) -> str:
    """Words for the origin of a split that no pressures give; empty where they give it."""
    if known["inlet_pressure_mmhg"] is not None:
        return ""
    return "as given" if known["split_right"] is not None else "assumed"


def _shares(states: Sequence[Section], held: str) -> Iterator[Fact]:
    """Facts on the division of flow; the side that gains most comes first, unless the split is
    `held`: as much before as after, whatever the stent does."""
    facts, note = [], held and f", {held}"
    for side in states[0]:
        more = {"column": f"flow_{side.replace(' ', '_')}_{{}}_percent", "note": note}
        facts.append(_banded(f"flow to the {side}", _each(states, side), "%", 100.0, **more))
    sides = [one for one, side in zip(facts, states[0], strict=True) if side != OTHERS]
    if len(states) > 1 and sides and not held:
        gained = max(sides, key=lambda one: one.after - one.before)
        tile = gained.label[:1].upper() + gained.label[1:]
        facts[facts.index(gained)] = gained._replace(key="share", level=GLANCE, tile=tile)
    yield from facts


def _drop(name: str, states: Sequence[Section]) -> Fact:
    """The drop over a narrowing; that of a stent comes first."""
    kinds = {kind: _each(states, f"{kind}_mmhg") for kind in ("recovered", "maximal")}
    told: dict[str, Any] = {"short": "drop", "tile": "Pressure drop", "worst": max}
    if name.startswith("stent ") and len(states) > 1:
        told["level"] = GLANCE
    fact = _banded(f"drop over {name}", kinds["recovered"], "mmHg", key=name, **told)
    words = "; ".join(f"{kind} {_banded('', each, 'mmHg').change}" for kind, each in kinds.items())
    return fact._replace(words=words, was="", column=DROP)


def _of_inlets(states: Sequence[Section]) -> Iterator[Fact]:
    """Facts on losses from each of several inlets to the outlets, before and after."""
    for number, inlet in enumerate(states[0]["inlets"]):
        each = [one["inlets"][number] for one in states]
        drops = _banded("", _each(each, "drop_mmhg"), "mmHg").change
        powers = _banded("", _each(each, "power_loss_w"), "mW", 1e3).change
        label = f"from {inlet['name']}, {brief(inlet['flow_ml_s'])} mL/s"
        yield Fact("", label, words=f"drop {drops}; power loss {powers}")
    if states[0]["power_loss_w"]:
        label, lost = "power loss of the connection", _each(states, "power_loss_w")
        fact = _banded(label, lost, "mW", 1e3, column="power_loss_{}_mw", tile="Power lost")
        if states[0]["indexed_power_loss"]:
            index = " -> ".join(f"{one['indexed_power_loss']['value']:.3g}" for one in states)
            fact = fact._replace(note=f"; indexed {index}")
        yield fact._replace(level=GLANCE) if len(states) > 1 else fact


def _each(states: Sequence[Section], key: str) -> list[Any]:
    return [one[key] for one in states]


def _banded(
    label: str, bands: Sequence[Mapping[str, float]], unit: str, scale: float = 1.0, **more: Any
) -> Fact:
    """Values with ranges, before and after treatment, or without one only these: `6.4 (5.1 to 8.0)
    -> 0.27 (0.2 to 0.4) mmHg`."""
    values = [scale * one["value"] for one in bands]
    words = [f"{band_words(one, scale)} {unit}" for one in bands]
    before, was = (values[0], words[0]) if len(bands) > 1 else (None, "")
    return Fact(more.pop("key", ""), label, before, values[-1], unit, words[-1], was, **more)


def _wave_words(wave: Section, known: Section) -> str:
    """Words for a wave, by which a wrong unit is seen."""
    return (
        f"mean {known['mean_flow_ml_s']:.3g}, peak {known['peak_flow_ml_s']:.3g} mL/s, "
        f"regurgitant fraction {100 * wave['regurgitant_fraction']:.0f} %, a cycle of "
        f"{wave['cycle_s']:.3g} s, {wave['rate_per_min']:.0f} beats/min"
    )


def _notes(answer: FlowAnswer) -> list[str]:
    told = _inlet_notes(answer.inlets)
    if answer.limbs:
        told.append(LOOPS)
    told += [] if answer.known.has_pressures else [FIXED_SPLIT]
    return [*told, *([QUASI_STEADY] if answer.is_quasi_steady else []), FLOW_NOTE]


def _inlet_notes(inlets: Inlets) -> list[str]:
    """Notes on the inlets taken where there are several, and on those that were closed."""
    told = []
    if inlets.closed:
        one = len(inlets.closed) == 1
        told.append(
            f"All blood comes in at {_listed(inlets.names)}; {_listed(inlets.closed)} "
            f"{'is an inlet' if one else 'are inlets'}, too, by the lines of the centerline, and "
            f"{'was' if one else 'were'} closed: give the flow at every inlet to know more."
        )
    return [*told, *([SEVERAL_INLETS, STENTED_FONTANS] if len(inlets.names) > 1 else [])]


def _listed(names: Sequence[str]) -> str:
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)
