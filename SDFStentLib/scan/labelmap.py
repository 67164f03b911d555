"""The voxels of one label: where they are in the patient, and how they hang together."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..validation import Flags, Floats, InputError, Points, coordinates, read_only

Grid = NDArray[np.floating[Any]]
"""Values (i, j, k) at voxels."""

AROUND = 12
"""Voxels round a label as room for its smoothed border, and for the vessel beyond the image."""

STRAIGHT = 1e-3
"""Largest product of two directions of voxels that are perpendicular; headers have few digits."""


@dataclass(frozen=True, eq=False)
class Labelmap:
    """Voxels of one vessel.

    Parameters
    ----------
    mask : (i, j, k) array of bool
        Whether each voxel belongs to the vessel.
    spacing : (3,) array
        Distances of the voxels' centers along each axis of the mask, mm.
    origin : (3,) array
        Center of the first voxel in the patient, LPS, mm.
    directions : (3, 3) array
        Unit vectors of the axes in its columns, LPS.

    Raises
    ------
    InputError
        No voxel, a spacing that is no length, or axes that are not perpendicular.
    """

    mask: NDArray[np.bool_]
    spacing: Floats
    origin: Points
    directions: Floats

    def __post_init__(self) -> None:
        for name in ("spacing", "origin", "directions"):
            object.__setattr__(self, name, read_only(np.array(getattr(self, name), dtype=float)))
        if not np.isfinite(self.spacing).all() or self.spacing.min() <= 0:
            raise InputError(
                "segmentation: expected voxels that are some mm apart along every axis, got a "
                f"spacing of {coordinates(self.spacing)}; correct it in the file's header."
            )
        askew = np.abs(self.directions.T @ self.directions - np.eye(3)).max()
        if askew > STRAIGHT:
            raise InputError(
                "segmentation: expected axes of voxels that are perpendicular, got such that are "
                "not, as of a tilted gantry; resample it onto straight axes, in Slicer by "
                "Resample Scalar Volume."
            )
        if not self.mask.any():
            raise InputError(
                "segmentation: expected voxels of a vessel, the label has none; choose another."
            )

    @property
    def voxel(self) -> float:
        """The side of a cube as large as a voxel, mm."""
        return float(np.prod(self.spacing) ** (1 / 3))

    def in_patient(self, places: Points) -> Points:
        """Places (n, 3), mm along the axes from the first voxel, in the patient's LPS."""
        return np.asarray(self.origin + places @ self.directions.T)


class LabelPiece(NamedTuple):
    """The largest part of a label that hangs together, and what was left out beside it."""

    labelmap: Labelmap
    left_out: int
    """Number of other parts."""
    left_volume: float
    """Their volume, mm^3."""
    filled: float
    """Volume of the hollows that were filled, mm^3."""
    is_cut: tuple[tuple[bool, bool], ...]
    """Whether, for each axis, the image cuts the part off at its beginning, and at its end."""


def largest_piece(labelmap: Labelmap) -> LabelPiece:
    """The largest part of a label, its hollows filled; voxels that touch at a corner are one."""
    from scipy.ndimage import binary_fill_holes, label

    around = _box(labelmap.mask)  # most of an image is beside its vessel
    labels, count = label(labelmap.mask[around], structure=np.ones((3, 3, 3), dtype=bool))
    counts = np.bincount(labels.ravel())[1:]
    mask = labels == 1 + int(counts.argmax())
    own = _box(mask)
    filled = np.asarray(binary_fill_holes(mask[own]))
    each = float(np.prod(labelmap.spacing))
    first = np.array([outer.start + side.start for outer, side in zip(around, own, strict=True)])
    origin = labelmap.in_patient((first * labelmap.spacing)[None])[0]
    sides = zip(first.tolist(), filled.shape, labelmap.mask.shape, strict=True)
    return LabelPiece(
        Labelmap(filled, labelmap.spacing, origin, labelmap.directions),
        count - 1,
        float(counts.sum() - counts.max()) * each,
        float(np.count_nonzero(filled) - counts.max()) * each,
        tuple((start == 0, start + length == whole) for start, length, whole in sides),
    )


def thin_bridges(labelmap: Labelmap) -> Points:
    """Places (k, 3), LPS, mm, where nothing wider than two voxels joins parts of five or more."""
    from scipy.ndimage import binary_erosion, label
    from scipy.spatial import cKDTree

    core = binary_erosion(labelmap.mask)
    labels, _ = label(core, structure=np.ones((3, 3, 3), dtype=bool))
    # What is five voxels wide has something left once two layers are off.
    wide = np.unique(labels[binary_erosion(core)])
    parts = sorted((np.argwhere(labels == number) for number in wide), key=len, reverse=True)
    found = []
    for number, part in enumerate(parts[1:], start=1):
        # The nearest of the larger parts: that is the one it hangs on.
        others = np.concatenate(parts[:number])
        away, nearest = cKDTree(others).query(part)
        closest = int(away.argmin())
        found.append((part[closest] + others[nearest[closest]]) / 2)
    return labelmap.in_patient(np.reshape(found, (-1, 3)) * labelmap.spacing)


def _box(mask: Flags) -> tuple[slice, ...]:
    """The box round all voxels of a mask, of which there is at least one."""
    has = (np.flatnonzero(mask.any(axis=tuple({0, 1, 2} - {axis}))) for axis in range(3))
    return tuple(slice(int(side[0]), int(side[-1]) + 1) for side in has)
