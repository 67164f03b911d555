"""The result at a glance: the library's tiles as a parameter node keeps them, and as a label shows them."""

import json
from html import escape

from SDFStentLib.report import COMPARED, Tile

from .Desktop import desktop
from .PanelParts import cut

SURFACE, IN_A_ROW = COMPARED[-1], 3
APART = 8
"""Pixels between the words of tiles side by side, which are read as one line otherwise."""
MIDDLE = 128
"""The middle of the scale of lightness of a color, 0 to 255."""
LONGEST = 44
"""Characters beneath a value, two lines: all words are in *Details*, and what lies below the tiles stays where it is."""

CAUTIONS = {
    False: "background-color: #fdf0e6; color: #8a3b12",
    True: "background-color: #4a3018; color: #ffc48f",
}
"""Both colors are named, in a light style and in a dark one."""


def tilesOf(parameterNode):
    """Tiles that the last deployment, or its preview, has left to be read at a glance."""
    return [Tile(*values) for values in json.loads(parameterNode.tiles or "[]")]


class TilesLabel:
    """Shows tiles in a label, in the colors of its style: also where that changes while they are shown."""

    def __init__(self, label):
        self._label, self._tiles, self._instead = label, (), ""
        self._unwatch = desktop().onEvent(label, "PaletteChange", self._write)

    def show(self, tiles, instead):
        """Show tiles; without any, a text `instead`."""
        self._tiles, self._instead = tiles, instead
        self._write()

    def _write(self):
        shown = html(self._tiles, isDark(self._label))
        self._label.text = shown if self._tiles else escape(self._instead)


def isDark(widget):
    """Whether a widget has a dark style; the page's have none, for it shows tiles of its own."""
    palette = getattr(widget, "palette", None)
    return palette is not None and palette.color(widget.backgroundRole()).lightness() < MIDDLE


def html(tiles, isDark=False):
    """Rows of tiles for a label: name small, value large, before and reference small beneath; the last value, the engineer's, is small."""
    cells = [_cell(tile, isDark, tile is tiles[-1]) for tile in tiles]
    rows = [cells[first : first + IN_A_ROW] for first in range(0, len(cells), IN_A_ROW)]
    content = "".join(f"<tr>{''.join(row)}</tr>" for row in rows)
    return f'<table width="100%" cellpadding="1" cellspacing="0">{content}</table>'


def _cell(tile, isDark, isLast):
    look = f"; {CAUTIONS[isDark]}" if tile.is_caution else ""
    size = "small" if isLast and tile.name == SURFACE else "large"
    name, value, beneath = (escape(cut(text, LONGEST)) for text in tile[:3])
    below = f'<br><span style="font-size: small">{beneath}</span>' if beneath else ""
    return (
        f'<td width="{100 // IN_A_ROW}%" style="padding-right: {APART}px{look}">'
        f'<span style="font-size: small">{name}</span><br>'
        f'<span style="font-size: {size}; font-weight: 600">{value}</span>{below}</td>'
    )
