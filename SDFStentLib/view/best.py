"""The views from which a stretch of vessel is seen best, within the limits of the arm."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..centerline import Centerline
from ..geometry import Line
from ..units import Frame
from ..validation import Flags, Floats, InputError
from .arm import ArmLimits, ArmView, arm_axes
from .shadow import Obstacles, covered_shares, covering_branches, foreshortenings, obstacles
from .target import Spheres, ostia_target, spheres_of, stretch_target

GRID = 5.0
"""Degrees between the views of a map; those around the best one are then looked at degree by
degree."""

APART = 60.0
"""Degrees between the two views of a biplane, at least."""

AS_GOOD = 0.01
"""Share by which views count as equal, as they are reported to the percent; of such the least steep
is taken."""


class SeenView(NamedTuple):
    """A view, and how it shows the stretch; shares are from 0 to 1."""

    view: ArmView
    foreshortening: float
    """Foreshortening: share of the length that is lost."""
    covered: float
    """Share of the stretch that lies under other lumen."""
    ostia_covered: float
    """Share of the beginnings of the branches beside it that is covered; 0 where there is none."""
    seen: float
    """Share that is seen: what is left of the length, times what is free of the area of both."""
    over_it: tuple[int, ...] = ()
    """Indices of the branches that cover the stretch, the one over most of it first."""


@dataclass(frozen=True, eq=False)
class ViewMap:
    """Views of a stretch from all angles of a grid: arrays (p, s) over the two angles."""

    primary: Floats
    """(p,) LAO, degrees."""
    secondary: Floats
    """(s,) CRA, degrees."""
    foreshortening: Floats
    covered: Floats
    ostia_covered: Floats
    seen: Floats
    is_reached: Flags
    """Whether it is within the limits of the arm."""


@dataclass(frozen=True, eq=False)
class Shown:
    """A stretch of a vessel tree to be shown, and the vessels that may lie in the way.

    Parameters
    ----------
    tree : Centerline
        Centerline with radii.
    line : Line
        The axis of the stretch, mm.
    radii : (k,) array
        Inscribed, at its points, mm.
    frame : "RAS" or "LPS"
        Patient frame of both.
    """

    tree: Centerline
    line: Line
    radii: Floats
    frame: Frame

    def __post_init__(self) -> None:
        if not np.isfinite(self.radii).any() or not np.isfinite(self.tree.inscribed_radius).any():
            raise InputError(
                "views: expected a centerline with radii of inscribed spheres, got none; without "
                "them nobody knows what lies in the way."
            )
        self.line.check_length()

    @cached_property
    def _stretch(self) -> Obstacles:
        return obstacles(stretch_target(self.line, self.radii), self._others)

    @cached_property
    def _ostia(self) -> Obstacles:
        return obstacles(ostia_target(self.tree, self.line), self._others)

    @cached_property
    def _others(self) -> Spheres:
        return spheres_of(self.tree)

    def mapped(self, primary: Floats, secondary: Floats, limits: ArmLimits) -> ViewMap:
        """Map of its views from all pairs of angles (p,) and (s,), degrees."""
        first, second = _pairs(primary, secondary)
        shares = self._shares(arm_axes(first, second, self.frame))
        lost, covered, ostia, seen = (one.reshape(len(primary), -1) for one in shares)
        is_reached = limits.reach(first, second).reshape(len(primary), -1)
        return ViewMap(primary, secondary, lost, covered, ostia, seen, is_reached)

    def seen_from(self, view: ArmView) -> SeenView:
        """The stretch from one view, with the branches that cover it there."""
        axes = view.axes(self.frame)
        lost, covered, ostia, seen = (float(one[0]) for one in self._shares(axes[None]))
        over = covering_branches(self._stretch, axes)
        return SeenView(view, lost, covered, ostia, seen, tuple(over.tolist()))

    def _shares(self, axes: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """Lost, covered, ostia covered, and seen, (k,) each."""
        lost = foreshortenings(self.line, axes)
        stretch, ostia = (covered_shares(one, axes) for one in (self._stretch, self._ostia))
        areas = np.array([self._stretch.target.area, self._ostia.target.area])
        free = areas[0] * (1 - stretch) + areas[1] * (1 - ostia)
        return lost, stretch, ostia, (1 - lost) * free / areas.sum()


class WorkingViews(NamedTuple):
    """Views that are proposed for a stretch."""

    map: ViewMap
    best: SeenView
    second: SeenView | None
    """The best of the views that are far enough from the first; None where the arm reaches none."""
    worst: SeenView


def working_views(shown: Shown, limits: ArmLimits, apart: float = APART) -> WorkingViews:
    """The best view, the best one at least `apart` degrees away, the worst, and the map of all.

    Raises
    ------
    InputError
        The arm reaches no view at all.
    """
    grid = shown.mapped(_side(limits.lao_rao), _side(limits.cra_cau), limits)
    if not grid.is_reached.any():
        raise InputError("limits of the arm: expected some view within them, got none; widen them.")
    best = _best(shown, limits, grid, grid.is_reached)
    far = grid.is_reached & are_apart_from(best, grid, shown.frame, apart)
    second = _best(shown, limits, grid, far, best, apart) if far.any() else None
    worst = _at(grid, int(np.where(grid.is_reached, grid.seen, np.inf).argmin()))
    other = None if second is None else shown.seen_from(second)
    return WorkingViews(grid, shown.seen_from(best), other, shown.seen_from(worst))


def are_apart_from(view: ArmView, grid: ViewMap, frame: Frame, apart: float) -> Flags:
    """Mask (p, s) of a map's views at least so many degrees from one; opposite ones show the
    same."""
    toward = arm_axes(*_pairs(grid.primary, grid.secondary), frame)[:, 2]
    cosine = np.abs(toward @ view.axes(frame)[2]).reshape(grid.is_reached.shape)
    return np.asarray(cosine <= np.cos(np.deg2rad(apart)) + 1e-12)


def _side(most: float) -> Floats:
    """Angles of the grid from one limit to the other."""
    count = int(most / GRID + 1e-9)
    return np.linspace(-count * GRID, count * GRID, 2 * count + 1)


def _pairs(primary: Floats, secondary: Floats) -> tuple[Floats, Floats]:
    """Pairs of angles (p,) and (s,), as two arrays (p s,)."""
    first, second = np.meshgrid(primary, secondary, indexing="ij")
    return first.ravel(), second.ravel()


def _at(grid: ViewMap, number: int) -> ArmView:
    first, second = np.unravel_index(number, grid.is_reached.shape)
    return ArmView(float(grid.primary[first]), float(grid.secondary[second]))


def _least_steep(grid: ViewMap, allowed: Flags, most: float) -> ArmView:
    """Least steep of the allowed views that show as much as `most`, or as the best of them."""
    seen = np.where(allowed, grid.seen, -np.inf).ravel()
    steepness = np.hypot(*_pairs(grid.primary, grid.secondary))
    good = np.flatnonzero(seen >= max(most, seen.max()) - AS_GOOD)
    return _at(grid, int(good[steepness[good].argmin()]))


def _best(
    shown: Shown,
    limits: ArmLimits,
    grid: ViewMap,
    allowed: Flags,
    other: ArmView | None = None,
    apart: float = 0.0,
) -> ArmView:
    """The best of the allowed views of a grid, degree by degree; far enough from another one."""
    most = float(grid.seen[allowed].max())
    view = _least_steep(grid, allowed, most)
    around = np.arange(1 - GRID, GRID)
    fine = shown.mapped(view.primary + around, view.secondary + around, limits)
    near = fine.is_reached
    if other is not None:
        near = near & are_apart_from(other, fine, shown.frame, apart)
    return _least_steep(fine, near, most)
