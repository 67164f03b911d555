"""Random stents in the real anatomies: size of the lumen, folds, and whether it can be meshed.

python benchmarks/sweep.py --count 60 --seed 1 --ratio 1.05 1.6 [--tetgen] [--anatomy NAME]

Needs `pymeshlab` and, with --tetgen, `tetgen` (both from the extra `test`), and the folder of the
anatomies (`SDFSTENT_DATA`, else ../shared/data). Every stent follows from seed and number alone:
`--seed S --only N` repeats one. Prints a row per stent and a summary; exits 1 when a stent fails.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

PROJECT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(PROJECT))

from benchmarks.judges import (  # noqa: E402
    JudgeError,
    meshlab_faces,
    tetrahedra,
    wall_distances,
    widest_spheres,
)
from SDFStentLib.centerline import Centerline, CenterlinePath  # noqa: E402
from SDFStentLib.deformation import Deployment, DeploymentResult, DeploymentSettings  # noqa: E402
from SDFStentLib.files import read_centerline, read_surface  # noqa: E402
from SDFStentLib.geometry import Precision, Surface  # noqa: E402
from SDFStentLib.lumen import InscribedSpheres, inscribed_spheres, wall_of  # noqa: E402
from SDFStentLib.stent import AlongAxis, Stent  # noqa: E402
from SDFStentLib.treatment import AxisChange, axis_in_vessel  # noqa: E402

DATA_FOLDER = Path(os.environ.get("SDFSTENT_DATA", PROJECT.parent / "shared" / "data"))

ANATOMIES = {
    "aorta_iliac": ("aorta_iliac_surface_cm.vtp", "aorta_iliac_centerline_cm.vtp", "cm"),
    "pulmonary": ("pulmonary_surface_cm.vtp", "pulmonary_centerline_cm.vtp", "cm"),
    "vmtk_aorta": ("vmtk_aorta_surface_mm.vtp", "vmtk_aorta_centerline_mm.vtp", "mm"),
}

RATIO = (1.05, 1.6)
LENGTH = (10.0, 40.0)
END_CLEARANCE = 5.0
"""Distance of a stent from the ends of the centerline, mm, but for hard stents."""

STRAIGHTENING = (0.0, 0.5, 1.0)
"""Straightening of hard stents, drawn at random; every third of these ends on a cap."""

NARROW = 0.97
"""Inscribed over prescribed diameter below which nothing may be certified."""

DOUBTFUL = 0.98
"""Inscribed over prescribed diameter below which the largest sphere near a station is searched."""

MOST_TETRAHEDRA = 2.0
"""Most tetrahedra over those of the untreated vessel; TetGen would need more for crumpled faces."""

SPIKE = 2.0
"""Motion of a point over the stent's radius that no deformation needs: facets that span 90 degrees
take 1.4, tissue the rest."""

STATION_SPACING = 2.0
"""Spacing of the inscribed spheres, mm."""

WIDE = 1.002
"""Inscribed over prescribed diameter above which a station is too wide: the goal."""


class SweepVessel(NamedTuple):
    surface: Surface
    centerline: Centerline
    precision: Precision

    @property
    def points(self) -> np.ndarray:
        return self.surface.points

    @property
    def triangles(self) -> np.ndarray:
        return self.surface.triangles


class WideStations(NamedTuple):
    """Numbers of stations whose sphere is more than `WIDE` times the prescribed one, by cause."""

    strayed: int = 0
    """The sphere does not hold its axis point: it is not of this lumen. None in 390 stents."""
    native: int = 0
    """The sphere is as wide even in the union of native lumen and stent, with nothing dragged: a
    stent only pushes, so no other deformation could make it smaller."""
    dragged: int = 0
    """Any other cause: wall dragged ahead, or facets pushed out too far."""


class RandomStent(NamedTuple):
    anatomy: str
    axis: np.ndarray
    radius: float
    ratio: float
    start: float
    straightening: float = 0.0


class StentRow(NamedTuple):
    """The outcome of one stent."""

    number: int
    anatomy: str
    length: float
    diameter: float
    ratio: float
    mean: float
    """Mean inscribed over prescribed diameter."""
    highest: float
    inside_highest: float
    """The same as `highest` where the vessel was narrower than the stent by 5 % or more."""
    wide: WideStations
    new_folds: int
    certified: bool
    """No face intersects, is turned over or lacks area that was sound before."""
    meshlab: int
    """Number of new self-intersecting faces that MeshLab finds."""
    tetgen: str
    tetrahedra: float
    """Tetrahedra over those of the untreated vessel, where TetGen was asked."""
    rounds: int
    seconds: float
    straightening: float = 0.0
    narrowest: float = 1.0
    """Smallest inscribed over prescribed diameter, by VTK's distances."""
    motion: float = 0.0
    """Largest motion of a point over the stent's radius."""

    @property
    def deceives(self) -> bool:
        """Whether it is certified although it is narrower than prescribed or has a spike."""
        return self.certified and (self.narrowest < NARROW or self.motion > SPIKE)

    @property
    def failed(self) -> bool:
        return bool(
            self.deceives
            or self.new_folds
            or not self.certified
            or self.meshlab
            or self.tetgen not in ("", "yes")
        )


