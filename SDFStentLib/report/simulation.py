"""Flow solved in three dimensions, beside the network: a document, sentences and a page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from ..simulation import UNSTEADY, CaseResult, Found, Prepared, Simulated, state_section
from .facts import Fact, Facts
from .html import file_part
from .markup import Moments, beginning, moments_table, notes_part, page
from .picture.drawing import svg
from .picture.plot import along_plot
from .words import RESEARCH_USE, band_words, brief

Section = Mapping[str, Any]

STATES = ("before", "after")
ALONG = {
    "static_along_mmhg": "static pressure (mmHg)",
    "fastest_along_m_s": "fastest blood (m/s)",
}

NOTES = (
    "Navier-Stokes equations by svMultiPhysics: rigid walls, blood of 1060 kg/m3 and 4 mPa s. "
    "Linear tetrahedra without layers along the wall. Behind +- stands the difference from a mesh "
    "with edges 1.5 times as long. Wall shear of such elements is low by up to an eighth on 20 "
    "edges round; its +- is twice the difference.",
    "In brackets what the network of the whole tree tells, with its range. No measured gradient, "
    "and no adaptation of the lungs to the new flow.",
)

NO_LEVEL = (
    "No pressures are known: the flows of the network are set at the outlets, and only differences "
    "of pressure are told."
)

NO_COARSE = "The coarser mesh was not solved: nothing tells how far the mesh decides."


def mesh_sentences(prepared: Prepared) -> list[str]:
    """Sentences of the shell on the meshes, before and after."""
    said = [_mesh_words(name, state_section(one)) for name, one in prepared.states.items()]
    said += _pressure_words(prepared.level)
    for name, by in prepared.extensions.items():
        said.append(f"{name}: {by:.1f} mm of straight tube stand for vessel that is missing.")
    return said


def _mesh_words(name: str, state: Section) -> str:
    """Words about the fine mesh of a state, as its document has it."""
    mesh = state["meshes"]["fine"]
    return (
        f"{name.capitalize()}: {mesh['tetrahedra']} tetrahedra, angles from "
        f"{mesh['smallest_angle']:.0f} to {mesh['largest_angle']:.0f} degrees, "
        f"{mesh['edges_round_throat']} edges round the throat of {state['throat_mm']:.2f} mm, the "
        f"wall within {mesh['wall_off_mm']:.3f} mm; no layers along the wall."
    )


def _pressure_words(level: float | None) -> list[str]:
    """Words about a wedge pressure that the solver has no place for."""
    if not level:
        return []
    return [
        "svMultiPhysics has no pressure beyond a resistance: those in its files are above the "
        f"wedge pressure of {level:.3g} mmHg, which is added where they are read."
    ]


def simulation_document(found: Simulated) -> dict[str, Any]:
    """Document of a simulation's results, for a program."""
    made = found.document
    return {
        "schema": "sdfstent-simulation-results",
        "version": 1,
        "notice": RESEARCH_USE,
        "inputs": made["inputs"],
        "notes": [*_notes(found), *NOTES],
        "main_outlet": made["main_outlet"],
        "along_mm": found.along,
        "meshes": {name: state["meshes"] for name, state in made["states"].items()},
        **{name: _moments(found, name, result) for name, result in found.fine.items()},
    }


def _moments(found: Simulated, name: str, fine: CaseResult) -> dict[str, Any]:
    """The mean, and of a wave the peak."""
    coarse = found.coarse.get(name)
    mean = _section(found, name, fine.mean, None if coarse is None else coarse.mean)
    mean["network"] = _network(found.document, name)
    if fine.peak is None:
        return {"mean": mean}
    peak = _section(found, name, fine.peak, None if coarse is None else coarse.peak)
    return {"mean": mean, "peak": peak}


def _section(found: Simulated, state: str, fine: Found, coarse: Found | None) -> dict[str, Any]:
    main, level = found.document["main_outlet"], found.document["level_mmhg"]
    values = _values(fine, main)
    others = None if coarse is None else _values(coarse, main)
    inlet = fine.faces["inlet"]
    return {
        "inflow_ml_s": -inlet.flow,
        "inlet_mmhg": None
        if level is None
        else {"static": level + inlet.pressure, "total": level + inlet.total},
        **{
            name: {"value": value, "error": None if others is None else _error(name, value, others)}
            for name, value in values.items()
        },
        "outlets": {
            name: {
                "flow_ml_s": face.flow,
                "static_mmhg": None if level is None else level + face.pressure,
            }
            for name, face in fine.faces.items()
            if name != "inlet"
        },
        "static_along_mmhg": fine.pressure + (level or 0.0),
        "fastest_along_m_s": fine.speed,
    }


def _error(name: str, fine: float, coarse: Mapping[str, float]) -> float:
    """The error bar of a value on the fine mesh."""
    return (2.0 if name.startswith("shear") else 1.0) * abs(fine - coarse[name])


