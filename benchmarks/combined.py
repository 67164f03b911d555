"""Random stents with their options combined, judged from the surface that they leave.

python -m benchmarks.combined [--count 300] [--seed 1] [--only N]

Anatomies, sizes, shapes and parameters of the method are drawn at random; each stent follows from
seed and number alone. What is certified is judged anew, by none of the certificate's code: heights
of triangles by their corners, intersections by MeshLab, the lumen by VTK's distances and a search
for the largest sphere. Exits 1 when a stent is certified but wrong, or a flaw is not reported.
"""

from __future__ import annotations

import argparse
import sys
import time
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from SDFStentLib.centerline import Centerline
from SDFStentLib.deformation import Deployment, DeploymentSettings
from SDFStentLib.files import read_centerline, read_surface
from SDFStentLib.geometry import Precision, Surface, frames, nearest_distances
from SDFStentLib.stent import (
    AtCenter,
    AtDistalEnd,
    AtProximalEnd,
    Shape,
    Stent,
    StentAxis,
    StentEnd,
    Waist,
)
from SDFStentLib.treatment import AxisChange, axis_in_vessel
from SDFStentLib.validation import DeploymentError, InputError

from . import phantoms, sweep
from .judges import meshlab_faces

FILES = {
    **sweep.ANATOMIES,
    "su0243": ("su0243_surface_mm.vtp", "su0243_centerline_mm.vtp", "mm"),
    "tree_narrowed": ("tree_narrowed_surface_mm.vtp", "tree_narrowed_centerline_mm.vtp", "mm"),
}
PHANTOMS = {
    "stenosed tube": lambda: phantoms.stenosed_tube(edge_length=0.9),
    "coarse tube": lambda: phantoms.stenosed_tube(edge_length=1.5),
    "hairpin": lambda: phantoms.hairpin_tube(),
    "branching": lambda: phantoms.branching_pulmonary_artery(),
    "neighbor": lambda: phantoms.tube_with_neighbor(),
}
ANATOMIES = (*FILES, *PHANTOMS)

FLAT, SLIVER_DEG = 1e-4, 1.0
"""Height over the longest edge that no certified triangle may newly have, and smallest angle that
none may have without a caution."""

UNTOLD = sweep.DOUBTFUL
"""Inscribed over prescribed diameter below which a caution has to report it."""


RAYS = 48
"""Number of points of a ring round a stent."""


class CombinedRow(NamedTuple):
    """The outcome of one stent, and the findings of an independent check."""

    number: int
    anatomy: str
    options: str
    outcome: str
    """certified, failed, or the reason why it was refused."""
    narrowest: float = 1.0
    flat: int = 0
    slivers: int = 0
    meshlab: int = 0
    motion: float = 0.0
    untold: str = ""
    seconds: float = 0.0

    @property
    def is_wrong(self) -> bool:
        """Whether it is certified but should not be."""
        bad = self.flat or self.meshlab or self.narrowest < sweep.NARROW
        return self.outcome == "certified" and bool(bad or self.motion > sweep.SPIKE)


@cache
def vessel(name: str) -> tuple[Surface, Centerline, Precision]:
    if name in PHANTOMS:
        made = PHANTOMS[name]()
        return Surface(made.points, made.triangles), made.centerline, Precision(np.float32)
    surface_file, line_file, units = FILES[name]
    read = read_surface(sweep.DATA_FOLDER / surface_file, units=units)
    line = read_centerline(sweep.DATA_FOLDER / line_file, units=units)
    return read.surface, line, read.precision


class RandomDeployment(NamedTuple):
    """A stent drawn at random."""

    words: str
    """Its options."""
    axis: StentAxis
    deployment: Deployment


