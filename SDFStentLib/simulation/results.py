"""Results of a solver: pressures, flows and wall shear of one case, from its files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..files import VolumeMesh, read_surface, read_volume, tetrahedra_at
from ..flow import ADULT, PASCAL_PER_MMHG
from ..geometry import Line, Surface, norm
from ..validation import DeploymentError, Floats, Indices, InputError, Points
from .solver_file import CYCLE_FRAMES, FRAMES, RESULTS

MMHG = 10 * PASCAL_PER_MMHG
"""dyn/cm^2."""

SAME = 1e-3
"""Points of a result lie so far from those of the mesh at most, mm."""

HIGH = 99.0
"""Percent of the wall that has no more than the high wall shear."""


class FaceFlow(NamedTuple):
    """The flow through one end of a segment."""

    flow: float
    """mL/s, out of the vessel."""
    pressure: float
    """Static, the mean over the area, mmHg."""
    total: float
    """Total pressure, static and dynamic, its mean weighted by the flow, mmHg."""


class Found(NamedTuple):
    """Quantities in one frame, or their mean over some."""

    faces: dict[str, FaceFlow]
    shear: tuple[float, float]
    """The shear of the wall, Pa: the mean, and what `HIGH` percent of the area does not exceed."""
    pressure: Floats
    """(k,) mean in slices along the way, mmHg; NaN where there is none."""
    speed: Floats
    """(k,) the fastest there, m/s."""


class CaseResult(NamedTuple):
    """The results of one state in one mesh."""

    mean: Found
    peak: Found | None
    """Values at the frame with the most flow through all inlets; None for steady flow."""
    spread: float
    """Spread of the inlet pressure over the frames, as a part of it."""


class SolvedCase:
    """A mesh, its faces and a way through it, ready for the frames that were solved on it.

    Parameters
    ----------
    folder : Path
        Folder of the case.
    way : (k, 3) array
        Points of the centerline, mm.
    walls : sequence of str
        The faces that are wall.
    """

    def __init__(self, folder: Path, way: Points, walls: Sequence[str]) -> None:
        exterior = read_surface(folder / "mesh" / "mesh-complete.exterior.vtp", "cm")
        faces = exterior.faces
        assert faces is not None
        self.folder, self.surface, self.faces = folder, exterior.surface, faces
        self.volume, _ = read_volume(folder / "mesh" / "mesh-complete.mesh.vtu")
        self.is_wall = np.isin(faces.ids, [n for n, name in faces.names.items() if name in walls])
        wall = self.surface.triangles[self.is_wall]
        behind = tetrahedra_at(Surface(self.surface.points, wall), self.volume)
        self._wall, self._behind = wall, self.volume.tetrahedra[behind]
        self._slices, self._weights = _slices(self.volume, way, self.surface.points[wall])
        self._count = len(way)

    def result(self, *, is_wave: bool) -> CaseResult:
        """Results that the solver has left in the folder.

        Raises
        ------
        InputError
            Nothing, or files of another mesh.
        DeploymentError
            Numbers that are none: the solver did not converge.
        """
        pattern = f"{RESULTS}/result_*.vtu"
        files = sorted(self.folder.glob(pattern), key=lambda path: (len(path.name), path.name))
        files = files[-(CYCLE_FRAMES if is_wave else FRAMES) :]
        if not files:
            raise InputError(
                f"{self.folder}: expected the results of a solver, {pattern}, got none; run sh "
                "run.sh in the folder above, and look at solver.log where it ended early."
            )
        frames = [self._frame(path) for path in files]
        mean, pressures = _mean(frames), np.array([one.faces["inlet"].pressure for one in frames])
        scale = max(abs(float(pressures.mean())), 1e-9)
        inlets = [name for name, face in mean.faces.items() if face.flow < 0]
        out = [sum(frame.faces[name].flow for name in inlets) for frame in frames]
        peak = frames[int(np.argmin(out))] if is_wave else None
        return CaseResult(mean, peak, float(np.ptp(pressures)) / scale)

    def _frame(self, path: Path) -> Found:
        volume, arrays = read_volume(path)
        missing = {"Velocity", "Pressure"} - set(arrays)
        if missing:
            raise InputError(
                f"{path}: expected Velocity and Pressure, got no {sorted(missing)[0]}; solve with "
                "the solver.xml of this folder."
            )
        order = self._order(volume.points, path)
        velocity, pressure = arrays["Velocity"][order], arrays["Pressure"][order] / MMHG
        if not (np.isfinite(velocity).all() and np.isfinite(pressure).all()):
            raise DeploymentError(
                f"{path}: expected numbers, got such that are none: the solver did not converge; "
                "halve Time_step_size in solver.xml, and look at solver.log beside it."
            )
        names = self.faces.names
        ends = {n: names[n] for n in np.unique(self.faces.ids[~self.is_wall]).tolist()}
        return Found(
            {name: self._through(n, velocity, pressure) for n, name in ends.items()},
            self._shear(velocity),
            self._sliced(pressure),
            self._fastest(norm(velocity)),
        )

    def _order(self, points: Points, path: Path) -> Indices:
        """The point of a result for every point of the mesh."""
        mesh = self.volume.points
        if len(points) == len(mesh) and np.abs(points - mesh).max() <= SAME:
            return np.arange(len(mesh))
        from scipy.spatial import cKDTree

        away, order = cKDTree(points).query(mesh)
        if away.max() > SAME:
            raise InputError(
                f"{path}: expected the points of the mesh beside it, got others, up to "
                f"{away.max():.3g} mm away; solve the case of this folder again."
            )
        return np.asarray(order)

    def _through(self, number: int, velocity: Floats, pressure: Floats) -> FaceFlow:
        """Integrals by the middles of triangles' sides, exact for squares of what is linear."""
        triangles = self.surface.triangles[self.faces.ids == number]
        corners = self.surface.points[triangles] / 10
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
        sides = [(triangles[:, k], triangles[:, (k + 1) % 3]) for k in range(3)]
        speeds = np.stack([(velocity[a] + velocity[b]) / 2 for a, b in sides])
        static = np.stack([(pressure[a] + pressure[b]) / 2 for a, b in sides])
        through = (speeds * normals).sum(axis=2) / 3
        total = static + ADULT.density / 1000 / 2 * (speeds**2).sum(axis=2) / MMHG
        areas = norm(normals)
        mean = float((static.mean(axis=0) * areas).sum() / areas.sum())
        flow = float(through.sum())
        moving = float((total * through).sum() / flow) if flow else mean
        return FaceFlow(flow, mean, moving)

    def _shear(self, velocity: Floats) -> tuple[float, float]:
        """Wall shear from the gradient in the tetrahedra at the wall, Pa."""
        corners = self.volume.points[self._behind] / 10
        arms = corners[:, 1:] - corners[:, :1]
        speeds = velocity[self._behind]
        # arms @ gradient = differences: gradient[j, i] = d v_i / d x_j.
        gradient = np.linalg.solve(arms, speeds[:, 1:] - speeds[:, :1])
        sides = self.surface.points[self._wall]
        normals = np.cross(sides[:, 1] - sides[:, 0], sides[:, 2] - sides[:, 0])
        areas = norm(normals) / 2
        normals /= 2 * areas[:, None]
        stress = ADULT.viscosity * np.einsum(
            "nji,nj->ni", gradient + np.swapaxes(gradient, 1, 2), normals
        )
        stress -= (stress * normals).sum(axis=1)[:, None] * normals
        shear = norm(stress)
        order = np.argsort(shear)
        part = np.cumsum(areas[order]) / areas.sum()
        high = shear[order][np.searchsorted(part, HIGH / 100)]
        return float((shear * areas).sum() / areas.sum()), float(high)

    def _sliced(self, values: Floats) -> Floats:
        inside = self._slices >= 0
        own, weights = self._slices[inside], self._weights[inside]
        total = np.bincount(own, weights * values[inside], self._count)
        size = np.bincount(own, weights, self._count)
        return np.where(size > 0, total / np.where(size > 0, size, 1.0), np.nan)

    def _fastest(self, speeds: Floats) -> Floats:
        found = np.full(self._count, np.nan)
        inside = self._slices >= 0
        np.fmax.at(found, self._slices[inside], speeds[inside] / 100)
        return found


