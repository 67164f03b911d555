"""The data of a PLY file: columns of its elements, from text or from bytes of either order."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..formats.text_numbers import numbers_in
from .plain_mesh import offsets_of


@dataclass(frozen=True)
class Property:
    """A property of an element: in every row a number, or a list of numbers."""

    name: str
    kind: str
    """NumPy type of the numbers."""
    count_kind: str | None
    """NumPy type of the length of a list; None for a single number."""


@dataclass(frozen=True)
class PlyElement:
    """An element: a number of rows with the same properties."""

    name: str
    count: int
    properties: list[Property]


def read_element(element: PlyElement, body: Any, order: str) -> tuple[dict[str, Any], Any]:
    """The columns of one element and the data that follow it; lists become (offsets, values)."""
    if element.count == 0 or not element.properties:
        return {}, body
    # The usual case: every row has lists as long as those of the first one.
    first = _read_rows(element, body, order, 1)[0]
    sizes = [len(first[p.name][1]) if p.count_kind else 1 for p in element.properties]
    if order == "":
        return _ascii_columns(element, body, sizes) or _read_rows(element, body, order)
    return _binary_columns(element, body, order, sizes) or _read_rows(element, body, order)


def _ascii_columns(element: PlyElement, tokens: list[bytes], sizes: list[int]) -> Any:
    widths = [s + bool(p.count_kind) for p, s in zip(element.properties, sizes, strict=True)]
    needed = element.count * sum(widths)
    if len(tokens) < needed:
        return None
    columns: dict[str, Any] = {}
    at, row = 0, sum(widths)
    for listed, size, width in zip(element.properties, sizes, widths, strict=True):
        if listed.count_kind:
            if set(tokens[at:needed:row]) != {b"%d" % size}:
                return None
            # One column of tokens after the other, then as rows again.
            parts = [tokens[at + part : needed : row] for part in range(1, width)]
            values = [numbers_in(b" ".join(part), listed.kind) for part in parts]
            corners = np.stack(values, axis=1) if values else np.zeros(0)
            offsets = size * np.arange(element.count + 1)
            columns[listed.name] = (offsets, corners.ravel())
        else:
            columns[listed.name] = numbers_in(b" ".join(tokens[at:needed:row]), listed.kind)
        at += width
    return columns, tokens[needed:]


def _binary_columns(element: PlyElement, body: memoryview, order: str, sizes: list[int]) -> Any:
    fields: list[Any] = []
    for position, (listed, size) in enumerate(zip(element.properties, sizes, strict=True)):
        if listed.count_kind:
            fields.append((f"count {position}", order + listed.count_kind))
        fields.append((f"{position}", order + listed.kind, (size,) if listed.count_kind else ()))
    row = np.dtype(fields)
    if len(body) < element.count * row.itemsize:
        return None
    table = np.frombuffer(body, row, element.count)
    columns: dict[str, Any] = {}
    for position, (listed, size) in enumerate(zip(element.properties, sizes, strict=True)):
        values = table[f"{position}"]
        if not listed.count_kind:
            columns[listed.name] = values.astype(listed.kind)
        elif (table[f"count {position}"] != size).any():
            return None
        else:
            offsets = size * np.arange(element.count + 1)
            columns[listed.name] = (offsets, values.ravel())
    return columns, body[element.count * row.itemsize :]


def _read_rows(
    element: PlyElement, body: Any, order: str, count: int | None = None
) -> tuple[dict[str, Any], Any]:
    """Columns read row by row, for lists of different lengths; `ValueError` if the data end."""
    at = 0

    def take(kind: str, number: int) -> NDArray[Any]:
        nonlocal at
        if number < 0:
            raise ValueError("negative length of a list")
        if order == "":
            found = numbers_in(b" ".join(body[at : at + number]), kind)
            at += number
        else:
            dtype = np.dtype(order + kind)
            found = np.frombuffer(body[at : at + number * dtype.itemsize], dtype)
            at += number * dtype.itemsize
        if len(found) != number or at > len(body):
            raise ValueError("data end")
        return found

    rows = element.count if count is None else count
    values: dict[str, list[Any]] = {listed.name: [] for listed in element.properties}
    for _ in range(rows):
        for listed in element.properties:
            number = int(take(listed.count_kind, 1)[0]) if listed.count_kind else 1
            values[listed.name].append(take(listed.kind, number))
    columns: dict[str, Any] = {}
    for listed in element.properties:
        joined = np.concatenate(values[listed.name])
        if listed.count_kind:
            sizes = [len(part) for part in values[listed.name]]
            columns[listed.name] = (offsets_of(sizes), joined)
        else:
            columns[listed.name] = joined.astype(listed.kind)
    return columns, body[at:]
