"""Folder of a simulation: cases for the solver, scripts that run it, and a document."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from ..files import MeshComplete
from ..geometry import Line, NamedFaces
from ..units import Frame
from ..validation import InputError, as_path
from .prepared import Mesh, Prepared, State
from .solver_file import PRESSURES, RESULTS, TimeSteps, solver_files

STEADY = 0.002
"""Part of the inlet pressure within which it has to stay."""

_RUN = """\
#!/bin/sh
# Solves the cases of this folder, one after the other: sh run.sh
# PROCESSES=4 sh run.sh takes so many cores; SOLVER names another svmultiphysics than the PATH's.
set -u
cd "$(dirname "$0")" || exit 1
processes=${PROCESSES:-@processes@}
solver=${SOLVER:-svmultiphysics}
pause=${PAUSE:-5}

# Writes the step to stop at, the next one that is saved, once the inlet pressure stays.
stop_when_steady() {
  tail -n "$1" @pressures@ 2>/dev/null | awk -v n="$1" -v every="$2" '
    NF > 2 && $1 ~ /^[0-9]+$/ {
      if (!rows++ || $3 > high) high = $3
      if (rows == 1 || $3 < low) low = $3
      size = $3 < 0 ? -$3 : $3; step = $1
    }
    END { if (rows == n && step >= 2 * n && high - low <= @steady@ * size)
            print (int(step / every) + 1) * every }' > stop.new
  if [ -s stop.new ] && [ ! -e STOP_SIM ]; then mv stop.new STOP_SIM; else rm -f stop.new; fi
}

# The case, the steps over which pressure has to stay (0 for a wave), and from one that is saved
# to the next.
solve() {
  echo "$1"
  cd "$1" || exit 1
  rm -rf @results@ STOP_SIM
  if [ "$processes" -gt 1 ]; then
    mpiexec -n "$processes" "$solver" solver.xml > solver.log 2>&1 &
  else
    "$solver" solver.xml > solver.log 2>&1 &
  fi
  child=$!
  trap 'kill $child 2>/dev/null; exit 130' INT TERM
  while kill -0 $child 2>/dev/null; do
    if [ "$2" -gt 0 ]; then stop_when_steady "$2" "$3"; fi
    sleep "$pause"
  done
  wait $child || { echo "$1: the solver ended with code $?, see $1/solver.log" >&2; exit 1; }
  cd - > /dev/null || exit 1
}

