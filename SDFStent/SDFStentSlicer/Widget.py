"""The panel: wires widgets to the logic and enables what can be done."""

import logging

import slicer
from slicer.ScriptedLoadableModule import ScriptedLoadableModuleWidget
from slicer.util import VTKObservationMixin
from vtkmodules.vtkCommonCore import vtkCommand

from . import Clock, Outputs, Showing
from .Binder import Binder
from .DeploySession import DeploySession
from .DeviceSection import DeviceSection
from .ExportSection import ExportSection, SegmentSection
from .FlowSection import FlowSection
from .History import HistoryButtons
from .LesionTable import LesionTable
from .Logic import SDFStentLogic
from .LowWindow import LowWindow
from .PanelParts import PanelSize
from .PanelState import PanelState
from .ParameterNode import stentsOf
from .PlaceSection import PlaceSection
from .PlanTable import PlanTable
from .Portions import RestedRun, SteppedRun
from .RoomyViews import RoomyViews
from .SceneEvents import InputWatch, SceneEvents
from .ShapeSection import ShapeSection
from .StentButtons import StentButtons
from .StentEnds import StentEnds
from .StentList import StentList
from .StentTable import StentTable
from .TypedNumbers import TypedNumbers
from .VesselSection import VesselSection
from .ViewSection import ViewSection

RECOIL_MS = 250
"""A stent has to rest so long for its recoil by the rule."""


