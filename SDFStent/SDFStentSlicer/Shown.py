"""What the scene shows of a parameter set."""

from . import Results
from .SurfaceOutput import outputSurface


class Shown:
    """The last deployment or preview of one parameter set as the scene shows it.

    `run` is the `Stenting` or the `PreviewRun` of it, None before the first; `signature` that of the plan and inputs it is of.
    """

    def __init__(self, parameterNode):
        self.parameterNode = parameterNode
        self.run = self.signature = self._surface = None

    def surface(self, vessel):
        """The output that shows the mesh of a `Vessel`."""
        self._surface = outputSurface(self.parameterNode, vessel, self._surface)
        return self._surface

    def isPreviewOf(self, signature):
        """Whether what is shown is the preview of the plan and inputs with a signature."""
        return self.run is not None and not self.run.recorded and self.signature == signature

    @property
    def hasSteps(self):
        """Whether there is a deployment to go back and forth over."""
        isRecorded = self.run is not None and bool(self.run.recorded)
        return isRecorded and self.parameterNode.outputVessel is not None

    def step(self, percent):
        """Show the run at a percentage of its steps."""
        if self.run is None or self._surface is None or not self._surface.isValid:
            return
        points, tubes = self.run.end() if percent >= 100 else self.run.at(percent)
        self._surface.show(points)
        Results.showStents(self.parameterNode, tubes, percent >= 100 and bool(self.run.recorded))

    def outline(self):
        """Show the outline in the slice views again: nothing more is coming for now."""
        if self._surface is not None:
            self._surface.showOutline()
