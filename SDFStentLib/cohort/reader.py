"""A cohort as arrays: parameters, numbers of the manifest, displacements on a fixed topology."""

from __future__ import annotations

import csv
import gzip
import json
import os
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..files import SurfaceFile, read_surface, write_bytes
from ..validation import Floats, InputError, Points, Triangles
from .manifest import CSV, TRUTHS, text_columns
from .moved import MovedPoints, decoded, points_of, write_restored
from .store import REPORT, SURFACES, Store


@dataclass(frozen=True, eq=False)
class TrainingSet:
    """Deployments in one patient, ready for a surrogate model.

    Attributes
    ----------
    cases : tuple of str
        Names of the k cases.
    names : tuple of str
        Names of the p parameters that are numbers.
    parameters : (k, p) array
        Values of the parameters, lengths in mm.
    displacements : (k, n, 3) float32 array
        Displacement of every point, mm, new minus old.
    points : (n, 3) array
        Points before treatment, mm.
    triangles : (m, 3) array
        Triangles, the same for all cases.
    """

    cases: tuple[str, ...]
    names: tuple[str, ...]
    parameters: Floats
    displacements: NDArray[np.float32]
    points: Points
    triangles: Triangles


class Cohort:
    """The cohort in a folder that a sweep has written.

    Parameters
    ----------
    folder : path

    Raises
    ------
    InputError
        The folder is not that of a cohort.
    """

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        self.store = Store(folder)
        self._document = self.store.cohort()
        self._surfaces: dict[str, SurfaceFile] = {}

    @property
    def patients(self) -> tuple[str, ...]:
        """Names of the patients."""
        return tuple(patient["name"] for patient in self._document["patients"])

    @cached_property
    def columns(self) -> dict[str, NDArray[Any]]:
        """Columns of the manifest by name, as text or numbers; NaN where a number is not known.

        `certified` is 1, 0 or NaN. `InputError` without a manifest: `write_manifest` makes it.
        """
        try:
            file = (self.store.folder / CSV).open(newline="", encoding="utf-8")
        except OSError as error:
            raise InputError(
                f"{self.store.folder}: expected {CSV}, got none; write the manifest again."
            ) from error
        with file:
            names, *rows = csv.reader(file)
        texts = text_columns(self._document)
        cells = list(zip(*rows, strict=True)) if rows else [() for _ in names]
        return {
            name: np.array(column, dtype=str) if name in texts else _numbers(name, column)
            for name, column in zip(names, cells, strict=True)
        }

    def cases(self, patient: str | None = None, *, certified: bool = True) -> list[str]:
        """Names of the cases that are done, in the order of the sweep.

        Parameters
        ----------
        patient : str, optional
            The only patient whose cases are listed.
        certified : bool
            Whether to leave out cases that are not certified.
        """
        names, columns = [], self.columns
        if "certified" not in columns:
            return []
        for case, person, status, judged in zip(
            *(columns[name] for name in ("case", "patient", "status", "certified")), strict=True
        ):
            is_wanted = patient in (None, person) and status == "done"
            if is_wanted and not (certified and judged == 0):
                names.append(str(case))
        return list(dict.fromkeys(names))

    def training_set(
        self, patient: str | None = None, cases: Sequence[str] | None = None
    ) -> TrainingSet:
        """Parameters and displacements of some cases of one patient.

        Parameters
        ----------
        patient : str, optional
            Name of the patient, needed if the cohort has several.
        cases : sequence of str, optional
            Names of the cases; by default all that are done and certified. The displacements are in
            memory: 12 bytes for every point of every case.

        Raises
        ------
        InputError
            No such patient, or a surface that is not the one of the sweep.
        """
        name = self._one(patient)
        chosen = self.cases(name) if cases is None else list(cases)
        surface = self.surface(name)
        numbers = [at for at, axis in enumerate(self._document["axes"]) if axis["is_number"]]
        values = {case: row for case, _, row in self._document["cases"]}
        moved = np.zeros((len(chosen), len(surface.points), 3), dtype=np.float32)
        for place, case in zip(moved, chosen, strict=True):
            found = self._moved(case, surface)
            place[found.indices] = found.coordinates - surface.points[found.indices]
        return TrainingSet(
            tuple(chosen),
            tuple(self._document["axes"][at]["name"] for at in numbers),
            np.array([[float(values[case][at]) for at in numbers] for case in chosen]).reshape(
                len(chosen), len(numbers)
            ),
            moved,
            surface.points,
            surface.triangles,
        )

    def surface(self, patient: str | None = None) -> SurfaceFile:
        """The surface of a patient before treatment; `InputError` if its file has changed."""
        name = self._one(patient)
        if name not in self._surfaces:
            entry = self._document["patients"][self.patients.index(name)]
            path = os.path.join(self.store.folder, entry["surface"]["file"])
            surface = read_surface(os.path.normpath(path), entry["units"])
            if surface.sha256 != entry["surface"]["sha256"]:
                raise InputError(
                    f"{path}: expected the file that the sweep was made with, got another one; "
                    "put the original back."
                )
            self._surfaces[name] = surface
        return self._surfaces[name]

    def points(self, case: str) -> Points:
        """The points (n, 3) of a case after treatment, mm."""
        surface = self.surface(self._patient_of(case))
        return points_of(surface, self._moved(case, surface))

    def write_surface(self, case: str, path: str | os.PathLike[str]) -> None:
        """Write the whole surface of a case; a .vtp has the same bytes whatever the store keeps."""
        if self._document["store"] == "vtp" and os.fspath(path).lower().endswith(".vtp"):
            write_bytes(path, self.store.data(case, SURFACES["vtp"]))
            return
        surface = self.surface(self._patient_of(case))
        write_restored(path, surface, self._moved(case, surface))

    def report(self, case: str) -> dict[str, Any]:
        """The report of a case, without times."""
        found: dict[str, Any] = json.loads(gzip.decompress(self.store.data(case, REPORT)))
        return found

    def _moved(self, case: str, surface: SurfaceFile) -> MovedPoints:
        if self._document["store"] == "moved":
            return decoded(self.store.data(case, SURFACES["moved"]))
        self.store.data(case, SURFACES["vtp"])  # whole, or it says why not
        after = read_surface(self.store.path(case) / SURFACES["vtp"], surface.units).points
        indices = np.flatnonzero((after != surface.points).any(axis=1))
        return MovedPoints(indices, after[indices])

    def _patient_of(self, case: str) -> str:
        if case not in self._patients:
            raise InputError(f"case: expected one of this cohort, got {case!r}.")
        return self.patients[self._patients[case]]

    @cached_property
    def _patients(self) -> dict[str, int]:
        return {case: patient for case, patient, _ in self._document["cases"]}

    def _one(self, patient: str | None) -> str:
        if patient is None and len(self.patients) == 1:
            return self.patients[0]
        if patient not in self.patients:
            raise InputError(
                f"patient: expected one of {', '.join(self.patients[:8])}, got {patient!r}."
            )
        return patient


def _numbers(name: str, column: Sequence[str]) -> NDArray[np.float64]:
    if name in TRUTHS:
        known = {"true": 1.0, "false": 0.0}
        return np.array([known.get(cell, np.nan) for cell in column], dtype=float)
    return np.array([float(cell) if cell else np.nan for cell in column], dtype=float)
