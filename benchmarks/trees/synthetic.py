"""Random vessel trees: calibers by Murray's law, vessels that bend and taper, 20 to 100 outlets."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from .layout import SPACING, VesselTree

LEAST_END = 0.75
"""Radius of the narrowest end, mm."""

_APART = 1.2
"""Least distance between the walls of vessels that are no neighbors, mm."""


class _Tip(NamedTuple):
    """An end at which a vessel goes on: number of the point, direction (3,), radius, parent's
    radius."""

    point: int
    way: np.ndarray
    radius: float
    parents: float
    is_side: bool


def random_tree(random: np.random.Generator, outlets: int) -> VesselTree:
    """A tree with about a number of outlets, or fewer if there is no room left."""
    root = float(random.uniform(4.0, 5.5))
    points, radius, parent = [np.zeros((1, 3))], [np.array([root])], [np.array([-1])]
    tips, ends = [_Tip(0, np.array([0.0, 0.0, 1.0]), root, root, False)], 0
    while tips:
        tips.sort(key=lambda tip: tip.radius)
        tip = tips.pop()
        made = _grown(tip, np.vstack(points), np.concatenate(radius), random)
        if made is None:
            ends += 1
            continue
        course, wide = made
        first = sum(map(len, parent))
        points.append(course)
        radius.append(wide)
        parent.append(np.r_[tip.point, first + np.arange(len(course) - 1)])
        last, way = first + len(course) - 1, course[-1] - course[-3]
        forks = _forked(last, way / np.linalg.norm(way), float(wide[-1]), random)
        if ends + len(tips) + 2 > outlets or wide[-1] < 1.25 * LEAST_END:
            ends += 1
        else:
            tips += forks
    return VesselTree(np.vstack(points), np.concatenate(radius), np.concatenate(parent))


def _grown(
    tip: _Tip, points: np.ndarray, radius: np.ndarray, random: np.random.Generator
) -> tuple[np.ndarray, np.ndarray] | None:
    """Points and radii of a vessel that stays clear of the others; None if there is no room."""
    others = cKDTree(points)
    is_long = 1.6 < tip.radius < 3.5 and random.uniform() < 0.25
    slenderness = random.uniform(5.0, 9.0) if is_long else random.uniform(1.5, 3.5)
    for attempt in range(12):
        length = max(2 * tip.radius * slenderness, 6.0) * 0.93**attempt + 2 * tip.parents
        steps = int(length / SPACING)
        along = SPACING * np.arange(1, steps + 1)
        aside = np.cross(tip.way, random.normal(size=3))
        aside /= np.linalg.norm(aside)
        bend = random.uniform(0.0, 1.5) / max(length, 12 * tip.radius)
        turn = bend * along * np.where(random.uniform() < 0.5, 1.0, np.cos(3 * along / length))
        ways = np.cos(turn)[:, None] * tip.way + np.sin(turn)[:, None] * aside
        course = points[tip.point] + np.cumsum(SPACING * ways, axis=0)
        taper = random.uniform(0.1, 0.3) if random.uniform() < 0.2 else random.uniform(0.0, 0.08)
        wide = tip.radius * (1 - taper * along / length)
        beyond = along > 2 * tip.parents + 2.5 * (tip.radius + _APART)
        near = others.query_ball_point(course[beyond], 2 * tip.radius + 8.0)
        if all(_is_clear(p, r, points[n], radius[n])
               for p, r, n in zip(course[beyond], wide[beyond], near, strict=True)):  # fmt: skip
            return course, wide + _funnel(tip, along)
    return None


def _is_clear(place: np.ndarray, wide: float, others: np.ndarray, radius: np.ndarray) -> bool:
    if not len(others):
        return True
    return bool((np.linalg.norm(others - place, axis=1) - radius).min() > wide + _APART)


def _funnel(tip: _Tip, along: np.ndarray) -> np.ndarray:
    """Additional radius of a vessel at its beginning, so that it leaves its parent
    without a step."""
    share = np.clip(along / (1.5 * tip.parents), 0, 1)
    more = 0.1 * tip.radius if tip.is_side else tip.parents - tip.radius
    return np.asarray(more * (1 - share * share * (3 - 2 * share)))


def _forked(point: int, way: np.ndarray, wide: float, random: np.random.Generator) -> list[_Tip]:
    """A side branch, or two equal vessels: the cubes of the radii add up to the parent's."""
    is_split = random.uniform() < 0.45
    small = wide * (random.uniform(0.72, 0.79) if is_split else random.uniform(0.35, 0.65))
    small = max(small, LEAST_END)
    large = (max(wide, 1.05 * small) ** 3 - small**3) ** (1 / 3)
    aside = np.cross(way, random.normal(size=3))
    aside /= np.linalg.norm(aside)
    angles = (35.0, -40.0) if is_split else (random.uniform(3.0, 12.0), -random.uniform(45.0, 70.0))
    ways = [np.cos(a) * way + np.sin(a) * aside for a in np.radians(angles)]
    return [
        _Tip(point, ways[0], large, wide, False),
        _Tip(point, ways[1], small, wide, not is_split),
    ]
