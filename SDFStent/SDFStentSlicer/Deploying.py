"""The full deployment of a parameter set: every step shown, then measured."""

from vtk.util.numpy_support import vtk_to_numpy

from . import Dependencies, Plans, Results
from .Portions import working
from .Stenting import Stenting


def steps(shown, signature, vessel, inputs):
    """Deploy the plan in a `Vessel` and show every step; an iterator as `SDFStentLogic.steps`.

    `shown` is the `Shown` of the parameter set, `inputs` the `Inputs` that the vessel is from.
    """
    parameterNode = shown.parameterNode
    hasTree = parameterNode.centerline is not None
    run = Stenting(
        vessel.surface,
        inputs.centerline(parameterNode) if hasTree else None,
        Plans.plannedOf(parameterNode),
        Plans.settingsOf(parameterNode),
        straightening=parameterNode.method.straightening / 100,
        dtype=vtk_to_numpy(vessel.polyData.GetPoints().GetData()).dtype,
        places=Dependencies.places(parameterNode),
        search=inputs.lesions(parameterNode) if hasTree else None,
        faces=vessel.faces,
    )
    surface, shown.run = shown.surface(vessel), run
    Plans.remember(parameterNode)
    surface.hideOutline()
    try:
        yield from _expand(run, surface)
    finally:
        surface.showOutline()
    lines = yield from working(run.lines())
    Results.showEnd(parameterNode, run, lines)
    shown.signature = signature
    Results.showMap(parameterNode, run)


def measured(shown):
    """Diameters, certificate, table and plot of the last deployment; an iterator as `SDFStentLogic.steps`."""
    run = shown.run
    if run is None or not run.recorded:
        return
    for _part in run.measure():
        yield 1.0
    Results.showMeasured(shown.parameterNode, run)


def _expand(run, surface):
    """Run the steps and show them; yields the fraction done."""
    fraction = 0.0
    for state in run.steps():
        if state is not None:
            fraction = state.fraction
            moved = state.deployment
            surface.show(state.before.points, moved.indices, moved.coordinates)
        yield fraction
    surface.show(run.points)
