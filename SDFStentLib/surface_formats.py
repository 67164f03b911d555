"""Formats in which surfaces are read and written: the only list, for command line,
page and panel."""

from __future__ import annotations

from typing import NamedTuple


class SurfaceFormat(NamedTuple):
    """A file format of surfaces."""

    suffix: str
    """The suffix in lower case, with its dot."""
    words: str
    """The name of the format."""
    is_written: bool
    """Whether it is also written, not only read."""
    is_whole: bool = True
    """Whether one file holds the whole surface."""


SURFACE_FORMATS = (
    SurfaceFormat(".vtp", "VTP", True),
    SurfaceFormat(".vtk", "VTK", True),
    SurfaceFormat(".stl", "STL", True),
    SurfaceFormat(".ply", "PLY", True),
    SurfaceFormat(".obj", "OBJ", True),
    SurfaceFormat(".off", "OFF", False),
    SurfaceFormat(".vtu", "VTU", False),
    SurfaceFormat(".pvtp", "PVTP", False, is_whole=False),
    SurfaceFormat(".pvtu", "PVTU", False, is_whole=False),
    SurfaceFormat(".vtkhdf", "VTKHDF", False),
)

READ_SUFFIXES = tuple(one.suffix for one in SURFACE_FORMATS)
WRITTEN_SUFFIXES = tuple(one.suffix for one in SURFACE_FORMATS if one.is_written)
WHOLE_SUFFIXES = tuple(one.suffix for one in SURFACE_FORMATS if one.is_whole)
"""Suffixes of formats whose surfaces are one file, which can be sent or packed alone."""


def _in_words() -> str:
    *most, last = (one.words for one in SURFACE_FORMATS)
    return f"{', '.join(most)} or {last}"


FORMATS_IN_WORDS = _in_words()


def written_suffix(suffix: str) -> str:
    """The suffix under which a surface read from a file with this one is written by default."""
    return suffix if suffix.lower() in WRITTEN_SUFFIXES else WRITTEN_SUFFIXES[0]
