"""What is known of the patient's flow before treatment: L/min, mmHg and % in the panel, the library's `Known` in a plan."""

import importlib
import json
import subprocess
from dataclasses import replace

import slicer
from slicer.i18n import tr as _

from SDFStentLib.flow import Inflow, Known, Wave, has_svzerod
from SDFStentLib.validation import InputError, one_line

from .ParameterNode import REMEDIES

ML_PER_S = 1000 / 60
"""In one liter per minute."""

SHOWN = 0.006
"""L/min, half of the last figure that is shown, and a little: so far the peak may be from its wave's."""

SOLVER = "svzerod>=3.2"


def waveOf(parameterNode):
    """The wave of a plan, None where there is none, or where mean and peak are no longer its own."""
    if not parameterNode.flowWave or parameterNode.flowMean <= 0:
        return None
    wave = Wave(*map(tuple, json.loads(parameterNode.flowWave)))
    wave = wave.scaled(parameterNode.flowMean * ML_PER_S)
    isOwn = abs(wave.peak / ML_PER_S - parameterNode.flowPeak) <= SHOWN * (
        1 + wave.peak / wave.mean
    )
    return wave if isOwn else None


def inletsOf(parameterNode, mean, hasWave):
    """The inlets of a plan with so much flow together, mL/s; their own waves where that of all is theirs."""
    found = json.loads(parameterNode.flowInlets or "[]")
    whole = sum(part for _name, part, _wave in found)
    return tuple(
        Inflow(name, part * mean / whole, Wave(*map(tuple, wave)) if wave and hasWave else None)
        for name, part, wave in found
    )


def flowsIn(parameterNode):
    """By name of an inlet what comes in there, L/min."""
    return {one.name: one.mean for one in inletsOf(parameterNode, parameterNode.flowMean, False)}


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
    with slicer.util.NodeModify(parameterNode):
        for field, value in valuesOf(replace(known, mean=mean, inlets=inlets, wave=wave)).items():
            setattr(parameterNode, field, value)


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
    if parameterNode.flowMean <= 0:
        return None
    hasPressures = parameterNode.inletPressure > 0
    wave = waveOf(parameterNode)
    mean = parameterNode.flowMean * ML_PER_S
    return Known(
        mean,
        inlets=inletsOf(parameterNode, mean, wave is not None),
        bsa=parameterNode.flowBsa or None,
        peak=parameterNode.flowPeak * ML_PER_S or None if wave is None else None,
        wave=wave,
        inlet=parameterNode.inletPressure if hasPressures else None,
        wedge=parameterNode.wedgePressure if hasPressures else None,
        split_right=parameterNode.splitRight / 100 or None,
        unusual=parameterNode.flowUnusual,
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


def valuesOf(known):
    """The library's `Known`, or None, as values of the parameter node."""
    if known is None:
        names = ("flowMean", "flowPeak", "inletPressure", "wedgePressure", "splitRight", "flowBsa")
        empty = {"flowWave": "", "flowInlets": "", "flowUnusual": False}
        return {**dict.fromkeys(names, 0.0), **empty}
    wave = known.wave
    inlets = [
        (one.name, one.mean, one.wave and (one.wave.time, one.wave.flow)) for one in known.inlets
    ]
    return {
        "flowUnusual": known.unusual,
        "flowWave": "" if wave is None else json.dumps([wave.time, wave.flow]),
        "flowInlets": json.dumps(inlets) if inlets else "",
        "flowBsa": known.bsa or 0.0,
        "flowMean": known.mean / ML_PER_S,
        "flowPeak": (known.most or 0.0) / ML_PER_S,
        "inletPressure": known.inlet or 0.0,
        "wedgePressure": known.wedge or 0.0,
        "splitRight": 100 * (known.split_right or 0.0),
    }


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
