"""Parameters to library values and back: stents, method settings, and the plan document."""

from SDFStentLib import stent as library
from SDFStentLib.deployment import DeploymentSettings

from . import Conversion
from .ParameterNode import Placement

BY_POINT = {
    Placement.CENTER: library.AtCenter,
    Placement.DISTAL_END: library.AtDistalEnd,
    Placement.PROXIMAL_END: library.AtProximalEnd,
}


def stentsOf(parameterNode):
    """(label, library stent) of every stent that is switched on, in order."""
    return [(stent.label, _stentOf(stent)) for stent in parameterNode.stents if stent.enabled]


def settingsOf(parameterNode, live=False):
    """The library's settings; `live` ones are its preview: same method, longer steps, no finish."""
    method = parameterNode.method
    settings = DeploymentSettings.preview() if live else DeploymentSettings()
    changes = {
        "influence_distance": method.influenceDistance,
        "smoothing_width": method.smoothingWidth,
        "capsule_length": method.capsuleLength,
        "tissue_gap": method.tissueGap,
        "falloff": method.falloff,
        "rule": method.rule,
    }
    if method.step > 0 and not live:
        changes["step"] = method.step
    return settings.with_changes(**changes)


def _stentOf(stent):
    placement = _placementOf(stent)
    if stent.placement.usesHandleLength:
        return library.Stent(stent.diameter, placement=placement)
    return library.Stent(
        stent.diameter,
        placement=placement,
        length=stent.length,
        foreshortening_fraction=stent.foreshortening / 100,
    )


def _placementOf(stent):
    if stent.placement == Placement.ALONG_CURVE:
        return library.AlongAxis(Conversion.curvePoints(stent.handle))
    points = Conversion.handlePoints(stent.handle, stent.placement.pointCount, stent.label)
    if stent.placement == Placement.BETWEEN_POINTS:
        return library.BetweenPoints(*points)
    return BY_POINT[stent.placement](points[0])
