"""Whether a legacy VTK file has all the numbers that it announces.

VTK's reader takes what memory holds for numbers that are missing in text, without an error, and
runs over its end for missing strings. So the blocks are counted before it sees the file.
"""

from __future__ import annotations

import re

from ...validation import InputError

_SIZES = {
    "char": 1, "unsigned_char": 1, "signed_char": 1, "short": 2, "unsigned_short": 2, "int": 4,
    "unsigned_int": 4, "float": 4, "long": 8, "unsigned_long": 8, "double": 8, "vtkidtype": 4,
    "vtktypeint64": 8, "vtktypeuint64": 8, "long_long": 8, "unsigned_long_long": 8,
    "vtktypeint32": 4, "vtktypeuint32": 4, "bit": 1, "string": 1,
}  # fmt: skip

# Of digits as many as any file needs; Python refuses to read thousands.
_BLOCK = re.compile(
    rb"^(?:(?P<rows>POINT_DATA|CELL_DATA)\s+(?P<count>\d{1,25})"
    rb"|POINTS\s+(?P<points>\d{1,25})\s+(?P<points_type>\w+)"
    rb"|(?:VERTICES|LINES|POLYGONS|TRIANGLE_STRIPS)\s+(?P<cells>\d{1,25})\s+(?P<size>\d{1,25})"
    rb"|(?P<part>OFFSETS|CONNECTIVITY)\s+(?P<part_type>\w+)"
    rb"|(?P<kind>NORMALS|VECTORS|TENSORS)\s+\S+\s+(?P<kind_type>\w+)"
    rb"|SCALARS\s+\S+\s+(?P<scalar_type>\w+)(?:[ ]+(?P<scalar_size>\d{1,25}))?\s*\nLOOKUP_TABLE \S+"
    rb"|FIELD\s+\S+\s+(?P<arrays>\d{1,25})"
    rb"|\S+ (?P<width>\d{1,25}) (?P<tuples>\d{1,25}) (?P<field_type>[a-zA-Z]\w*))[ \t\r]*(?:\n|\Z)",
    re.MULTILINE | re.IGNORECASE,
)


def check_blocks(data: bytes, name: str) -> None:
    """Check that every block of points, cells and arrays has as much as its header says.

    Parameters
    ----------
    data : bytes
        A whole legacy VTK file.
    name : str
        What to call it in messages.

    Raises
    ------
    InputError
        No points, or a block that ends early.
    """
    lines = data.split(b"\n", 3)
    is_text = len(lines) > 2 and lines[2].strip().upper() == b"ASCII"
    has_points, arrays_left = False, 0
    sizes = _Sizes()
    position = 0
    # Ends: no header is empty, and a block ends behind its header.
    while block := _BLOCK.search(data, position):
        has_points = has_points or block["points"] is not None
        arrays_left += int(block["arrays"] or 0) - (block["width"] is not None)
        count, kind = sizes.numbers_after(block, data)
        position = _end_of_block(data, block.end(), count, kind.lower(), is_text, name)
    if not has_points:
        raise InputError(f"{name}: expected POINTS, found none; it may be cut short.")
    if arrays_left > 0:
        raise InputError(
            f"{name}: {arrays_left} of its arrays are missing; it is cut short, write it again."
        )


class _Sizes:
    """What a header says for the blocks after it: rows of arrays, cells and their corners."""

    def __init__(self) -> None:
        self._rows = self._cells = self._corners = 0

    def numbers_after(self, block: re.Match[bytes], data: bytes) -> tuple[int, str]:
        """How many numbers follow this header at once, and their type."""
        count, kind = 0, b"float"
        if block["rows"]:
            self._rows = int(block["count"])
        elif block["points"]:
            count, kind = 3 * int(block["points"]), block["points_type"]
        elif block["cells"]:
            self._cells, self._corners = int(block["cells"]), int(block["size"])
            if not data[block.end() : block.end() + 7].upper().startswith(b"OFFSETS"):
                count, kind = self._corners, b"int"
        elif block["part"]:
            is_offsets = block["part"].upper() == b"OFFSETS"
            count, kind = self._cells if is_offsets else self._corners, block["part_type"]
        elif block["kind"]:
            count = self._rows * (9 if block["kind"].upper() == b"TENSORS" else 3)
            kind = block["kind_type"]
        elif block["scalar_type"]:
            count, kind = self._rows * int(block["scalar_size"] or 1), block["scalar_type"]
        elif block["width"]:
            count, kind = int(block["width"]) * int(block["tuples"]), block["field_type"]
        return count, kind.decode("latin-1")


def _end_of_block(data: bytes, start: int, count: int, kind: str, is_text: bool, name: str) -> int:
    """Where a block of `count` numbers ends at the earliest; `InputError` behind the end."""
    if count == 0:
        return start
    if is_text:
        # At least a digit and a blank each; a file may end without the last blank.
        is_whole = 2 * count <= len(data) - start + 1
        if is_whole and kind == "string":
            is_whole = data.count(b"\n", start) >= count
        elif is_whole and kind != "bit":
            is_whole = len(data[start:].split(None, count)) >= count
        end = start + count
    elif kind == "string":
        end = _end_of_strings(data, start, count)
        is_whole = end <= len(data)
    else:
        bits = kind == "bit"
        end = start + ((count + 7) // 8 if bits else count * _SIZES.get(kind, 1))
        is_whole = end <= len(data)
    if not is_whole:
        raise InputError(
            f"{name}: expected {count} numbers or words in a block, the file ends before; it is "
            "cut short, write it again."
        )
    return end


def _end_of_strings(data: bytes, start: int, count: int) -> int:
    """Where binary strings end, or a place behind the end of the data.

    Each begins with its length in 1, 2, 4 or 8 bytes; the first two bits say in how many.
    """
    for _ in range(count):
        if start >= len(data):
            return len(data) + 1
        width = (8, 4, 2, 1)[data[start] >> 6]
        length = int.from_bytes(data[start : start + width], "big") & ((1 << (8 * width - 2)) - 1)
        start += width + length
    return start