@cache
def vessel(name: str, folder: Path = DATA_FOLDER) -> SweepVessel:
    surface_file, centerline_file, units = ANATOMIES[name]
    surface = read_surface(folder / surface_file, units=units)
    centerline = read_centerline(folder / centerline_file, units=units)
    return SweepVessel(surface.surface, centerline, surface.precision)


def leaves_by_place(line: Centerline) -> list[int]:
    """Leaves by falling x, so that a seed means the same place however points are numbered."""
    return sorted(line.leaves.tolist(), key=lambda leaf: tuple(line.points[leaf]), reverse=True)


def random_stent(
    name: str,
    seed: int,
    number: int,
    ratios: tuple[float, float],
    folder: Path = DATA_FOLDER,
    *,
    hard: bool = False,
) -> RandomStent:
    """A stent at a random place on a random root-to-leaf path, 10 to 40 mm long, sized by the
    lumen.

    The widest lumen counts. A hard stent is straightened, and may end on a cap.
    """
    rng = np.random.default_rng([seed, number])
    line = vessel(name, folder).centerline
    leaf = leaves_by_place(line)[rng.integers(len(line.leaves))]
    path: CenterlinePath = line.path(line.points[line.roots[0]], line.points[leaf])
    length = min(rng.uniform(*LENGTH), path.length - 2 * END_CLEARANCE)
    start = rng.uniform(END_CLEARANCE, path.length - END_CLEARANCE - length)
    at = path.line.arc_lengths
    covered = (at >= start) & (at <= start + length)
    ratio = rng.uniform(*ratios)
    straightening = 0.0
    if hard:
        straightening = float(rng.choice(STRAIGHTENING))
        # Every place up to the very ends is as likely, and each end as all of them together.
        start = float(rng.choice([0.0, rng.uniform(0, path.length - length), path.length - length]))
        covered = (at >= start - 1e-6) & (at <= start + length + 1e-6)
    radius = ratio * float(np.nanmax(path.inscribed_radius[covered]))
    axis = path.line.cut(start, start + length).points
    if straightening:
        where = vessel(name, folder)
        stent = Stent(2 * radius, placement=AlongAxis(axis))
        axis = axis_in_vessel(stent, None, where.surface, AxisChange(straightening)).points
    return RandomStent(name, axis, radius, ratio, start, straightening)


def deployed(
    stent: RandomStent, settings: DeploymentSettings, folder: Path = DATA_FOLDER
) -> tuple[Deployment, DeploymentResult]:
    where = vessel(stent.anatomy, folder)
    deployment = Deployment(
        where.surface, settings.chain(stent.axis), stent.radius, settings, precision=where.precision
    )
    return deployment, deployment.result


@cache
def untreated_tetrahedra(name: str, folder: Path = DATA_FOLDER) -> int:
    where = vessel(name, folder)
    return len(tetrahedra(stored_points(where.points, where), where.triangles))


def stored_points(points: np.ndarray, where: SweepVessel) -> np.ndarray:
    """The coordinates that a file of this vessel would hold."""
    scaled = np.asarray(points * where.precision.scale, dtype=where.precision.dtype)
    return scaled.astype(float)


def tetgen_verdict(points: np.ndarray, name: str, folder: Path) -> tuple[str, float]:
    """`yes` or the fault, and tetrahedra over those of the untreated vessel."""
    try:
        count = len(tetrahedra(points, vessel(name, folder).triangles))
    except JudgeError as error:
        return str(error), float("nan")
    share = count / untreated_tetrahedra(name, folder)
    return ("yes" if share <= MOST_TETRAHEDRA else f"{share:.1f}x tetrahedra"), share


