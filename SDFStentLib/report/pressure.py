"""The pressure drop of a stent's stretch before and after, in documents and words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

from ..measure import (
    ADULT,
    TOO_LOW,
    DiameterProfile,
    VesselBlock,
    pressure_band,
    vessel_block,
)
from ..plan import PlanResult
from ..treatment import TreatedStent
from ..validation import InputError

NOTE = (
    "Bands of closed forms (Poiseuille with Young and Tsai's loss behind a stenosis, by inscribed "
    "and by equivalent diameters, and 4 v^2), steady flow, rigid wall, "
    f"{ADULT.density:g} kg/m3 and {1e3 * ADULT.viscosity:g} mPa s. The upper end is the highest "
    f"form times {TOO_LOW[True]:g} in a stenosis and times {TOO_LOW[False]:g} without one: such "
    "forms are too low by as much, after a stent above all. No measured gradient."
)

Flow = tuple[float, float]


def pressure_section(stent: TreatedStent, flow: Flow | None) -> dict[str, Any] | None:
    """The bands before and after at the least and at the most flow; None without a flow."""
    if flow is None:
        return None
    reason = _why_not(stent)
    section: dict[str, Any] = {"flow_ml_s": flow, "note": NOTE, "not_estimated": reason}
    for name, profile in (("before", stent.before), ("after", stent.after)):
        bands = None if reason else [pressure_band(profile, value) for value in flow]
        section[f"{name}_mmhg"] = bands and [[band.low, band.high] for band in bands]
    return section


def stent_pressure_sentences(stent: TreatedStent, flow: Flow | None) -> list[str]:
    """What the shell says of it; nothing without a flow."""
    section = pressure_section(stent, flow)
    return [] if section is None else [pressure_words(section), *_note(section)]


def pressure_words(section: Mapping[str, Any]) -> str:
    """A section in one sentence."""
    if section["not_estimated"]:
        return f"Pressure drop: not estimated; {section['not_estimated']}."
    flows = section["flow_ml_s"]
    spans = [
        ", ".join(
            f"{low:.2g} to {high:.2g} mmHg at {value:g} mL/s"
            for value, (low, high) in dict(zip(flows, section[f"{name}_mmhg"], strict=True)).items()
        )
        for name in ("before", "after")
    ]
    return f"Pressure drop over the stented length, estimated: before {spans[0]}; after {spans[1]}."


def pressure_part(stents: Sequence[Mapping[str, Any]]) -> list[str]:
    """A part of the page; nothing without a flow."""
    told = [(stent["number"], stent["pressure"]) for stent in stents if stent.get("pressure")]
    if not told:
        return []
    label = "Stent {}: " if len(told) > 1 else ""
    lines = "".join(
        f"<p>{escape(label.format(number) + pressure_words(one))}</p>" for number, one in told
    )
    return [f"<h2>Pressure</h2>{lines}<p class='small'>{escape(NOTE)}</p>"]


def zero_d_document(result: PlanResult) -> dict[str, Any]:
    """Values for the vessel blocks of a lumped (0D) solver, of every stent, before and after.

    Raises
    ------
    InputError
        A diameter along a stent could not be measured.
    """
    return {
        "notice": "Research use only, not a medical device.",
        "units": "cgs: R in dyn s/cm^5, L in dyn s^2/cm^5, S in dyn s^2/cm^8, length in cm",
        "formula": "P_in - P_out = (R_poiseuille + stenosis_coefficient |Q|) Q + L dQ/dt",
        "stenosis_coefficient": "K_t density / (2 A_0^2) (A_0/A_s - 1)^2, K_t = 1.52; A_0 mean of "
        "the ends, A_s the narrowest; inscribed diameters",
        "capacitance": "C is 0: the wall is rigid",
        "density_g_cm3": ADULT.density / 1000,
        "viscosity_poise": ADULT.viscosity * 10,
        "vessels": [
            {"vessel_name": f"stent {stent.number}, {name}", **_block(_measured(profile))}
            for stent in result.treatment.stents
            for name, profile in (("before", stent.before), ("after", stent.after))
        ],
    }


def _measured(profile: DiameterProfile) -> VesselBlock:
    return vessel_block(profile.arc_length, profile.inscribed_diameter)


def _block(block: VesselBlock) -> dict[str, Any]:
    """A vessel as svZeroDSolver has it: SI to cgs."""
    return {
        "vessel_length": 100 * block.length,
        "zero_d_element_type": "BloodVessel",
        "zero_d_element_values": {
            "R_poiseuille": 1e-5 * block.resistance,
            "L": 1e-5 * block.inertance,
            "C": 0.0,
            "stenosis_coefficient": 1e-11 * block.stenosis,
        },
    }


def _why_not(stent: TreatedStent) -> str | None:
    """What flow leaves by, or where the lumen is not known."""
    length = float(stent.before.arc_length[-1])
    within = [one.name for one in stent.branches if one.start < length and one.end > 0]
    if within:
        return f"flow leaves through {' and '.join(within)} within the stent"
    try:
        for profile in (stent.before, stent.after):
            pressure_band(profile, 1.0)
    except InputError:
        return "a diameter along the stent could not be measured"
    return None


def _note(section: Mapping[str, Any]) -> list[str]:
    return [] if section["not_estimated"] else [section["note"]]
