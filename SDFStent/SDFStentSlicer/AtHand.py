"""The few lines that the 3D views tell of the selected stent, in their upper left corner."""

import slicer
from vtkmodules.vtkRenderingAnnotation import vtkCornerAnnotation

from SDFStentLib.report import CERTIFIED, NOT_CERTIFIED

PENDING, GOOD, BAD = "pending", "good", "bad"
COLORS = {PENDING: (0.85, 0.87, 0.90), GOOD: (0.62, 0.93, 0.66), BAD: (1.0, 0.72, 0.45)}
"""On `BACKGROUND`, which lets them be read on any view. What a color says stands in the last line, too."""
BACKGROUND, OPACITY = (0.08, 0.10, 0.13), 0.65
LARGEST_FONT = 18


class AtHand:
    """Shows lines in all 3D views. `text` is what is shown, `kind` one of `COLORS`."""

    def __init__(self):
        self.text, self.kind = "", PENDING

    def show(self, text, instead=""):
        """Show lines, one a row; `instead` of the last what else is to be known of them, where something is."""
        lines = text.split("\n")
        if text and instead:
            lines[-1] = instead
        kind = {CERTIFIED: GOOD, NOT_CERTIFIED: BAD}.get(lines[-1], PENDING)
        self.text, self.kind = "\n".join(lines), kind
        self.write()

    def write(self):
        """Write the lines into the views that do not show them yet, as those of another layout."""
        for view in _views():
            corner = view.cornerAnnotation()
            font, color = corner.GetTextProperty(), COLORS[self.kind]
            shown = corner.GetText(vtkCornerAnnotation.UpperLeft) or ""
            if shown == self.text and (not shown or font.GetColor() == color):
                continue
            corner.SetMaximumFontSize(LARGEST_FONT)
            corner.SetText(vtkCornerAnnotation.UpperLeft, self.text)
            font.SetColor(*color)
            font.BoldOn()  # thin letters are hard to read from where an operator stands
            font.ShadowOff()
            font.SetBackgroundColor(*BACKGROUND)
            font.SetBackgroundOpacity(OPACITY if self.text else 0.0)
            view.scheduleRender()


def _views():
    """The 3D views of the application; none without a window."""
    manager = slicer.app.layoutManager()
    count = 0 if manager is None else manager.threeDViewCount
    return [manager.threeDWidget(number).threeDView() for number in range(count)]
