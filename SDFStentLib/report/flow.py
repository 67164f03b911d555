"""Pressures and flows of a network, before and after, in documents, words and a page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

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
from .markup import paragraph, table
from .words import RESEARCH_USE

Section = Mapping[str, Any]

ML_PER_L = 1000.0

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
    """All that is told, for a program, with the files by name."""
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
    """By its least diameter, and a place halfway."""
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


Rows = list[tuple[str, str]]


def flow_moments(section: Section, most: int | None = None) -> list[tuple[str, Rows]]:
    """What is told at the mean flow and at its peak: a heading, and rows of a label and words.

    Of the narrowings the first ones, `most`.
    """
    return [(_at(name, section), _of_moment(section, name, most)) for name in section["before"]]


def flow_rows(section: Section, most: int | None = None) -> Rows:
    """The same, the heading in every label."""
    return [
        (f"{at}, {label}", words)
        for at, rows in flow_moments(section, most)
        for label, words in rows
    ]


def flow_sentences(section: Section, most: int | None = None) -> list[str]:
    """Headings, the rows below each as lines, and what has to be known of them."""
    lines = []
    for at, rows in flow_moments(section, most):
        lines += [f"{at}:", *(f"  {label}: {words}" for label, words in rows)]
    count = len(section["before"]["mean"]["narrowings"])
    if most is not None and count > most:
        more = "1 more narrowing" if count - most == 1 else f"{count - most} more narrowings"
        lines.append(f"{more}; all of them are in the document.")
    return [*lines, *section["notes"]]


def flow_line(section: Section) -> str:
    """What a plan does at the mean flow, in one line: of narrowings the stents are told."""
    rows = _of_moment(section, "mean", stents_in(section))
    told = "; ".join(f"{label} {words}" for label, words in rows)
    return f"{_at('mean', section)}, estimated: {told or 'nothing to tell'}."


class Gained(NamedTuple):
    """The side whose share of the flow grows most: percent before and after."""

    side: str
    before: float
    after: float


def share_gained(before: Section, after: Section) -> Gained | None:
    """Of the sections of a moment; None without sides."""
    found = [
        Gained(side, *(100 * one["share"][side]["value"] for one in (before, after)))
        for side in before["share"]
        if side != OTHERS
    ]
    return max(found, key=lambda one: one.after - one.before, default=None)


def stents_in(section: Section) -> int:
    """How many of the narrowings, the first ones, are stents."""
    narrowings = section["before"]["mean"]["narrowings"]
    return sum(one["name"].startswith("stent ") for one in narrowings)


def flow_part(section: Section) -> list[str]:
    """A table and its notes for a page."""
    return [moments_table(flow_moments(section)), *notes_part(section)]


def moments_table(moments: Sequence[tuple[str, Rows]]) -> str:
    """Headings, each with its rows."""
    rows = [row for at, told in moments for row in ((at,), *told)]
    return table(rows, look="words")


def notes_part(section: Section) -> list[str]:
    """What has to be known of the numbers."""
    return [paragraph(note, "small") for note in section["notes"]]


def _at(moment: str, section: Section) -> str:
    flow = section["before"][moment]["flow_ml_s"]
    return f"At the {moment} flow of {flow:.3g} mL/s ({flow * L_PER_MIN:.3g} L/min)"


def _of_moment(section: Section, moment: str, most: int | None) -> Rows:
    found = [section[name][moment] for name in ("before", "after") if section[name]]
    first, rows = found[0], list[tuple[str, str]]()
    wave = section["known"]["wave"]
    if wave and moment == "mean":
        rows.append(("wave", _wave_words(wave, section["known"])))
    inlets = first["inlets"]
    if first["inlet_mmhg"]:
        which = f" at {inlets[0]['name']}" if inlets else ""
        told = _change([one["inlet_mmhg"] for one in found], "mmHg")
        rows.append((f"inlet pressure{which}", told))
    for side in first["share"]:
        shares = [one["share"][side] for one in found]
        rows.append((f"flow to the {side}", _change(shares, "%", 100.0)))
    for number, limb in enumerate(first["limbs"]):
        shares = [one["limbs"][number]["share"] for one in found]
        rows.append((f"flow through the {limb['name']}", _change(shares, "%", 100.0)))
    for number, narrowing in enumerate(first["narrowings"][:most]):
        drops = [one["narrowings"][number] for one in found]
        words = "; ".join(
            f"{kind} {_change([drop[f'{kind}_mmhg'] for drop in drops], 'mmHg')}"
            for kind in ("recovered", "maximal")
        )
        rows.append((f"drop over {narrowing['name']}", words))
    return [*rows, *_of_inlets(found)]


def _of_inlets(found: Sequence[Section]) -> Rows:
    """What is lost from each of several inlets to the outlets, before and after."""
    rows, (first, *_) = [], found
    for number, inlet in enumerate(first["inlets"]):
        each = [one["inlets"][number] for one in found]
        drops = _change([one["drop_mmhg"] for one in each], "mmHg")
        powers = _change([one["power_loss_w"] for one in each], "mW", 1e3)
        flow = brief(inlet["flow_ml_s"])
        rows.append((f"from {inlet['name']}, {flow} mL/s", f"drop {drops}; power loss {powers}"))
    if first["power_loss_w"]:
        words = _change([one["power_loss_w"] for one in found], "mW", 1e3)
        if first["indexed_power_loss"]:
            index = " -> ".join(f"{one['indexed_power_loss']['value']:.3g}" for one in found)
            words += f"; indexed {index}"
        rows.append(("power loss of the connection", words))
    return rows


def _wave_words(wave: Section, known: Section) -> str:
    """All that shows a wrong unit."""
    return (
        f"mean {known['mean_flow_ml_s']:.3g}, peak {known['peak_flow_ml_s']:.3g} mL/s, "
        f"regurgitant fraction {100 * wave['regurgitant_fraction']:.0f} %, a cycle of "
        f"{wave['cycle_s']:.3g} s, {wave['rate_per_min']:.0f} beats/min"
    )


def _change(bands: list[dict[str, float]], unit: str, scale: float = 1.0) -> str:
    """`6.4 (5.1 to 8.0) -> 0.27 (0.2 to 0.4) mmHg`."""
    return " -> ".join(band_words(one, scale) for one in bands) + f" {unit}"


def band_words(band: Mapping[str, float], scale: float = 1.0) -> str:
    """A value and between what it lies, where that is known."""
    value, low, high = (brief(scale * band[name]) for name in ("value", "low", "high"))
    return value if low == high else f"{value} ({low} to {high})"


def brief(value: float) -> str:
    """Two digits behind the point below one, one below a hundred; no minus zero."""
    digits = 2 if abs(value) < 1 else 1
    return f"{round(value, digits) + 0.0:.{digits}f}"


def _notes(answer: FlowAnswer) -> list[str]:
    told = _inlet_notes(answer.inlets)
    if answer.limbs:
        told.append(LOOPS)
    told += [] if answer.known.has_pressures else [FIXED_SPLIT]
    return [*told, *([QUASI_STEADY] if answer.is_quasi_steady else []), FLOW_NOTE]


def _inlet_notes(inlets: Inlets) -> list[str]:
    """Which inlets were taken where there are several, and which were closed."""
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
