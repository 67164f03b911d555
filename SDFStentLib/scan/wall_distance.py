"""A smooth distance from the border of a label: zero where the vessel's wall is.

The border of voxels is a staircase. A Gauss filter evens it out, and moves a round wall inward by
what is proportional to its width squared; filtered twice and subtracted (Tukey's twicing, 1977;
Stuetzle and Mittal 1979, doi 10.1007/BFb0098495) that term is gone. A filter is as wide as the
vessel allows: what is a staircase in an aorta is a vessel elsewhere.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from math import prod

import numpy as np

from ..geometry import norm, search_tree
from ..threads import side_by_side
from ..validation import Flags, Floats, Indices
from .labelmap import Grid, Labelmap

SHARE = 0.5
"""Width of the filter over the vessel's radius. `python -m benchmarks.voxels` has diameters for
others: below, the staircase stays, above, tight throats close."""

WIDTHS = (0.7, 1.0, 1.4, 2.0, 2.8, 4.0)
"""Widths that are computed, in voxels; between them values are blended. Below the first a
staircase is not smoothed at all; the last one leaves less of it than a facet is off."""


Box = tuple[slice, ...]

_TAIL = 8
"""Widths of a filter, applied twice, that a value depends on: scipy cuts each off at four."""

_NEAR = 2 * WIDTHS[-1]
"""Distance from the border, in voxels, beyond which no filter gives another sign."""


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
    distance = _border_distance(labelmap)
    per_width = labelmap.voxel / labelmap.spacing
    is_near = np.abs(distance) < _NEAR * labelmap.voxel
    smooth = distance.copy()
    # Depth counts where the vessel is; voxels beside it may be noise on its border.
    is_beside = distance < 2 * labelmap.spacing.max()

    def smoothen(boxes: tuple[Box, Box]) -> None:
        box, inner = boxes
        own = _filtered(distance[box], per_width)[inner]
        np.copyto(smooth[box][inner], own, where=is_beside[box][inner])

    side_by_side(smoothen, _boxes(is_beside, _reach(_TAIL, per_width)))
    wanted = share * _local_radius(-smooth, labelmap, is_near)[is_near]
    level = np.full(distance.shape, np.inf, dtype=np.float32)
    level[is_near] = np.interp(np.log(wanted), np.log(WIDTHS), np.arange(len(WIDTHS)))
    near, levels = np.flatnonzero(is_near), level[is_near]
    found = np.where(is_near, 0, distance)

    def add(number: int, boxes: tuple[Box, Box]) -> None:
        box, inner = boxes
        own = _filtered(distance[box], WIDTHS[number] * per_width)[inner]
        found[box][inner] += np.clip(1 - np.abs(level[box][inner] - number), 0, 1) * own

    for number, width in enumerate(WIDTHS):
        is_own = _marked(distance.shape, near.compress(np.abs(levels - number) < 1))
        side_by_side(partial(add, number), _boxes(is_own, _reach(_TAIL * width, per_width)))
    step = float(labelmap.spacing.max())
    found.ravel()[near] = _as_seen(found.ravel()[near], smooth.ravel()[near], step)
    return found


def _as_seen(found: Floats, seen: Floats, step: float) -> Floats:
    """Filtered distances (n,), and more of those by a filter as wide as a voxel where they differ.

    A staircase is within half a step of its wall. What a wide filter moves farther is vessel: the
    crotch of a fork, a throat beside what is wider, the rim of a flat end, a vessel of two voxels.
    """
    off = (found - seen) / step
    size = np.abs(off)
    return seen + step * np.sign(off) * np.maximum(np.minimum(size, (1.5 - size) / 2), 0)


def _border_distance(labelmap: Labelmap) -> Grid:
    """Distance of every voxel to the nearest one outside, or inside; mm, negative inside."""
    from scipy.ndimage import binary_dilation, distance_transform_edt

    mask, spacing = labelmap.mask, labelmap.spacing
    nearest = distance_transform_edt(
        ~mask, sampling=spacing, return_distances=False, return_indices=True
    )
    distance = np.empty(mask.shape, dtype=np.float32)
    own = np.indices((1, *mask.shape[1:]))

    def measure(number: int) -> None:  # a layer, that stays in the processor's cache
        offset = nearest[:, number] - own[:, 0]
        offset[0] -= number
        squares = [(one * side) ** 2 for one, side in zip(offset, spacing, strict=True)]
        distance[number] = np.sqrt(sum(squares))

    side_by_side(measure, range(len(distance)))
    # Few voxels are inside: a search among those beside them takes less than another transform.
    inside, beside = np.argwhere(mask), np.argwhere(binary_dilation(mask) & ~mask)
    if not len(beside):  # a label that fills its image; SciPy's transform takes that place
        beside = np.array([[-1, 0, 0]])
    found = search_tree(beside * spacing).query(inside * spacing)[1]
    distance[mask] = -norm((beside[found] - inside) * spacing)
    return distance


def _marked(shape: tuple[int, ...], numbers: Indices) -> Flags:
    """Mask of a grid's shape, set at some places (k,) of it."""
    mask = np.zeros(shape, dtype=bool)
    mask.ravel()[numbers] = True
    return mask