def _slices(volume: VolumeMesh, way: Points, wall: Points) -> tuple[Indices, Floats]:
    """The nearest point of a way to each of the mesh, -1 beyond the lumen round it; and a volume.

    Side branches lie farther from the way than the wall round it.
    """
    from scipy.spatial import cKDTree

    radius = cKDTree(wall.reshape(-1, 3)).query(way)[0]
    near = Line(way).nearest(volume.points)
    place = np.rint(np.interp(near.arc_lengths, Line(way).arc_lengths, np.arange(len(way))))
    number = place.astype(np.int64)
    number[near.distances > radius[number] * (1 + 1e-9)] = -1
    corners = volume.points[volume.tetrahedra]
    arms = corners[:, 1:] - corners[:, :1]
    sizes = np.abs(np.linalg.det(arms)) / 6
    count = len(volume.points)
    weights = np.bincount(volume.tetrahedra.ravel(), np.repeat(sizes, 4), count)
    return number, weights.astype(np.float64)


def _mean(frames: Sequence[Found]) -> Found:
    faces = {
        name: FaceFlow(*np.mean([frame.faces[name] for frame in frames], axis=0).tolist())
        for name in frames[0].faces
    }
    mean, high = np.mean([frame.shear for frame in frames], axis=0).tolist()
    return Found(
        faces,
        (mean, high),
        np.mean([frame.pressure for frame in frames], axis=0),
        np.mean([frame.speed for frame in frames], axis=0),
    )
