"""How high the panel is: as high as its texts are in the width that it has."""

import qt
import slicer

from . import Clock


class PanelHeight:
    """Gives the panel the height that it needs, as its least one.

    From the second visit of a module on, Slicer's module panel keeps the height that it was told first, and squeezes what does not fit
    (`qSlicerModulePanel::removeModule` leaves an item of the layout behind, which alone hears that sizes change). Least sizes it asks for anew.
    """

    def __init__(self, panel):
        self._panel = panel
        self._timer = Clock.timer(self._fit, 0)
        for section in slicer.util.findChildren(panel, className="ctkCollapsibleButton"):
            section.connect("contentsCollapsed(bool)", lambda _isCollapsed: self.fit())

    def fit(self):
        """Something in the panel may be higher or lower now."""
        self._timer.start()

    def _fit(self):
        # Layouts hear of changes one within the other, each by an event.
        qt.QCoreApplication.sendPostedEvents(None, qt.QEvent.LayoutRequest)
        needed = self._panel.layout().heightForWidth(self._panel.width)
        self._panel.minimumHeight = max(0, needed)  # -1 where no text is shown
