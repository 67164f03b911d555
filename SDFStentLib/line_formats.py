"""Formats in which centerlines and axes are read and written: the only list, for command line and
page."""

from __future__ import annotations

from typing import NamedTuple


class LineFormat(NamedTuple):
    """A file format of lines."""

    suffix: str
    """The suffix in lower case, with its dot."""
    is_written: bool
    """Whether it is also written, not only read."""
    is_polydata: bool = False
    """Whether it keeps lines with arrays, not only points."""


LINE_FORMATS = (
    LineFormat(".vtp", True, is_polydata=True),
    LineFormat(".vtk", True, is_polydata=True),
    LineFormat(".mrk.json", True),
    LineFormat(".pth", False),
    LineFormat(".fcsv", False),
)

LINE_INPUTS = tuple(one.suffix for one in LINE_FORMATS)
LINE_SUFFIXES = tuple(one.suffix for one in LINE_FORMATS if one.is_written)
VTK_LINE_SUFFIXES = tuple(one.suffix for one in LINE_FORMATS if one.is_polydata)

LINES_IN_WORDS = f"{', '.join(LINE_INPUTS[:-1])} or {LINE_INPUTS[-1]}"
