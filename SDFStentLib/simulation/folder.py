"""The folder of a simulation: cases for the solver, scripts, and what has to be known of them."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from ..files import MeshComplete
from ..geometry import Line, NamedFaces
from ..units import Frame
from ..validation import InputError, as_path
from .prepared import Mesh, Prepared, State
from .scripts import scripts_of
from .solver_file import solver_files

DOCUMENT = "simulation.json"
SCHEMA = "sdfstent-simulation"
SPACING = 1.0
"""Of the way in the document, mm."""

CASES = {
    ("before", "fine"): "before",
    ("after", "fine"): "after",
    ("before", "coarse"): "coarse/before",
    ("after", "coarse"): "coarse/after",
}
"""The folder of each state and mesh, in the order in which they are solved."""

FILES = frozenset({DOCUMENT, "run.sh", "job.sbatch", "before", "after", "coarse"})
"""What is in the folder."""


class Origin(NamedTuple):
    """Of the vessel."""

    inputs: Mapping[str, Any]
    notice: str
    frame: Frame | None = None


def write_cases(folder: Path, prepared: Prepared, origin: Origin, processes: int = 2) -> None:
    """Write all that is needed to solve the flow in a vessel before and after.

    Parameters
    ----------
    folder : Path
        Which is made.
    prepared : Prepared
    origin : Origin
    processes : int
        That `run.sh` takes.

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
    """What has to be known of the cases in a folder.

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
        "is_wave": first.conditions.wave is not None,
        "level_mmhg": prepared.level,
        "main_outlet": prepared.main_outlet,
        "way_mm": Line(prepared.way).resampled(SPACING).points.tolist(),
        "extensions_mm": prepared.extensions,
        "network_mmhg": {name: dict(told) for name, told in prepared.network.items()},
        "states": {name: _state(state) for name, state in prepared.states.items()},
    }


def _state(state: State) -> dict[str, Any]:
    conditions = state.conditions
    return {
        "inflow_ml_s": conditions.inflow,
        "outlets": [outlet._asdict() for outlet in conditions.outlets],
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
