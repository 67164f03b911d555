"""Shapes of stents as documents, and profiles as tables in files."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Callable
from typing import Any

from ..files import read_content
from ..stent import Shape, StentEnd, Waist
from ..validation import InputError, as_path, in_short
from .json_document import number, section, sequence

HEADER = ("fraction", "diameter")

PARTS: dict[str, tuple[Callable[..., Any], tuple[str, ...], tuple[str, ...]]] = {
    "waist": (Waist, ("diameter",), ("position", "length")),
    "start": (StentEnd, ("diameter", "length"), ()),
    "end": (StentEnd, ("diameter", "length"), ()),
}
"""Parts of a shape: what they are, the numbers that they need, and those that they may have."""


def read_profile(path: str | os.PathLike[str]) -> tuple[tuple[float, float], ...]:
    """Diameters along a stent from a CSV file with the columns `fraction,diameter`.

    Fractions of the deployed length from the proximal end, 0 to 1; diameters in mm.

    Raises
    ------
    InputError
        A file that cannot be read, no such columns, or cells that are no numbers.
    """
    path = as_path(path)
    try:
        text = read_content(path, "rows of fraction,diameter").data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(
            f"{path}: expected rows of fraction,diameter, got no text; save it as text."
        ) from error
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


def shape_document(shape: Shape | None) -> dict[str, Any] | None:
    """A shape as values of JSON, without the parts that it has not."""
    if shape is None:
        return None
    document: dict[str, Any] = {"cap_height": shape.cap_height}
    if shape.waist is not None:
        document["waist"] = {
            "diameter": shape.waist.diameter,
            "position": shape.waist.position,
            "length": shape.waist.length,
        }
    for name in ("start", "end"):
        end = getattr(shape, name)
        if end is not None:
            document[name] = {"diameter": end.diameter, "length": end.length}
    if shape.table:
        document["table"] = [list(row) for row in shape.table]
    return document


def shape_from_document(value: Any, where: str) -> Shape | None:
    """A shape from its document; None from null.

    Raises
    ------
    InputError
        Unknown keys, or values that do not belong there, with their place.
    """
    if value is None:
        return None
    given = section(value, where, (), (*PARTS, "table", "cap_height"))
    parts = {
        name: _numbers(given[name], f"{where}.{name}", required, optional)
        for name, (_, required, optional) in PARTS.items()
        if given.get(name) is not None
    }
    rows = [] if given.get("table") is None else sequence(given["table"], f"{where}.table")
    table = tuple(_pair(row, f"{where}.table[{index}]") for index, row in enumerate(rows))
    cap_height = float(number(given.get("cap_height", 1.0), f"{where}.cap_height"))
    try:
        made = {name: PARTS[name][0](**values) for name, values in parts.items()}
        return Shape(**made, table=table, cap_height=cap_height)
    except InputError as error:
        raise error.labeled(f"{where}: ") from error


def _row(path: Any, at: int, row: list[str]) -> tuple[float, float]:
    try:
        fraction, diameter = (float(cell) for cell in row)
    except ValueError:
        raise InputError(
            f"{path}, row {at}: expected two numbers, fraction,diameter, got "
            f"{in_short(','.join(row))}; correct it."
        ) from None
    return fraction, diameter


def _numbers(
    value: Any, where: str, required: tuple[str, ...], optional: tuple[str, ...]
) -> dict[str, Any]:
    given = section(value, where, required, optional)
    return {
        key: None if item is None and key in optional else float(number(item, f"{where}.{key}"))
        for key, item in given.items()
    }


def _pair(value: Any, where: str) -> tuple[Any, ...]:
    return tuple(float(number(item, where)) for item in sequence(value, where))
