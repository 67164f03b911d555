"""Values for a lumped (0D) solver."""

from __future__ import annotations

from typing import Any

from ..cautions import Caution
from ..flow import ADULT, TURBULENCE, VesselBlock, vessel_block
from ..lumen import DiameterProfile
from ..treatment import TreatmentResult
from .pressure import flow_leaves
from .report import RESEARCH_USE


def zero_d_document(result: TreatmentResult) -> dict[str, Any]:
    """Values for the vessel blocks of a lumped (0D) solver, of every stent, before and after.

    Raises
    ------
    InputError
        A diameter along a stent could not be measured.
    """
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
