"""The module without widgets: the panel and the Python console both use this."""

import logging
import sys
import weakref

import numpy as np
import slicer
from slicer.i18n import tr as _
from slicer.ScriptedLoadableModule import ScriptedLoadableModuleLogic

from SDFStentLib.validation import DeploymentError, InputError

from . import (
    Calculating,
    Conversion,
    Dependencies,
    Deploying,
    Display,
    Flow,
    Handles,
    MadeCenterline,
    Outputs,
    Plans,
    Results,
    Showing,
)
from .Alternatives import Alternatives
from .Carrying import Carrying
from .Dragging import Dragging
from .Exporting import Exporting, Segments
from .Fitting import Fitting
from .Inputs import Inputs
from .Leavings import Removing
from .ParameterNode import stentOf, stentsOf
from .ParameterSets import ParameterSets
from .PlanFields import REMEDIES, SIZING
from .Planning import Planning
from .Portions import untilDone, working
from .Previewing import Previewing
from .Sighting import Sighting
from .Snapping import Snapping
from .Suggesting import Suggesting
from .SurfaceOutput import ShownResult


class SDFStentLogic(
    *(
        Planning,
        Fitting,
        Suggesting,
        Alternatives,
        Removing,
        Segments,
        Exporting,
        Sighting,
        ParameterSets,
    ),
    ScriptedLoadableModuleLogic,
):
    """Deploys the stents of a parameter node.

        logic = SDFStentLogic()
        parameters = logic.getParameterNode()
        parameters.vessel, parameters.centerline = vesselModel, centerlineModel
        logic.addStent(parameters, diameter=8, length=20)
        result = logic.deploy(parameters)
        print(parameters.lumenSummary, result.certificate.sentence())

    `deploy` is `steps` run to its end; `steps` can be stopped at any time. The inputs are never changed.
    """

    def __init__(self):
        ScriptedLoadableModuleLogic.__init__(self)
        # A singleton would be emptied when the scene is closed, and overwritten by that of a scene that is imported.
        self.isSingletonParameterNode = False
        self.begin()
        logic = weakref.ref(self)  # the scene outlives this object and must not keep it
        scene = slicer.mrmlScene
        scene.AddObserver(scene.EndImportEvent, lambda *_: logic() and logic().begin())
        scene.AddObserver(scene.EndCloseEvent, lambda *_: logic() and logic().forget())

    def forget(self):
        """Let go of everything that belongs to the scene, which was closed or has got other content."""
        # A wrapper that lived through an import may have cached references that were not resolved yet.
        self._wrappers = {}
        self._shown, self._inputs = {}, Inputs()
        self._snapping, self._previewing, self._dragging = Snapping(), Previewing(), Dragging()
        self._carrying = Carrying()

    # The plan

    def restoreMethod(self, parameterNode):
        """Set the method, and what a suggestion goes by, back to the defaults."""
        with slicer.util.NodeModify(parameterNode):
            parameterNode.change({"settings": {}})
            parameterNode.suggestRatio = SIZING["ratio"][1]
            parameterNode.suggestMargin = SIZING["margin"][1]

    def loadPlan(self, path, parameterNode):
        """Replace stents and method by those of a plan document; what to know about it is in `status` afterward."""
        former = [stent.handle for stent in stentsOf(parameterNode)]
        parameterNode.status = Plans.load(path, parameterNode)
        plans = map(self.parameterSet, self.getAllParameterNodes())
        used = [stent.handle for plan in plans for stent in stentsOf(plan)]
        for handle in {one for one in former if one not in used}:
            Handles.removeHandle(handle)

    def savePlan(self, path, parameterNode):
        """Write stents and method as a plan document; what to know about it is in `status` afterward."""
        parameterNode.status = Plans.save(path, parameterNode)

    # What a deployment depends on

    inputNodes = staticmethod(Dependencies.inputNodes)
    missing = staticmethod(Dependencies.missing)
    standing = staticmethod(Dependencies.standing)
    places = staticmethod(Dependencies.places)
    leave = staticmethod(Dependencies.leave)
    chooseSegment = staticmethod(Dependencies.chooseSegment)
    takenIDs = staticmethod(Outputs.takenIDs)

    def carry(self, parameterNode):
        """Bring handles and results along where the transform of what they lie in has changed since this was asked last.

        Returns whether it has.
        """
        plans = map(self.parameterSet, self.getAllParameterNodes())
        return self._carrying.follow(parameterNode, plans)

    def centerlineOf(self, parameterNode):
        """The library's centerline of a parameter node, in world coordinates."""
        return self._inputs.centerline(parameterNode)

    def makeCenterline(self, parameterNode):
        """Make a centerline of nothing but the vessel's surface, as a model, and choose it; what to know about it is in `status` afterward.

        Raises `InputError` or `DeploymentError` with a sentence where the vessel has no two ends.
        """
        untilDone(self.centerlineInPortions(parameterNode))

    def centerlineInPortions(self, parameterNode):
        """Centerline in portions: a generator that yields the share that is done and returns the one that was chosen before."""
        return (yield from MadeCenterline.portions(parameterNode, self._inputs))

    def vesselInPortions(self, parameterNode):
        """Wall of the vessel: a generator that yields None and returns its `VesselInput`."""
        return self._inputs.vesselInPortions(parameterNode)

    def lesionSearch(self, parameterNode):
        """The search for the lesions of the vessel; None before vessel and centerline are chosen.

        `for _ in search.portions(): pass` ends with `search.found`, the library's lesions, in its order.
        """
        if parameterNode.vessel is None or parameterNode.centerline is None:
            return None
        return self._inputs.lesions(parameterNode)

    def sizeLimits(self, parameterNode):
        """Largest sensible diameter and length for the sliders, mm."""
        return self._inputs.sizeLimits(parameterNode)

    # Deploying

    def deploy(self, parameterNode=None):
        """Everything in one call; returns the library's `TreatmentResult`.

        Raises `InputError` or `DeploymentError` with a sentence for the user.
        """
        parameterNode = parameterNode or self.getParameterNode()
        for _fraction in self.steps(parameterNode):
            pass
        return self.lastRun(parameterNode).result

    def steps(self, parameterNode, live=False, standing=None, mayGoOn=lambda: False):
        """Deploy step by step: an iterator over the fraction done that shows every step in the output.

        `live` is for dragging: the end of the library's preview, neither finished nor certified, with about its numbers.
        `standing` is that of the parameter node, where it was just asked for. While `mayGoOn()`, the end of a full run that
        takes a preview's place is not shown before what can be measured without it. The iterator also stops every 5 ms during longer calculations, so that whoever runs it can react.
        """
        missing, signature = standing or self.standing(parameterNode)
        if missing:
            raise InputError(missing)
        shown = self._shownOf(parameterNode)
        if shown.signature and Dependencies.areOfTwoVessels(shown.signature, signature):
            Results.clearNumbers(parameterNode, _("Not measured yet."))
            Results.clearCenterline(parameterNode)
        vessel = yield from working(self._inputs.vesselInPortions(parameterNode))
        reported = self._snapping.reported(parameterNode)
        if reported or not self.isProposal(parameterNode):
            parameterNode.status = reported
        if live:
            search = self.lesionSearch(parameterNode)
            yield from self._previewing.steps(shown, signature, vessel, self._inputs, search)
        else:
            yield from Deploying.steps(shown, signature, vessel, self._inputs, mayGoOn)
            yield from Deploying.measured(shown)

    def isFlowOld(self, parameterNode):
        """Whether the pressures and flows shown are those of other flow data than are set."""
        run = self.lastRun(parameterNode)
        isTold = run is not None and run.result is not None and parameterNode.certificateSummary
        return isTold and Flow.toldFlow(parameterNode) != run.shownFlow

    def tellFlow(self, parameterNode):
        """Show the pressures and flows of the last deployment by the flow data that are set; an iterator as `steps`."""
        yield from Deploying.flow(self._shownOf(parameterNode))

    def ranged(self, parameterNode):
        """Tell the range that half a voxel makes of the last deployment in a vessel that was made of voxels; an iterator as `steps`."""
        yield from Deploying.ranged(self._shownOf(parameterNode))

    def landmarks(self, parameterNode):
        """The library's `Landmarks` of the vessel; None before its lesions were searched, or where it has none."""
        search = self.lesionSearch(parameterNode)
        return None if search is None else search.landmarks

    def endNames(self, parameterNode):
        """The names by which the ends of the vessel are found as inlets, as the library's; none before its lesions were searched."""
        search = self.lesionSearch(parameterNode)
        return () if search is None else search.endNames

    setInlet = staticmethod(Flow.setInlet)

    def installSolver(self, parameterNode):
        """Install the solver of waves; the numbers of the last deployment are old then."""
        Flow.installSolver()
        run = self.lastRun(parameterNode)
        if run is not None:
            run.shownFlow = None

    def prepared(self, parameterNode):
        """Make what the first preview and deployment of a vessel need; an iterator as `steps`."""
        if parameterNode.vessel is not None and parameterNode.centerline is not None:
            _begun = Calculating.processes.deploying
            preview = yield from working(self._inputs.previewInPortions(parameterNode))
            yield from working(preview.prepared())

    def measure(self, parameterNode):
        """Diameters, certificate, table and plot of the last deployment; an iterator as `steps`."""
        yield from Deploying.measured(self._shownOf(parameterNode))

    # What is shown

    def _shownOf(self, parameterNode):
        """The `ShownResult` of a parameter node, always the same one."""
        node = parameterNode.parameterNode
        shown = self._shown.get(node.GetID())
        if shown is None or shown.parameterNode.parameterNode is not node:
            shown = self._shown[node.GetID()] = ShownResult(parameterNode)
        return shown

    def forgetRun(self, parameterNode):
        """Forget the last deployment."""
        self._shown.pop(parameterNode.parameterNode.GetID(), None)

    def lastRun(self, parameterNode):
        """The `Stenting` of the last deployment, with its recorded steps; None before the first."""
        return self._shownOf(parameterNode).run

    def hasChanged(self, parameterNode, standing=None):
        """Whether the results are those of another plan, or of other inputs, than the parameters have now."""
        shown = self._shownOf(parameterNode).signature
        standing = standing or self.standing(parameterNode)
        return shown is not None and shown != standing.signature

    def showsPlan(self, parameterNode):
        """Whether the stents are shown as the parameters have them now."""
        return parameterNode.outputStents is not None and not self.hasChanged(parameterNode)

    def showsEnd(self, parameterNode):
        """Whether the stents are shown deployed as the parameters have them now, not a preview of them."""
        return self.hasSteps(parameterNode) and not self.hasChanged(parameterNode)

    def hasSteps(self, parameterNode):
        """Whether the steps of a deployment are kept."""
        return self._shownOf(parameterNode).hasSteps

    def showStep(self, parameterNode, percent):
        """Show the last deployment at a percentage of its steps."""
        self._shownOf(parameterNode).step(percent)

    def showOutline(self, parameterNode):
        """Show the stented vessel's outline in the slice views again: nothing more is coming for now."""
        self._shownOf(parameterNode).outline()

    def reset(self, parameterNode):
        """Show the vessel without stents again."""
        self.showStep(parameterNode, 0)
        with slicer.util.NodeModify(parameterNode):
            parameterNode.expansion = 0.0
            Results.clearNumbers(parameterNode)

    @staticmethod
    def showLesion(lesion):
        """Center all views on a lesion."""
        Display.showPlace(lesion.point, Display.sizeRound(lesion.length))

    @staticmethod
    def showStent(parameterNode):
        """Center all views on the selected stent, once it is placed."""
        stent = stentOf(parameterNode)
        points = [] if stent.handle is None else Conversion.placedPoints(stent.handle)
        if len(points):
            length = max(stent.draft.length, float(np.linalg.norm(np.ptp(points, axis=0))))
            Display.showPlace(np.mean(points, axis=0), Display.sizeRound(length))

    showPlot = staticmethod(Showing.showPlot)
    showTable = staticmethod(Showing.showTable)

    def updateDisplay(self, parameterNode):
        """Adapt the display to the parameters; makes no nodes."""
        if (
            parameterNode.outputStents is not None
            and parameterNode.outputStents.GetDisplayNode() is not None
        ):
            parameterNode.outputStents.GetDisplayNode().SetVisibility(parameterNode.showStents)
        Display.nameFolder(parameterNode)
        run = self.lastRun(parameterNode)
        if run is None:
            return
        Results.followDevice(parameterNode, run)
        Results.followSelection(parameterNode, run)
        if run.shownMap != parameterNode.map:
            Results.showMap(parameterNode, run)

    @staticmethod
    def sentence(error):
        """Sentence for the user about an error."""
        if isinstance(error, InputError):
            return error.sentence(REMEDIES)
        if isinstance(error, DeploymentError):
            return str(error)
        return _("Unexpected error: {kind}: {text}").format(kind=type(error).__name__, text=error)

    @staticmethod
    def log(error, level=logging.INFO):
        """Put an error with its traceback into the log, at `level` when the user's sentence explains it."""
        if not isinstance(error, (InputError, DeploymentError)):
            level = logging.ERROR
        logging.log(level, "SDF Stent: %s", error, exc_info=error)

    @staticmethod
    def dropLoadedPackages():
        """Make the next import read both halves again (used by Reload)."""
        for name in [
            n for n in sys.modules if n.split(".")[0] in ("SDFStentLib", "SDFStentSlicer")
        ]:
            del sys.modules[name]
