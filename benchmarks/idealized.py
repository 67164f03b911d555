"""Idealized tubes, as everybody tries them first: none refused, every narrowing reported once.

python -m benchmarks.idealized [--count 1000] [--seed S] [--only N] [--quick] [--json FILE]

Along an axis, in a plane, along arcs and sines, oblique; of 16 to 64 sides; capped by fans or open;
narrowed by 40 to 85 %. Each follows from seed and number alone, and a new seed is drawn if none is
given. Degrees are held against the largest empty spheres by VTK's distances from the facets. Exits
1 when a tube is refused, a narrowing missed or reported twice, or a degree off by more than `NEAR`
points.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np

from SDFStentLib.centerline import Centerline
from SDFStentLib.files import check_same_space
from SDFStentLib.geometry import Surface
from SDFStentLib.validation import InputError
from SDFStentLib.vessel import find_lesions

from .common import Found, markdown, progress
from .judges import widest_spheres

NEAR = 3.0
"""Largest error of a degree, percentage points."""

WAYS = ("axis", "plane", "arc", "sine", "oblique")

_TAIL = 3.0
"""Distance from the middle of a narrowing, in its widths, at which it is gone: a Gauss bell is
1e-4."""

_WIDEST = 2.0
"""Largest width of a bell, in diameters: wider ones have no room in a tube of these lengths."""


class TubeNarrowing(NamedTuple):
    """A narrowing of a tube: place from the beginning and width, mm, and share of
    the radius lost."""

    at: float
    width: float
    depth: float


class DrawnTube(NamedTuple):
    """A tube drawn at random; lengths in mm."""

    words: str
    axis: np.ndarray
    """(n, 3) middles of its rings."""
    along: np.ndarray
    """(n,) arc lengths of these middles."""
    points: np.ndarray
    triangles: np.ndarray
    is_cap: np.ndarray
    """(m,) whether each triangle belongs to a cap."""
    line: np.ndarray
    """(k, 3) points of its centerline, from end to end."""
    line_radius: np.ndarray
    """(k,) radii of the centerline; NaN where the file has none."""
    narrowings: tuple[TubeNarrowing, ...]

    @property
    def surface(self) -> Surface:
        return Surface(self.points, self.triangles)

    @property
    def centerline(self) -> Centerline:
        return Centerline.from_lines(
            self.line, [np.arange(len(self.line))], self.line_radius, wall=self.points
        )

    def degrees(self) -> list[float]:
        """Degrees of the facets, %: the largest sphere at each throat against those beyond both
        tails."""
        wall, found = self.triangles[~self.is_cap], []
        for one in self.narrowings:
            step = 0.1 * one.width
            throat = one.at + step * np.arange(-6, 7)
            beside = [one.at + side * (_TAIL * one.width + step * np.arange(3)) for side in (-1, 1)]
            narrow, *healthy = (
                widest_spheres(self.points, wall, self._at(places)) for places in (throat, *beside)
            )
            found.append(
                float(100 * (1 - narrow.min() / np.mean([np.mean(one) for one in healthy])))
            )
        return found

    def _at(self, along: np.ndarray) -> np.ndarray:
        return np.stack([np.interp(along, self.along, column) for column in self.axis.T], axis=1)


def random_tube(seed: int, number: int) -> DrawnTube:
    """The tube of a seed and a number; every kind of axis is equally frequent."""
    rng = np.random.default_rng([seed, number])
    way = WAYS[number % len(WAYS)]
    radius = float(rng.choice([2.5, rng.uniform(1.6, 6.0)]))
    length = float(rng.choice([60.0, rng.uniform(14, 30) * radius]))
    sides, is_capped = int(rng.integers(16, 65)), bool(rng.random() < 0.5)
    step = rng.uniform(0.1, 0.35) * radius
    axis = _axis(way, length, radius, step, rng)
    along = np.r_[0, np.cumsum(np.linalg.norm(np.diff(axis, axis=0), axis=1))]
    narrowings = _narrowings(float(along[-1]), radius, rng)
    share = np.prod([1 - n.depth * np.exp(-(((along - n.at) / n.width) ** 2)) for n in narrowings],
                    axis=0)  # fmt: skip
    points, triangles, is_cap = _tube(axis, radius * share, sides, is_capped)
    if rng.random() < 0.2:
        triangles = triangles[:, ::-1]
    # From end to end, with the rings' own middles or with fewer points than there are rings.
    kept = np.arange(len(axis)) if rng.random() < 0.5 else _some(len(axis), rng)
    has_radius = rng.random() < 0.5
    line_radius = (radius * share)[kept] if has_radius else np.full(len(kept), np.nan)
    degrees = " and ".join(f"{100 * one.depth:.0f} % at {one.at:.1f} mm" for one in narrowings)
    ends = "capped" if is_capped else "open"
    words = f"{way}, {sides} sides, {ends}, {2 * radius:.1f} x {along[-1]:.0f} mm, {degrees}"
    return DrawnTube(
        words, axis, along, points, triangles, is_cap, axis[kept], line_radius, narrowings
    )


def _some(count: int, rng: np.random.Generator) -> np.ndarray:
    """Evenly spaced numbers below `count`, with the first and the last."""
    every = int(rng.integers(2, 4))
    return np.unique(np.r_[0:count:every, count - 1])


def _narrowings(
    length: float, radius: float, rng: np.random.Generator
) -> tuple[TubeNarrowing, ...]:
    """One narrowing, or two with healthy vessel between and beyond them."""
    count = 2 if length > 20 * radius and rng.random() < 0.3 else 1
    room = length / count
    found = []
    for number in range(count):
        at = (number + rng.uniform(0.4, 0.6)) * room
        free = min(at - number * room, (number + 1) * room - at) - 1.5 * radius
        widest = np.clip(free / _TAIL, radius, _WIDEST * 2 * radius)
        width = rng.uniform(0.8 * radius, widest)
        found.append(TubeNarrowing(float(at), float(width), float(rng.uniform(0.4, 0.85))))
    return tuple(found)


def _axis(
    way: str, length: float, radius: float, step: float, rng: np.random.Generator
) -> np.ndarray:
    """Points (n, 3) of an axis, about `step` mm apart; bends are wider than the tube by half."""
    at = np.linspace(0, length, max(round(length / step), 40) + 1)
    turn = np.eye(3)[rng.permutation(3)] * rng.choice([-1.0, 1.0], 3)
    if way == "plane":
        angle = rng.choice([np.pi / 4, np.pi / 6, rng.uniform(0, np.pi)])
        flat = np.stack([at * np.cos(angle), at * np.sin(angle), 0 * at], axis=1)
    elif way == "arc":
        bend = max(rng.uniform(3, 12) * radius, length / np.pi)
        flat = bend * np.stack([np.cos(at / bend), np.sin(at / bend), 0 * at], axis=1)
    elif way == "sine":
        wave = rng.uniform(0.12, 0.5) * length
        most = wave**2 / (2.5 * radius)  # of a bend at the crest
        high = min(rng.uniform(0.5, 2.0) * radius, most)
        flat = np.stack([high * np.sin(at / wave), 0 * at, at], axis=1)
    else:
        flat = np.stack([0 * at, 0 * at, at], axis=1)
    if way == "oblique":
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    shift = rng.choice([0.0, 1.0]) * np.round(rng.uniform(-50, 50, 3), int(rng.integers(0, 3)))
    return flat @ turn.T + shift


def _tube(
    axis: np.ndarray, radius: np.ndarray, sides: int, is_capped: bool
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points, triangles and whether each is of a cap: rings across the axis, fans over its ends."""
    ways = np.gradient(axis, axis=0)
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    first = np.eye(3)[np.abs(ways[0]).argmin()]
    angle = np.arange(sides) * 2 * np.pi / sides
    rings = []
    for middle, size, along in zip(axis, radius, ways, strict=True):
        first = first - (first @ along) * along
        first /= np.linalg.norm(first)
        ring = np.outer(np.cos(angle), first) + np.outer(np.sin(angle), np.cross(along, first))
        rings.append(middle + size * ring)
    ring, after = np.arange(sides), np.roll(np.arange(sides), -1)
    base = sides * np.arange(len(axis) - 1)[:, None]
    low, low_after, high, high_after = (
        (base + column).ravel() for column in (ring, after, ring + sides, after + sides)
    )
    wall = [np.stack([low, low_after, high_after], 1), np.stack([low, high_after, high], 1)]
    points, triangles = np.concatenate(rings), np.concatenate(wall)
    if not is_capped:
        return points, triangles, np.zeros(len(triangles), dtype=bool)
    middle, last = np.full(sides, len(points)), sides * (len(axis) - 1)
    caps = [
        np.stack([after, ring, middle], 1),
        np.stack([last + ring, last + after, middle + 1], 1),
    ]
    is_cap = np.repeat([False, True], [len(triangles), 2 * sides])
    return np.vstack([points, axis[[0, -1]]]), np.concatenate([triangles, *caps]), is_cap


