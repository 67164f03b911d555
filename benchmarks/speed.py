"""How long whole commands take, in turn with another checkout of the project.

python -m benchmarks.speed [--against PATH] [--rounds 4] [--only NAME ...] [--largest SUBDIVISIONS]

Every row is a process of its own, run once for each checkout in every round; the table has the
best clock and processor times, the least memory, and the ratios of this checkout to the other.
Both run with the Python that runs this. Meshes are those of the aorto-iliac model: 3 subdivisions
have 1.19 million triangles, 5 have 19 million.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter

from .common import AORTA_TRIANGLES, aorta_case, markdown, progress
from .sweep import DATA_FOLDER, PROJECT

SURFACE, CENTERLINE = (
    str(DATA_FOLDER.resolve() / f"su0243_{name}_mm.vtp") for name in ("surface", "centerline")
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


def rows(folder: Path, largest: int, only: Sequence[str] = ()) -> Iterator[Row]:
    """All rows in turn; a large mesh is written into a folder if it is one of `only`."""
    command = ("-m", "SDFStentLib")
    out = ("-o", str(folder / "out.vtp"), "--report", str(folder / "report.json"))
    stent = ("--center", *IN_LEFT_ARTERY, "--length", "34", "--diameter", "6")
    patient = (SURFACE, "--centerline", CENTERLINE)
    yield Row("deploy", (*command, "deploy", *patient, *stent, *out))
    yield Row("measure", (*command, "measure", *patient))
    yield Row("moved stent", (str(PROJECT / "benchmarks" / "moved_stent.py"),), is_own=True)
    for level in range(2, largest + 1):
        name = f"{AORTA_TRIANGLES * 4**level:,} triangles"
        if only and name not in only:
            continue  # a large mesh takes a while to be written
        case = aorta_case(level)
        surface, axis = folder / f"aorta_{level}.vtp", folder / "axis.vtp"
        _write(surface, case.points, case.triangles)
        _write(axis, case.axis)
        place = ("--axis", str(axis), "--diameter", str(2 * case.radius))
        yield Row(name, (*command, "deploy", str(surface), *place, *out))


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
        cwd=checkout,  # Python looks there before all else
        env=environment(checkout),
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


def environment(checkout: Path) -> dict[str, str]:
    """That of this process with the library of a checkout, whose bytecode is kept as it is where
    somebody uses it: compiling takes as long as all imports."""
    kept = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    return {**kept, "PYTHONPATH": str(checkout)}


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="benchmarks.speed", description=__doc__.splitlines()[0])
    parser.add_argument("--against", type=Path, metavar="PATH", help="another checkout")
    parser.add_argument("--rounds", type=int, default=4)
    parser.add_argument("--only", nargs="+", metavar="NAME", help="these rows")
    parser.add_argument("--largest", type=int, default=3, metavar="SUBDIVISIONS")
    chosen = parser.parse_args(arguments)
    checkouts = [PROJECT, *([chosen.against.resolve()] if chosen.against else [])]
    with TemporaryDirectory() as name:
        found = {
            row.name: _in_turn(row, checkouts, chosen.rounds)
            for row in rows(Path(name), chosen.largest, chosen.only or ())
            if not chosen.only or row.name in chosen.only
        }
    print(table(found))
    return 0


def _in_turn(row: Row, checkouts: Sequence[Path], rounds: int) -> list[Run]:
    """The best run of every checkout."""
    runs: dict[Path, list[Run]] = {checkout: [] for checkout in checkouts}
    for number in range(rounds):
        progress(f"{row.name}, round {number + 1}")
        for checkout in checkouts:
            runs[checkout].append(run(row, checkout))
    return [Run.best(each) for each in runs.values()]


def table(found: dict[str, list[Run]]) -> str:
    """The best runs of every row, of this checkout and perhaps of another one."""
    header = ["", "clock, s", "processor, s", "memory, MB"]
    if any(len(best) > 1 for best in found.values()):
        header += ["clock to the other", "processor", "memory"]
    return markdown(header, [[name, *_cells(best)] for name, best in found.items()])


def _cells(best: list[Run]) -> list[str]:
    own = best[0]
    cells = [f"{own.seconds:.2f}", f"{own.processor:.2f}", f"{own.megabytes:.0f}"]
    for other in best[1:]:
        cells += [f"{one / two:.2f}" for one, two in zip(own, other, strict=True)]
    return cells


if __name__ == "__main__":
    sys.exit(main())
