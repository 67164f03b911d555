"""The lesions of the vessel in the views: numbers beside them, a line along one, and a plot of it."""

import numpy as np
from slicer.i18n import tr as _

from . import Results, Showing
from .Charts import createChart
from .Handles import CURVE, POINTS
from .Marks import createMark, removeMark

COLOR, SELECTED_COLOR = (0.65, 0.38, 0.02), (1.0, 0.36, 0.0)
"""Of the numbers: they can be read on light and dark views, and on the wall."""
SPACING, THICKNESS = 1.5, 1.2
"""Of the points of a line, mm, and its diameter, mm."""
GLYPH, TEXT, NO_GLYPH = 1.5, 4.0, 0.01
"""Of a point; of a number; of the point of one, which marks nothing; percent of a view."""
GROUND = (1.0, 0.97, 0.92)
"""Of a number."""
FRONT, SIDE = np.array([0.0, 1.0, 0.0]), np.array([1.0, 0.0, 0.0])
"""To where one looks who looks at a patient, and across that."""
NEARLY = 0.1
"""Part of a line seen from the front below which it goes to the front itself."""
BESIDE = (1.0, -1.0, 1.7, -1.7, 2.4, -2.4, 3.2, -3.2, 4.0, -4.0, 5.0, -5.0)
"""So many diameters of the healthy vessel beside its axis a number may stand."""
ALONG = (0.0, 0.7, -0.7, 1.4, -1.4, 2.2, -2.2, 3.0, -3.0)
"""And so many along it from the narrowest place; what is nearest comes first."""
APART = 5.0
"""Between two numbers at least, where there is room, mm."""
SIGN, DIGIT = 1.1, 0.65
"""Height of a sign, and width of one of its characters, of the height of its text, as seen; its blanks are as one digit."""


class LesionMarks:
    """Markups to look at only, which nobody can move, and a plot along one of them, its `Around` `plotted`."""

    def __init__(self):
        self._lesions, self._numbers, self._extent, self._chart = (), None, None, []
        self.plotted = self._selected = None

    def show(self, lesions):
        """Mark the library's lesions in place of all former ones; none of them is selected."""
        for node in (self._numbers, *self._chart):
            removeMark(node)
        self._lesions, self._numbers, self._chart, self.plotted = lesions, None, [], None
        with Showing.inOneFrame():
            if lesions:
                texts = [f" {number} " for number in range(1, len(lesions) + 1)]
                self._numbers = _locked(
                    createMark(
                        POINTS, _("Lesions"), _besides(lesions, Showing.firstRenderer()), texts
                    )
                )
                _asSigns(self._numbers.GetDisplayNode())
            self._mark(None)

    def hideLine(self):
        """Take away the line along the one that is marked strongly."""
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
        """That plot, None without."""
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


def _besides(lesions, renderer=None):
    """Where the numbers stand, a row each: beside the vessel as it is seen from the front, where no handle is, and none on another.

    Nor is one as the signs are seen by a `vtkRenderer` now; where there is no room, where there is most.
    """
    placed, boxes = [], []
    for number, lesion in enumerate(lesions, start=1):
        places = _choices(lesion)
        seen = signBoxes(places, number, renderer)
        room = np.full(len(places), np.inf)
        for place, box in zip(placed, boxes, strict=True):
            apart = np.linalg.norm(places - place, axis=1) / APART
            room = np.minimum(room, np.minimum(apart, signsApart(seen, box)))
        best = int(np.argmax(np.minimum(room, 1.0)))
        placed.append(places[best])
        boxes.append(seen[best])
    return placed


def _choices(lesion):
    """Places for the number of a lesion (n, 3), the nearest first."""
    across = np.cross(np.diff(lesion.line.points[[0, -1]], axis=0)[0], FRONT)
    length = np.linalg.norm(across)
    across = across / length if length > NEARLY * lesion.line.length else SIDE
    steps = sorted(
        ((beside, along) for along in ALONG for beside in BESIDE), key=lambda step: np.hypot(*step)
    )
    shifts = np.array(steps) @ [across, np.cross(across, FRONT)]
    return lesion.point + lesion.reference_diameter * shifts


def signBoxes(places, number, renderer):
    """Middles and half sizes (n, 4) of a number's sign at places (n, 3), of half the height of a view; NaN without one."""
    if renderer is None:
        return np.full((len(places), 4), np.nan)
    aspect = renderer.GetTiledAspectRatio()
    matrix = renderer.GetActiveCamera().GetCompositeProjectionTransformMatrix(aspect, -1.0, 1.0)
    rows = np.array([[matrix.GetElement(i, j) for j in range(4)] for i in range(4)])
    seen = places @ rows[:, :3].T + rows[:, 3]
    middles = seen[:, :2] / seen[:, 3:] * (aspect, 1.0)
    # A text is as high as its part of the diagonal of the view.
    text = TEXT / 100.0 * np.hypot(1.0, aspect)
    half = text * np.array([DIGIT * (len(str(number)) + 1), SIGN])
    return np.hstack([middles, np.broadcast_to(half, middles.shape)])


def signsApart(boxes, other):
    """How far signs (n, 4) are from another one (4,): 1 where they touch, less where they lie on each other (n,)."""
    apart = np.abs(boxes[:, :2] - other[:2]) / (boxes[:, 2:] + other[2:])
    return np.nan_to_num(apart.max(axis=1), nan=np.inf)


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