def wide_stations(
    deployment: Deployment, spheres: InscribedSpheres, stations: np.ndarray
) -> WideStations:
    """The causes why spheres at some stations are larger than prescribed."""
    too_wide = spheres.radii > WIDE * deployment.radius
    if not too_wide.any():
        return WideStations()
    apart = np.linalg.norm(spheres.centers - stations, axis=1)
    strayed = too_wide & (apart >= spheres.radii)
    radius, chain, united = deployment.radius, deployment.chain, deployment.surface.points.copy()
    short = radius - chain.axis_distance(united)
    united[short > 0] += short[short > 0, None] * chain.field(united[short > 0]).direction
    union = inscribed_spheres(united, deployment.surface.triangles, stations).radii
    native = too_wide & ~strayed & (union > WIDE * radius)
    return WideStations(
        int(strayed.sum()), int(native.sum()), int((too_wide & ~strayed & ~native).sum())
    )


def judged(
    number: int,
    stent: RandomStent,
    settings: DeploymentSettings,
    *,
    with_tetgen: bool,
    folder: Path = DATA_FOLDER,
) -> StentRow:
    where = vessel(stent.anatomy, folder)
    began = time.perf_counter()
    deployment, result = deployed(stent, settings, folder)
    seconds = time.perf_counter() - began

    nodes = deployment.chain.nodes
    stations = nodes[:: max(1, round(STATION_SPACING / settings.capsule_length))]
    # A cap counts as open: no stent pushes it aside, and it is no wall of the lumen.
    wall = wall_of(where.surface)
    spheres = inscribed_spheres(result.points, wall, stations)
    after = spheres.radii / stent.radius
    before = inscribed_spheres(where.points, wall, stations).radii / stent.radius
    narrow = before < 1 / 1.05
    certificate = result.certificate
    assert certificate is not None
    stored, original = (stored_points(points, where) for points in (result.points, where.points))
    faces = meshlab_faces(stored, where.triangles)
    if len(faces):
        faces = np.setdiff1d(faces, meshlab_faces(original, where.triangles))
    verdict, share = "", float("nan")
    if with_tetgen:
        verdict, share = tetgen_verdict(stored, stent.anatomy, folder)
    return StentRow(
        number=number,
        anatomy=stent.anatomy,
        length=deployment.chain.length,
        diameter=2 * stent.radius,
        ratio=stent.ratio,
        mean=float(after.mean()),
        highest=float(after.max()),
        inside_highest=float(after[narrow].max()) if narrow.any() else float("nan"),
        wide=wide_stations(deployment, spheres, stations),
        new_folds=len(certificate.new_self_intersecting),
        certified=certificate.passed,
        meshlab=len(faces),
        tetgen=verdict,
        tetrahedra=share,
        rounds=result.untangling_rounds,
        seconds=seconds,
        straightening=stent.straightening,
        narrowest=narrowest(where.surface, result.points, nodes, np.full(len(nodes), stent.radius)),
        motion=float(np.linalg.norm(result.points - where.points, axis=1).max() / stent.radius),
    )


def narrowest(before: Surface, after: np.ndarray, nodes: np.ndarray, radii: np.ndarray) -> float:
    """Smallest inscribed over prescribed diameter, without any of the certificate's code.

    A cap is where the vessel was cut: faces whose points lay in one plane at an end of the axis.

    Parameters
    ----------
    before : Surface
    after : (n, 3) array
        Places of its points after the deployment, mm.
    nodes, radii : (k, 3) and (k,) arrays
        Stations of the stent's axis, and the radius that a sphere shall have there, mm.
    """
    is_cap = np.zeros(len(before.triangles), dtype=bool)
    corners = before.points[before.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]
    radius = radii.max()
    for end, inner in (nodes[:2], nodes[:-3:-1]):
        direction = (end - inner) / np.linalg.norm(end - inner)
        offset = corners - end
        is_near = (np.linalg.norm(offset, axis=2) < 2.5 * radius).all(axis=1)
        is_ahead = (offset @ direction > -0.5 * radius).all(axis=1)
        is_cap |= is_near & is_ahead & (np.abs(normals @ direction) > 0.86)
    wall = before.triangles[~is_cap]
    width = wall_distances(after, wall, nodes) / radii
    doubtful = np.flatnonzero(width < DOUBTFUL)
    if len(doubtful):
        spheres = widest_spheres(after, wall, nodes)[doubtful]
        width[doubtful] = np.maximum(width[doubtful], spheres / radii[doubtful])
    return float(width.min())


