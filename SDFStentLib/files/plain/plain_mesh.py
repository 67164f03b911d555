"""Polygons as arrays: the result of reading the plain formats."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...cautions import Caution


@dataclass(frozen=True)
class PlainMesh:
    """A mesh of polygons as a plain format has it.

    Attributes
    ----------
    points : (n, 3) array of float32 or float64
        Coordinates in the file's unit and precision.
    offsets : (m + 1,) array of int64
        Polygon i has the corners `corners[offsets[i]:offsets[i + 1]]`.
    corners : array of int64
        Indices into the points; unchecked.
    point_arrays, cell_arrays : dict of str to array
        Other values that the file has for points and polygons.
    face_ids : (m,) array of int32 or None
        The part of the model to which every polygon belongs; `None` where it has no parts.
    face_names : dict of int to str
        Names of the parts that have one.
    text : str
        Header or comments of the file.
    warnings : tuple of Caution
        Contents of the file that are not kept.
    """

    points: NDArray[Any]
    offsets: NDArray[np.int64]
    corners: NDArray[np.int64]
    point_arrays: dict[str, NDArray[Any]] = field(default_factory=dict)
    cell_arrays: dict[str, NDArray[Any]] = field(default_factory=dict)
    face_ids: NDArray[np.int32] | None = None
    face_names: dict[int, str] = field(default_factory=dict)
    text: str = ""
    warnings: tuple[Caution, ...] = ()


Decoder = Callable[[bytes, str], PlainMesh]
"""A function that decodes a whole plain file; the text is what to call it in messages.

`InputError` for bytes that are not of its format, or cut short.
"""


def not_kept(contents: Iterable[str], file_format: str, name: str) -> Caution:
    """A caution about contents of a file that are left behind."""
    numbers = {"contents": ", ".join(contents), "format": file_format}
    return Caution("contents-not-kept", numbers, label=f"{name}: ")


def offsets_of(sizes: ArrayLike) -> NDArray[np.int64]:
    """Offsets (m + 1,) of polygons with these numbers of corners (m,)."""
    return np.concatenate([[0], np.cumsum(np.asarray(sizes, dtype=np.int64))]).astype(np.int64)
