"""The lesions of the vessel, in a table of the panel and in the views."""

from slicer.i18n import tr as _

from SDFStentLib.report import NO_LESION, lesion_facts, voxel_facts
from SDFStentLib.validation import printable

from . import Clock, Showing
from .Desktop import desktop
from .LesionMarks import LesionMarks
from .PanelParts import tellOnce
from .Portions import SteppedRun, working

LEAST, ROW = 72, 24
"""Pixels of the table with two rows, as in the `.ui` file, and of a row."""

LOOK_MS = 200
"""Milliseconds after which it is looked whether the mouse has left the table."""

SETTLE_MS = 250
"""The vessel has to rest so long, so that nothing is searched while it is being edited."""


class LesionTable:
    """Searches in small portions once vessel and centerline are chosen, and shows in `ui.lesionTable` what was found.

    `roomOf()` is the number of pixels by which it may be higher. `onSelect(lesion)` is called when the user selects a lesion; `selected` is that one, None without. `onFound()` is called when
    a search has ended and the vessel could be measured.
    """

    def __init__(self, ui, searchOf, onSelect, onFound, roomOf=lambda: 0):
        self.ui, self._searchOf, self._onSelect, self._onFound = ui, searchOf, onSelect, onFound
        self._roomOf = roomOf
        self._parameterNode = self._search = self._inputs = None
        self._updating, self._marks = False, LesionMarks()
        self._run = SteppedRun(lambda _value: None, self._done)
        self._plotting = SteppedRun(lambda _value: None, self._onPlotted)
        self._ranging = SteppedRun(lambda _value: None, self._onPlotted)
        self._timer = Clock.timer(self._begin, SETTLE_MS)
        desktop().fitColumns(ui.lesionTable)
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
        runs = self._run, self._plotting, self._ranging
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
        """`Around` of the plotted lesion; None without one."""
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

    def followLayout(self):
        """Keep the numbers apart in the present views."""
        self._marks.followLayout()

    def clearSelection(self):
        """Select no lesion."""
        self.ui.lesionTable.clearSelection()

    def _leave(self):
        self._timer.stop()
        self._run.cancel()
        self._plotting.cancel()
        self._ranging.cancel()
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
            said = "\n".join(filter(None, (search.remark, search.sentence)))
            self._show(said, search.found, "" if search.found or search.sentence else NO_LESION)
            if not search.sentence:
                self._ranging.start(self._ranged(search))
                self._onFound()

    def _show(self, sentence, lesions=(), state=""):
        """A sentence, and the lesions with a row each, or a `state` in their place, which is as high: what lies below stays."""
        table = self.ui.lesionTable
        rows = [([state], state)] if state else []
        for number, lesion in enumerate(lesions, 1):
            side = "" if self._search is None else self._search.sideOf(lesion)
            facts = lesion_facts(number, lesion)
            rows.append((_texts(facts, side), " ".join(facts.sentences)))
        self._updating = True
        try:
            table.clearSelection()
            table.setRowCount(len(rows))
            for row, (texts, tip) in enumerate(rows):
                for column, text in enumerate(texts):
                    item = desktop().cell(text, isSelectable=not state)
                    item.setToolTip(tip)
                    table.setItem(row, column, item)
        finally:
            self._updating = False
        self._marks.show(lesions)
        if lesions:
            self._plot(0)
        self._reach(len(rows))
        table.visible = len(rows) > 0
        self._offer()
        self.ui.lesionLabel.text = printable(sentence)
        tellOnce(self.ui)

    def _ranged(self, search):
        """Tell how exact voxels let the lesions of a vessel be known; yields until that is known."""
        found = yield from working(search.ranges())
        for row in range(0 if found is None else len(search.found)):
            one = found.of_lesions([row + 1])
            tip = " ".join(voxel_facts(one).sentences)
            for column, ((told,), digits) in enumerate(((one.stenoses, 0), (one.minima, 1)), 1):
                item = self.ui.lesionTable.item(row, column)
                low, high = told.before
                item.setText(f"{item.text()} ({low:.{digits}f}-{high:.{digits}f})")
            for column in range(self.ui.lesionTable.columnCount):
                item = self.ui.lesionTable.item(row, column)
                item.setToolTip(f"{item.toolTip()} {tip}")
        yield 1.0

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
            with Showing.inOneFrame():
                self._goTo(None if self.selected is None else self.ui.lesionTable.currentRow())

    def _goTo(self, row):
        self._marks.select(row)
        if row is not None:
            self._plot(row)
            self._onSelect(self.selected)

    def _plot(self, row):
        """Plot the lesion while no result can be plotted."""
        if self._parameterNode.outputChart is None:
            self._plotting.cancel()
            self._plotting.start(self._plotted(self._search, row))

    def _plotted(self, search, row):
        """Plot a lesion once the vessel on both sides of it is measured, unless a result exists then; yields until then."""
        around = yield from working(search.around(search.found[row]))
        if self._parameterNode.outputChart is None:  # there may be a result by now
            self._marks.plot(row, around)
        yield 1.0

    @staticmethod
    def _onPlotted(error):
        if error is not None:
            raise error

    def _clicked(self, _row, _column):
        """Go to the selected lesion again when it is clicked once more."""
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
        """Select a row by Enter: an only row has the focus without being selected, and arrows find no other."""
        if self.selected is None:
            self.ui.lesionTable.selectRow(row)
        else:
            self._selectionChanged()


SHOWN = "percent_diameter", "minimum.diameter_mm", "extent.length_mm"
"""Keys of the facts beside the name of a vessel."""


def _texts(facts, side):
    # What the vessel leads to is in the tooltip: there is little room.
    name = facts.value("branch_name").partition(" (")[0]
    if name.startswith("main branch"):  # both are called so
        name = _("{side} main branch").format(side=side) if side else _("main branch")
    elif side and name.startswith("branch "):  # by its size, which tells nobody which one it is
        name = _("{side}, generation {generation}").format(
            side=side, generation=facts.value("generation")
        )
    numbered = _("{number} {branch}").format(number=facts.value("number"), branch=name)
    return numbered, *(facts.named(key).in_few for key in SHOWN)