def _reach(voxels: float, per_width: Floats) -> Indices:
    return np.ceil(voxels * per_width).astype(int)


def _boxes(marked: Flags, reach: Indices) -> Iterator[tuple[Box, Box]]:
    """Boxes round all marked voxels, each wider by a reach, and the box itself within it.

    They part where that leaves fewer voxels; none is in two of the boxes themselves.
    """
    from scipy.ndimage import find_objects

    sides = np.maximum(reach, _TAIL)
    bricks = marked
    for axis, side in enumerate(sides):
        bricks = np.logical_or.reduceat(bricks, np.arange(0, marked.shape[axis], side), axis)
    for rough in _parted(bricks):
        low = np.array([one.start for one in rough]) * sides
        room = tuple(
            slice(first, one.stop * side)
            for first, one, side in zip(low, rough, sides, strict=True)
        )
        (tight,) = find_objects(marked[room].astype(np.uint8))
        box, inner = [], []
        for first, side, more in zip(low, tight, reach, strict=True):
            start, stop = int(first + side.start), int(first + side.stop)
            begin = max(start - int(more), 0)
            box.append(slice(begin, stop + int(more)))
            inner.append(slice(start - begin, stop - begin))
        yield tuple(box), tuple(inner)


def _parted(bricks: Flags) -> list[Box]:
    """Boxes round all marked bricks, halved where those take less room with a brick round each."""
    from scipy.ndimage import find_objects

    if not bricks.any():
        return []
    (tight,) = find_objects(bricks.astype(np.uint8))
    sizes = [side.stop - side.start for side in tight]
    longest = int(np.argmax(sizes))
    if sizes[longest] <= 2:
        return [tight]
    whole, found = tight[longest], []
    middle = (whole.start + whole.stop) // 2
    for half in (slice(whole.start, middle), slice(middle, whole.stop)):
        room = tuple(half if axis == longest else side for axis, side in enumerate(tight))
        found += [_shifted(box, room) for box in _parted(bricks[room])]
    return found if sum(map(_with_margin, found)) < _with_margin(tight) else [tight]


def _shifted(box: Box, room: Box) -> Box:
    """A box of a room in what the room is part of."""
    return tuple(
        slice(outer.start + side.start, outer.start + side.stop)
        for side, outer in zip(box, room, strict=True)
    )


def _with_margin(box: Box) -> int:
    return prod(side.stop - side.start + 2 for side in box)


def _filtered(distance: Grid, widths: Floats) -> Grid:
    """The distance without its staircase; widths (3,) in voxels along each axis."""
    from scipy.ndimage import gaussian_filter

    once = gaussian_filter(distance, widths, mode="nearest")
    return np.asarray(2 * once - gaussian_filter(once, widths, mode="nearest"))


def _local_radius(depth: Grid, labelmap: Labelmap, asked: Flags) -> Grid:
    """Radius of the vessel beside every voxel that is asked for, in voxels.

    It is the depth of the deepest place, not farther than that depth and the diagonal of a voxel,
    as the filter sees the wall from outside, too. Places are taken by depth, from one step of
    `WIDTHS` to the next. Balls stand as boxes here, for which a filter takes a tenth of the time;
    where a wide vessel's box holds another one `_as_seen` tells.
    """
    from scipy.ndimage import gaussian_filter, maximum_filter

    depth = depth / labelmap.voxel
    steps = np.array(WIDTHS) / SHARE
    diagonal = float(np.linalg.norm(labelmap.spacing)) / labelmap.voxel
    found = np.full_like(depth, steps[0])
    inside = np.flatnonzero(depth >= steps[0])
    depths = depth.ravel()[inside]
    for least, most in zip(steps, [*steps[1:], np.inf], strict=True):
        is_own = _marked(depth.shape, inside.compress((depths >= least) & (depths < most)))
        reach = np.rint((least + diagonal) * labelmap.voxel / labelmap.spacing).astype(int)
        for box, _ in _boxes(is_own, reach):
            own = np.where(is_own[box], np.minimum(depth[box], steps[-1]), 0)
            deepest = maximum_filter(own, (2 * reach + 1).tolist())
            np.maximum(found[box], deepest, out=found[box])
    even = found.copy()
    for box, inner in _boxes(asked, np.full(3, _TAIL // 2)):
        even[box][inner] = gaussian_filter(found[box], 1.0)[inner]
    return even
