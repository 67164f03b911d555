"""Vessel trees as points with radii: read from a file, cut to subtrees, split into vessels."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

SPACING = 0.5
"""Spacing of the points along a vessel, mm."""


@dataclass(frozen=True)
class VesselTree:
    """Points (n, 3) and radii (n,), mm; `parent` (n,) is -1 at the root, which is the first point.

    A point comes after its parent.
    """

    points: np.ndarray
    radius: np.ndarray
    parent: np.ndarray

    @cached_property
    def children(self) -> list[list[int]]:
        found: list[list[int]] = [[] for _ in self.parent]
        for child, parent in enumerate(self.parent[1:].tolist(), start=1):
            found[parent].append(child)
        return found

    @cached_property
    def leaves(self) -> list[int]:
        return [number for number, some in enumerate(self.children) if not some]

    @cached_property
    def arc_length(self) -> np.ndarray:
        """Arc length of every point from the root, mm."""
        steps = np.linalg.norm(self.points - self.points[self.parent], axis=1)
        found = np.zeros(len(self.points))
        for number in range(1, len(found)):
            found[number] = found[self.parent[number]] + steps[number]
        return found

    @cached_property
    def chains(self) -> list[np.ndarray]:
        """Numbers of points from the root or a fork to the next fork or an end, both included."""
        found = []
        for number, parent in enumerate(self.parent.tolist()):
            if parent < 0 or (parent > 0 and len(self.children[parent]) == 1):
                continue
            chain = [parent, number]
            while len(self.children[chain[-1]]) == 1:
                chain.append(self.children[chain[-1]][0])
            found.append(np.array(chain))
        return found

    @cached_property
    def calibers(self) -> dict[int, float]:
        """Radius of every chain beyond its ostium, by the chain's second point."""
        found = {}
        for chain in self.chains:
            from_fork = self.arc_length[chain] - self.arc_length[chain[0]]
            beyond = chain[from_fork > 1.2 * self.radius[chain[0]]]
            own = beyond if len(beyond) >= 3 else chain[-max(len(chain) // 3, 1) :]
            found[int(chain[1])] = float(np.median(self.radius[own]))
        return found

    @cached_property
    def vessels(self) -> list[np.ndarray]:
        """Numbers of points along vessels, which go on from every fork along the widest child."""
        by_start = {int(chain[1]): chain for chain in self.chains}
        found, starts = [], list(self.children[0])
        while starts:
            vessel = by_start[starts.pop()]
            while self.children[vessel[-1]]:
                widest, *others = sorted(
                    self.children[vessel[-1]], key=lambda child: -self.calibers[child]
                )
                starts += others
                vessel = np.r_[vessel, by_start[widest][1:]]
            found.append(vessel)
        return sorted(found, key=lambda vessel: int(vessel[0]))

    def path_to(self, point: int) -> np.ndarray:
        """Numbers of the points from the root to a given one."""
        path = [point]
        while self.parent[path[-1]] >= 0:
            path.append(int(self.parent[path[-1]]))
        return np.array(path[::-1])

    def only(self, keep: np.ndarray) -> VesselTree:
        """The part of marked points (n,); the parent of a kept point has to be kept as well."""
        number = np.cumsum(keep) - 1
        parent = np.where(self.parent[keep] < 0, -1, number[self.parent[keep]])
        return VesselTree(self.points[keep], self.radius[keep], parent)

    def with_radius(self, radius: np.ndarray) -> VesselTree:
        return replace(self, radius=radius)


def resampled(tree: VesselTree, smoothed: float = 1.0) -> VesselTree:
    """The same chains in steps of about `SPACING`, with their course smoothed over some mm."""
    points, radius, parent = [tree.points[:1]], [tree.radius[:1]], [np.array([-1])]
    number, count = {0: 0}, 1
    for chain in tree.chains:
        along = tree.arc_length[chain] - tree.arc_length[chain[0]]
        steps = max(round(along[-1] / SPACING), 2)
        at = np.linspace(0, along[-1], steps + 1)
        course = np.stack([np.interp(at, along, x) for x in tree.points[chain].T], axis=1)
        for _ in range(int(np.ceil((smoothed / SPACING) ** 2))):
            course[1:-1] = (course[:-2] + 2 * course[1:-1] + course[2:]) / 4
        points.append(course[1:])
        radius.append(np.interp(at, along, tree.radius[chain])[1:])
        parent.append(np.r_[number[int(chain[0])], count + np.arange(steps - 1)])
        count += steps
        number[int(chain[-1])] = count - 1
    return VesselTree(np.vstack(points), np.concatenate(radius), np.concatenate(parent))


def read_tree(path: Path, scale: float) -> VesselTree:
    """The tree of a centerline of 2-point lines with `MaximumInscribedSphereRadius`,
    cm, enlarged."""
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy

    reader = vtk.vtkXMLPolyDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    read = reader.GetOutput()
    points = vtk_to_numpy(read.GetPoints().GetData()).astype(float)
    edges = vtk_to_numpy(read.GetLines().GetConnectivityArray()).reshape(-1, 2)
    data = read.GetPointData()
    radius = vtk_to_numpy(data.GetArray("MaximumInscribedSphereRadius")).astype(float)
    root = int(np.argmin(vtk_to_numpy(data.GetArray("Path"))))
    beside: list[list[int]] = [[] for _ in points]
    for first, second in edges.tolist():
        beside[first].append(second)
        beside[second].append(first)
    order, parent = [root], [-1]
    for place, one in enumerate(order):
        before = order[parent[place]] if parent[place] >= 0 else -1
        for other in beside[one]:
            if other != before:
                order.append(other)
                parent.append(place)
    made = VesselTree(10 * scale * points[order], 10 * scale * radius[order], np.array(parent))
    return resampled(made)


def with_some_ends(tree: VesselTree, count: int, random: np.random.Generator) -> VesselTree:
    """The part of a tree that leads to a number of its ends."""
    keep = np.zeros(len(tree.points), dtype=bool)
    for leaf in random.permutation(tree.leaves)[:count]:
        keep[tree.path_to(int(leaf))] = True
    return tree.only(keep)


def turned(tree: VesselTree, random: np.random.Generator) -> VesselTree:
    """The tree in another position, so that no direction of space is special."""
    turn, _ = np.linalg.qr(random.normal(size=(3, 3)))
    if np.linalg.det(turn) < 0:
        turn[:, 0] *= -1
    return replace(tree, points=(tree.points - tree.points[0]) @ turn.T)
