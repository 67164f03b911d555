"""Polydata as a VTK file has it, in NumPy: what the strict readers of both formats return."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...cautions import Caution

CELL_KINDS = ("Verts", "Lines", "Polys", "Strips")
"""Kinds of cells in the order in which polydata numbers its cells."""


class Kind(NamedTuple):
    """Kind of stored values: VTK's array class, and the NumPy type of the numbers."""

    vtk_class: str
    dtype: str

    @property
    def is_text(self) -> bool:
        """Whether the values are strings."""
        return self.vtk_class == "vtkStringArray"

    @property
    def is_bit(self) -> bool:
        """Whether eight values are packed in one byte."""
        return self.vtk_class == "vtkBitArray"


class Damage(ValueError):
    """The fault of a file, as the second half of a sentence."""


def check_cells(offsets: NDArray[np.int64], corners: NDArray[np.int64], point_count: int) -> None:
    """Raise `Damage` for offsets that do not rise to the number of corners, or corners of no point.

    Parameters are as in `Cells` of `polydata`.
    """
    if offsets[0] != 0 or offsets[-1] != len(corners) or (np.diff(offsets) < 0).any():
        raise Damage(f"expected offsets that rise to {len(corners)}, got others")
    if len(corners) and (corners.min() < 0 or corners.max() >= point_count):
        raise Damage(
            f"expected point indices from 0 to {point_count - 1} in its cells, got "
            f"{corners.min()} to {corners.max()}"
        )


def cells_of_list(
    listed: NDArray[np.int64], count: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Cells from the old form, in which each has its number of corners before the corners.

    Offsets and corners are as in `Cells` of `polydata`; `Damage` if the numbers are no such cells.
    """
    width = len(listed) // count if count else 0
    if count and width * count == len(listed) and (listed[::width] == width - 1).all():
        corners = listed.reshape(count, width)[:, 1:].ravel()
        return (width - 1) * np.arange(count + 1), corners
    heads: list[int] = []
    at = 0
    numbers = listed.tolist()
    # Ends: `at` grows by one at least.
    while at < len(numbers) and len(heads) < count and numbers[at] >= 0:
        heads.append(at)
        at += 1 + numbers[at]
    if at != len(numbers) or len(heads) != count:
        raise Damage(f"expected {count} cells in {len(numbers)} numbers, got others")
    is_corner = np.ones(len(listed), dtype=bool)
    is_corner[heads] = False
    return np.concatenate([[0], np.cumsum(listed[heads])]).astype(np.int64), listed[is_corner]


def first_of_steps(steps: int, time: str, name: str) -> Caution:
    """A caution about a file with several time steps, of which the first is read."""
    return Caution("first-of-steps", {"steps": steps, "time": time}, label=f"{name}: ")


ARRAYS_WITH_ONE_MORE = ("Radius",)
"""Point arrays with one value too many, as VMTK's network extraction writes them."""


@dataclass(frozen=True)
class StoredArray:
    """An array with its name.

    Attributes
    ----------
    name : str or None
    kind : Kind
    values : array, shape (n, k), or list of bytes of length n * k
        Numbers, or the strings of a string array.
    components : int
        The k above.
    component_names : dict of int to str
        Names of the components that have one.
    """

    name: str | None
    kind: Kind
    values: NDArray[Any] | list[bytes]
    components: int = 1
    component_names: dict[int, str] = field(default_factory=dict)

    def without_last(self) -> StoredArray:
        """The array without its last row."""
        return replace(self, values=self.values[: -self.components or None])


@dataclass(frozen=True)
class ArrayGroup:
    """The arrays of the points, of the cells or of the whole, and their roles.

    Attributes
    ----------
    arrays : list of StoredArray
    roles : dict of str to str
        Name of the array for each role, in VTK's words, such as `{"Normals": "name"}`.
    tables : dict of str to array, shape (m, 4), uint8
        Lookup tables (red, green, blue, opacity) by the name of the array that is shown so.
    """

    arrays: list[StoredArray] = field(default_factory=list)
    roles: dict[str, str] = field(default_factory=dict)
    tables: dict[str, NDArray[np.uint8]] = field(default_factory=dict)


@dataclass(frozen=True)
class StoredPolydata:
    """Everything that a file of polydata holds.

    Attributes
    ----------
    points : StoredArray
        Coordinates, with three components.
    cells : dict of str to (offsets, corners)
        Cells by the names of `CELL_KINDS`; offsets (m + 1,) and corners are int64 and fit together.
    point_data, cell_data, field_data : ArrayGroup
    cautions : tuple of Caution
        Contents of the file that are left out.
    """

    points: StoredArray
    cells: dict[str, tuple[NDArray[np.int64], NDArray[np.int64]]]
    point_data: ArrayGroup
    cell_data: ArrayGroup
    field_data: ArrayGroup
    cautions: tuple[Caution, ...] = ()
