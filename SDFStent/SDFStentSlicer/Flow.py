"""What is known of the patient's flow before treatment: L/min, mmHg and % in the panel, the library's `Known` in a plan."""

import importlib
import json
import subprocess
from dataclasses import replace

import slicer
from slicer.i18n import tr as _

from SDFStentLib.flow import Inflow, Known, Wave, has_svzerod
from SDFStentLib.plan import from_document, to_document
from SDFStentLib.validation import InputError, one_line

from .PlanFields import ML_PER_S, REMEDIES

SHOWN = 0.006
"""L/min, half of the last figure that is shown, and a little: so far the peak may be from its wave's."""

SOLVER = "svzerod>=3.2"


def waveOf(parameterNode):
    """The wave of a plan, None where there is none, or where mean and peak are no longer its own."""
    document, mean = parameterNode.get("flow.wave"), parameterNode.get("flow.mean")
    if not document or not mean:
        return None
    wave = from_document(Wave, document, "wave").scaled(mean)
    away = abs(wave.peak - (parameterNode.get("flow.peak") or 0.0)) / ML_PER_S
    return wave if away <= SHOWN * (1 + wave.peak / wave.mean) else None


def inletsOf(parameterNode, mean, hasWave):
    """The inlets of a plan with so much flow together, mL/s; their own waves where that of all is theirs."""
    found = parameterNode.get("flow.inlets") or []
    whole = sum(one["mean"] for one in found)
    return tuple(
        Inflow(one["name"], one["mean"] * mean / whole, _waveIn(one) if hasWave else None)
        for one in found
    )


def _waveIn(inlet):
    document = inlet.get("wave")
    return document and from_document(Wave, document, "wave")


def flowsIn(parameterNode):
    """The flow that comes in at each inlet, by its name, L/min."""
    mean = parameterNode.get("flow.mean") or 0.0
    return {one.name: one.mean / ML_PER_S for one in inletsOf(parameterNode, mean, False)}


def inletOf(parameterNode, names):
    """The inlet that is called one of these names, as it was called first; None where there is none."""
    own = [name.casefold() for name in names]
    return next((one for one in flowsIn(parameterNode) if one.casefold() in own), None)


def setInlet(parameterNode, names, flow):
    """Let so much blood come in, L/min, at the end that is called one of these names; at None it is no inlet.

    The first inlet brings the whole flow, whatever is asked for; of several the flow is the sum.
    Raises `InputError` where that contradicts what else is set.
    """
    known, own = knownOf(parameterNode), inletOf(parameterNode, names)
    found = {one.name: one for one in known.inlets}
    if flow is None:
        found.pop(own, None)
    else:
        name = own or names[0]
        wave = found[name].wave if own else None
        found[name] = Inflow(name, flow * ML_PER_S if found else known.mean, wave)
    mean = sum(one.mean for one in found.values()) if found else known.mean
    if not mean > 0:
        raise InputError(
            _("Flow: expected more than 0 L/min at one inlet, got none; leave one of them open.")
        )
    inlets = tuple(found.values())
    wave = None if known.is_uneven else known.wave
    setKnown(parameterNode, replace(known, mean=mean, inlets=inlets, wave=wave))


def lacksSolver(parameterNode):
    """Whether there is a wave, and the solver that it needs could be installed here."""
    wave = waveOf(parameterNode)
    return wave is not None and hasattr(slicer.util, "pip_install") and not has_svzerod()


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


def knownOf(parameterNode):
    """What is set, as the library has it; None where no flow is. Raises `InputError` for what contradicts itself."""
    flow = parameterNode.get("flow") or {}
    mean = flow.get("mean")
    if not mean:
        return None
    wave, hasPressures = waveOf(parameterNode), bool(flow.get("inlet"))
    return Known(
        mean,
        inlets=inletsOf(parameterNode, mean, wave is not None),
        bsa=flow.get("bsa"),
        peak=flow.get("peak") if wave is None else None,
        wave=wave,
        inlet=flow.get("inlet") if hasPressures else None,
        wedge=flow.get("wedge") or 0.0 if hasPressures else None,
        split_right=flow.get("split_right"),
        unusual=bool(flow.get("unusual")),
    )


def toldFlow(parameterNode):
    """The same, and None while what is set contradicts itself."""
    return None if refusal(parameterNode) else knownOf(parameterNode)


def plannedFlow(parameterNode, place):
    """The same for a plan; `place(point)` turns a place, mm in RAS, into the frame of the plan.

    A plan tells where the right branch is, for a file may not tell: as soon as that is known.
    """
    known = knownOf(parameterNode)
    if known is None or not parameterNode.rightBranch:
        return known
    return replace(known, right=place(json.loads(parameterNode.rightBranch)))


def documentOf(known):
    """The library's `Known`, or None, as the plan's document has it here: with the peak of a wave beside it."""
    if known is None:
        return None
    found = {**to_document(known), "peak": known.most}
    found.pop("right", None)  # it is found by itself
    return found


def setKnown(parameterNode, known):
    """Set what is known of the flow, the library's `Known` or None."""
    parameterNode.change({"flow": documentOf(known)})


def refusal(parameterNode):
    """Why no plan can have this flow, as a sentence; "" when it can."""
    mean, peak = parameterNode.flowMean, parameterNode.flowPeak
    if 0 < peak < mean:
        return _(
            "Results: expected a peak flow of {mean:g} L/min or more, got {peak:g} L/min; choose a larger one, or none."
        ).format(mean=round(mean, 2), peak=round(peak, 2))
    try:
        knownOf(parameterNode)
    except InputError as error:
        return _("Results: {sentence}").format(sentence=error.sentence(REMEDIES))
    return ""