def random_deployment(seed: int, number: int) -> RandomDeployment:
    """A stent with its options, determined by seed and number alone; `InputError` for some."""
    rng = np.random.default_rng([seed, number])
    surface, line, precision = vessel(ANATOMIES[number % len(ANATOMIES)])
    leaf = line.leaves[rng.integers(len(line.leaves))]
    way = line.path(line.points[line.roots[0]], line.points[leaf]).points
    at = int(rng.choice([0, len(way) - 1, rng.integers(len(way))], p=[0.1, 0.1, 0.8]))
    near = way[max(at - 20, 0) : at + 20]
    radius = float(nearest_distances(near, surface.points).max()) * rng.uniform(1.05, 1.8)
    length = float(rng.uniform(4, 40))
    values: dict[str, Any] = {
        "tissue_gap": float(rng.choice([0.0, 0.4, 1.0])),
        "capsule_length": float(rng.choice([0.5, 1.0, 1.0, 5.0, 20.0])),
        "rule": str(rng.choice(["events", "events", "published"])),
        "smoothing_width": float(rng.choice([0.0, 0.4, 0.4, 1.0])),
        "influence_distance": float(rng.choice([3.0, 6.5, 12.0])),
        "falloff": str(rng.choice(["compact", "wendland", "cosine"])),
        "blend": str(rng.choice(["linear", "quadratic", "exponential"])),
        "facet_compensation": bool(rng.random() > 0.05),
    }
    change = AxisChange(float(rng.choice([0.0, 0.0, 0.5, 1.0])), float(rng.choice([0.0, 0.0, 5.0])))
    place = [AtCenter, AtDistalEnd, AtProximalEnd][rng.integers(3)]
    kind = str(rng.choice(["plain", "plain", "waist", "flares", "table", "cap"]))
    stent = Stent(
        2 * radius, length=length, placement=place(way[at]), **_shape(kind, rng, radius, length)
    )
    axis = axis_in_vessel(stent, line, surface, change)
    settings = DeploymentSettings(**values)
    chain = settings.chain(axis.points, axis.profile)
    words = f"{2 * radius:.2f} x {length:.1f} mm, {place.__name__}, {kind}, {change}, {values}"
    deployment = Deployment(
        surface, chain, stent.widest_diameter / 2, settings, precision=precision
    )
    return RandomDeployment(words, axis, deployment)


def _shape(kind: str, rng: np.random.Generator, radius: float, length: float) -> dict[str, Any]:
    share = float(rng.uniform(0.5, 1.5))
    if kind == "plain":
        return {}
    if kind == "waist":
        shape = Shape(waist=Waist(2 * radius * min(share, 0.95)))
    elif kind == "flares":
        end = StentEnd(2 * radius * share, length / 3)
        shape = Shape(start=end, end=end)
    elif kind == "table":
        shape = Shape(table=((0.0, 1.6 * radius), (0.5, 2 * radius), (1.0, 1.8 * radius)))
    else:
        shape = Shape(cap_height=0.2)
    return {"shape": shape}


def judged(seed: int, number: int) -> CombinedRow:
    began, name = time.perf_counter(), ANATOMIES[number % len(ANATOMIES)]
    try:
        drawn = random_deployment(seed, number)
        result = drawn.deployment.result
    except (InputError, DeploymentError) as error:
        return CombinedRow(number, name, "", str(error)[:70])
    certificate, radius = result.certificate, drawn.deployment.radius
    assert certificate is not None
    before, line, precision = vessel(name)
    where = sweep.SweepVessel(before, line, precision)
    stored, native = (
        sweep.stored_points(surface.points, where) / precision.scale
        for surface in (result.surface, before)
    )
    (flat, angle), (was_flat, was_angle) = (
        _quality(points, before.triangles) for points in (stored, native)
    )
    slivers = (angle < 0.9 * SLIVER_DEG) & (angle < 0.45 * was_angle) & (flat > 2 * FLAT)
    faces = meshlab_faces(stored, before.triangles)
    if len(faces):
        faces = np.setdiff1d(faces, meshlab_faces(native, before.triangles))
    nodes, narrowest = drawn.axis.line.resampled(1.0).points, 1.0
    if certificate.lumen:
        narrowest = sweep.narrowest(before, stored, nodes, _prescribed(drawn.axis, nodes, radius))
    reported = {one.kind for part in (certificate, *certificate.lumen) for one in part.cautions()}
    untold = ["slivers"] if slivers.any() and "new-slivers" not in reported else []
    if certificate.passed and narrowest < UNTOLD and "narrower" not in reported:
        untold.append("narrower")
    return CombinedRow(
        number,
        name,
        drawn.words,
        "certified" if certificate.passed else "failed",
        narrowest,
        int(((flat <= FLAT) & (was_flat > FLAT)).sum()),
        int(slivers.sum()),
        len(faces),
        float(np.linalg.norm(stored - native, axis=1).max() / radius),
        " ".join(untold),
        time.perf_counter() - began,
    )


