"""The table of the plan's stents in the panel."""

from slicer.i18n import tr as _

from SDFStentLib.plan import entry_words
from SDFStentLib.validation import one_line

from .Desktop import desktop


class StentTable:
    """Shows the stents of a plan in `ui.stentTable`; reports what the user selects and switches on or off."""

    def __init__(self, ui, onSelect, onEnable):
        self.ui, self._onSelect, self._onEnable = ui, onSelect, onEnable
        self._updating = False
        self._shown = None
        desktop().fitColumns(self.ui.stentTable)
        self.ui.stentTable.connect("itemSelectionChanged()", self._selectionChanged)
        self.ui.stentTable.connect("itemChanged(QTableWidgetItem*)", self._itemChanged)

    def show(self, stents, selected):
        """Fill the table; does nothing when it shows this already."""
        rows = [_texts(one) for one in stents]
        details = [one_line(entry_words(one.draft.entry)) for one in stents]
        if self._shown == (rows, details, selected):
            return
        self._updating = True
        try:
            self.ui.stentTable.setRowCount(len(rows))
            for row, texts in enumerate(rows):
                self._fill(row, texts, stents[row].enabled, details[row])
            if 0 <= selected < len(rows):
                self.ui.stentTable.selectRow(selected)
            else:
                self.ui.stentTable.clearSelection()
        finally:
            self._updating = False
        self._shown = (rows, details, selected)

    def _fill(self, row, texts, enabled, details):
        for column, text in enumerate(texts[:-1]):
            item = desktop().cell(text, isChecked=enabled if column == 0 else None)
            if column == 0:
                tip = _("Tick to deploy this stent, untick to leave it out.")
                item.setToolTip(f"{text}\n{tip}")
            if column == 1 and details:
                item.setText(f"{text} +")
                item.setToolTip(_("With {details}.").format(details=details))
            self.ui.stentTable.setItem(row, column, item)

    def _selectionChanged(self):
        row = self.ui.stentTable.currentRow()
        if not self._updating and row >= 0:
            self._onSelect(row)

    def _itemChanged(self, item):
        if not self._updating and item.column() == 0:
            self._onEnable(item.row(), desktop().isChecked(item))


def _texts(stent):
    length = (
        _("as placed")
        if stent.placement.usesHandleLength and stent.wholeCurve
        else f"{stent.draft.length:.1f} mm"
    )
    return (
        one_line(stent.label),
        f"{stent.diameter:.1f} mm",
        length,
        stent.placement.label() if stent.enabled else _("switched off"),
        stent.enabled,
    )
