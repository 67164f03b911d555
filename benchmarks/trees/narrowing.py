"""Narrowings of a tree: place, depth and length, in a vessel but not in its branches."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from .layout import VesselTree

HOURGLASS = "hourglass"
"""The shape of `hourglass.py`, anywhere along a vessel of a tree."""

AT_FORK = "hourglass at a fork"
"""The same where the vessel divides, or the way leaves it, between the healthy parts on both sides:
the caliber of one of them is that of another vessel, and several degrees may be called right."""

SHAPES = ("focal", "long", "ostial", "tandem apart", "tandem merged", "across", "tapering")

LEAST_RADIUS = 1.55
"""Least radius of a vessel that is narrowed, mm: lesions are reported in vessels above 3 mm."""

LEAST_THROAT = 0.75
"""Least radius of a throat, mm: the grid makes narrower ones bumpy, with bumps as
narrowest places."""

DEPTHS = (0.35, 0.75)

_UNEVEN = 0.08
"""Largest relative deviation of a vessel's radius from a straight line between its healthy ends."""


@dataclass(frozen=True)
class MadeNarrowing:
    """A narrowing of a vessel, given by the numbers of its points; lengths from the first one, mm.

    `healthy` are the arc lengths at which it begins and ends; `throats` those where it is deepest.
    """

    shape: str
    vessel: np.ndarray
    healthy: tuple[float, float]
    throats: tuple[float, ...]
    factor: np.ndarray
    """(number of points of the vessel,) factors on its radii."""


def narrowed(tree: VesselTree, narrowings: Sequence[MadeNarrowing]) -> VesselTree:
    """The tree with narrowed vessels; branches keep their caliber beyond their ostia."""
    radius = tree.radius.copy()
    for one in narrowings:
        own = set(one.vessel.tolist())
        radius[one.vessel] *= one.factor
        for number, factor in zip(one.vessel.tolist(), one.factor.tolist(), strict=True):
            if factor < 1 and number != one.vessel[0]:
                for child in tree.children[number]:
                    if child not in own:
                        _fit_ostium(tree, radius, number, child)
    return tree.with_radius(radius)


def _fit_ostium(tree: VesselTree, radius: np.ndarray, fork: int, child: int) -> None:
    """Let a branch of a narrowed vessel start as narrow as that is, not as it was before."""
    waiting, reach = [child], 1.5 * tree.radius[fork]
    while waiting:
        one = waiting.pop()
        share = (tree.arc_length[one] - tree.arc_length[fork]) / reach
        if share < 1:
            eased = share * share * (3 - 2 * share)
            most = radius[fork] + (tree.calibers[child] - radius[fork]) * eased
            radius[one] = min(radius[one], most)
            waiting += tree.children[one]


def narrowings(
    tree: VesselTree, shapes: Sequence[str], random: np.random.Generator
) -> list[MadeNarrowing]:
    """A narrowing of each shape, as far as the tree has room; none touches another."""
    found: list[MadeNarrowing] = []
    taken = np.zeros(len(tree.points), dtype=bool)
    for shape in shapes:
        for one in _tries(tree, shape, random):
            begin, end = one.healthy
            along = _along(tree, one.vessel)
            room = 3 * LEAST_RADIUS
            near = one.vessel[(along > begin - room) & (along < end + room)]
            if not taken[near].any():
                found.append(one)
                apart = np.linalg.norm(tree.points[:, None] - tree.points[near][None, ::4], axis=2)
                taken |= apart.min(axis=1) < 6.0
                break
    return found


def _along(tree: VesselTree, vessel: np.ndarray) -> np.ndarray:
    return np.asarray(tree.arc_length[vessel] - tree.arc_length[vessel[0]])


def _tries(tree: VesselTree, shape: str, random: np.random.Generator) -> Iterator[MadeNarrowing]:
    wide = [v for v in tree.vessels if tree.calibers[int(v[1])] >= LEAST_RADIUS]
    for _ in range(400):
        vessel = wide[random.integers(len(wide))]
        made = _ostial(tree, vessel, random) if shape == "ostial" else _within(
            tree, shape, vessel, random
        )  # fmt: skip
        if made is not None:
            yield made


def _depth(radius: float, random: np.random.Generator) -> float:
    return float(min(random.uniform(*DEPTHS), 1 - LEAST_THROAT / radius))


def _ostial(
    tree: VesselTree, vessel: np.ndarray, random: np.random.Generator
) -> MadeNarrowing | None:
    """A narrowing that is deepest where a branch leaves its parent's lumen, healthy only distally.

    Distally the branch has an even caliber: on a slope every place would be a different reference,
    and no operator could tell which one was meant.
    """
    fork = int(vessel[0])
    if fork == 0 or _is_widest(tree, fork, int(vessel[1])):
        return None
    along, radius = _along(tree, vessel), tree.radius[vessel]
    parents = np.linalg.norm(tree.points[vessel][:, None] - tree.points[tree.path_to(fork)], axis=2)
    inside = parents.min(axis=1) < 1.05 * tree.radius[fork]
    leaves = along[np.argmin(inside)] if not inside.all() else np.inf
    throat = leaves + random.uniform(0.0, 2.0)
    length = random.uniform(4.0, 10.0)
    pad = 2.5 * tree.calibers[int(vessel[1])]
    if throat + length + pad > along[-1]:
        return None
    beyond = (along >= throat + length) & (along <= throat + length + pad)
    if not _is_even(tree, vessel, along, (throat + length, throat + length + pad), slope=0):
        return None
    depth = _depth(float(np.median(radius[beyond])), random)
    share = np.clip((along - throat) / length, 0, 1)
    factor = 1 - depth * (1 + np.cos(np.pi * share)) / 2
    return MadeNarrowing("ostial", vessel, (0.0, throat + length), (throat,), factor)


