"""What a stent does to the pressure, estimated, and values for a lumped (0D) solver."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import TYPE_CHECKING, Any

from ..cautions import Caution
from ..lumen import DiameterProfile
from ..treatment import TreatedStent, TreatmentResult
from ..validation import InputError
from .words import RESEARCH_USE

if TYPE_CHECKING:
    from ..flow import VesselBlock

Flow = tuple[float, float]

L_PER_MIN = 0.06
"""In one mL/s."""


def pressure_note() -> str:
    """What has to be known of the bands."""
    # Late, here and below: a deployment without a flow does without the room.
    from ..flow import ADULT, TOO_LOW

    return (
        "Bands of closed forms (Poiseuille with Young and Tsai's loss behind a stenosis, by "
        "inscribed and by equivalent diameters, and 4 v^2), steady flow, rigid wall, "
        f"{ADULT.density:g} kg/m3 and {1e3 * ADULT.viscosity:g} mPa s. The upper end is the "
        f"highest form times {TOO_LOW[True]:g} in a stenosis and times {TOO_LOW[False]:g} without "
        "one: such forms are too low by as much, after a stent above all. No measured gradient."
    )


def pressure_section(stent: TreatedStent, flow: Flow | None) -> dict[str, Any] | None:
    """The bands before and after at the least and at the most flow; None without a flow."""
    if flow is None:
        return None
    from ..flow import pressure_band

    reason = _why_not(stent)
    section: dict[str, Any] = {"flow_ml_s": flow, "note": pressure_note(), "not_estimated": reason}
    for name, profile in (("before", stent.before), ("after", stent.after)):
        bands = None if reason else [pressure_band(profile, value) for value in flow]
        section[f"{name}_mmhg"] = bands and [[band.low, band.high] for band in bands]
    return section


def stent_pressure_sentences(
    stent: TreatedStent, flow: Flow | None, unit: str = "mL/s"
) -> list[str]:
    """What is said of it at a flow in mL/s; nothing without one. `unit` as of `pressure_words`."""
    section = pressure_section(stent, flow)
    return [] if section is None else [pressure_words(section, unit), *_note(section)]


def pressure_words(section: Mapping[str, Any], unit: str = "mL/s") -> str:
    """A section in one sentence, for a reader who has given the flow in mL/s or in L/min."""
    if section["not_estimated"]:
        return f"Pressure drop: not estimated; {section['not_estimated']}."
    flows = section["flow_ml_s"]
    spans = [
        ", ".join(
            f"{low:.2g} to {high:.2g} mmHg at {_flow_words(value, unit)}"
            for value, (low, high) in dict(zip(flows, section[f"{name}_mmhg"], strict=True)).items()
        )
        for name in ("before", "after")
    ]
    return f"Pressure drop over the stented length, estimated: before {spans[0]}; after {spans[1]}."


def _flow_words(flow: float, unit: str) -> str:
    """A flow, mL/s, in the unit in which it was given, and roughly in the other."""
    values = {"mL/s": flow, "L/min": flow * L_PER_MIN}
    given = values.pop(unit)
    ((other, value),) = values.items()
    return f"{given:.4g} {unit} ({value:.3g} {other})"


def pressure_part(stents: Sequence[Mapping[str, Any]]) -> list[str]:
    """A part of the page; nothing without a flow."""
    told = [(stent["number"], stent["pressure"]) for stent in stents if stent.get("pressure")]
    if not told:
        return []
    label = "Stent {}: " if len(told) > 1 else ""
    lines = "".join(
        f"<p>{escape(label.format(number) + pressure_words(one))}</p>" for number, one in told
    )
    return [f"<h2>Pressure</h2>{lines}<p class='small'>{escape(pressure_note())}</p>"]


def flow_leaves(stent: TreatedStent) -> str | None:
    """By which side branches flow leaves within a stent, which no form for one tube knows."""
    length = float(stent.before.arc_length[-1])
    within = [one.name for one in stent.branches if one.start < length and one.end > 0]
    return f"flow leaves through {' and '.join(within)} within the stent" if within else None


def _why_not(stent: TreatedStent) -> str | None:
    """What flow leaves by, or where the lumen is not known."""
    if leaves := flow_leaves(stent):
        return leaves
    from ..flow import pressure_band

    try:
        for profile in (stent.before, stent.after):
            pressure_band(profile, 1.0)
    except InputError:
        return "a diameter along the stent could not be measured"
    return None


def _note(section: Mapping[str, Any]) -> list[str]:
    return [] if section["not_estimated"] else [section["note"]]


def zero_d_document(result: TreatmentResult) -> dict[str, Any]:
    """Values for the vessel blocks of a lumped (0D) solver, of every stent, before and after.

    Raises
    ------
    InputError
        A diameter along a stent could not be measured.
    """
    from ..flow import ADULT, TURBULENCE

    twice = [one.numbers for one in zero_d_cautions(result) if one.kind == "blocks-overlap"]
    return {
        "notice": RESEARCH_USE,
        "units": "cgs: R in dyn s/cm^5, L in dyn s^2/cm^5, S in dyn s^2/cm^8, length in cm",
        "formula": "P_in - P_out = (R_poiseuille + stenosis_coefficient |Q|) Q + L dQ/dt",
        "stenosis_coefficient": "K_t density / (2 A_0^2) (A_0/A_s - 1)^2, "
        f"K_t = {TURBULENCE:g}; A_0 mean of the ends, A_s the narrowest; inscribed diameters",
        "capacitance": "C is 0: the wall is rigid",
        # One block has one flow: where this is not empty, its values alone mislead.
        "not_one_vessel": {
            f"stent {stent.number}": leaves
            for stent in result.final_stents
            if (leaves := flow_leaves(stent))
        },
        # Nor may blocks that have a stretch of vessel in common be put in series as they are.
        "length_in_both_cm": {
            f"stents {one['first']} and {one['second']}": 0.1 * float(one["length_mm"])
            for one in twice
        },
        "density_g_cm3": ADULT.density / 1000,
        "viscosity_poise": ADULT.viscosity * 10,
        "vessels": [
            {"vessel_name": f"stent_{stent.number}_{name}", **_block(_measured(profile))}
            for stent in result.final_stents
            for name, profile in (("before", stent.before), ("after", stent.after))
        ],
    }


def zero_d_cautions(result: TreatmentResult) -> tuple[Caution, ...]:
    """What has to be known before the blocks are put into a network."""
    found = []
    for stent in result.final_stents:
        if leaves := flow_leaves(stent):
            found.append(Caution("block-divides", {"number": stent.number, "leaves": leaves}))
    overlaps = (one.numbers for one in result.warnings if one.kind == "overlap")
    return (*found, *(Caution("blocks-overlap", numbers) for numbers in overlaps))


def _measured(profile: DiameterProfile) -> VesselBlock:
    from ..flow import vessel_block

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
