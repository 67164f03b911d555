"""The device table and profiles of stents, as they stand in files."""

from __future__ import annotations

import csv
import io
import os
from difflib import get_close_matches
from functools import cache
from pathlib import Path
from typing import Any

from ..files import read_text
from ..stent import Device
from ..validation import InputError, as_path, in_short
from .json_document import check_schema, in_words, parsed, section, sequence
from .typed import from_document

SCHEMA = "sdfstent-devices"
SCHEMA_VERSION = 1


def device_table(path: str | os.PathLike[str] | None = None) -> tuple[Device, ...]:
    """Devices of the table, those that come along first.

    Parameters
    ----------
    path : path, optional
        A table of the user's own. Its rows come in place of those of the same name.

    Raises
    ------
    InputError
        A file that cannot be read, no JSON, another schema or version, a name that stands twice,
        or a row whose numbers have no source or contradict each other.
    """
    own = () if path is None else _table_of(as_path(path))
    return tuple({device.name.casefold(): device for device in (*_own_table(), *own)}.values())


def device_named(name: str, path: str | os.PathLike[str] | None = None) -> Device:
    """Device by its name, in upper or lower case; parameters and errors as `device_table`."""
    table = device_table(path)
    by_name = {device.name.casefold(): device for device in table}
    if name.casefold() in by_name:
        return by_name[name.casefold()]
    near = get_close_matches(name.casefold(), by_name, n=3)
    there = f"such as {', '.join(near)}" if near else ", ".join(by_name)
    raise InputError(
        f"device: expected a known one ({there}), got {in_short(name)}; see ",
        "devices",
        otherwise="the device table, or give one of your own",
        end=".",
    )


@cache
def _own_table() -> tuple[Device, ...]:
    return _table_of(Path(__file__).with_name("devices.json"))


def _table_of(path: Path) -> tuple[Device, ...]:
    document = parsed(read_text(path, "a device table in JSON"), str(path))
    try:
        return _rows_of(document)
    except InputError as error:
        raise error.labeled(f"{path}: ") from error


def _rows_of(document: Any) -> tuple[Device, ...]:
    table = section(document, "device table", ("schema", "version", "devices"))
    check_schema(table, SCHEMA, SCHEMA_VERSION, "correct it")
    rows: dict[str, Device] = {}
    for index, value in enumerate(sequence(table["devices"], "devices")):
        device = from_document(Device, value, f"devices[{index}]")
        if device.name.casefold() in rows:
            raise InputError(
                f"devices[{index}]: expected a device of another name than those before, got "
                f"{in_words(device.name)}; rename it."
            )
        rows[device.name.casefold()] = device
    return tuple(rows.values())


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
