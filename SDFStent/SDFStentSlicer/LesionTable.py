"""The lesions of the vessel, in a table of the panel and in the views."""

import numpy as np
import qt
from slicer.i18n import tr as _

from SDFStentLib.report import degree_word, lesion_sentences
from SDFStentLib.vessel import SMALLEST_DEGREE

from . import Clock, Results
from .Charts import createChart
from .Handles import CURVE, POINTS
from .Marks import createMark, removeMark
from .PanelParts import fitColumns
from .Portions import SteppedRun, working

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
BESIDE = (1.0, -1.0, 1.7, -1.7, 2.4, -2.4)
"""So many diameters of the healthy vessel beside its axis a number may stand."""
APART = 5.0
"""Between two numbers at least, where there is room, mm."""


class LesionMarks:
    """Markups to look at only, which nobody can move, and a plot along one of them, its `Around` `plotted`."""

    def __init__(self):
        self._lesions, self._numbers, self._extent, self._chart = (), None, None, []
        self.plotted = None

    def show(self, lesions):
        """Mark the library's lesions in place of all former ones; none of them is selected."""
        for node in (self._numbers, *self._chart):
            removeMark(node)
        self._lesions, self._numbers, self._chart, self.plotted = lesions, None, [], None
        if lesions:
            texts = [f" {number} " for number in range(1, len(lesions) + 1)]
            self._numbers = _locked(createMark(POINTS, _("Lesions"), _besides(lesions), texts))
            _asSigns(self._numbers.GetDisplayNode())
        self.select(None)

    def hideLine(self):
        """Take away the line along the one that is marked strongly."""
        removeMark(self._extent)
        self._extent = None

    def select(self, index):
        """Mark one of them strongly, or None."""
        self.hideLine()
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


def _besides(lesions):
    """Where the numbers stand, a row each: beside the vessel as it is seen from the front, where no handle is, and none on another."""
    placed = []
    for lesion in lesions:
        across = np.cross(np.diff(lesion.line.points[[0, -1]], axis=0)[0], FRONT)
        length = np.linalg.norm(across)
        across = across / length if length > NEARLY * lesion.line.length else SIDE
        steps = lesion.reference_diameter * np.outer(BESIDE, across)
        places = np.add(lesion.point, steps)
        apart = [min((np.linalg.norm(one - p) for p in placed), default=np.inf) for one in places]
        free = [place for place, room in zip(places, apart, strict=True) if room >= APART]
        placed.append(free[0] if free else places[int(np.argmax(apart))])
    return placed


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


LEAST, ROW = 72, 24
"""Pixels of the table with two rows, as in the `.ui` file, and of a row."""

LOOK_MS = 200
"""So often it is looked whether the mouse has left the table."""

SETTLE_MS = 250
"""The vessel has to rest so long, so that nothing is searched while it is being edited."""


