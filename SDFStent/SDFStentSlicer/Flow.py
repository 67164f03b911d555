"""The range of flow for which pressure drops are estimated: L/min in the panel, mL/s in the library."""

from slicer.i18n import tr as _

ML_PER_S = 1000 / 60
"""In one liter per minute."""

UNIT = "L/min"
"""In which the panel asks, and is answered."""


def flowOf(parameterNode):
    """The least and the most flow, mL/s; None where no pressure drop is wanted. They are the same where there is no most."""
    least, most = parameterNode.flowLeast, parameterNode.flowMost
    return (least * ML_PER_S, (most or least) * ML_PER_S) if least > 0 else None


def toldFlow(parameterNode):
    """The same, and None while what is set contradicts itself."""
    return None if refusal(parameterNode) else flowOf(parameterNode)


def valuesOf(plan):
    """The flow of a plan as values of the parameter node."""
    least, most = (0.0, 0.0) if plan.flow is None else plan.flow
    return {"flowLeast": least / ML_PER_S, "flowMost": most / ML_PER_S}


def refusal(parameterNode):
    """Why no plan can have this flow, as a sentence; "" when it can."""
    least, most = parameterNode.flowLeast, parameterNode.flowMost
    if not 0 < most < least:
        return ""
    return _(
        "Results: expected a flow at most of {least:g} L/min or more, got {most:g} L/min; choose a larger one, or less for the first."
    ).format(least=least, most=most)