class SDFStentWidget(SceneEvents, StentButtons, ScriptedLoadableModuleWidget, VTKObservationMixin):
    """See `SDFStentLogic` for everything that is computed; this class knows only how it is asked for and shown."""

    def __init__(self, parent=None, logic=None):
        ScriptedLoadableModuleWidget.__init__(self, parent)
        VTKObservationMixin.__init__(self)
        self.logic = logic
        self.session = self.stents = self.binder = self.table = self.lesions = self.plans = (
            self._state
        ) = None
        self._size = self._typed = self._parameterNode = self._lastSet = self._leavings = None
        self._present, self._chosen, self._timers = [], None, []
        self._inputs = InputWatch(
            self.onInputModified, self.onHandleGrabbed, self.onHandleReleased, self.onHandleMoved
        )

    # Life cycle

    def setup(self):
        ScriptedLoadableModuleWidget.setup(self)
        uiWidget = slicer.util.loadUI(self.resourcePath("UI/SDFStent.ui"))
        self.layout.addWidget(uiWidget)
        self.ui = slicer.util.childWidgetVariables(uiWidget)
        self.ui.parameterSetSelector.addAttribute(
            "vtkMRMLScriptedModuleNode", "ModuleName", self.moduleName
        )
        self.ui.outputSelector.addAttribute("vtkMRMLModelNode", Outputs.ATTRIBUTE, "outputVessel")
        uiWidget.setMRMLScene(slicer.mrmlScene)
        with Clock.listed() as self._timers:
            self._makeSections(uiWidget)
            self._connect()
            self._observeScene(slicer.mrmlScene)
        self.initializeParameterNode()
        self.logic.showPlan(self._parameterNode)

    def _makeSections(self, uiWidget):
        self.logic = self.logic or SDFStentLogic()
        self.session = DeploySession(
            self.logic,
            self._onStart,
            self._onProgress,
            self._onDone,
            self._carry,
            lambda: self.recoil.hurry(),
            lambda: self._attempt(self.recoil.finish),
        )
        self._size, self._typed = PanelSize(uiWidget), TypedNumbers(uiWidget, self._attempt)
        self._state = PanelState(self.ui, self.logic, self.session, self._size)
        self.binder = Binder(self.ui, self._attempt)
        self.vessel = VesselSection(self.ui, self.logic, self._attempt)
        self.table = StentTable(self.ui, self._onSelectStent, self._onEnableStent)
        self.lesions = LesionTable(
            self.ui,
            self.logic.lesionSearch,
            self._onSelectLesion,
            self._prepare,
            lambda: self._size.room,
        )
        self.plans = PlanTable(self.ui, self.logic, self._attempt, self._switchTo)
        self.sections = [
            kind(self.ui, self.logic, self._attempt)
            for kind in (
                HistoryButtons,
                PlaceSection,
                DeviceSection,
                ShapeSection,
                FlowSection,
                ExportSection,
                SegmentSection,
            )
        ]
        self.sight = ViewSection(self.ui, self.logic, self._attempt, self._state.atHand.showAngles)
        self.views = RoomyViews(self.ui)
        self.ends = StentEnds(self.logic, self._isDeploying, self.session.letGo)
        self.window = LowWindow()
        self.recoil = RestedRun(
            lambda: self.logic.recoilByRule(self._parameterNode), self._onPrepared, RECOIL_MS
        )
        self.sections[0].isAwaited = lambda: self.recoil.isBusy
        self.vessel.making.onMade = self.sections[0].join
        self.preparation, self.ranging = (
            SteppedRun(lambda _value: None, self._onPrepared) for _ in range(2)
        )
        self._carrying = Clock.timer(self._carry, 0)

    def cleanup(self):
        for button in (self.plans.comparing, self.sections[-1].writing, self.vessel.making):
            button.stop()
        self.setParameterNode(None)
        self.removeObservers()
        for timer in self._timers:  # what they call has no widgets any more
            timer.stop()

    def enter(self):
        self._added.stop()  # what came before is no news
        self.window.enter()
        self.initializeParameterNode()
        self.vessel.chooseOnly(self._parameterNode)

    def exit(self):
        self.setParameterNode(None)
        self.views.leave()
        self.window.leave()

    def onReload(self):
        self.logic.dropLoadedPackages()
        ScriptedLoadableModuleWidget.onReload(self)

    # Parameter node

    def initializeParameterNode(self):
        """Show the last shown parameter set, or the selected one, or the module's first."""
        isThere = self._lastSet is not None and self._lastSet.GetScene() is slicer.mrmlScene
        node = self._lastSet if isThere else self.logic.markedPlan()
        node = node or self.ui.parameterSetSelector.currentNode()
        self.setParameterNode(
            self.logic.getParameterNode() if node is None else self.logic.parameterSet(node)
        )

    def onParameterSetSelected(self, node):
        """Change over to another node, the first one as well; only a panel that is shown does."""
        if self._parameterNode is not None and node is not self._parameterNode.parameterNode:
            self.setParameterNode(None)
            self._lastSet = node
            self.initializeParameterNode()
            self.logic.showPlan(self._parameterNode)

    def _switchTo(self, parameterNode):
        self.onParameterSetSelected(parameterNode.parameterNode)

    def setParameterNode(self, parameterNode):
        """Show and observe another parameter node, or none."""
        if parameterNode is self._parameterNode:
            return
        if self._parameterNode is not None:
            self.removeObserver(
                self._parameterNode.parameterNode,
                vtkCommand.ModifiedEvent,
                self.onParameterNodeModified,
            )
            self._inputs.watch([])
            for widget in (self.ui.placeWidget, self.ui.segmentPlaceWidget):
                widget.setCurrentNode(None)
            self._parameterNode.status = ""  # of a click that is long ago when this is shown again
        self._parameterNode = parameterNode
        for run in (self.preparation, self.ranging, self._suggesting):
            run.cancel()
        self.session.setParameterNode(parameterNode)
        self.stents = None
        self.binder.show(None)
        self.vessel.show(None)
        self.lesions.follow(parameterNode)
        self.recoil.follow(*self.logic.recoilStanding(parameterNode))
        self.plans.show(None)
        if parameterNode is None:
            self._state.atHand.show("")
            for section in (self.ends, self.sight):
                section.leave()
        else:
            self._lastSet = parameterNode.parameterNode
            self.logic.markShown(parameterNode)
            self.ui.parameterSetSelector.setCurrentNode(self._lastSet)
            taken = self.logic.takenIDs(parameterNode, "outputVessel")
            self.ui.outputSelector.sortFilterProxyModel().hiddenNodeIDs = taken
            self._chosen = parameterNode.vessel, parameterNode.centerline
            self.stents = StentList(parameterNode)
            self.addObserver(
                parameterNode.parameterNode,
                vtkCommand.ModifiedEvent,
                self.onParameterNodeModified,
            )
            self.onParameterNodeModified()

    def onParameterNodeModified(self, caller=None, event=None):
        if self._parameterNode is None:
            return
        self.vessel.show(self._parameterNode)  # first: what is not offered cannot be shown
        self.binder.show(self._parameterNode)
        chosen = self._parameterNode.vessel, self._parameterNode.centerline
        if chosen != self._chosen:
            Showing.inPlaceOf(self._chosen, chosen)
            self._chosen = chosen
            self._parameterNode.status = ""  # what was said is of others
        self.logic.chooseSegment(self._parameterNode)
        Showing.inOneColor(self._parameterNode.vessel, self._parameterNode.centerline)
        self._inputs.watch(self.logic.inputNodes(self._parameterNode))
        self._carrying.start()
        self.lesions.follow(self._parameterNode)
        self.recoil.follow(*self.logic.recoilStanding(self._parameterNode))
        self.table.show(stentsOf(self._parameterNode), self._parameterNode.selected)
        self._state.show(self._parameterNode)
        self._showSections()
        self._requestUpdate()

    def _showSections(self):
        self.logic.followLandmarks(self._parameterNode)
        self.logic.giveWay(self._parameterNode)
        for section in (*self.sections, self.plans, self.views, self.ends, self.sight):
            section.show(self._parameterNode)

    def onInputModified(self):
        self._carrying.start()  # who hardens a transform changes the content first
        self.lesions.follow(self._parameterNode)
        self.recoil.follow(*self.logic.recoilStanding(self._parameterNode))
        self._showSections()
        self._state.enable(self._parameterNode)
        self._requestUpdate()

    def _isDeploying(self):
        return self.session.isBusy and not self.logic.showsEnd(self._parameterNode)

    def _carry(self):
        if self._parameterNode is not None and self.logic.carry(self._parameterNode):
            self.sections[0].restart()

    def _requestUpdate(self):
        if self._parameterNode is None:
            return
        if self._parameterNode.autoUpdate:
            self.session.request()
        self.session.followFlow()

    # Deploying

    def _onStart(self):
        self.ranging.cancel()
        self.ui.progressBar.value = 0
        self._state.enable(self._parameterNode)

    def _onProgress(self, fraction):
        self.ui.progressBar.value = int(100 * fraction)

    def _onDone(self, error, standing):
        self.ui.progressBar.value = 0 if error else 100
        if error is not None:  # of a hand that goes on there may be many
            self._showError(error, logging.DEBUG if self.session.isPreview else logging.INFO)
        elif self._parameterNode is not None:
            self.ranging.cancel()
            self.ranging.start(self.logic.ranged(self._parameterNode))
        self._state.enable(self._parameterNode, standing)

    def _showError(self, error, level=logging.INFO):
        self.logic.log(error, level)
        if self._parameterNode is not None:  # what was begun before may end when nothing is shown
            self._parameterNode.status = self.logic.sentence(error)
            self._state.enable(self._parameterNode)

    # Buttons

    def _connect(self):
        self.ui.parameterSetSelector.connect(
            "currentNodeChanged(vtkMRMLNode*)", self.onParameterSetSelected
        )
        self.ui.deployButton.connect("clicked()", self.onDeploy)
        self.ui.cancelButton.connect("clicked()", self.onCancel)
        self.ui.beforeButton.connect("clicked()", self.onBefore)
        self.ui.expansionSlider.connect("valueChanged(double)", self.onExpansionChanged)
        self.ui.showPlotButton.connect("clicked()", self.views.showPlot)
        self.ui.showTableButton.connect(
            "clicked()", lambda: self.logic.showTable(self._parameterNode)
        )
        self.ui.placeCollapsibleButton.connect(
            # A section that is opened shows what was hidden while it was closed.
            "contentsCollapsed(bool)",
            lambda _isClosed: self._state.enable(self._parameterNode),
        )
        self.ui.defaultsButton.connect(
            "clicked()", lambda: self.logic.restoreMethod(self._parameterNode)
        )
        self._connectStents()

    def _onSelectLesion(self, lesion):
        self.logic.showLesion(lesion)

    def _prepare(self):
        """Let the first preview wait for nothing that can be made now; the vessel is known by now."""
        self.preparation.cancel()
        if self._parameterNode is not None:
            self._state.show(self._parameterNode)
            self._showSections()
            self.preparation.start(self.logic.prepared(self._parameterNode))

    def _onPrepared(self, error):
        if error is not None:
            self.logic.log(error)  # the user hears of it when something is deployed

    def onDeploy(self):
        self._attempt(self.recoil.finish)
        self.session.start()

    def onExpansionChanged(self, percent):
        if self._parameterNode is not None and not self.session.isRunning:
            self.logic.showStep(self._parameterNode, percent)

    def onBefore(self):
        """The vessel without stents, or with them again."""
        self.ui.expansionSlider.value = 0.0 if self.ui.expansionSlider.value > 0 else 100.0

    def onCancel(self):
        self.session.cancel()
        self.ui.progressBar.value = 0
        self._state.enable(self._parameterNode)

    def _attempt(self, action):
        """Do what a button asks for; when the input does not allow it, say the library's sentence."""
        try:
            action()
        except (ValueError, RuntimeError, OSError) as error:
            self._showError(error)
