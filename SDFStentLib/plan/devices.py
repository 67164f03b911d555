"""The device table: rows that come along, rows of the user, and both as documents."""

from __future__ import annotations

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
    """The devices that are known, those that come along first.

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
    """The device of that name, in upper or lower case; parameters and errors as `device_table`."""
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
