"""Columns of the panel's tables."""

import qt


def fitColumns(table):
    """Let the first column, with the names, have the room that the others leave, which are as wide as what they hold."""
    header = table.horizontalHeader()
    header.setStretchLastSection(False)
    header.setSectionResizeMode(qt.QHeaderView.ResizeToContents)
    header.setSectionResizeMode(0, qt.QHeaderView.Stretch)
