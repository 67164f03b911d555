"""Places of the numbers of lesions: beside the vessel, and not on each other as they are seen."""

import numpy as np
from vtkmodules.vtkRenderingAnnotation import vtkCornerAnnotation
from vtkmodules.vtkRenderingCore import vtkTextProperty, vtkTextRenderer

from . import Clock, Showing

TEXT = 4.0
"""Height of a number, percent of a view."""
FRONT, SIDE = np.array([0.0, 1.0, 0.0]), np.array([1.0, 0.0, 0.0])
"""Direction of the look at a patient from the front, and that across."""
NEARLY = 0.1
"""Part of a line seen from the front below which it goes to the front itself."""
BESIDE = (1.0, -1.0, 1.7, -1.7, 2.4, -2.4, 3.2, -3.2, 4.0, -4.0, 5.0, -5.0)
"""Distances of a number beside the axis, in diameters of the healthy vessel, or heights of a sign where that is more, as from afar."""
ALONG = (0.0, 0.7, -0.7, 1.4, -1.4, 2.2, -2.2, 3.0, -3.0)
"""Distances likewise along it from the narrowest place; the nearest comes first."""
APART = 5.0
"""Least distance of two numbers, where there is room, mm."""
SIGN, DIGIT = 1.2, 0.65
"""Height of a sign, and width of one of its characters, of the height of its text, as seen; its blanks are as one digit."""

REST_MS = 300
"""Rest of a view before signs move in it, ms: none does while a hand turns it."""
DPI, INSET = 72, 5
"""Dots per inch of the texts of views; pixels by which `vtkCornerAnnotation` keeps them away from the edges."""


class WatchedView:
    """Calls `onRest()` once the first 3D view rests that shows things elsewhere than before: by its camera, its size, the text in its corner."""

    def __init__(self, onRest):
        self._timer = Clock.timer(onRest, REST_MS)
        self._window = self._tag = self._seen = None

    def watch(self, isWanted):
        """Watch the first present view, if wanted, and no other."""
        self._timer.stop()
        if self._window is not None:
            self._window.RemoveObserver(self._tag)
        views = Showing.threeDViews() if isWanted else []
        self._window = views[0].renderWindow() if views else None
        if views:
            self._tag = self._window.AddObserver("EndEvent", self._onDrawn)
            self._timer.start()

    def _onDrawn(self, *_event):
        rows, _aspect = _projection(Showing.firstRenderer())
        corner = firstCorner()
        seen = *rows[[0, 1, 3]].flat, *(() if corner is None else corner)
        if seen != self._seen:
            self._seen = seen
            self._timer.start()


def firstCorner():
    """The box that the text in the upper left corner of the first 3D view fills at most, as that of a sign; None without a text."""
    views = Showing.threeDViews()
    text = views and views[0].cornerAnnotation().GetText(vtkCornerAnnotation.UpperLeft)
    if not text:
        return None
    corner, font = views[0].cornerAnnotation(), vtkTextProperty()
    font.ShallowCopy(corner.GetTextProperty())
    font.SetFontSize(corner.GetMaximumFontSize())
    box = [0, 0, 0, 0]
    vtkTextRenderer.GetInstance().GetBoundingBox(font, text, box, DPI)
    width, height = Showing.firstRenderer().GetSize()
    half = np.minimum([box[1] - box[0] + INSET, box[3] - box[2] + INSET], [width, height])
    half = half / max(height, 1)
    return np.array([half[0] - width / max(height, 1), 1.0 - half[1], *half])


