"""What a plan does to the flow through the vessel."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..flow import (
    FlowAnswer,
    FlowModel,
    Known,
    Part,
    SideClues,
    has_svzerod,
    solved_by_svzerod,
)
from ..treatment import TreatmentResult, Vessel
from ..units import Frame, are_apart, flipped
from ..validation import InputError, as_place
from ..vessel import SMALL_VESSEL
from .plan import Plan


def flow_model(vessel: Vessel, known: Known, frame: Frame | None = None) -> FlowModel:
    """A vessel before treatment as a network; `frame`, of the vessel, may tell where right is.

    Raises
    ------
    InputError
        No centerline, or as `FlowModel`.
    """
    if vessel.centerline is None:
        raise InputError(
            "flow: expected a centerline of the vessel tree, got none: an axis does not tell where "
            "the flow divides, nor where it goes on; name one (extract makes it), or leave the "
            "flow out."
        )
    return FlowModel(vessel.channels, known, SideClues(frame, names=vessel.given_names))


def flow_of_plan(plan: Plan, vessel: Vessel, frame: Frame | None) -> FlowModel | None:
    """`flow_model` for what a plan knows, in its frame; None where it knows nothing."""
    known = plan.flow
    if known is None:
        return None
    if known.right is not None and are_apart(plan.frame, frame):
        known = replace(known, right=as_place(flipped(np.array(known.right))))
    return flow_model(vessel, known, frame)


def flow_answer(
    model: FlowModel, vessel: Vessel, treated: TreatmentResult | None = None
) -> FlowAnswer:
    """Pressures and flows before treatment and after it, over its stents and the lesions.

    A wave is solved by `svzerod` where that is installed. `DeploymentError` where that fails.
    """
    assert vessel.centerline is not None
    after, parts = None, list[Part]()
    if treated is not None:
        assert treated.centerline is not None
        after = vessel.followed.after(treated.centerline, treated.surface)
        parts = [Part(f"stent {one.number}", one.axis.points) for one in treated.final_stents]
    for number, lesion in enumerate(vessel.lesions or (), start=1):
        if lesion.reference_diameter >= SMALL_VESSEL:
            name, before = f"lesion {number}, {lesion.branch_name}", lesion.reference_diameter
            parts.append(Part(name, lesion.line.points, before))
    return model.answer(after, parts, solved_by_svzerod if has_svzerod() else None)
