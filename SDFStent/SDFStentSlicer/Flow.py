"""Flow data of the patient before treatment: L/min, mmHg and % in the panel, mL/s in the plan."""

import importlib
import json
import subprocess
from dataclasses import replace

import slicer
from slicer.i18n import tr as _

from SDFStentLib.plan import inflows, inlet_named, known_of, lacks_solver, with_inlet
from SDFStentLib.validation import InputError, one_line

from .PlanFields import ML_PER_S, REMEDIES

SOLVER = "svzerod>=3.2"


def flowsIn(parameterNode):
    """Flows into the vessel at its inlets, by their names, L/min."""
    found = inflows(parameterNode.get("flow"))
    return {name: flow / ML_PER_S for name, flow in found.items()}


def inletOf(parameterNode, names):
    """Inlet by one of these names, as it was called first; None for none."""
    return inlet_named(parameterNode.get("flow"), names)


def setInlet(parameterNode, names, flow):
    """Set the flow, L/min, into the end of one of these names; with None that is no inlet.

    Raises `InputError` where that contradicts what else is set.
    """
    through = None if flow is None else flow * ML_PER_S
    parameterNode.change({"flow": with_inlet(parameterNode.get("flow"), names, through)})


def lacksSolver(parameterNode):
    """Whether a wave is given whose solver is missing here and can be installed."""
    return hasattr(slicer.util, "pip_install") and lacks_solver(parameterNode.get("flow"))


def installSolver():
    """Install the solver; what pip said of a failure is in Slicer's log. Raises `InputError`."""
    try:
        slicer.util.pip_install(SOLVER)
    except (subprocess.SubprocessError, RuntimeError, OSError) as error:
        raise InputError(
            _(
                'svzerod: expected to install it, got "{reason}"; mean and peak are told without it, try again once the network is there.'
            ).format(reason=one_line(str(error)))
        ) from error
    importlib.invalidate_caches()


def toldFlow(parameterNode):
    """Flow data that are set, as the library has them; None where no flow is, and while they contradict themselves."""
    return None if refusal(parameterNode) else known_of(parameterNode.get("flow"))


def plannedFlow(parameterNode, isFound=True):
    """Flow data for a plan in RAS, with the place of the right branch once it `isFound`, since a file may lack it.

    Raises `InputError` for what contradicts itself.
    """
    known = known_of(parameterNode.get("flow"))
    if known is None or not (isFound and parameterNode.rightBranch):
        return known
    return replace(known, right=tuple(json.loads(parameterNode.rightBranch)))


def refusal(parameterNode):
    """Sentence on why no plan can have this flow; "" when it can."""
    mean, peak = parameterNode.flowMean, parameterNode.flowPeak
    if 0 < peak < mean:
        return _(
            "Results: expected a peak flow of {mean:g} L/min or more, got {peak:g} L/min; choose a larger one, or none."
        ).format(mean=round(mean, 2), peak=round(peak, 2))
    try:
        known_of(parameterNode.get("flow"))
    except InputError as error:
        return _("Results: {sentence}").format(sentence=error.sentence(REMEDIES))
    return ""
