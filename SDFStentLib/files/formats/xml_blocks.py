"""Whether a VTP file can have as much as its headers announce.

VTK asks the machine for the memory that a damaged number names, and aborts the process when it
does not get it. So the numbers are compared with the length of the file before VTK sees it.
"""

from __future__ import annotations

import re

from ...validation import InputError
from .xml_arrays import LARGEST_EXPANSION

_MARKUP_READ = 100_000  # bytes in which sizes are looked for; inline arrays come between them

_COUNT = re.compile(rb"\bNumberOf\w+\s*=\s*[\"'](\d+)[\"']")

# What points to points, or into the list of such indices: their ranges tell sizes. Those of all
# other arrays are values, such as hashes or the numbers of a patient.
_CELLS = re.compile(rb"<(Verts|Lines|Strips|Polys)\b.*?(?:</\1\s*>|\Z)", re.DOTALL)
_CELL_ARRAY = re.compile(rb"<DataArray\b[^>]*\bName\s*=\s*[\"'](?:offsets|connectivity)[\"'][^>]*>")
_RANGE = re.compile(rb"\bRangeM(?:in|ax)\s*=\s*[\"'](\d+)[\"']")


def check_announced_sizes(data: bytes, name: str) -> None:
    """Check that no number of points, cells or components is beyond what the file can hold.

    Parameters
    ----------
    data : bytes
        A whole VTP file.
    name : str
        What to call it in messages.

    Raises
    ------
    InputError
        A count that needs more bytes than the file has, compressed as far as possible.
    """
    end = data.find(b"<AppendedData")
    markup = data[: min(end if end >= 0 else len(data), _MARKUP_READ)]
    counts = _COUNT.findall(markup)
    for cells in _CELLS.finditer(markup):
        for array in _CELL_ARRAY.findall(cells.group()):
            counts += _RANGE.findall(array)
    # Python refuses to read thousands of digits; this many are more than any file anyway.
    most = max((int(count[:25]) for count in counts), default=0)
    if most > LARGEST_EXPANSION * len(data):
        raise InputError(
            f"{name}: its header announces {most} elements, too many for {len(data)} "
            "bytes; the file is damaged."
        )
