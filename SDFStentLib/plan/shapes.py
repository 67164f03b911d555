"""Profiles of stents as tables in files."""

from __future__ import annotations

import csv
import io
import os
from typing import Any

from ..files import read_text
from ..validation import InputError, as_path, in_short

HEADER = ("fraction", "diameter")


def read_profile(path: str | os.PathLike[str]) -> tuple[tuple[float, float], ...]:
    """Diameters along a stent from a CSV file with the columns `fraction,diameter`.

    Fractions of the deployed length from the proximal end, 0 to 1; diameters in mm.

    Raises
    ------
    InputError
        A file that cannot be read, no such columns, or cells that are no numbers.
    """
    path = as_path(path)
    text = read_text(path, "rows of fraction,diameter")
    try:
        # Whatever its lines end with.
        table = list(csv.reader(io.StringIO(text, newline=None)))
    except csv.Error as error:
        raise InputError(
            f"{path}: expected rows of fraction,diameter, got what is none ({error}); correct it."
        ) from error
    rows = [row for row in table if any(cell.strip() for cell in row)]
    if not rows or tuple(cell.strip().lower() for cell in rows[0]) != HEADER:
        found = in_short(",".join(rows[0])) if rows else "nothing"
        raise InputError(
            f"{path}: expected the header fraction,diameter in its first row, got {found}; add it."
        )
    if len(rows) < 3:
        raise InputError(
            f"{path}: expected two rows of fraction,diameter at least, got {len(rows) - 1}; "
            "add some."
        )
    return tuple(_row(path, at, row) for at, row in enumerate(rows[1:], start=1))


def _row(path: Any, at: int, row: list[str]) -> tuple[float, float]:
    try:
        fraction, diameter = (float(cell) for cell in row)
    except ValueError:
        raise InputError(
            f"{path}, row {at}: expected two numbers, fraction,diameter, got "
            f"{in_short(','.join(row))}; correct it."
        ) from None
    return fraction, diameter