class TubeRow(NamedTuple):
    """The findings about one tube."""

    number: int
    words: str
    refused: str
    """Words of the refusal; empty if it was accepted."""
    true: tuple[float, ...]
    found: tuple[float, ...]
    """Degrees in the order along the tube, %: as they are, and as they are reported."""
    is_placed: bool
    """Whether every narrowing is reported at its place."""

    @property
    def off(self) -> float:
        """Largest error, percentage points; infinite unless each narrowing is reported once."""
        if self.refused or len(self.true) != len(self.found) or not self.is_placed:
            return float("inf")
        return float(np.abs(np.subtract(self.true, self.found)).max())

    @property
    def is_wrong(self) -> bool:
        return not self.off <= NEAR


def judged(seed: int, number: int) -> TubeRow:
    """A tube read as its files would be, its lesions found, and held against its facets."""
    tube = random_tube(seed, number)
    true = tuple(tube.degrees())
    try:
        surface, centerline = tube.surface, tube.centerline
        cautions = check_same_space(surface, centerline.points)
        lesions = find_lesions(surface, centerline)
    except InputError as error:
        return TubeRow(number, tube.words, str(error), true, (), False)
    along = [
        float(tube.along[np.linalg.norm(tube.axis - one.point, axis=1).argmin()]) for one in lesions
    ]
    order = np.argsort(along)
    found = tuple(lesions[k].percent_diameter for k in order)
    is_placed = not cautions and len(found) == len(true)
    for one, at in zip(tube.narrowings, np.sort(along), strict=False):
        is_placed &= abs(at - one.at) < one.width
    return TubeRow(number, tube.words, "", true, found, is_placed)


