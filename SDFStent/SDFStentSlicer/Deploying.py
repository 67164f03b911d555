"""The full deployment of a parameter set: shown, then measured."""

from vtkmodules.util.numpy_support import vtk_to_numpy

from SDFStentLib.geometry import Precision

from . import Conversion, Dependencies, Flow, Plans, Previewing, Results
from .Portions import ELSEWHERE, inPortions, isPortion, working
from .Previewing import PreviewRun
from .Stenting import Stenting


def steps(shown, signature, vessel, inputs, mayGoOn=lambda: False):
    """Deploy the plan in a `Vessel` and show every step; an iterator as `SDFStentLogic.steps`.

    A preview of the same plan is not taken back, though: what it shows stays until the end takes its place. While `mayGoOn()`,
    what can be measured before the end is shown comes first; and where there is no such preview, only what has grown is shown, as one.
    `shown` is the `ShownResult` of the parameter set, `inputs` the `Inputs` that the vessel is from.
    """
    parameterNode, isPreviewed = shown.parameterNode, shown.isPreviewOf(signature)
    run = yield from working(_begun(parameterNode, vessel, inputs))
    surface = shown.surface(vessel)
    if isPreviewed or mayGoOn():
        surface.hideOutline()
        yield from _grow(shown, signature, run, None if isPreviewed else surface)
        if mayGoOn():
            yield from working(run.survey(), fraction=lambda: 1.0)
    else:
        shown.run = run
        surface.hideOutline()
        try:
            yield from _expand(run, surface)
        finally:
            surface.showOutline()
    # Before anything is shown: what comes of it is seen in one frame.
    lines = yield from working(run.lines(), fraction=lambda: 1.0)
    surface.show(run.points)
    surface.showOutline()
    shown.run, shown.signature = run, signature
    Results.showEnd(parameterNode, run, lines)
    Results.showMap(parameterNode, run)
    yield 1.0


def _begun(parameterNode, vessel, inputs):
    """Place the stents; yields None until that is done, then returns the `Stenting`."""
    patient = yield from inputs.patientInPortions(parameterNode)
    search = None if patient.centerline is None else inputs.lesions(parameterNode)
    precision = Precision(dtype=vtk_to_numpy(vessel.polyData.GetPoints().GetData()).dtype)
    case = Plans.caseOf(parameterNode, patient, precision=precision)
    yield from inputs.placedInPortions(parameterNode, case)
    further = {
        "places": Dependencies.places(parameterNode),
        "search": search,
        "remark": vessel.remark,
        "halfVoxel": Conversion.halfVoxel(
            parameterNode.vessel, Conversion.segmentOf(parameterNode)
        ),
    }
    return (yield from inPortions(lambda: Stenting(case, **further)))


def measured(shown):
    """Diameters, certificate, table and plot of the last deployment; an iterator as `SDFStentLogic.steps`."""
    run = shown.run
    if run is None or not run.recorded:
        return
    yield from working(run.measure(), fraction=lambda: 1.0)
    Results.showMeasured(shown.parameterNode, run)
    yield from flow(shown)


def flow(shown):
    """Pressures and flows of the last deployment, as far as they are known; an iterator as `SDFStentLogic.steps`."""
    run, known = shown.run, Flow.toldFlow(shown.parameterNode)
    if known == run.shownFlow:
        return
    former = run.flowRemark
    yield from working(run.findFlow(known), fraction=lambda: 1.0)
    Results.showFlow(shown.parameterNode, run, former)


def ranged(shown):
    """The range that half a voxel makes of the last deployment, where it is measured; an iterator as `SDFStentLogic.steps`."""
    run, parameterNode = shown.run, shown.parameterNode
    if run is None or not run.recorded or run.result is None:
        return
    yield from working(run.findRange(), fraction=lambda: 1.0)
    if shown.run is run and parameterNode.certificateSummary:  # else the numbers were taken away
        Results.showRange(parameterNode, run)


def _grow(shown, signature, run, surface=None):
    """Run the steps and show in a surface, where one is given, what has grown in the end, as a preview; yields the fraction done."""
    fraction = 0.0
    for state in run.steps():
        if not isPortion(state):
            fraction = state.fraction
            if surface is not None and state.deployment.is_grown:
                grown = PreviewRun.grown(run, state)
                grown.follow(shown.run)
                Previewing.show(shown, surface, grown, signature)
                Results.tellMeasuring(shown.parameterNode, run)
        yield ELSEWHERE if state is ELSEWHERE else fraction


def _expand(run, surface):
    """Run the steps and show them in a surface; yields the fraction done."""
    fraction = 0.0
    for state in run.steps():
        if not isPortion(state):
            fraction = state.fraction
            moved = state.deployment
            surface.show(state.before.points, moved.indices, moved.coordinates)
        yield ELSEWHERE if state is ELSEWHERE else fraction