def besides(lesions, renderer=None, corner=None, former=()):
    """Places of the numbers, a row each: beside the vessel as it is seen from the front, where no handle is, and none on another.

    Nor is one as the signs are seen by a `vtkRenderer` now, where none is on the `corner` (4,), a box as that of a sign; where there
    is no room, where there is most. One that is on nothing stays at its `former` place, if there are any, unless there is room
    nearer by a whole step. Of a lesion in the view it is in the view.
    """
    placed, boxes = [], []
    for number, lesion in enumerate(lesions, start=1):
        places = np.vstack([*former[number - 1 : number], _choices(lesion, renderer)])
        seen = signBoxes(places, number, renderer)
        room = np.ones(len(places)) if corner is None else signsApart(seen, corner)
        if isIn(signBoxes(np.array([lesion.point]), number, renderer) * (1, 1, 0, 0), renderer)[0]:
            room *= isIn(seen, renderer)
        for place, box in zip(placed, boxes, strict=True):
            apart = np.linalg.norm(places - place, axis=1) / APART
            room = np.minimum(room, np.minimum(apart, signsApart(seen, box)))
        best = _bestOf(places, room, lesion.point, len(former) > 0)
        placed.append(places[best])
        boxes.append(seen[best])
    return placed


def _bestOf(places, room, point, hasFormer):
    """Index of the place among (n, 3), with so much room (n,), for a lesion at a point; the first is the former one if there is one."""
    best = int(np.argmax(np.minimum(room, 1.0)))
    if hasFormer and best == 0:
        away = np.linalg.norm(places - point, axis=1)
        step = away[1]  # the nearest choice is one step away
        nearer = np.flatnonzero((room >= 1.0) & (away < away[0] - step))
        best = int(nearer[0]) if len(nearer) else 0
    return best


def _choices(lesion, renderer):
    """Places for the number of a lesion (n, 3), the nearest first."""
    across = np.cross(np.diff(lesion.line.points[[0, -1]], axis=0)[0], FRONT)
    length = np.linalg.norm(across)
    across = across / length if length > NEARLY * lesion.line.length else SIDE
    steps = sorted(
        ((beside, along) for along in ALONG for beside in BESIDE), key=lambda step: np.hypot(*step)
    )
    shifts = np.array(steps) @ [across, np.cross(across, FRONT)]
    step = max(lesion.reference_diameter, _signHeight(lesion.point, renderer))
    return lesion.point + step * shifts


def _signHeight(point, renderer):
    """Height of a sign at a point as a renderer shows it, mm; 0 without one."""
    if renderer is None:
        return 0.0
    rows, aspect = _projection(renderer)
    depth = rows[3, :3] @ point + rows[3, 3]
    return 2.0 * SIGN * _textHeight(aspect) * depth / np.linalg.norm(rows[1, :3])


def signBoxes(places, number, renderer):
    """Middles and half sizes (n, 4) of a number's sign at places (n, 3), of half the height of a view; NaN without one."""
    if renderer is None:
        return np.full((len(places), 4), np.nan)
    rows, aspect = _projection(renderer)
    seen = places @ rows[:, :3].T + rows[:, 3]
    middles = seen[:, :2] / seen[:, 3:] * (aspect, 1.0)
    half = _textHeight(aspect) * np.array([DIGIT * (len(str(number)) + 1), SIGN])
    return np.hstack([middles, np.broadcast_to(half, middles.shape)])


def isIn(boxes, renderer):
    """Whether a renderer shows the whole of boxes (n, 4) (n,); all of them without one."""
    if renderer is None:
        return np.ones(len(boxes), dtype=bool)
    ends = renderer.GetTiledAspectRatio(), 1.0
    return (np.abs(boxes[:, :2]) + boxes[:, 2:] <= ends).all(axis=1)


def signsApart(boxes, other):
    """Distances (n,) of signs (n, 4) from another one (4,): 1 where they touch, less where they lie on each other."""
    apart = np.abs(boxes[:, :2] - other[:2]) / (boxes[:, 2:] + other[2:])
    return np.nan_to_num(apart.max(axis=1), nan=np.inf)


def _textHeight(aspect):
    """Half the height of a text, of half the height of a view: it is as high as its part of the diagonal."""
    return TEXT / 100.0 * np.hypot(1.0, aspect)


def _projection(renderer):
    """The matrix (4, 4) by which a renderer shows places, and the ratio of its sides."""
    aspect = renderer.GetTiledAspectRatio()
    matrix = renderer.GetActiveCamera().GetCompositeProjectionTransformMatrix(aspect, -1.0, 1.0)
    return np.array([[matrix.GetElement(i, j) for j in range(4)] for i in range(4)]), aspect
