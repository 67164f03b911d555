"""A smooth distance from the border of a label: zero where the vessel's wall is.

The border of voxels is a staircase. A Gauss filter evens it out, and moves a round wall inward by
what is proportional to its width squared; filtered twice and subtracted (Tukey's twicing, 1977;
Stuetzle and Mittal 1979, doi 10.1007/BFb0098495) that term is gone. A filter is as wide as the
vessel allows: what is a staircase in an aorta is a vessel elsewhere.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..validation import Flags, Floats, Indices
from .labelmap import Grid, Labelmap

SHARE = 0.5
"""Width of the filter over the vessel's radius. `python -m benchmarks.voxels` has diameters for
others: below, the staircase stays, above, tight throats close."""

WIDTHS = (0.7, 1.0, 1.4, 2.0, 2.8, 4.0)
"""Widths that are computed, in voxels; between them values are blended. Below the first a
staircase is not smoothed at all; the last one leaves less of it than a facet is off."""

BESIDE = 1.0
"""Voxels outside of a vessel up to which its radius counts: there the filter sees its wall."""


Box = tuple[slice, ...]

_TAIL = 8
"""Widths of a filter, applied twice, that a value depends on: scipy cuts each off at four."""


def wall_distance(labelmap: Labelmap, share: float = SHARE) -> Grid:
    """Distance from the wall at every voxel, mm, negative inside.

    Near the wall it is that of the smoothed border; elsewhere it only has the right sign.

    Parameters
    ----------
    labelmap : Labelmap
        Labelmap with room round the vessel.
    share : float
        See `SHARE`.
    """
    from scipy.ndimage import distance_transform_edt

    spacing = labelmap.spacing
    depth = distance_transform_edt(labelmap.mask, sampling=spacing).astype(np.float32)
    outside = distance_transform_edt(~labelmap.mask, sampling=spacing).astype(np.float32)
    distance = outside - depth
    per_width = labelmap.voxel / spacing
    smooth = -_filtered(distance, per_width)
    wanted = share * _local_radius(smooth, labelmap)
    level = np.interp(np.log(wanted), np.log(WIDTHS), np.arange(len(WIDTHS))).astype(np.float32)
    found = np.zeros_like(distance)
    for number, width in enumerate(WIDTHS):
        part = np.clip(1 - np.abs(level - number), 0, 1)
        reach = np.ceil(_TAIL * width * per_width).astype(int)
        for box, inner in _boxes(part > 0, reach):
            own = _filtered(distance[box], width * per_width)
            found[box][inner] += (part[box] * own)[inner]
    return found


def _boxes(marked: Flags, reach: Indices) -> Iterator[tuple[Box, Box]]:
    """Box round the marked voxels, wider by a reach, and the box itself within it."""
    from scipy.ndimage import find_objects

    for tight in find_objects(marked.astype(np.uint8)):
        low = [max(side.start - more, 0) for side, more in zip(tight, reach, strict=True)]
        high = [side.stop + more for side, more in zip(tight, reach, strict=True)]
        box = tuple(slice(*ends) for ends in zip(low, high, strict=True))
        inner = tuple(
            slice(side.start - first, side.stop - first)
            for side, first in zip(tight, low, strict=True)
        )
        yield box, inner


def _filtered(distance: Grid, widths: Floats) -> Grid:
    """The distance without its staircase; widths (3,) in voxels along each axis."""
    from scipy.ndimage import gaussian_filter

    once = gaussian_filter(distance, widths, mode="nearest")
    return np.asarray(2 * once - gaussian_filter(once, widths, mode="nearest"))


def _local_radius(depth: Grid, labelmap: Labelmap) -> Grid:
    """Radius of the vessel beside every voxel, in voxels.

    It is the depth of the deepest place, not farther than that depth: balls stand as boxes here,
    for which a filter takes a tenth of the time. Places are taken by depth, from one step of
    `WIDTHS` to the next.
    """
    from scipy.ndimage import gaussian_filter, maximum_filter

    depth = depth / labelmap.voxel
    steps = np.array(WIDTHS) / SHARE
    found = np.full_like(depth, steps[0])
    for least, most in zip(steps, [*steps[1:], np.inf], strict=True):
        own = np.where((depth >= least) & (depth < most), np.minimum(depth, steps[-1]), 0)
        if own.any():
            reach = (least + BESIDE) * labelmap.voxel / labelmap.spacing
            sides = 2 * np.rint(reach).astype(int) + 1
            np.maximum(found, maximum_filter(own, sides.tolist()), out=found)
    return np.asarray(gaussian_filter(found, 1.0))
