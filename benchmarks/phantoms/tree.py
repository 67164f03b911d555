"""A vessel tree of hundreds of branches that divide in two again and again."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from SDFStentLib.centerline import Centerline
from SDFStentLib.geometry import Surface, ranges, smooth_minimum
from SDFStentLib.validation import Floats, Indices, Points, as_number, read_only

from .axis import narrowing, planar_axis
from .field import FieldValues, TubeField, TubeUnion
from .junction import branching_tube
from .value import CENTERLINE_SPACING, Phantom, TrueOpening, TrueVessel

ROOT_RADIUS = 5.0
"""Radius of the first branch, mm."""

SLENDERNESS = 9.0
"""Length of the first branch over its radius."""

NARROWER = 2 ** (-1 / 3)
"""Radius of a branch over its parent's: the cube law of Murray for two equal branches."""

SHORTER = 0.76
"""Length of a branch over its parent's; if longer, branches of the sixth generation would meet."""

HALF_ANGLE = np.radians(50.0)
"""Angle of a branch with its parent; every division lies across the one before."""

BLEND_WIDTH = 0.6
"""Blend width of the union of the branches, mm."""

LESION_HALF_LENGTH = 1.2
"""Half the length of a lesion, over the radius of its branch."""

_MARGIN = 6.0
"""Distance from a branch within which the field is exact, mm; the search for the surface needs
less."""

_FAR = 1e3
"""Value of the field where no branch is near, mm."""

_CELL = 8.0
"""Size of the cells of space in which the branches nearby are known, mm."""


def vascular_tree(
    outlets: int = 150, edge_length: float = 0.5, lesions: Mapping[int, float] | None = None
) -> Phantom:
    """A tree that divides in two until it has a number of outlets: 150 make 299 branches.

    The root has a diameter of 10 mm; every division makes two equal branches in the plane across
    that of the last division. The widest of the outlets always divides next.

    Parameters
    ----------
    outlets : int
        Number of outlets, 1 to 256.
    edge_length : float
        Edge length, mm, at most 0.65 of the smallest radius; 150 outlets and 0.5 mm make some
        200,000 triangles.
    lesions : mapping of int to float, optional
        Share of the diameter that is lost at the middle of a branch, in a raised cosine 2.4 radii
        long, by the number of the branch, which is 0 for the root.

    Raises
    ------
    InputError
        A number out of its range, or a lesion in a branch that is not there.
    """
    layout = _layout(int(as_number(outlets, "outlets", minimum=1, maximum=256)))
    depths = dict(lesions or {})
    for number, depth in depths.items():
        as_number(number, "number of the branch", minimum=0, maximum=len(layout) - 1)
        as_number(depth, "share of the diameter", above=0, maximum=0.9)
    narrowest = min(b.radius * (1 - depths.get(n, 0.0)) for n, b in enumerate(layout))
    as_number(edge_length, "edge_length", unit="mm", above=0, maximum=0.65 * narrowest)
    vessels = tuple(_vessel(n, branch, depths.get(n, 0.0)) for n, branch in enumerate(layout))
    parents = {branch.parent for branch in layout}
    leaves = [n for n in range(len(layout)) if n not in parents]
    # The ends reach less than three radii beyond their rims, where they are cut off.
    union = _Tree([TubeField(v.axis, v.radius) for v in vessels], leaves, 3 * edge_length)
    patch = branching_tube(union, edge_length, is_repaired=True)
    wall = patch.points[np.unique(patch.triangles[patch.face_ids == 1])]
    names = ("inlet", *(f"outlet of branch {n}" for n in leaves))
    return Phantom(
        name="vascular tree",
        surface=Surface(patch.points, patch.triangles),
        face_ids=read_only(patch.face_ids),
        centerline=_centerline(layout, vessels, lambda at: union.inscribed_radii(at, wall)),
        vessels=vessels,
        openings=tuple(
            TrueOpening(name, number + 2, read_only(rim.center), read_only(rim.outward), rim.radius)
            for number, (name, rim) in enumerate(zip(names, union.rims(), strict=True))
        ),
    )


class _Branch(NamedTuple):
    """A branch: its start, heading and direction of division (3,); sizes in mm."""

    parent: int
    start: Floats
    heading: Floats
    aside: Floats
    length: float
    radius: float


