"""Pressures and flows of a network, before and after, in documents, words and a page."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from typing import TYPE_CHECKING, Any

from .html import page
from .words import RESEARCH_USE

if TYPE_CHECKING:
    from ..flow import Band, FlowAnswer, Moment

FLOW_NOTE = (
    "A network of the vessel tree: friction of steady laminar flow in rigid elliptic sections, and "
    "the loss of jets behind narrowings; blood of 1060 kg/m3 and 4 mPa s. Pressures at the inlet "
    "are total ones. Recovered drops are what is lost for good, maximal ones reach to the lowest "
    "pressure in the narrowing. In brackets the range by uncertain "
    "{}. No measured gradient, and no adaptation of the lungs to the new flow."
)

FIXED_SPLIT = (
    "Without pressures the split is as given, or as the diameters of the outlets have it, after "
    "treatment, too: give the mean pressure at the inlet and the wedge pressure to know more."
)

QUASI_STEADY = (
    "The wave was taken as a row of steady flows, without inertia: svzerod, which solves it, is "
    "not installed (pip install svzerod)."
)


def flow_document(
    answer: FlowAnswer, inputs: Mapping[str, Any], is_quasi_steady: bool = False
) -> dict[str, Any]:
    """All that is told, for a program."""
    known = answer.known
    states = {"before": answer.before, "after": answer.after}
    return {
        "schema": "sdfstent-flow",
        "version": 1,
        "notice": RESEARCH_USE,
        "notes": _notes(answer, is_quasi_steady),
        "inputs": dict(inputs),
        "known": {
            "mean_flow_ml_s": known.mean,
            "peak_flow_ml_s": answer.flows.get("peak"),
            "is_wave": known.wave is not None,
            "inlet_pressure_mmhg": known.inlet,
            "wedge_mmhg": known.wedge,
            "split_right": known.split_right,
        },
        **{
            state: moments and {name: _section(answer, name, one) for name, one in moments.items()}
            for state, moments in states.items()
        },
    }


def _section(answer: FlowAnswer, name: str, moment: Moment) -> dict[str, Any]:
    flow = answer.flows[name]
    sides = answer.sides.names if answer.sides else ()
    return {
        "flow_ml_s": flow,
        "inlet_mmhg": _triple(moment.inlet),
        "share": {side: _triple(b) for side, b in zip(sides, moment.sides or (), strict=True)},
        "narrowings": [
            {
                "name": part,
                "recovered_mmhg": _triple(drop.recovered),
                "maximal_mmhg": _triple(drop.maximal),
            }
            for part, drop in zip(answer.parts, moment.drops, strict=True)
        ],
    }


def _triple(band: Band | None) -> dict[str, float] | None:
    return None if band is None else {name: one for name, one in band._asdict().items()}


def flow_rows(document: Mapping[str, Any], most: int | None = None) -> list[tuple[str, str]]:
    """What is told, a label and words each; of the narrowings the first ones."""
    states = [document[name] for name in ("before", "after") if document[name]]
    rows = []
    for moment, first in states[0].items():
        at = f"At the {moment} flow of {first['flow_ml_s']:.3g} mL/s"
        found = [state[moment] for state in states]
        if first["inlet_mmhg"]:
            rows.append(
                (f"{at}, inlet pressure", _change([one["inlet_mmhg"] for one in found], "mmHg"))
            )
        for side in first["share"]:
            shares = [one["share"][side] for one in found]
            rows.append((f"{at}, flow to the {side}", _change(shares, "%", 100.0)))
        for number, narrowing in enumerate(first["narrowings"][:most]):
            drops = [one["narrowings"][number] for one in found]
            words = "; ".join(
                f"{kind} {_change([drop[f'{kind}_mmhg'] for drop in drops], 'mmHg')}"
                for kind in ("recovered", "maximal")
            )
            rows.append((f"{at}, drop over {narrowing['name']}", words))
    return rows


def flow_sentences(document: Mapping[str, Any], most: int | None = None) -> list[str]:
    """The rows as lines, and what has to be known of them."""
    lines = [f"{label}: {words}." for label, words in flow_rows(document, most)]
    count = len(document["before"]["mean"]["narrowings"])
    if most is not None and count > most:
        lines.append(f"{count - most} more narrowings; all of them are in the document.")
    return [*lines, *document["notes"]]


def flow_page(document: Mapping[str, Any]) -> str:
    """The page made from a document."""
    rows = "".join(
        f"<tr><td>{escape(label)}</td><td>{escape(words)}</td></tr>"
        for label, words in flow_rows(document)
    )
    files = "".join(
        f"<tr><td>{escape(name)}</td><td>{escape(str(file))}</td></tr>"
        for name, file in document["inputs"].items()
    )
    notes = "".join(f"<p class='small'>{escape(note)}</p>" for note in document["notes"])
    body = (
        f"<h1>Flow before and after</h1><p class='notice'>{escape(document['notice'])}</p>"
        f"<table class='words'>{rows}</table>{notes}"
        f"<h2>Files</h2><table class='file'>{files}</table>"
    )
    return page("Flow before and after", body)


def _change(bands: list[dict[str, float]], unit: str, scale: float = 1.0) -> str:
    """`6.4 (5.1 to 8.0) -> 0.27 (0.2 to 0.4) mmHg`."""
    return " -> ".join(_band(one, scale) for one in bands) + f" {unit}"


def _band(band: Mapping[str, float], scale: float) -> str:
    value, low, high = (_number(scale * band[name]) for name in ("value", "low", "high"))
    return value if low == high else f"{value} ({low} to {high})"


def _number(value: float) -> str:
    """Two digits behind the point below one, one below a hundred; no minus zero."""
    return f"{value + 0.0:.2f}" if abs(value) < 1 else f"{value:.1f}"


def _notes(answer: FlowAnswer, is_quasi_steady: bool) -> list[str]:
    from ..flow import UNCERTAIN  # late, as in `pressure`

    note = FLOW_NOTE.format(", ".join(name for name, _ in UNCERTAIN))
    told = [] if answer.known.has_pressures else [FIXED_SPLIT]
    return [*told, *([QUASI_STEADY] if is_quasi_steady else []), note]