@cases@
"""

_JOB = """\
#!/bin/bash
#SBATCH -J sdfstent
#SBATCH -N 1
#SBATCH -n 24
#SBATCH -t 24:00:00
# Load the modules with which svMultiPhysics was built here, then: sbatch job.sbatch
cd "${SLURM_SUBMIT_DIR:-.}" || exit 1
PROCESSES="${SLURM_NTASKS:-24}" PAUSE=30 exec sh run.sh
"""


def scripts_of(cases: Sequence[tuple[str, TimeSteps]], processes: int) -> dict[str, str]:
    """`run.sh` and `job.sbatch`, by name.

    Parameters
    ----------
    cases : sequence of folders and their steps
        Cases in the order in which they are solved.
    processes : int
        Number of processes for `run.sh`.
    """
    told = {
        "processes": str(processes),
        "pressures": PRESSURES,
        "results": RESULTS,
        "steady": f"{STEADY:g}",
        "cases": "\n".join(f"solve {n} {steps.window} {steps.save_every}" for n, steps in cases),
    }
    text = _RUN
    for name, value in told.items():
        text = text.replace(f"@{name}@", value)
    return {"run.sh": text, "job.sbatch": _JOB}


DOCUMENT = "simulation.json"
SCHEMA = "sdfstent-simulation"
SPACING = 1.0
"""The distance of places on the way in the document, mm."""

CASES = {
    ("before", "fine"): "before",
    ("after", "fine"): "after",
    ("before", "coarse"): "coarse/before",
    ("after", "coarse"): "coarse/after",
}
"""The folder of each state and mesh, in the order in which they are solved."""

FILES = frozenset({DOCUMENT, "run.sh", "job.sbatch", "before", "after", "coarse"})
"""Names of the files and folders in the folder."""


class Origin(NamedTuple):
    """The origin of the vessel."""

    inputs: Mapping[str, Any]
    notice: str
    frame: Frame | None = None


def write_cases(folder: Path, prepared: Prepared, origin: Origin, processes: int = 2) -> None:
    """Write all that the solver needs for the flow in a vessel before and after.

    Parameters
    ----------
    folder : Path
        Folder to make.
    prepared : Prepared
    origin : Origin
    processes : int
        Number of processes for `run.sh`.

    Raises
    ------
    OSError
        A file that cannot be written.
    """
    folder.mkdir()
    (folder / "coarse").mkdir()
    for (name, size), place in CASES.items():
        state = prepared.states[name]
        _write_case(folder / place, state, state.meshes[size], origin.frame)
    steps = [(place, prepared.states[n].meshes[size].steps) for (n, size), place in CASES.items()]
    for name, text in scripts_of(steps, processes).items():
        (folder / name).write_text(text, encoding="utf-8")
    (folder / "run.sh").chmod(0o755)
    text = json.dumps(_document(prepared, origin), indent=1, allow_nan=False)
    (folder / DOCUMENT).write_text(text + "\n", encoding="utf-8")


def read_document(folder: Path) -> dict[str, Any]:
    """Document of the cases in a folder.

    Raises
    ------
    InputError
        A folder that `write_cases` has not written.
    """
    path = as_path(folder) / DOCUMENT
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        document = None
    if not isinstance(document, dict) or document.get("schema") != SCHEMA:
        raise InputError(
            f"{folder}: expected a folder of `sdfstent simulate`, got one without a sound "
            f"{DOCUMENT}; name the folder that it wrote."
        )
    return document


def _write_case(folder: Path, state: State, mesh: Mesh, frame: Frame | None) -> None:
    folder.mkdir()
    made = mesh.made
    names = {face.number: face.name for face in state.segment.faces}
    walls = state.segment.walls
    faces = NamedFaces(made.face_ids, names)
    MeshComplete(made.surface, faces, walls, frame, mesh.volume).write(folder / "mesh")
    for name, text in solver_files(state.conditions, mesh.steps).items():
        (folder / name).write_text(text, encoding="utf-8")


def _document(prepared: Prepared, origin: Origin) -> dict[str, Any]:
    first = next(iter(prepared.states.values()))
    return {
        "schema": SCHEMA,
        "version": 1,
        "notice": origin.notice,
        "inputs": dict(origin.inputs),
        "cases": {
            name: {size: CASES[name, size] for size in state.meshes}
            for name, state in prepared.states.items()
        },
        "is_wave": first.conditions.cycle is not None,
        "level_mmhg": prepared.level,
        "main_outlet": prepared.main_outlet,
        "way_mm": Line(prepared.way).resampled(SPACING).points.tolist(),
        "extensions_mm": prepared.extensions,
        "network_mmhg": {name: dict(told) for name, told in prepared.network.items()},
        "states": {name: state_section(state) for name, state in prepared.states.items()},
    }


def state_section(state: State) -> dict[str, Any]:
    """A state of the vessel as it stands in the document: ends, walls and meshes."""
    inlet, *others = state.conditions.ends
    return {
        "inflow_ml_s": -inlet.flow,
        "outlets": [end._asdict() for end in others],
        "walls": sorted(face.name for face in state.segment.faces if face.kind == "wall"),
        "throat_mm": 2 * state.throat.radius,
        "meshes": {
            size: {
                **mesh.quality._asdict(),
                "edges_round_throat": mesh.edges_round,
                "wall_off_mm": mesh.made.deviation,
                "steps": mesh.steps._asdict(),
            }
            for size, mesh in state.meshes.items()
        },
    }
