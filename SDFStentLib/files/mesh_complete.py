"""A closed surface as SimVascular's solvers read it: a folder with one file per face.

The layout is that of SimVascular's *mesh-complete*, in cm, with 32-bit ids that count from 1, as
svMultiPhysics asks for. `GlobalNodeID` holds for every volume mesh that keeps the surface and has
its points first; `GlobalElementID`, the tetrahedron at each triangle, is known with that mesh only
and is left out before, so that a solver says so.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry import NamedFaces, Surface
from ..units import MILLIMETERS, Frame
from ..validation import Floats, Indices, InputError, Points
from .content import read_content
from .formats import decode_vtu, encode_vtp, encode_vtu
from .model_faces import ID_ARRAY, set_face_names
from .polydata import polydata_from_arrays, set_frame_of_polydata

EXTERIOR, WALLS, FACES = "mesh-complete.exterior.vtp", "walls_combined.vtp", "mesh-surfaces"
VOLUME = "mesh-complete.mesh.vtu"
UNITS = "cm"

_SIDES = [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]


class VolumeMesh(NamedTuple):
    """Tetrahedra in a closed surface, whose points come first and are unchanged."""

    points: Points
    """(k, 3) points, mm."""
    tetrahedra: Indices
    """(t, 4) corners."""


@dataclass(frozen=True)
class MeshComplete:
    """A closed surface with faces, to be written.

    Parameters
    ----------
    surface : Surface
        The surface, wound outward, mm.
    faces : NamedFaces
        A face for every triangle, and the names of the faces, which become names of files.
    walls : collection of int
        Numbers of the faces that are wall.
    frame : "RAS", "LPS" or None
        Frame of the points.
    volume : VolumeMesh, optional
    """

    surface: Surface
    faces: NamedFaces
    walls: frozenset[int]
    frame: Frame | None = None
    volume: VolumeMesh | None = None

    def write(self, folder: str | os.PathLike[str]) -> None:
        """Write `mesh-complete.exterior.vtp`, `walls_combined.vtp` and `mesh-surfaces/*.vtp`.

        With a volume it also writes `mesh-complete.mesh.vtu`, and the tetrahedra's ids in all
        files.

        Raises
        ------
        InputError
            A volume mesh that has not kept the surface.
        OSError
            A folder that is there already, or cannot be made.
        """
        folder = Path(folder)
        elements = None if self.volume is None else tetrahedra_at(self.surface, self.volume)
        folder.mkdir()
        (folder / FACES).mkdir()
        if self.volume is not None:
            (folder / VOLUME).write_bytes(_encoded_volume(self.volume))
        every = np.arange(len(self.faces.ids))
        self._write(folder / EXTERIOR, every, elements)
        is_wall = np.isin(self.faces.ids, list(self.walls))
        self._write(folder / WALLS, every[is_wall], elements)
        for number in np.unique(self.faces.ids).tolist():
            path = folder / FACES / f"{self.faces.names[number]}.vtp"
            self._write(path, every[self.faces.ids == number], elements)

    def _write(self, path: Path, own: Indices, elements: Indices | None) -> None:
        """Write some triangles, with the ids of their points in the whole surface."""
        nodes, corners = np.unique(self.surface.triangles[own], return_inverse=True)
        cells = {ID_ARRAY: _ids(self.faces.ids[own])}
        if elements is not None:
            cells["GlobalElementID"] = _ids(elements[own] + 1)
        polydata = polydata_from_arrays(
            self.surface.points[nodes] / MILLIMETERS[UNITS],
            corners.reshape(-1, 3),
            {"GlobalNodeID": _ids(nodes + 1)},
            cells,
        )
        set_frame_of_polydata(polydata, self.frame)
        set_face_names(
            polydata, {n: self.faces.names[n] for n in np.unique(self.faces.ids[own]).tolist()}
        )
        path.write_bytes(encode_vtp(polydata))


def tetrahedra_at(surface: Surface, volume: VolumeMesh) -> Indices:
    """The tetrahedron (m,) behind every triangle of the surface."""
    count = len(surface.points)
    is_kept = np.array_equal(volume.points[:count], surface.points)
    sides = volume.tetrahedra[:, _SIDES].reshape(-1, 3)
    owner = np.repeat(np.arange(len(volume.tetrahedra)), len(_SIDES))
    outer = (sides < count).all(axis=1)
    keys, owner = _keys(sides[outer], count), owner[outer]
    order = np.argsort(keys)
    wanted = _keys(surface.triangles, count)
    place = np.searchsorted(keys, wanted, sorter=order)
    found = order[np.minimum(place, len(order) - 1)] if len(order) else place[:0]
    if not is_kept or not len(found) or (keys[found] != wanted).any():
        raise InputError(
            "volume mesh: expected the points of the surface first and a tetrahedron behind every "
            "triangle, got another surface; let the mesher keep it as it is (TetGen: -Y)."
        )
    return owner[found]


def _keys(corners: Indices, count: int) -> Indices:
    """A number for three points in any order; it fits for up to two million points."""
    low, middle, high = np.sort(corners.astype(np.int64), axis=1).T
    return np.asarray((low * count + middle) * count + high)


def _encoded_volume(volume: VolumeMesh) -> bytes:
    nodes, elements = len(volume.points), len(volume.tetrahedra)
    return encode_vtu(
        volume.points / MILLIMETERS[UNITS],
        volume.tetrahedra,
        {"GlobalNodeID": _ids(1 + np.arange(nodes))},
        {"GlobalElementID": _ids(1 + np.arange(elements))},
    )


def _ids(numbers: Indices) -> NDArray[Any]:
    return numbers.astype(np.int32)


def read_volume(path: str | os.PathLike[str]) -> tuple[VolumeMesh, dict[str, Floats]]:
    """Tetrahedra of a VTU file in cm, and the arrays (n,) or (n, k) at their points, by name.

    Raises
    ------
    InputError
        No such file, another kind of file, a damaged one, or coordinates that are no numbers.
    """
    content = read_content(path, "a volume mesh")
    points, tetrahedra, arrays = decode_vtu(content.data, str(content.path))
    if not np.isfinite(points).all():
        raise InputError(f"{content.path}: expected finite coordinates, got others; make it anew.")
    return VolumeMesh(MILLIMETERS[UNITS] * points, tetrahedra), arrays