def _layout(outlets: int) -> list[_Branch]:
    root = (np.zeros(3), np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0]))
    branches = [_Branch(-1, *root, SLENDERNESS * ROOT_RADIUS, ROOT_RADIUS)]
    # Branches come in the order of their radii: the next one that divides is the first outlet.
    for number in range(outlets - 1):
        one = branches[number]
        end = one.start + one.length * one.heading
        across = np.cross(one.heading, one.aside)
        for side in (1, -1):
            heading = np.cos(HALF_ANGLE) * one.heading + side * np.sin(HALF_ANGLE) * one.aside
            sizes = SHORTER * one.length, NARROWER * one.radius
            branches.append(_Branch(number, end, heading, across, *sizes))
    return branches


def _vessel(number: int, branch: _Branch, depth: float) -> TrueVessel:
    axis = planar_axis(
        [(branch.length, 0.0)], start=branch.start, heading=branch.heading, toward=branch.aside
    )
    half = LESION_HALF_LENGTH * branch.radius

    def radius(at: Floats) -> Floats:
        return branch.radius * narrowing(at, branch.length / 2, half, depth)

    return TrueVessel(f"branch {number}", axis, radius)


def _centerline(
    layout: list[_Branch], vessels: tuple[TrueVessel, ...], radii_at: Callable[[Points], Floats]
) -> Centerline:
    points, parent, last = [vessels[0].axis.point(0.0)], [np.array([-1])], {-1: 0}
    for number, (branch, vessel) in enumerate(zip(layout, vessels, strict=True)):
        count = int(np.ceil(branch.length / CENTERLINE_SPACING))
        points.append(vessel.axis.point(np.linspace(0, branch.length, count + 1)[1:]))
        first = sum(map(len, parent))
        parent.append(np.r_[last[branch.parent], first + np.arange(count - 1)])
        last[number] = first + count - 1
    line = np.vstack(points)
    return Centerline(points=line, inscribed_radius=radii_at(line), parent=np.concatenate(parent))


class _Tree(TubeUnion):
    """The union of many tubes, evaluated at a place from the tubes near it only."""

    def __init__(self, tubes: list[TubeField], leaves: list[int], beyond: float) -> None:
        super().__init__(tubes, BLEND_WIDTH, beyond, open_ends=leaves)
        lower, upper = self.bounds()
        self._lower = lower - _MARGIN - _CELL
        self._counts = np.ceil((upper - lower + 2 * _MARGIN) / _CELL).astype(np.int64) + 2
        self._near = [self._cells_near(number) for number in range(len(tubes))]

    def __call__(self, points: Points) -> FieldValues:
        """The field at points (n, 3): exact within `_MARGIN` of the wall, and large farther out."""
        cell = self._cell_numbers(points)
        order = np.argsort(cell, kind="stable")
        in_order = cell[order]
        value, gradient = np.full(len(points), _FAR), np.zeros((len(points), 3))
        for number, near in enumerate(self._near):
            first, after = (np.searchsorted(in_order, near, side) for side in ("left", "right"))
            own = order[ranges(first, after - first)]
            if len(own):
                other, slope = self._tube_field(number, points[own])
                value[own], share = smooth_minimum(value[own], other, self.blend_width)
                part = share[:, None]
                gradient[own] = part * gradient[own] + (1 - part) * slope
        return FieldValues(value, gradient)

    def _cell_numbers(self, points: Points) -> Indices:
        at = np.clip(((points - self._lower) // _CELL).astype(np.int64), 0, self._counts - 1)
        return np.ravel_multi_index(tuple(at.T), tuple(self._counts))

    def _cells_near(self, number: int) -> Indices:
        """Numbers of the cells that come within the margin of a tube, and of few others."""
        table = self._tables[number]
        reach = float(table.radii[:, 0].max()) + self.blend_width + _MARGIN
        # Balls round places half a cell apart; the widening makes up for what is between them.
        every = max(int(_CELL / 2 / np.linalg.norm(table.points[1] - table.points[0])), 1)
        places = np.vstack([table.points[::every], table.points[-1:]])
        steps = np.arange(-int(np.ceil(reach / _CELL)) - 1, int(np.ceil(reach / _CELL)) + 2)
        offsets = np.stack(np.meshgrid(steps, steps, steps), axis=-1).reshape(-1, 3) * _CELL
        cells = (places[:, None] + offsets).reshape(-1, 3)
        apart = np.linalg.norm(offsets, axis=1) < reach + _CELL * (0.25 + np.sqrt(3))
        return np.unique(self._cell_numbers(cells[np.tile(apart, len(places))]))
