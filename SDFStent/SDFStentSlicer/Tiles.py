"""The result at a glance: the library's tiles as a parameter node keeps them, and as a label shows them."""

import json
from html import escape

from SDFStentLib.report import Tile

from .PanelParts import cut

IN_A_ROW = 3
LONGEST = 44
"""Characters beneath a value, two lines: all words are in *Details*, and what lies below the tiles stays where it is."""

CAUTION = "background-color: #fdf0e6; color: #8a3b12"
"""Both are named, to be read in a light style and in a dark one."""


def tilesOf(parameterNode):
    """What the last deployment, or its preview, has left to be read at a glance."""
    return [Tile(*values) for values in json.loads(parameterNode.tiles or "[]")]


def html(tiles):
    """Rows of tiles for a label: name small, value large, before and reference small beneath."""
    rows = [tiles[first : first + IN_A_ROW] for first in range(0, len(tiles), IN_A_ROW)]
    cells = "".join(f"<tr>{''.join(map(_cell, row))}</tr>" for row in rows)
    return f'<table width="100%" cellpadding="2" cellspacing="0">{cells}</table>'


def _cell(tile):
    look = f' style="{CAUTION}"' if tile.is_caution else ""
    name, value, beneath = (escape(cut(text, LONGEST)) for text in tile[:3])
    return (
        f'<td width="{100 // IN_A_ROW}%"{look}><span style="font-size: small">{name}</span><br>'
        f'<span style="font-size: large; font-weight: 600">{value}</span><br>'
        f'<span style="font-size: small">{beneath}</span></td>'
    )
