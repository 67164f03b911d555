"""The lesions of the vessel in the views: a number at the narrowest place of each, the selected one along its whole length."""

import slicer
from slicer.i18n import tr as _

from .Handles import CURVE, POINTS, removeWhole

COLOR, SELECTED_COLOR = (0.65, 0.38, 0.02), (1.0, 0.36, 0.0)
"""Of the numbers: they can be read on light and dark views, and on the wall."""
SPACING, THICKNESS = 1.5, 1.2
"""Of the points of a line, mm, and its diameter, mm."""
GLYPH, TEXT = 1.5, 4.0
"""Of a point, less than of a handle, which may be there; of a number beside it; percent of a view."""


class LesionMarks:
    """Markups to look at only: nobody can move, choose or save them. They are seen through what lies before them."""

    def __init__(self):
        self._lesions, self._numbers, self._extent = (), None, None

    def show(self, lesions):
        """Mark the library's lesions in place of all former ones; none of them is selected."""
        _remove(self._numbers)
        self._lesions, self._numbers = lesions, None
        if lesions:
            texts = [f"  {number}" for number in range(1, len(lesions) + 1)]
            points = [lesion.point for lesion in lesions]
            self._numbers = _shown(POINTS, _("Lesions"), points, texts)
        self.select(None)

    def select(self, index):
        """Mark one of them strongly, or None."""
        _remove(self._extent)
        self._extent = None
        for number in range(len(self._lesions)):
            self._numbers.SetNthControlPointSelected(number, number == index)
        if index is not None:
            points = self._lesions[index].line.resampled(SPACING).points
            self._extent = _shown(CURVE, _("Selected lesion"), points, [""] * len(points))


def _shown(className, name, points, texts):
    """A node of markups that is in nobody's way."""
    scene = slicer.mrmlScene
    node = scene.CreateNodeByClass(className)
    node.UnRegister(None)
    node.SetName(name)
    node.SetHideFromEditors(True)
    node.SetSaveWithScene(False)
    node.SetLocked(True)
    for number, (point, text) in enumerate(zip(points, texts, strict=True)):
        node.AddControlPointWorld(point, text)
        node.SetNthControlPointVisibility(number, bool(text))
    selection = slicer.app.applicationLogic().GetSelectionNode()
    placed, className = selection.GetActivePlaceNodeID(), selection.GetActivePlaceNodeClassName()
    with slicer.util.NodeModify(selection):  # else it would be the one to which clicks add points
        scene.AddNode(node)
        selection.SetReferenceActivePlaceNodeClassName(className)
        selection.SetActivePlaceNodeID(placed)
    node.CreateDefaultDisplayNodes()
    display = node.GetDisplayNode()
    display.SetSaveWithScene(False)
    display.SetColor(*COLOR)
    display.SetSelectedColor(*SELECTED_COLOR)
    display.SetPropertiesLabelVisibility(False)
    display.SetGlyphScale(GLYPH)
    display.SetOccludedVisibility(True)
    display.SetOccludedOpacity(1.0)
    display.SetCurveLineSizeMode(display.UseLineDiameter)
    display.SetLineDiameter(THICKNESS)
    display.SetTextScale(TEXT)
    return node


def _remove(node):
    if node is not None and node.GetScene() is not None:
        removeWhole(node)