class LesionTable:
    """Searches in small portions once vessel and centerline are chosen, and shows in `ui.lesionTable` what was found.

    `roomOf()` tells how many pixels it may be higher. `onSelect(lesion)` is called when the user selects a lesion; `selected` is that one, None without. `onFound()` is called when
    a search has ended and the vessel could be measured.
    """

    def __init__(self, ui, searchOf, onSelect, onFound, roomOf=lambda: 0):
        self.ui, self._searchOf, self._onSelect, self._onFound = ui, searchOf, onSelect, onFound
        self._roomOf = roomOf
        self._parameterNode = self._search = self._inputs = None
        self._updating, self._marks = False, LesionMarks()
        self._run = SteppedRun(lambda _value: None, self._done)
        self._plotting = SteppedRun(lambda _value: None, self._onPlotted)
        self._timer = Clock.timer(self._begin, SETTLE_MS)
        fitColumns(ui.lesionTable)
        ui.lesionTable.connect("itemSelectionChanged()", self._selectionChanged)
        ui.lesionTable.connect("cellClicked(int,int)", self._clicked)
        ui.lesionTable.connect("cellActivated(int,int)", self._activated)
        ui.lesionTable.connect("cellEntered(int,int)", self._entered)
        ui.lesionTable.setMouseTracking(True)
        self._hovering = Clock.timer(self._look, LOOK_MS)
        self._show("")

    @property
    def isBusy(self):
        """Whether a search is under way or about to start."""
        runs = self._run, self._plotting
        return any(run.isRunning for run in runs) or self._timer.isActive()

    @property
    def selected(self):
        """The lesion that the user has selected, or None."""
        row = self.ui.lesionTable.currentRow()
        found = () if self._search is None else self._search.found or ()
        isSelected = bool(self.ui.lesionTable.selectedItems())
        return found[row] if isSelected and 0 <= row < len(found) else None

    @property
    def chart(self):
        """The plot chart of a lesion, None without."""
        return self._marks.chart

    @property
    def plotted(self):
        """The `Around` of that plot, None without."""
        return self._marks.plotted

    def follow(self, parameterNode):
        """Show the lesions of a parameter node's vessel, or of none; called whenever its inputs may have changed.

        Those of another vessel are gone at once; those of one that is edited stay until it rests.
        """
        inputs = parameterNode and (parameterNode.vessel, parameterNode.centerline)
        if parameterNode is not self._parameterNode or inputs != self._inputs:
            self._leave()
            if inputs and None not in inputs:
                self._show("", state=_("Looking for lesions..."))
        self._parameterNode, self._inputs = parameterNode, inputs
        if parameterNode is not None:
            self._timer.start()

    def hideLine(self):
        """Mark the selected lesion by its number only, so that the stent in it is seen; a click on it shows the line again."""
        self._marks.hideLine()

    def clearSelection(self):
        """Select no lesion."""
        self.ui.lesionTable.clearSelection()

    def _leave(self):
        self._timer.stop()
        self._run.cancel()
        self._plotting.cancel()
        self._search = None
        self._show("")

    def _begin(self):
        try:
            search = self._searchOf(self._parameterNode)
        except ValueError as error:
            self._leave()
            self._show(str(error))
            return
        if search is self._search:
            return
        self._leave()
        self._search = search
        if search is not None:
            self._show("", state=_("Looking for lesions..."))
            self._run.start(0.0 for _part in search.portions())

    def _done(self, error):
        search = self._search
        if error is not None or search.sentence:
            # Vessel and centerline do not belong together: there something else is to be chosen.
            self.ui.inputsCollapsibleButton.collapsed = False
        if error is not None:
            self._show(str(error))
        else:
            none = _("No lesion of {percent} % or more was found.")
            none = none.format(percent=round(100 * SMALLEST_DEGREE))
            said = "\n".join(filter(None, (search.remark, search.sentence)))
            self._show(said, search.found, "" if search.found or search.sentence else none)
            if not search.sentence:
                self._onFound()

    def _show(self, sentence, lesions=(), state=""):
        """A sentence, and the lesions with a row each, or a `state` in their place, which is as high: what lies below stays."""
        table = self.ui.lesionTable
        rows = [([state], state)] if state else []
        for number, lesion in enumerate(lesions, 1):
            side = "" if self._search is None else self._search.sideOf(lesion)
            rows.append((_texts(number, lesion, side), " ".join(lesion_sentences(number, lesion))))
        self._updating = True
        try:
            table.clearSelection()
            table.setRowCount(len(rows))
            for row, (texts, tip) in enumerate(rows):
                for column, text in enumerate(texts):
                    item = qt.QTableWidgetItem(text)
                    item.setToolTip(tip)
                    if state:
                        item.setFlags(qt.Qt.ItemIsEnabled)
                    table.setItem(row, column, item)
        finally:
            self._updating = False
        self._marks.show(lesions)
        if lesions:
            self._plot(0)
        self._reach(len(rows))
        table.visible = len(rows) > 0
        self._offer()
        self.ui.lesionLabel.text = sentence
        self.ui.lesionLabel.visible = bool(sentence)

    def _reach(self, count):
        """Be as high as all rows need, as far as the window has room; what lies below moves only when a search ends."""
        table = self.ui.lesionTable
        table.minimumHeight = table.maximumHeight = LEAST
        more = min(max(0, count - 2), self._roomOf() // ROW) * ROW
        table.minimumHeight = table.maximumHeight = LEAST + more

    def _offer(self):
        self.ui.suggestButton.enabled = self.selected is not None

    def _selectionChanged(self):
        self._offer()
        if not self._updating:
            self._marks.select(None if self.selected is None else self.ui.lesionTable.currentRow())
            if self.selected is not None:
                self._plot(self.ui.lesionTable.currentRow())
                self._onSelect(self.selected)

    def _plot(self, row):
        """As long as there is no result to be plotted."""
        if self._parameterNode.outputChart is None:
            self._plotting.cancel()
            self._plotting.start(self._plotted(self._search, row))

    def _plotted(self, search, row):
        """Plot a lesion once the vessel on both sides of it is measured; yields until then."""
        around = yield from working(search.around(search.found[row]))
        self._marks.plot(row, around)
        yield 1.0

    @staticmethod
    def _onPlotted(error):
        if error is not None:
            raise error

    def _clicked(self, _row, _column):
        """Go there again when the selected one is clicked once more."""
        self._selectionChanged()

    def _entered(self, row, _column):
        """Mark in the view what the mouse is on in the table."""
        found = () if self._search is None else self._search.found or ()
        if row < len(found):
            self._marks.select(row)
            self._hovering.start()

    def _look(self):
        """Mark the selected one again once the mouse has left."""
        if self.ui.lesionTable.underMouse():
            self._hovering.start()
        elif self._search is not None:
            self._marks.select(None if self.selected is None else self.ui.lesionTable.currentRow())

    def _activated(self, row, _column):
        """By Enter: an only row has the focus without being selected, and arrows find no other."""
        if self.selected is None:
            self.ui.lesionTable.selectRow(row)
        else:
            self._selectionChanged()


def _texts(number, lesion, side):
    # What the vessel leads to is in the tooltip: there is little room.
    name = lesion.branch_name.partition(" (")[0]
    if name.startswith("branch "):  # by its size, which tells nobody which one it is
        name = _("{side}, generation {generation}").format(side=side, generation=lesion.generation)
    return (
        _("{number} {branch}").format(number=number, branch=name),
        degree_word(lesion.percent_diameter),
        f"{lesion.minimum_diameter:.1f} mm",
        f"{lesion.length:.0f} mm",
    )
