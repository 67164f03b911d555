"""Arithmetic on trees in point form: every point knows the next one toward the root."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..geometry import Line, search_tree, segment_count
from ..validation import Floats, Indices, InputError, Points

NO_LOOPS: Indices = np.empty((0, 2), dtype=np.int64)


class PointTree(NamedTuple):
    """Points (n, 3) and inscribed radii (n,), NaN where unknown, mm; parents (n,),
    -1 at the root."""

    points: Points
    inscribed_radius: Floats
    parent: Indices
    loops: Indices = NO_LOOPS
    """(k, 2) points joined by a line that the tree has to leave out."""


def as_radii(values: ArrayLike | None, count: int) -> Floats:
    """Inscribed radius (n,) per point; NaN where it is missing, not finite or not positive.

    Raises
    ------
    InputError
        Not one number per point.
    """
    if values is None:
        return np.full(count, np.nan)
    try:
        radius = np.array(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"inscribed radius: expected numbers, got {error}.") from error
    if radius.shape != (count,):
        raise InputError(
            f"inscribed radius: expected one number for each of {count} centerline points, "
            f"got shape {radius.shape}."
        )
    radius[~(np.isfinite(radius) & (radius > 0))] = np.nan
    return radius


def as_parents(values: ArrayLike, count: int) -> Indices:
    """Parent (n,) of each point, -1 at a root.

    Raises
    ------
    InputError
        Not one integer per point, a parent that does not exist, a circle, or no edge at all.
    """
    parent = np.asarray(values)
    if parent.shape != (count,) or parent.dtype.kind not in "iu":
        raise InputError(
            f"centerline parents: expected {count} integers, got {parent.dtype} {parent.shape}."
        )
    if parent.min() < -1 or parent.max() >= count:
        raise InputError(
            f"centerline parents: expected -1 to {count - 1}, got {parent.min()} to {parent.max()}."
        )
    above = parent = parent.astype(np.int64)
    # Each round doubles the steps upward, so that only a circle outlasts log2(count) of them.
    for _ in range(count.bit_length()):
        above = np.where(above >= 0, above[above], -1)
    if (above >= 0).any():
        raise InputError(
            "centerline parents: expected every point to lead to a root, "
            f"got a circle that holds point {above.max()}; open it somewhere."
        )
    if (parent < 0).all():
        raise InputError("centerline parents: expected connected points, got roots only.")
    return parent


def as_loops(values: ArrayLike, count: int) -> Indices:
    """Pairs (k, 2) of points between which lines close a loop; `InputError` unless they exist."""
    loops = np.asarray(values)
    is_fit = loops.ndim == 2 and loops.shape[1:] == (2,) and loops.dtype.kind in "iu"
    if not is_fit or (loops.size and not 0 <= loops.min() <= loops.max() < count):
        raise InputError(
            f"centerline loops: expected pairs of point indices from 0 to {count - 1}, "
            f"got {loops.dtype} {loops.shape}."
        )
    return loops.astype(np.int64)


def distal_ends(parent: Indices, loops: Indices) -> Indices:
    """Points (k,) at which vessels of a tree end: no child, and no other limb of a loop met there.

    Parameters
    ----------
    parent : (n,) array
    loops : (j, 2) array
        Of `Centerline` both.
    """
    return np.setdiff1d(np.arange(len(parent)), np.r_[parent, loops[:, 0]])


def sums_to_root(parent: Indices, values: Floats) -> Floats:
    """Sums (n,) of the values from the root down to each point, both included."""
    sums, above = values.copy(), parent.copy()
    # Ends: parents are checked for circles, so that everything comes to a root.
    while (above >= 0).any():
        sums = sums + np.where(above >= 0, sums[above], 0.0)
        above = np.where(above >= 0, above[above], -1)
    return sums


def run_starts(parent: Indices) -> Indices:
    """The points (k,), ascending, that do not directly follow their parents."""
    return np.flatnonzero(np.r_[True, parent[1:] != np.arange(len(parent) - 1)])


def ancestry_of(parent: Indices, index: int, starts: Indices | None = None) -> Indices:
    """Indices (k,) from the root down to `index`, both included; `starts` are `run_starts` if
    known."""
    # Most points come right after their parents: such runs are taken as a whole.
    starts = run_starts(parent) if starts is None else starts
    runs, last = [], int(index)
    # Ends: parents are checked for circles.
    while last >= 0:
        first = int(starts[np.searchsorted(starts, last, side="right") - 1])
        runs.append(np.arange(first, last + 1))
        last = parent.item(first)
    return np.concatenate(runs[::-1])


class NeighborTable(NamedTuple):
    """Neighbors of point i: `points[starts[i]:starts[i + 1]]`, ascending by the
    child of each pair."""

    starts: Indices
    points: Indices

    def of(self, index: int) -> list[int]:
        """The points next to point `index`."""
        first, after = self.starts[index : index + 2].tolist()
        return list(self.points[first:after].tolist())


def neighbor_table(parent: Indices) -> NeighborTable:
    """The parent and the children of every point (n,)."""
    child = np.flatnonzero(parent >= 0)
    one, other = np.r_[child, parent[child]], np.r_[parent[child], child]
    order = np.lexsort((np.r_[child, child], one))
    starts = np.searchsorted(one[order], np.arange(len(parent) + 1))
    return NeighborTable(starts, other[order])


def branches_of(parent: Indices) -> tuple[Indices, ...]:
    """Point indices from root or junction to the next junction or leaf, both included."""
    child_counts = np.bincount(parent[parent >= 0], minlength=len(parent))
    stops = (child_counts != 1) | (parent < 0)
    found = []
    for end in np.flatnonzero(stops & (parent >= 0)):
        branch = [int(end), int(parent[end])]
        # Ends: upward, where the root is a stop.
        while not stops[branch[-1]]:
            branch.append(int(parent[branch[-1]]))
        found.append(np.array(branch[::-1], dtype=np.int64))
    return tuple(found)


def points_between(up: Indices, down: Indices) -> Indices | None:
    """Points (k,) passed on the way from one place to another, from the ancestries of both.

    A place lies on the segment that leads to a point from its parent; the ancestry is that of the
    point. Places on one segment have no point between; None when the roots differ.
    """
    count = min(len(up), len(down))
    differs = np.flatnonzero(up[:count] != down[:count])
    shared = int(differs[0]) if len(differs) else count
    if shared == 0:
        return None
    if shared == len(up) == len(down):
        return up[:0]
    if shared == len(up):
        return down[shared - 1 : -1]
    if shared == len(down):
        return up[shared - 1 : -1][::-1]
    return np.concatenate([up[shared - 1 : -1][::-1], down[shared:-1]])


def mixed_radius(first: ArrayLike, second: ArrayLike, fraction: ArrayLike) -> Floats:
    """Radii interpolated linearly between two arrays; the known one where only one is known."""
    first, second, fraction = np.asarray(first), np.asarray(second), np.asarray(fraction)
    mean = (1.0 - fraction) * first + fraction * second
    return np.where(np.isnan(first), second, np.where(np.isnan(second), first, mean))


def interpolated(line: Line, radius: Floats, at: Floats) -> tuple[Points, Floats]:
    """Points and radii at the given arc lengths of a line of at least two points."""
    segments, fractions = line.located(at)
    return line.at(at), mixed_radius(radius[segments], radius[segments + 1], fractions)


def resampled_tree(tree: PointTree, spacing: float) -> PointTree:
    """The tree with equal arc length along every branch; roots, junctions and leaves stay."""
    paths = branches_of(tree.parent)
    nodes = np.unique(np.concatenate([*[path[[0, -1]] for path in paths], _roots(tree.parent)]))
    number = {int(node): i for i, node in enumerate(nodes)}
    points, radius = [tree.points[nodes]], [tree.inscribed_radius[nodes]]
    parent = [np.full(len(nodes), -1, dtype=np.int64)]
    count = len(nodes)
    for path in paths:
        line = Line(tree.points[path])
        total = line.arc_lengths[-1]
        at = np.linspace(0.0, total, segment_count(float(total), spacing) + 1)[1:-1]
        new_points, new_radius = interpolated(line, tree.inscribed_radius[path], at)
        chain = np.array([number[int(path[0])], *range(count, count + len(at))], dtype=np.int64)
        points.append(new_points)
        radius.append(new_radius)
        parent.append(chain[:-1])
        parent[0][number[int(path[-1])]] = chain[-1]
        count += len(at)
    every = np.concatenate(points)
    loops = search_tree(every).query(tree.points[tree.loops.ravel()])[1].reshape(-1, 2)
    return PointTree(every, np.concatenate(radius), np.concatenate(parent), loops)


def _roots(parent: Indices) -> Indices:
    return np.flatnonzero(parent < 0)