def summary(rows: list[TubeRow]) -> Found:
    """The numbers of `table`, and the tubes that are wrong."""
    found = [row for row in rows if np.isfinite(row.off)]
    return {
        "tubes": len(rows),
        "narrowings": sum(len(row.true) for row in rows),
        "refused": sum(bool(row.refused) for row in rows),
        "missed": sum(not row.refused and not np.isfinite(row.off) for row in rows),
        "apart": sum(NEAR < row.off < np.inf for row in rows),
        "median": float(np.median([row.off for row in found])) if found else float("nan"),
        "most": max((row.off for row in found), default=float("nan")),
        "wrong": [[str(value) for value in row] for row in rows if row.is_wrong],
    }


def of_seed(seed: int, count: int) -> Found:
    rows = []
    for number in range(count):
        rows.append(judged(seed, number))
        if rows[-1].is_wrong:
            progress(" | ".join(map(str, rows[-1])))
    return {"seed": seed, **summary(rows)}


def table(found: Found) -> str:
    header = ["seed", "tubes", "narrowings", "refused", "missed or told twice",
              f"off by more than {NEAR:g} points", "off, points: median", "most"]  # fmt: skip
    keys = ("seed", "tubes", "narrowings", "refused", "missed", "apart")
    numbers = [f"{found[key]:.2f}" for key in ("median", "most")]
    return markdown(header, [[*(found[key] for key in keys), *numbers]])


def options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, help="drawn anew, and told, without one")
    parser.add_argument("--only", type=int, metavar="N", help="the tube of that number")
    parser.add_argument("--quick", action="store_true", help="fifty tubes")
    parser.add_argument("--largest", type=int, help=argparse.SUPPRESS)
    parser.add_argument("--json", type=Path, metavar="FILE", help="also write the numbers here")
    return parser.parse_args()


def main() -> int:
    chosen = options()
    seed = chosen.seed
    if seed is None:
        seed = int(np.random.SeedSequence().generate_state(1)[0])
    print(f"seed {seed}", flush=True)
    if chosen.only is not None:
        print(*judged(seed, chosen.only), sep=" | ")
        return 0
    found = of_seed(seed, 50 if chosen.quick else chosen.count)
    print(table(found))
    if chosen.json:
        chosen.json.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
        return 0
    return int(bool(found["wrong"]))


if __name__ == "__main__":
    sys.exit(main())