def _values(found: Found, main: str) -> dict[str, float]:
    inlet, outlet = found.faces["inlet"], found.faces[main]
    return {
        "total_drop_mmhg": inlet.total - outlet.total,
        "static_drop_mmhg": inlet.pressure - outlet.pressure,
        "largest_drop_mmhg": inlet.pressure - float(np.nanmin(found.pressure)),
        "shear_mean_pa": found.shear[0],
        "shear_high_pa": found.shear[1],
    }


def _network(made: Section, name: str) -> dict[str, Any]:
    told = made["network_mmhg"][name]
    return {
        **{
            f"{key}_mmhg": dict(zip(("value", "low", "high"), told[key], strict=True))
            for key in told
        },
        "outlets_ml_s": {one["name"]: one["flow"] for one in made["states"][name]["outlets"]},
    }


def simulation_moments(document: Section) -> Moments:
    """Facts at the mean flow, and at the peak of a wave, each under a heading."""
    states = [document[name] for name in STATES]
    return [
        (f"At the {moment} flow", Facts(_facts(document, [state[moment] for state in states])))
        for moment in states[0]
    ]


def simulation_sentences(document: Section) -> list[str]:
    """Facts as lines, and the notes on them."""
    lines = []
    for heading, facts in simulation_moments(document):
        lines += [f"{heading}, before -> after:", *(f"  {one}." for one in facts)]
    return [*lines, *document["notes"]]


def _facts(document: Section, states: Sequence[Section]) -> Iterator[Fact]:
    main, networks = document["main_outlet"], [one.get("network") for one in states]
    yield _fact("flow in", [f"{one['inflow_ml_s']:.3g}" for one in states], "mL/s")
    if states[0]["inlet_mmhg"]:
        total = [f"{one['inlet_mmhg']['total']:.1f}" for one in states]
        yield _fact("total pressure at the inlet", total, "mmHg")
    for label, key, network in (
        (f"drop of total pressure to {main}", "total_drop_mmhg", "recovered_mmhg"),
        (f"drop of static pressure to {main}", "static_drop_mmhg", ""),
        ("drop of static pressure to its lowest", "largest_drop_mmhg", "maximal_mmhg"),
    ):
        known = [band_words(one[network]) for one in networks if one and network]
        yield _fact(label, [_with_error(one[key]) for one in states], "mmHg", known)
    for name in states[0]["outlets"]:
        yield _through(name, states, [one["outlets_ml_s"][name] for one in networks if one])
    for label, key in (("mean", "shear_mean_pa"), ("99th percentile", "shear_high_pa")):
        yield _fact(f"wall shear, {label}", [_with_error(one[key]) for one in states], "Pa")


def _fact(label: str, words: Sequence[str], unit: str, network: Sequence[str] = ()) -> Fact:
    """Values before and after treatment, and those of the network where it has them."""
    was, after = (f"{one} {unit}" for one in words)
    note = f" [network {' -> '.join(network)} {unit}]" if network else ""
    return Fact(label=label, unit=unit, words=after, was=was, note=note)


def _through(name: str, states: Sequence[Section], network: Sequence[float]) -> Fact:
    """The flow out of the vessel through a face, or into it through a further inlet."""
    flows = [one["outlets"][name]["flow_ml_s"] for one in states]
    is_inlet = max(flows) < 0
    each, known = ([-one if is_inlet else one for one in some] for some in (flows, network))
    label = f"flow {'in ' if is_inlet else ''}through {name}"
    return _fact(label, [f"{one:.3g}" for one in each], "mL/s", [f"{one:.3g}" for one in known])


def _with_error(one: Section) -> str:
    error = "" if one["error"] is None else f" +- {brief(one['error'])}"
    return f"{brief(one['value'])}{error}"


def _notes(found: Simulated) -> Iterator[str]:
    if found.document["level_mmhg"] is None:
        yield NO_LEVEL
    yield from _pressure_words(found.document["level_mmhg"])
    if len(found.coarse) < len(found.fine):
        yield NO_COARSE
    for name, result in found.fine.items():
        yield _mesh_words(name, found.document["states"][name])
        if result.peak is None and result.spread > UNSTEADY:
            yield (
                f"{name.capitalize()}: the flow did not become steady, the inlet pressure still "
                f"varies by {100 * result.spread:.0f} %; what is told is the mean of the last "
                "frames."
            )


def simulation_page(document: Section) -> str:
    """The page made from a document of `simulation_document`: it loads nothing from elsewhere."""
    moments = [(f"{at}, before -> after", told) for at, told in simulation_moments(document)]
    drawings = []
    for key, words in ALONG.items():
        values = {name: document[name]["mean"][key] for name in STATES}
        plot = along_plot(document["along_mm"], values, words)
        drawings.append(f"<section>{svg(plot)}</section>")
    title = "Flow in three dimensions, before and after"
    parts = [*beginning(title, document), moments_table(moments), *drawings]
    return page(title, [*parts, *notes_part(document), *file_part(document["inputs"])])
