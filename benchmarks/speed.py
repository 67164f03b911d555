"""How long whole commands take, in turn with another checkout of the project.

python -m benchmarks.speed [--against PATH] [--rounds 4] [--only NAME ...] [--largest SUBDIVISIONS]

Every row is a process of its own, run once for each checkout in every round; the table has the
best clock and processor times, the largest memory, and the ratios of this checkout to the other.
Both run with the Python that runs this. `growth` is the exponent of the deformation's time over
the number of triangles between one size of a mesh and the next.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np

from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter

from .common import aorta_case, markdown, progress
from .sweep import DATA_FOLDER, PROJECT

SURFACE, CENTERLINE = (
    str(DATA_FOLDER / f"su0243_{name}_mm.vtp") for name in ("surface", "centerline")
)
IN_LEFT_ARTERY = ("9.30", "-77.34", "-55.57")
"""Where the left artery of the patient is narrowest, mm."""


class Run(NamedTuple):
    """What one process took."""

    seconds: float
    """Of the clock,"""
    processor: float
    """of the processor,"""
    megabytes: float
    """and its largest memory."""

    @classmethod
    def best(cls, runs: Sequence[Run]) -> Run:
        """The least of every number."""
        return cls(*(min(column) for column in zip(*runs, strict=True)))


class Row(NamedTuple):
    """One thing that is timed."""

    name: str
    arguments: tuple[str, ...]
    """Of Python."""
    is_own: bool = False
    """Whether it prints its processor times itself, of which the mean counts."""


def rows(folder: Path, largest: int) -> list[Row]:
    """All rows; large meshes are written into a folder."""
    command = ("-m", "SDFStentLib")
    out = ("-o", str(folder / "out.vtp"), "--report", str(folder / "report.json"))
    stent = ("--center", *IN_LEFT_ARTERY, "--length", "34", "--diameter", "6")
    patient = (SURFACE, "--centerline", CENTERLINE)
    found = [
        Row("deploy", (*command, "deploy", *patient, *stent, *out)),
        Row("measure", (*command, "measure", *patient)),
        Row("moved stent", (str(PROJECT / "benchmarks" / "moved_stent.py"),), is_own=True),
    ]
    for level in range(2, largest + 1):
        case = aorta_case(level)
        surface, axis = folder / f"aorta_{level}.vtp", folder / "axis.vtp"
        _write(surface, case.points, case.triangles)
        _write(axis, case.axis)
        place = ("--axis", str(axis), "--diameter", str(2 * case.radius))
        name = f"{len(case.triangles):,} triangles"
        found.append(Row(name, (*command, "deploy", str(surface), *place, *out)))
    return found


def _write(path: Path, points: np.ndarray, triangles: np.ndarray | None = None) -> None:
    """Write triangles, or without them one line through all points."""
    data, placed, cells = vtkPolyData(), vtkPoints(), vtkCellArray()
    placed.SetData(numpy_to_vtk(points, deep=True))
    data.SetPoints(placed)
    rows = np.arange(len(points))[None] if triangles is None else triangles
    offsets = np.arange(len(rows) + 1) * rows.shape[1]
    flat = (numpy_to_vtkIdTypeArray(values, deep=True) for values in (offsets, rows.ravel()))
    cells.SetData(*flat)
    (data.SetLines if triangles is None else data.SetPolys)(cells)
    writer = vtkXMLPolyDataWriter()
    writer.SetFileName(str(path))
    writer.SetInputData(data)
    writer.Write()


def run(row: Row, checkout: Path) -> Run:
    """Run a row once with the library of a checkout."""
    start = time.perf_counter()
    child = subprocess.Popen(
        [sys.executable, *row.arguments],
        env={**os.environ, "PYTHONPATH": str(checkout)},
        stdout=subprocess.PIPE,
        text=True,
    )
    assert child.stdout is not None
    said = child.stdout.read()
    _, status, used = os.wait4(child.pid, 0)
    seconds = time.perf_counter() - start
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode not in (0, 3):  # 3: deployed, and not certified
        raise SystemExit(f"{row.name} with {checkout} ended with {child.returncode}.")
    processor = used.ru_utime + used.ru_stime
    if row.is_own:
        processor = seconds = float(np.mean(json.loads(said)))
    return Run(seconds, processor, used.ru_maxrss / 1024)


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="benchmarks.speed", description=__doc__.splitlines()[0])
    parser.add_argument("--against", type=Path, metavar="PATH", help="another checkout")
    parser.add_argument("--rounds", type=int, default=4)
    parser.add_argument("--only", nargs="+", metavar="NAME", help="these rows")
    parser.add_argument("--largest", type=int, default=3, metavar="SUBDIVISIONS")
    chosen = parser.parse_args(arguments)
    checkouts = [PROJECT, *([chosen.against.resolve()] if chosen.against else [])]
    with TemporaryDirectory() as name:
        table = []
        for row in rows(Path(name), chosen.largest):
            if chosen.only and row.name not in chosen.only:
                continue
            runs: dict[Path, list[Run]] = {checkout: [] for checkout in checkouts}
            for number in range(chosen.rounds):
                progress(f"{row.name}, round {number + 1}")
                for checkout in checkouts:
                    runs[checkout].append(run(row, checkout))
            table.append([row.name, *_cells([Run.best(runs[one]) for one in checkouts])])
    header = ["", "clock, s", "processor, s", "memory, MB"]
    print(markdown([*header, *(["clock", "processor", "memory"] if chosen.against else [])], table))
    return 0


def _cells(best: list[Run]) -> list[str]:
    own = best[0]
    cells = [f"{own.seconds:.2f}", f"{own.processor:.2f}", f"{own.megabytes:.0f}"]
    for other in best[1:]:
        cells += [f"{one / two:.2f}" for one, two in zip(own, other, strict=True)]
    return cells


if __name__ == "__main__":
    sys.exit(main())