def rows(
    count: int,
    seed: int,
    ratios: tuple[float, float] = RATIO,
    *,
    anatomies: tuple[str, ...] = tuple(ANATOMIES),
    only: int | None = None,
    hard: bool = False,
    with_tetgen: bool = True,
    settings: DeploymentSettings | None = None,
    folder: Path = DATA_FOLDER,
) -> Iterator[StentRow]:
    """Judged random stents, the anatomies in turn."""
    for number in range(count) if only is None else [only]:
        name = anatomies[number % len(anatomies)]
        stent = random_stent(name, seed, number, ratios, folder, hard=hard)
        yield judged(
            number, stent, settings or DeploymentSettings(), with_tetgen=with_tetgen, folder=folder
        )


def summary(found: list[StentRow]) -> str:
    lines = [
        f"{'anatomy':12} {'stents':>6} {'mean of means':>13} {'lowest':>7} {'highest':>7} "
        f"{'max anywhere':>12} {'> 1.002':>7} {'folds':>6} {'failed':>6} "
        f"{'MeshLab':>7} {'TetGen':>7} {'untangled':>9} {'s':>6}"
    ]
    for name in [*ANATOMIES, "all"]:
        part = [row for row in found if name in ("all", row.anatomy)]
        if not part:
            continue
        means = np.array([row.mean for row in part])
        meshed = [row.tetgen == "yes" for row in part if row.tetgen]
        lines.append(
            f"{name:12} {len(part):6} {means.mean():13.4f} {means.min():7.4f} {means.max():7.4f} "
            f"{max(row.highest for row in part):12.4f} "
            f"{sum(row.highest > WIDE for row in part):7} "
            f"{sum(row.new_folds > 0 for row in part):6} "
            f"{sum(not row.certified for row in part):6} {sum(row.meshlab > 0 for row in part):7} "
            f"{f'{sum(meshed)}/{len(meshed)}' if meshed else '-':>7} "
            f"{sum(row.rounds > 0 for row in part):9} "
            f"{np.median([row.seconds for row in part]):6.2f}"
        )
    shares = [row.tetrahedra for row in found if row.tetgen]
    if shares:
        lines.append(f"tetrahedra over those untreated: at most {np.nanmax(shares):.2f}")
    if found:
        lines.append(
            f"narrowest {min(row.narrowest for row in found):.3f}, largest motion "
            f"{max(row.motion for row in found):.2f} radii, certified though narrower or with a "
            f"spike: {sum(row.deceives for row in found)}"
        )
    counts = WideStations(*np.sum([row.wide for row in found], axis=0)) if found else WideStations()
    lines.append(
        f"stations above {WIDE}: {counts.native} where the native lumen and the stent united are "
        f"as wide, {counts.dragged} others, {counts.strayed} not around the axis"
    )
    return "\n".join(lines)


def as_text(row: StentRow) -> str:
    return (
        f"{row.number:4} {row.anatomy:12} {row.length:5.1f} x {row.diameter:5.2f} mm "
        f"ratio {row.ratio:.2f} mean {row.mean:.4f} max {row.highest:.4f} "
        f"(narrow {row.inside_highest:.4f}) folds {row.new_folds} "
        f"narrowest {row.narrowest:.3f} motion {row.motion:.2f} R "
        f"{'' if row.certified else 'NOT CERTIFIED '}MeshLab {row.meshlab} "
        f"TetGen {row.tetgen or '-'} {row.tetrahedra:.2f} rounds {row.rounds} {row.seconds:.2f} s"
        + ("  FAILED" if row.failed else "")
    )


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=60, help="how many stents (60)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", type=int, help="repeat the stent of this number")
    parser.add_argument(
        "--ratio", type=float, nargs=2, default=RATIO, metavar=("LOW", "HIGH"),
        help="stent radius over the largest local lumen radius (1.05 1.6)",
    )  # fmt: skip
    parser.add_argument("--anatomy", choices=list(ANATOMIES), help="only this one")
    parser.add_argument("--hard", action="store_true", help="straightened, and up to the caps")
    parser.add_argument("--tetgen", action="store_true", help="mesh every result with TetGen")
    parser.add_argument("--published", action="store_true", help="the method as in the paper")
    options = parser.parse_args(arguments)
    found = []
    for row in rows(
        options.count,
        options.seed,
        tuple(options.ratio),
        anatomies=(options.anatomy,) if options.anatomy else tuple(ANATOMIES),
        only=options.only,
        hard=options.hard,
        with_tetgen=options.tetgen,
        settings=DeploymentSettings.published() if options.published else None,
    ):
        print(as_text(row), flush=True)
        found.append(row)
    print()
    print(summary(found))
    return int(any(row.failed for row in found))


if __name__ == "__main__":
    sys.exit(main())
