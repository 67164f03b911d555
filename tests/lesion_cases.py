"""Random vessels with known lesions, for the tests of their detection."""

from typing import NamedTuple

import numpy as np

from benchmarks.phantoms import TrueVessel
from benchmarks.phantoms.axis import narrowing, planar_axis
from benchmarks.phantoms.field import TubeField, TubeUnion
from benchmarks.phantoms.junction import branching_tube
from benchmarks.phantoms.mesh import swept_tube
from benchmarks.phantoms.value import assembled
from SDFStentLib.centerline import Centerline
from SDFStentLib.geometry import Line, Surface
from SDFStentLib.vessel.runs import VesselRun


class Known(NamedTuple):
    """A lesion that was built: the place of its smallest width, and its degree by diameter."""

    point: np.ndarray
    percent: float
    length: float


class Case(NamedTuple):
    surface: Surface
    centerline: Centerline
    known: list[Known]


def tapering(first, last, length):
    return lambda at: first + (last - first) * np.clip(np.asarray(at) / length, 0, 1)


def narrowed(healthy, lesions):
    """The radius by arc length of a healthy vessel with lesions (center, half length, depth)."""

    def radius(at):
        value = healthy(at)
        for center, half, depth in lesions:
            value = value * narrowing(at, center, half, depth)
        return value

    return radius


def with_noise(points, triangles, amount, random):
    """The points displaced across the wall by up to `amount` mm."""
    if amount == 0:
        return points
    from SDFStentLib.geometry import vertex_normals

    shift = random.uniform(-amount, amount, len(points))
    return points + shift[:, None] * vertex_normals(points, triangles)


def tube_case(seed: int, count: int) -> Case:
    """An unbranched vessel, tapering, straight or bent, with `count` lesions in series."""
    random = np.random.default_rng(seed)
    first = random.uniform(2.0, 8.0)
    diameter = 2 * first
    half = [diameter * random.uniform(0.5, 2.0) for _ in range(count)]
    depth = [random.uniform(0.2, 0.9) for _ in range(count)]
    gap = 1.5 * diameter
    at, centers = gap, []
    for reach in half:
        centers.append(at + reach)
        at += 2 * reach + gap
    length = max(at, 6 * diameter)
    # At most 0.06 mm of diameter per mm, and not below half.
    last = first - min(0.5 * first, 0.03 * length) * random.choice([0.0, 0.5, 1.0])
    bend = random.choice([0.0, 1 / (6 * first), 1 / (12 * first)])
    bend = min(bend, 5.0 / length)
    axis = planar_axis([(length / 2, bend), (length / 2, -bend)])
    lesions = list(zip(centers, half, depth, strict=True))
    healthy = tapering(first, last, length)
    radius = narrowed(healthy, lesions)
    narrowest = float(radius(np.linspace(0, length, 1000)).min())
    edge = min(random.choice([0.15, 0.25, 0.4]) * first, 1.2 * narrowest)
    patch = swept_tube(axis, radius, edge)
    noise = random.choice([0.0, 0.01, 0.02]) * narrowest
    points = with_noise(patch.points, patch.triangles, noise, random)
    made = assembled("tube", patch, (TrueVessel("tube", axis, radius),), [])
    known = [Known(axis.point(c)[0], 100 * d, 2 * h) for c, h, d in lesions]
    return Case(Surface(points, patch.triangles), made.centerline, known)


def bifurcation_case(seed: int, where: str | None, fineness: float = 0.3) -> Case:
    """A trunk that divides, with a lesion in the trunk, at an ostium or farther on, or without one.

    `fineness` is the length of the edges relative to the smallest radius.
    """
    random = np.random.default_rng(seed)
    trunk = random.uniform(4.0, 6.0)
    share = random.uniform(0.65, 0.85)
    left = trunk * share
    right = trunk * (1 - share ** (7 / 3)) ** (3 / 7)
    before, after = 8 * trunk, 16 * left
    # Where the branches part, after some trunk radii, the main line has the left branch's width.
    main = planar_axis(
        [(before, 0.0), (6 * trunk, 1 / (12 * trunk)), (after, 0.0)], toward=(-1, 0, 0)
    )
    heading = np.array([1.0, 0.0, 1.2])
    side = planar_axis(
        [(14 * right + 2 * trunk, 0.0)], start=main.point(before)[0], heading=heading
    )
    depth = random.uniform(0.25, 0.6)
    lesion = {
        None: None,
        "trunk": (before - 3.5 * trunk, 2.0 * trunk),
        "ostium": (before + 3.0 * trunk, 2.5 * left),
        "branch": (before + 10 * left, 3 * left),
    }[where]

    def healthy(at):
        x = np.clip((np.asarray(at) - before + trunk) / (2.5 * trunk), 0, 1)
        return trunk + (left - trunk) * x * x * (3 - 2 * x)

    lesions = [] if lesion is None else [(*lesion, depth)]
    vessels = (
        TrueVessel("main", main, narrowed(healthy, lesions)),
        TrueVessel("side", side, lambda at: np.full(np.shape(at), right), before),
    )
    edge = fineness * min(right, (1 - depth) * left)
    union = TubeUnion([TubeField(v.axis, v.radius) for v in vessels], 0.3 * right, 4 * edge)
    patch = branching_tube(union, edge)
    made = assembled("bifurcation", patch, vessels, [])
    known = []
    for center, reach, _ in lesions:
        # Where the branches still share a lumen, it is wider than the narrowed branch.
        at = np.linspace(center - reach, center + reach, 200)
        wall = patch.points[np.unique(patch.triangles[patch.face_ids == 1])]
        degree = 1 - union.inscribed_radii(main.point(at), wall) / healthy(at)
        known.append(Known(main.point(at[degree.argmax()])[0], 100 * degree.max(), 2 * reach))
    return Case(Surface(patch.points, patch.triangles), made.centerline, known)


SPACING = 0.5
"""Of the stations along a vessel, mm."""


def vessel_along(diameter, parent=-1, along=None, *, start=0.0) -> VesselRun:
    """A vessel along z with these diameters at its stations."""
    along = start + SPACING * np.arange(len(diameter)) if along is None else np.array(along)
    columns = (np.outer(along, [0.0, 0, 1]), along, diameter, np.zeros(len(along), dtype=np.int64))
    return VesselRun(Line(columns[0]), *columns[1:], along, (), (), parent, parent + 1, 5.0, 1)
