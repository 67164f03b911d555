"""Trees of patients' radii with hourglasses anywhere, also where the vessel tapers or divides.

Nothing is asked of the vessel about a narrowing but that its caliber there is that of both ends of
it: what tells them apart from `narrowing.py` is that no place is chosen because it is even. Those
at a fork, half of them, have a row of their own.
"""

from __future__ import annotations

import itertools
from functools import lru_cache
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from .case import MEASURED, TreeCase
from .layout import VesselTree, read_tree, resampled, turned, with_some_ends
from .narrowing import AT_FORK, HOURGLASS, LEAST_THROAT, MadeNarrowing, goes_on
from .pressed import tree_of_lines
from .surface import wall_near, wall_of
from .truth import Truth, truths

_PATIENTS = (MEASURED, "su0243_centerline_mm.vtp")
"""Files of patients' radii."""

_LENGTHS, _DEPTHS = (8.0, 24.0), (0.4, 0.68)

_LEAST = 2.0
"""Least radius of the vessel at both ends of a narrowing, mm."""

_WIDEST = 6.5
"""Largest radius there: a trunk is too short for healthy vessel on both sides of a narrowing."""

_SHALLOW = 0.25
"""Least share of the narrower end's caliber that a narrowing takes."""

_EVEN = (0.85, 1.2)
"""Least share of the narrower end's caliber, and largest one of the wider end's, that the vessel
had within a narrowing and `_BEYOND` mm beyond: no branch's own narrow beginning, and no aneurysm,
is its reference."""

_BEYOND = 3.0


def hourglass_case(seed: int, number: int, data: Path, only: str | None = None) -> TreeCase:
    """The case of a number, of every tenth, the fourth first, without a narrowing.

    Its shapes do not depend on `only`.
    """
    random = np.random.default_rng([seed, number, 2])
    name = _PATIENTS[number % len(_PATIENTS)]
    tree = bare_tree(number, data, random)
    chosen = [] if number % 10 == 4 else hourglasses(tree, 4, random)
    after = narrowed(tree, chosen)
    box = float(np.prod(np.ptp(tree.points, axis=0) + 2 * tree.radius.max()))
    step = max(0.4, (box / 45e6) ** (1 / 3))
    wall, found, refused = wall_of(after, step, "round"), list[Truth](), list[str]()
    for one in chosen:
        healthy = wall_near(tree, step, tree.points[one.vessel[one.factor < 1]])
        try:
            found += truths((tree, healthy), (after, wall), one)
        except ValueError as error:
            refused.append(str(error))
    facts = {
        "tree": name.split("_")[0], "ends": "round", "step": round(step, 3), "seed": seed,
        "number": number, "outlets": len(tree.leaves), "triangles": len(wall.triangles),
        "refused": refused, "wander": float(random.choice([0.0, 0.08])),
        "has_radius": bool(random.uniform() < 0.7),
    }  # fmt: skip
    return TreeCase(f"hourglass_{number:04d}", after, wall, found, facts)


def bare_tree(number: int, data: Path, random: np.random.Generator) -> VesselTree:
    """Some vessels of one of the patients, before they are narrowed."""
    whole = _patient(data / _PATIENTS[number % len(_PATIENTS)])
    return turned(with_some_ends(whole, int(random.integers(18, 40)), random), random)


@lru_cache
def _patient(path: Path) -> VesselTree:
    return read_tree(path, 1.6) if path.name == MEASURED else resampled(tree_of_lines(path))


def hourglasses(tree: VesselTree, count: int, random: np.random.Generator) -> list[MadeNarrowing]:
    """Narrowings apart from each other, as many as there is room for; vessels are whole ways."""
    found: list[MadeNarrowing] = []
    taken = np.zeros(len(tree.points), dtype=bool)
    for _ in range(2000):
        one = _tried(tree, random)
        if one is None:
            continue
        near = _reach(tree, one)
        if not taken[near].any():
            found.append(one)
            taken |= near
        if len(found) == count:
            break
    return found


def _tried(tree: VesselTree, random: np.random.Generator) -> MadeNarrowing | None:
    path = tree.path_to(int(random.choice(tree.leaves)))
    along, radius = tree.arc_length[path], tree.radius[path]
    length = float(random.uniform(*_LENGTHS))
    if along[-1] < length + 8:
        return None
    middle = float(random.uniform(length / 2 + 4, along[-1] - length / 2 - 4))
    begin, end = middle - length / 2, middle + length / 2
    ends = np.interp([begin, end], along, radius)
    share = np.clip(np.abs(along - middle) / (length / 2), 0, 1)
    factor = 1 - random.uniform(*_DEPTHS) * (1 + np.cos(np.pi * share)) / 2
    throat = float((radius * factor)[share < 1].min())
    about = radius[(along > begin - _BEYOND) & (along < end + _BEYOND)]
    is_fair = (
        ends.min() >= _LEAST and ends.max() <= _WIDEST and begin > ends[0]
        and LEAST_THROAT <= throat <= (1 - _SHALLOW) * ends.min()
        and about.min() >= _EVEN[0] * ends.min() and about.max() <= _EVEN[1] * ends.max()
    )  # fmt: skip
    if not is_fair:
        return None
    near = np.flatnonzero((along > begin - _BEYOND) & (along < end + _BEYOND))
    shape = HOURGLASS if _is_one_vessel(tree, path, near) else AT_FORK
    return MadeNarrowing(shape, path, (begin, end), (middle,), factor)


def _is_one_vessel(tree: VesselTree, path: np.ndarray, part: np.ndarray) -> bool:
    """Whether a part of a way, numbers (n,) of its points, is of one vessel."""
    for fork, onward in itertools.pairwise(path[part[0] : part[-1] + 2].tolist()):
        children = tree.children[fork]
        if len(children) > 1 and not (
            goes_on(tree, fork) and onward == max(children, key=lambda one: tree.calibers[one])
        ):
            return False
    return True


def _reach(tree: VesselTree, one: MadeNarrowing) -> np.ndarray:
    """Points (n,) that are as near to a narrowing as it is long."""
    throat = tree.points[one.vessel[int(np.argmin(one.factor))]]
    length = one.healthy[1] - one.healthy[0]
    return np.asarray(np.linalg.norm(tree.points - throat, axis=1) < length)


def narrowed(tree: VesselTree, narrowings: list[MadeNarrowing]) -> VesselTree:
    """The tree with narrowed ways, and all that lies in their lumen as narrow as that."""
    radius = tree.radius.copy()
    for one in narrowings:
        away, nearest = cKDTree(tree.points[one.vessel]).query(tree.points)
        is_in = away < tree.radius[one.vessel][nearest]
        radius[is_in] *= one.factor[nearest[is_in]]
    return tree.with_radius(radius)