def _is_widest(tree: VesselTree, fork: int, child: int) -> bool:
    return tree.calibers[child] > 0.95 * max(tree.calibers[c] for c in tree.children[fork])


def _within(
    tree: VesselTree, shape: str, vessel: np.ndarray, random: np.random.Generator
) -> MadeNarrowing | None:
    """A narrowing that is healthy on both sides."""
    along, radius = _along(tree, vessel), tree.radius[vessel]
    lengths, gaps, depths, flat = _profile(shape, random)
    length = sum(lengths) + sum(gaps)
    own = tree.calibers[int(vessel[1])]
    pad = max(2.5 * own, 4.0)
    first = tree.radius[vessel[0]] * 1.5 if vessel[0] else 1.0
    room = along[-1] - length - 2 * pad - first
    if room <= 0:
        return None
    begin = first + pad + random.uniform(0, room)
    end = begin + length
    inner = (along >= begin) & (along <= end)
    if radius[inner].min() < LEAST_RADIUS:
        return None
    if shape.startswith("tandem") and gaps[0] > 0 and gaps[0] < 3.5 * radius[inner].max():
        return None
    if not _is_even(tree, vessel, along, (begin - pad, end + pad)):
        return None
    forks = sum(len(tree.children[n]) > 1 for n in vessel[inner].tolist())
    if (shape == "across") != (forks > 0) and shape in ("across", "focal", "tapering"):
        return None
    if shape == "tapering" and not _tapers(along, radius, begin, end):
        return None
    depths = [min(d, 1 - LEAST_THROAT / float(radius[inner].min())) for d in depths]
    factor, throats, at = np.ones(len(along)), [], begin
    for reach, depth, gap in zip(lengths, depths, [*gaps, 0.0], strict=True):
        throats.append(at + reach / 2)
        factor *= 1 - depth * _bump((along - at) / reach, flat)
        at += reach + gap
    return MadeNarrowing(shape, vessel, (begin, end), tuple(throats), factor)


def _profile(
    shape: str, random: np.random.Generator
) -> tuple[list[float], list[float], list[float], float]:
    """Lengths, gaps between, depths, and the share of a length that is as deep as its throat."""
    depth = float(random.uniform(*DEPTHS))
    if shape == "focal":
        return [random.uniform(5.0, 8.0)], [], [depth], 0.0
    if shape == "long":
        return [random.uniform(15.0, 30.0)], [], [depth], random.uniform(0.0, 0.5)
    if shape == "tandem apart":
        reach = [random.uniform(5.0, 10.0) for _ in range(2)]
        return reach, [random.uniform(8.0, 16.0)], [depth, random.uniform(*DEPTHS)], 0.0
    if shape == "tandem merged":
        # The two overlap by so much that the vessel between is not healthy.
        reach = [random.uniform(8.0, 12.0) for _ in range(2)]
        return reach, [-0.45 * min(reach)], [max(depth, 0.45), random.uniform(0.45, 0.7)], 0.0
    return [random.uniform(8.0, 22.0)], [], [depth], random.uniform(0.0, 0.4)


def _bump(share: np.ndarray, flat: float) -> np.ndarray:
    """A raised cosine from 0 to 1 whose middle part is flat."""
    from_end = np.clip(np.minimum(share, 1 - share) / max((1 - flat) / 2, 1e-9), 0, 1)
    return np.asarray((1 - np.cos(np.pi * from_end)) / 2)


def _is_even(
    tree: VesselTree,
    vessel: np.ndarray,
    along: np.ndarray,
    window: tuple[float, float],
    slope: int = 1,
) -> bool:
    """Whether a part of a vessel tapers evenly, or has one caliber, and has small branches only."""
    begin, end = window
    inner = (along >= begin) & (along <= end)
    radius = tree.radius[vessel]
    line = np.polynomial.Polynomial.fit(along[inner], radius[inner], slope)(along[inner])
    if np.abs(radius[inner] / line - 1).max() > _UNEVEN:
        return False
    return all(goes_on(tree, n) for n in vessel[inner].tolist() if len(tree.children[n]) > 1)


def goes_on(tree: VesselTree, fork: int) -> bool:
    """Whether a vessel goes on through a fork: it keeps its caliber, and the branch is small."""
    *small, large = sorted(tree.calibers[child] for child in tree.children[fork])
    return large > 0.78 * tree.radius[fork] and max(small) < 0.7 * large


def _tapers(along: np.ndarray, radius: np.ndarray, begin: float, end: float) -> bool:
    first, last = np.interp([begin, end], along, radius)
    return bool(last < 0.9 * first)