def _quality(points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Height over the longest edge, and the smallest angle, degrees, of every triangle."""
    corners = points[triangles]
    a, b, c = (np.linalg.norm(corners[:, k] - corners[:, k - 2], axis=1) for k in range(3))
    # Kahan's area of needles, from sorted sides.
    c, b, a = np.sort([a, b, c], axis=0)
    area = np.sqrt(np.maximum((a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c)), 0)) / 4
    tiny = np.maximum(a, 1e-300)
    return 2 * area / tiny**2, np.rad2deg(
        np.arcsin(np.minimum(2 * area / np.maximum(a * b, 1e-300), 1))
    )


def _prescribed(axis: StentAxis, nodes: np.ndarray, radius: float) -> np.ndarray:
    """Radius of the largest sphere inside of a stent round each of some stations, mm.

    It is measured to rings of points round the axis, without points inside of the stent, as in a
    tight bend.
    """
    if axis.profile is None:
        return np.full(len(nodes), radius)
    line = axis.line.resampled(0.2)
    fine = line.points
    radii = axis.profile.at(np.linspace(0, 1, len(fine))) / 2
    along, first, second = frames(line).swapaxes(0, 1)
    turn = np.linspace(0, 2 * np.pi, RAYS, endpoint=False)[:, None, None]
    round_axis = np.cos(turn) * first + np.sin(turn) * second
    rings = fine + radii[:, None] * round_axis
    rings = rings.reshape(-1, 3)
    distance, place = cKDTree(fine).query(rings)
    wall = rings[distance > 0.999 * radii[place]]
    inside = cKDTree(wall).query(nodes)[0]
    part = np.linspace(0, 1, RAYS)[:, None, None]
    for end, ahead in ((0, -along[0]), (-1, along[-1])):
        # Rings of the cap: half an ellipsoid, nearer than its own middle where the axis bends.
        height = axis.profile.cap_height * np.sqrt(1 - part**2) * ahead
        cap = fine[end] + radii[end] * (height + part * round_axis[:, end])
        inside = np.minimum(inside, cKDTree(cap.reshape(-1, 3)).query(nodes)[0])
    return inside


def summary(rows: list[CombinedRow]) -> str:
    heads = ("stents", "refused", "certified", "failed", "wrong", "untold", "flat*", "slivers*")
    lines = [f"{'anatomy':14}" + "".join(f"{head:>10}" for head in heads) + "  narrowest*"]
    for name in (*ANATOMIES, "all"):
        part = [row for row in rows if name in ("all", row.anatomy)]
        sure = [row for row in part if row.outcome == "certified"]
        failed = sum(row.outcome == "failed" for row in part)
        counts = (
            len(part), len(part) - len(sure) - failed, len(sure), failed,
            sum(row.is_wrong for row in part), sum(bool(row.untold) for row in part),
            sum(row.flat > 0 for row in sure), sum(row.slivers > 0 for row in sure),
        )  # fmt: skip
        low = min((row.narrowest for row in sure), default=1.0)
        lines.append(f"{name:14}" + "".join(f"{count:10}" for count in counts) + f"{low:12.3f}")
    return "\n".join([*lines, "* of those that were certified"])


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", type=int)
    options = parser.parse_args()
    rows = []
    for number in range(options.count) if options.only is None else [options.only]:
        rows.append(judged(options.seed, number))
        print(*rows[-1], sep=" | ", flush=True)
    print(summary(rows))
    return int(any(row.is_wrong or row.untold for row in rows))


if __name__ == "__main__":
    sys.exit(main())
