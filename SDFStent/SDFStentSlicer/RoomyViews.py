"""The layout of views that this module offers while it is shown: a large 3D view with the plot beneath.

It is not saved with a scene: without this module, Slicer would then show no view at all.
"""

import slicer

from . import Showing

LAYOUT = 5330
"""Number of the layout, which no layout of Slicer has."""

DESCRIPTION = """
<layout type="vertical" split="true">
  <item splitSize="700">
    <view class="vtkMRMLViewNode" singletontag="1">
      <property name="viewlabel" action="default">1</property>
    </view>
  </item>
  <item splitSize="300">
    <view class="vtkMRMLPlotViewNode" singletontag="PlotView1">
      <property name="viewlabel" action="default">P</property>
    </view>
  </item>
</layout>
"""


class RoomyViews:
    """Follows the button of that name: shows this layout, and returns to the former one."""

    def __init__(self, ui):
        self._button = ui.roomyViewsButton
        self._former = self._parameterNode = None
        self._button.connect("toggled(bool)", self._follow)

    def show(self, parameterNode):
        """Show the layout for this parameter node, if the button is pressed."""
        self._parameterNode = parameterNode
        self._follow()

    def showPlot(self):
        """Show the plot, in this layout if the present one has no plot: Slicer's own layouts with a plot and a 3D view
        are wider than a small screen."""
        node = slicer.mrmlScene.GetFirstNodeByClass("vtkMRMLLayoutNode")
        if node is not None and not Showing.hasPlot(node):
            self._button.checked = True
        Showing.showPlot(self._parameterNode)

    def onLayoutChanged(self, node):
        """Release the button if the user or a scene has chosen another layout; changes while a scene is closed do not
        count."""
        isOurs = node.GetViewArrangement() == LAYOUT or node.GetScene().IsClosing()
        if self._former is not None and not isOurs:
            self._button.checked = False

    def leave(self):
        """Return to the former layout when the module is left."""
        self._parameterNode = None
        self._follow()

    def _follow(self, *_state):
        node = slicer.mrmlScene.GetFirstNodeByClass("vtkMRMLLayoutNode")
        if node is None:  # without a window
            return
        if self._parameterNode is None or not self._button.checked:
            former, self._former = self._former, None
            if former is not None:
                node.SetSaveWithScene(True)
                if node.GetViewArrangement() == LAYOUT:
                    node.SetViewArrangement(former)
            return
        if self._former is None:
            former = node.GetViewArrangement()
            if not node.IsLayoutDescription(LAYOUT):
                node.AddLayoutDescription(LAYOUT, DESCRIPTION)
            node.SetViewArrangement(LAYOUT)
            node.SetSaveWithScene(False)
            self._former = former
            if self._parameterNode.outputChart is not None:
                Showing.showPlot(self._parameterNode)
            else:  # to a view that may be new
                slicer.app.applicationLogic().PropagatePlotChartSelection()
