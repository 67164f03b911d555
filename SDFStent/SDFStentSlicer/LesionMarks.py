"""Marks of lesions in the views: numbers beside them, a line along one, and a plot of it."""

import numpy as np
from slicer.i18n import tr as _

from . import Results, Showing
from .Charts import createChart
from .Handles import CURVE, POINTS
from .Marks import createMark, removeMark
from .SignPlaces import TEXT, WatchedView, besides, firstCorner

COLOR, SELECTED_COLOR = (0.65, 0.38, 0.02), (1.0, 0.36, 0.0)
"""Colors of the numbers: they can be read on light and dark views, and on the wall."""
SPACING, THICKNESS = 1.5, 1.2
"""The distance of the points of a line, mm, and its diameter, mm."""
GLYPH, NO_GLYPH = 1.5, 0.01
"""Sizes of a point; of the point of a number, which marks nothing; percent of a view."""
GROUND = (1.0, 0.97, 0.92)
"""The background of a number."""


class LesionMarks:
    """Marks of lesions that nobody can move, and a plot along one of them, its `Around` `plotted`."""

    def __init__(self):
        self._lesions, self._numbers, self._extent, self._chart = (), None, None, []
        self.plotted = self._selected = None
        self._view = WatchedView(self._placeAnew)

    def show(self, lesions):
        """Mark the library's lesions in place of all former ones; none of them is selected."""
        for node in (self._numbers, *self._chart):
            removeMark(node)
        self._lesions, self._numbers, self._chart, self.plotted = lesions, None, [], None
        with Showing.inOneFrame():
            if lesions:
                texts = [f" {number} " for number in range(1, len(lesions) + 1)]
                places = besides(lesions, Showing.firstRenderer(), firstCorner())
                self._numbers = _locked(createMark(POINTS, _("Lesions"), places, texts))
                _asSigns(self._numbers.GetDisplayNode())
            self._mark(None)
        self.followLayout()

    def followLayout(self):
        """Keep the numbers apart in the first 3D view."""
        self._view.watch(bool(self._lesions))

    def _placeAnew(self):
        """Move the numbers that lie on something as they are seen now."""
        numbers = range(len(self._lesions))
        former = [np.array(self._numbers.GetNthControlPointPositionWorld(n)) for n in numbers]
        places = besides(self._lesions, Showing.firstRenderer(), firstCorner(), former)
        with Showing.inOneFrame():
            for number, (place, old) in enumerate(zip(places, former, strict=True)):
                if not np.array_equal(place, old):
                    self._numbers.SetNthControlPointPositionWorld(number, *place)

    def hideLine(self):
        """Remove the line along the strongly marked lesion."""
        removeMark(self._extent)
        self._extent = None

    def select(self, index):
        """Mark one of them strongly, or None; what is marked so already stays."""
        if index != self._selected or (index is None) != (self._extent is None):
            with Showing.inOneFrame():
                self._mark(index)

    def _mark(self, index):
        self.hideLine()
        self._selected = index
        for number in range(len(self._lesions)):
            self._numbers.SetNthControlPointSelected(number, number == index)
        if index is not None:
            points = self._lesions[index].line.resampled(SPACING).points
            texts = [""] * len(points)
            self._extent = _locked(createMark(CURVE, _("Selected lesion"), points, texts))

    @property
    def chart(self):
        """The plot of the lesions, None without."""
        return self._chart[-1] if self._chart else None

    def plot(self, index, around):
        """Show how wide the vessel is along one of them, by its `Around`, unless the user looks at a plot of his own."""
        former, self.plotted = self._chart, around
        red, _blue, dark = Results.SERIES.values()
        self._chart = createChart(
            _("Lesion {number}: red lumen, dashed healthy vessel").format(number=index + 1),
            (_("From the root (mm)"), around.along),
            {
                _("Lumen (mm)"): (around.diameters, red),
                _("Healthy vessel (mm)"): (around.healthy, dark),
            },
        )
        for node in former:
            removeMark(node)


def _asSigns(display):
    """Numbers on a ground of their own: on the wall a 1 was read as a bracket."""
    display.SetGlyphScale(NO_GLYPH)
    text = display.GetTextProperty()
    text.BoldOn()
    text.ShadowOff()
    text.SetBackgroundColor(*GROUND)
    text.SetBackgroundOpacity(1.0)


def _locked(node):
    node.SetLocked(True)
    display = node.GetDisplayNode()
    display.SetColor(*COLOR)
    display.SetSelectedColor(*SELECTED_COLOR)
    display.SetGlyphScale(GLYPH)
    display.SetCurveLineSizeMode(display.UseLineDiameter)
    display.SetLineDiameter(THICKNESS)
    display.SetTextScale(TEXT)
    return node
