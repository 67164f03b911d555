"""A table widget as a value: rows of items, one of which is selected."""

from __future__ import annotations

from typing import Any

from .widgets import Widget, shown

LONGEST = 200
"""Largest number of characters that can be typed into a cell."""


class TableItem:
    """A cell, as the panel uses Qt's; `is_checked` is None if it has no box to check."""

    def __init__(
        self, text: str = "", can_be_edited: bool = False, is_checked: bool | None = None
    ) -> None:
        self._text, self._tip = text, ""
        self.can_be_edited, self.is_checked = can_be_edited, is_checked
        self.table: Table | None = None
        self.place = (-1, -1)

    def text(self) -> str:
        return self._text

    def setText(self, text: str) -> None:
        self._text = text
        self._changed()

    def toolTip(self) -> str:
        return self._tip

    def setToolTip(self, text: str) -> None:
        self._tip = text
        self._changed()

    def check(self, is_checked: bool) -> None:
        """Set or clear the box."""
        self.is_checked = is_checked
        self._changed()

    def row(self) -> int:
        return self.place[0]

    def column(self) -> int:
        return self.place[1]

    def state(self) -> dict[str, Any]:
        """The cell as the page shows it."""
        words = {"text": self._text, "tip": self._tip}
        return {**words, "check": self.is_checked, "edit": self.can_be_edited}

    def _changed(self) -> None:
        if self.table is not None:
            self.table.tell()
            self.table.emit("itemChanged", self)


class Table(Widget):
    """A table whose rows can be selected, as `QTableWidget` is used."""

    columns = shown(())

    def __init__(self, name: str = "", parameter: str = "") -> None:
        super().__init__(name, parameter)
        self._rows: list[list[TableItem | None]] = []
        self._selected = self._current = -1
        self._is_under_mouse = False

    def setRowCount(self, count: int) -> None:
        """Drop rows at the end, or append empty ones."""
        del self._rows[count:]
        self._rows += [[None] * len(self.columns) for _ in range(count - len(self._rows))]
        if self._selected >= count:
            self.clearSelection()
        self._current = min(self._current, count - 1)
        self.tell()

    @property
    def rowCount(self) -> int:
        return len(self._rows)

    def setItem(self, row: int, column: int, item: TableItem) -> None:
        self._rows[row][column] = item
        item.table, item.place = self, (row, column)
        self.tell()

    def item(self, row: int, column: int) -> TableItem | None:
        return self._rows[row][column]

    def currentRow(self) -> int:
        return self._current

    def selectedItems(self) -> list[TableItem]:
        row = self._rows[self._selected] if self._selected >= 0 else []
        return [item for item in row if item is not None]

    def selectRow(self, row: int) -> None:
        self._select(row)

    def clearSelection(self) -> None:
        self._select(-1)

    def setMouseTracking(self, _isTracked: bool) -> None:
        """Do nothing: the page always reports the rows that the mouse enters and leaves."""

    def underMouse(self) -> bool:
        """Whether the mouse is on a row."""
        return self._is_under_mouse

    def hover(self, row: int) -> None:
        """Note that the mouse is on a row, or with -1 on none."""
        self._is_under_mouse = 0 <= row < len(self._rows)
        if self._is_under_mouse:
            self.emit("cellEntered", row, 0)

    def setFocus(self) -> None:
        """Do nothing: the browser decides where keys go."""

    def _select(self, row: int) -> None:
        if row == self._selected:
            return
        self._selected = row
        if row >= 0:
            self._current = row
        self.tell()
        self.emit("itemSelectionChanged")

    def state(self) -> dict[str, Any]:
        rows = [[item.state() if item else {} for item in row] for row in self._rows]
        table = {"columns": list(self.columns), "rows": rows, "selected": self._selected}
        return {**super().state(), **table}

    def edit(self, value: Any) -> None:
        """Take a click, `[row, column]`; with a third value, `true` or `false` for a check box or
        the text that was typed."""
        place = self._place(value)
        if place is None:
            return
        row, column = place
        item = self._rows[row][column]
        if len(value) == 2:
            self._select(row)
            self.emit("cellClicked", row, column)
        elif item is None:
            return
        elif isinstance(value[2], bool) and item.is_checked is not None:
            item.check(value[2])
        elif isinstance(value[2], str) and item.can_be_edited:
            item.setText(value[2][:LONGEST])

    def _place(self, value: Any) -> tuple[int, int] | None:
        """Row and column of a value from the page, if the table has such a cell; otherwise None."""
        if not isinstance(value, list) or len(value) not in (2, 3):
            return None
        row, column = value[:2]
        if type(row) is not int or type(column) is not int:
            return None
        isThere = 0 <= row < len(self._rows) and 0 <= column < len(self.columns)
        return (row, column) if isThere else None
