"""What the module does, without widgets: the panel and the Python console both use this."""

import logging
import sys
import time
import weakref

import numpy as np
import slicer
from slicer.i18n import tr as _
from slicer.ScriptedLoadableModule import ScriptedLoadableModuleLogic
from vtk.util.numpy_support import vtk_to_numpy

from SDFStentLib.stent import DEFAULT_FORESHORTENING, AtCenter
from SDFStentLib.treatment import placement_at
from SDFStentLib.validation import DeploymentError, InputError

from . import Dependencies, Display, Handles, Outputs, Plans, Results
from .Inputs import Inputs
from .ParameterNode import STENT_FIELDS, MethodParameters, Placement, SDFStentParameterNode
from .Snapping import Snapping
from .Stenting import Stenting
from .StentList import StentList
from .SurfaceOutput import outputSurface

NUMBERS_EVERY_S = 0.15
"""Previews are measured no more often: a number that changes faster is not read."""


class SDFStentLogic(ScriptedLoadableModuleLogic):
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
        self.forget()
        logic = weakref.ref(self)  # the scene outlives this object and must not keep it
        for event in (slicer.mrmlScene.EndCloseEvent, slicer.mrmlScene.EndImportEvent):
            slicer.mrmlScene.AddObserver(event, lambda *_: logic() and logic().forget())

    def forget(self):
        """Let go of everything that belongs to the scene, which was closed or has got other content."""
        # A wrapper that lived through an import may have cached references that were not resolved yet.
        self._wrappers = {}
        self._runs, self._surfaces, self._signatures, self._inputs = {}, {}, {}, Inputs()
        self._snapping = Snapping()
        self._numbersTime = 0.0

    def getParameterNode(self):
        """The parameters that the panel starts with."""
        return self.parameterSet(super().getParameterNode())

    def parameterSet(self, node):
        """The parameters in a `vtkMRMLScriptedModuleNode`, always the same object for the same node."""
        wrapper = self._wrappers.get(node.GetID())
        if wrapper is None or wrapper.parameterNode is not node:
            wrapper = self._wrappers[node.GetID()] = SDFStentParameterNode(node)
        return wrapper

    def addParameterSet(self, name):
        """Another plan in the same scene, with inputs, stents and outputs of its own; returns its parameters."""
        node = slicer.mrmlScene.CreateNodeByClass("vtkMRMLScriptedModuleNode")
        node.UnRegister(None)
        node.SetName(slicer.mrmlScene.GenerateUniqueName(name))
        node.SetAttribute("ModuleName", self.moduleName)
        return self.parameterSet(slicer.mrmlScene.AddNode(node))

    # The plan's stents

    @staticmethod
    def stentList(parameterNode):
        """The ordered list of stents, to add, copy, remove, move and switch them."""
        return StentList(parameterNode)

    def addStent(self, parameterNode, **values):
        """Append a stent, with a handle of its own unless `handle` is given; returns the handle.

        The handle is put at the middle of the centerline. Along a curve, which is the placement where there is no centerline,
        it is a curve without points, for the user to draw.
        """
        unknown = set(values) - set(STENT_FIELDS)
        if unknown:
            raise InputError(
                f"Stent: expected values of {', '.join(STENT_FIELDS)}, got {', '.join(sorted(unknown))}."
            )
        stents = StentList(parameterNode)
        if "handle" not in values:
            if parameterNode.centerline is None:
                values.setdefault("placement", Placement.ALONG_CURVE)
            else:
                values.setdefault("diameter", self._inputs.suggestedDiameter(parameterNode))
            values.setdefault("label", stents.freeLabel())
            values["handle"] = self._newHandle(parameterNode, values)
        if values.get("placement", Placement.CENTER).usesHandleLength:
            values.setdefault("foreshortening", 0.0)
        stents.add(**values)
        return values["handle"]

    def _newHandle(self, parameterNode, values):
        placement = values.get("placement", Placement.CENTER)
        if placement == Placement.ALONG_CURVE:
            return Handles.createHandle(slicer.mrmlScene, values["label"], [], Handles.CURVE)
        centerline = self._inputs.centerline(parameterNode)
        handle = Handles.createHandle(
            slicer.mrmlScene, values["label"], [Handles.middlePoint(centerline)]
        )
        Handles.fitHandle(handle, placement, centerline, values.get("length", 20.0))
        return handle

    def copyStent(self, parameterNode):
        """Append a copy of the selected stent with a handle of its own."""
        stents = StentList(parameterNode)
        stents.copy(Handles.copyHandle(parameterNode.stent.handle, stents.freeLabel()))

    def removeStent(self, parameterNode):
        """Remove the selected stent, and its handle if this module made it."""
        handle = parameterNode.stent.handle
        StentList(parameterNode).remove()
        if handle not in [stent.handle for stent in parameterNode.stents]:
            Handles.removeHandle(handle)

    def fitHandle(self, parameterNode):
        """Give the selected stent's handle the points that its placement needs."""
        stent = parameterNode.stent
        stent.foreshortening = 0.0 if stent.placement.usesHandleLength else 10.0
        if stent.handle is not None and parameterNode.centerline is not None:
            Handles.fitHandle(
                stent.handle, stent.placement, self._inputs.centerline(parameterNode), stent.length
            )

    def snapHandle(self, parameterNode, handle):
        """Move a handle's points onto the centerline; from how far, where that is far, is in `status` afterwards.

        Raises `InputError` with a sentence where no stent can be, as outside of the lumen; then the handle stays where it is.
        """
        stents = [stent for stent in parameterNode.stents if stent.handle is handle]
        if stents and parameterNode.centerline is not None and not self.missing(parameterNode):
            surface = self._inputs.vessel(parameterNode).surface
            self._snapping.snap(stents[0], self._inputs.centerline(parameterNode), surface)
            parameterNode.status = self._snapping.told(parameterNode)

    def restoreMethod(self, parameterNode):
        """Set the method back to its defaults."""
        parameterNode.planDocument = ""
        parameterNode.method = MethodParameters()

    def loadPlan(self, path, parameterNode):
        """Replace stents and method by those of a plan document; what to know about it is in `status` afterwards."""
        parameterNode.status = Plans.load(path, parameterNode)

    def savePlan(self, path, parameterNode):
        """Write stents and method as a plan document; what to know about it is in `status` afterwards."""
        parameterNode.status = Plans.save(path, parameterNode)

    # What a deployment depends on

    inputNodes = staticmethod(Dependencies.inputNodes)
    missing = staticmethod(Dependencies.missing)
    signature = staticmethod(Dependencies.signature)
    leave = staticmethod(Dependencies.leave)
    chooseSegment = staticmethod(Dependencies.chooseSegment)
    takenIDs = staticmethod(Outputs.takenIDs)

    def centerlineOf(self, parameterNode):
        """The library's centerline of a parameter node, in world coordinates."""
        return self._inputs.centerline(parameterNode)

    def lesionSearch(self, parameterNode):
        """The search for the lesions of the vessel; None before vessel and centerline are chosen.

        `for _ in search.portions(): pass` ends with `search.found`, the library's lesions, the tightest first.
        """
        if parameterNode.vessel is None or parameterNode.centerline is None:
            return None
        return self._inputs.lesions(parameterNode)

    def addStentAt(self, parameterNode, lesion):
        """Append a stent at a lesion, as wide as the healthy vessel there; returns the handle.

        Expanded it is as long as the lesion, whose ends are where the lumen is within a tenth of the healthy one; in whole mm.
        """
        length = float(np.ceil(lesion.length / (1 - DEFAULT_FORESHORTENING)))
        place = placement_at(lesion, self._inputs.centerline(parameterNode), length)
        handle = self.addStent(
            parameterNode,
            diameter=round(lesion.reference_diameter, 1),
            length=length,
            placement=Placement.CENTER if isinstance(place, AtCenter) else Placement.DISTAL_END,
        )
        handle.SetNthControlPointPositionWorld(0, *place.point)
        return handle

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
        return self._runs[parameterNode.parameterNode.GetID()].result

    def steps(self, parameterNode, live=False):
        """Deploy step by step: an iterator over the fraction done that shows every step in the output.

        `live` is for dragging: the end of the library's preview, neither finished nor certified, with about the minimum lumen.
        The iterator also stops every 10 ms during longer calculations, so that whoever runs it can react.
        """
        missing = self.missing(parameterNode)
        if missing:
            raise InputError(missing)
        vessel = self._inputs.vessel(parameterNode)
        signature = self.signature(parameterNode)
        parameterNode.status = self._snapping.told(parameterNode)
        if live:
            yield from self._preview(parameterNode, vessel)
        else:
            yield from self._deploy(parameterNode, vessel)
        self._signatures[parameterNode.parameterNode.GetID()] = signature
        run = self.lastRun(parameterNode)
        Results.showMap(parameterNode, run)
        if live:
            yield from self._previewNumbers(parameterNode, run)
        else:
            yield from self.measure(parameterNode)

    def _preview(self, parameterNode, vessel):
        """Show what the library's preview says of the plan."""
        method = parameterNode.method
        portions = self._inputs.preview(parameterNode).portions(
            Plans.plannedOf(parameterNode),
            Plans.settingsOf(parameterNode, live=True),
            method.straightening / 100,
            Dependencies.places(parameterNode),
        )
        surface = self._surface(parameterNode, vessel)
        surface.hideOutline()  # until nothing more is coming
        run = yield from _working(portions)
        surface.showChanged(run.state.indices, run.state.coordinates)
        self._runs[parameterNode.parameterNode.GetID()] = run
        Results.showStents(parameterNode, run.tubes())
        parameterNode.expansion = 100.0

    def _previewNumbers(self, parameterNode, run):
        """Show about the minimum lumen, unless that was done just now."""
        if time.perf_counter() - self._numbersTime < NUMBERS_EVERY_S:
            return
        lumens = yield from _working(run.lumens())
        self._numbersTime = time.perf_counter()
        Results.showPreviewed(parameterNode, run, lumens)

    def prepared(self, parameterNode):
        """Make what the first preview and deployment of a vessel need; an iterator as `steps`."""
        if parameterNode.vessel is not None and parameterNode.centerline is not None:
            yield from _working(self._inputs.preview(parameterNode).prepared())

    def _surface(self, parameterNode, vessel):
        """The output that shows the vessel's mesh."""
        key = parameterNode.parameterNode.GetID()
        former = self._surfaces.get(key)
        self._surfaces[key] = outputSurface(parameterNode, vessel.polyData, former)
        return self._surfaces[key]

    def _deploy(self, parameterNode, vessel):
        """Show every step of the plan's deployment."""
        centerline = (
            None if parameterNode.centerline is None else self._inputs.centerline(parameterNode)
        )
        run = Stenting(
            vessel.surface,
            centerline,
            Plans.plannedOf(parameterNode),
            Plans.settingsOf(parameterNode),
            straightening=parameterNode.method.straightening / 100,
            dtype=vtk_to_numpy(vessel.polyData.GetPoints().GetData()).dtype,
            places=Dependencies.places(parameterNode),
            search=None if centerline is None else self._inputs.lesions(parameterNode),
            faces=vessel.faces,
        )
        surface = self._surface(parameterNode, vessel)
        self._runs[parameterNode.parameterNode.GetID()] = run
        Plans.remember(parameterNode)
        surface.hideOutline()
        try:
            yield from _expand(run, surface)
        finally:
            surface.showOutline()
        Results.showEnd(parameterNode, run)

    def measure(self, parameterNode):
        """Diameters, certificate, table and plot of the last deployment; an iterator as `steps`."""
        run = self.lastRun(parameterNode)
        if run is None or not run.recorded:
            return
        for _part in run.measure():
            yield 1.0
        Results.showMeasured(parameterNode, run)

    def lastRun(self, parameterNode):
        """The `Stenting` of the last deployment, with its recorded steps; None before the first."""
        return self._runs.get(parameterNode.parameterNode.GetID())

    def hasChanged(self, parameterNode):
        """Whether the results are those of another plan, or of other inputs, than the parameters have now."""
        signature = self._signatures.get(parameterNode.parameterNode.GetID())
        return signature is not None and signature != self.signature(parameterNode)

    def hasSteps(self, parameterNode):
        """Whether there is a deployment to go back and forth over."""
        run = self.lastRun(parameterNode)
        return run is not None and bool(run.recorded) and parameterNode.outputVessel is not None

    def showStep(self, parameterNode, percent):
        """Show the last deployment at a percentage of its steps."""
        run = self.lastRun(parameterNode)
        surface = self._surfaces.get(parameterNode.parameterNode.GetID())
        if run is None or surface is None or not surface.isValid:
            return
        points, tubes = run.end() if percent >= 100 else run.at(percent)
        surface.show(points)
        Results.showStents(parameterNode, tubes)

    def showOutline(self, parameterNode):
        """Show the stented vessel's outline in the slice views again: nothing more is coming for now."""
        surface = self._surfaces.get(parameterNode.parameterNode.GetID())
        if surface is not None:
            surface.showOutline()

    def reset(self, parameterNode):
        """Show the vessel without stents again."""
        self.showStep(parameterNode, 0)
        with slicer.util.NodeModify(parameterNode):
            parameterNode.expansion = 0.0
            Results.clearNumbers(parameterNode)

    # Showing

    showPlace = staticmethod(Display.showPlace)

    def updateDisplay(self, parameterNode):
        """Bring what is shown into line with the parameters; makes no nodes."""
        if (
            parameterNode.outputStents is not None
            and parameterNode.outputStents.GetDisplayNode() is not None
        ):
            parameterNode.outputStents.GetDisplayNode().SetVisibility(parameterNode.showStents)
        run = self.lastRun(parameterNode)
        if run is None:
            return
        Results.followSelection(parameterNode, run)
        if run.shownMap != parameterNode.map:
            Results.showMap(parameterNode, run)

    def showPlot(self, parameterNode):
        """Show the chart in a layout that has a plot."""
        slicer.modules.plots.logic().ShowChartInLayout(parameterNode.outputChart)

    def showTable(self, parameterNode):
        """Show the table in a layout that has one."""
        layout = slicer.mrmlScene.GetFirstNodeByClass("vtkMRMLLayoutNode")
        if layout is not None:
            tables = slicer.modules.tables.logic()
            layout.SetViewArrangement(tables.GetLayoutWithTable(layout.GetViewArrangement()))
        selection = slicer.app.applicationLogic().GetSelectionNode()
        selection.SetActiveTableID(parameterNode.outputTable.GetID())
        slicer.app.applicationLogic().PropagateTableSelection()

    @staticmethod
    def sentence(error):
        """What the user reads about an error."""
        if isinstance(error, (InputError, DeploymentError)):
            return str(error)
        return _("Unexpected error: {kind}: {text}").format(kind=type(error).__name__, text=error)

    @staticmethod
    def log(error):
        """Put an error with its traceback into the log; what the user's sentence explains is no error of the module."""
        isExplained = isinstance(error, (InputError, DeploymentError))
        level = logging.INFO if isExplained else logging.ERROR
        logging.log(level, "SDF Stent: %s", error, exc_info=error)

    @staticmethod
    def dropLoadedPackages():
        """Make the next import read both halves again (used by Reload)."""
        for name in [
            n for n in sys.modules if n.split(".")[0] in ("SDFStentLib", "SDFStentSlicer")
        ]:
            del sys.modules[name]


def _working(portions):
    """Yield 0.0 for every portion of a calculation; returns what it returns."""
    # Ends: with the calculation.
    while True:
        try:
            next(portions)
        except StopIteration as end:
            return end.value
        yield 0.0


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
