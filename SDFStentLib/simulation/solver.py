"""svMultiPhysics of the user's own installation: found, started, watched, its results read."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..geometry import Line
from ..validation import DeploymentError, Floats, InputError
from .folder import CASES, read_document
from .results import CaseResult, SolvedCase
from .solver_file import RESULTS

PROGRAM = "svmultiphysics"

GET_IT = (
    "svMultiPhysics is not on the PATH: build it or take its container as "
    "https://github.com/SimVascular/svMultiPhysics says, then sh run.sh in the folder, here or on "
    "another machine (sbatch job.sbatch on a cluster)."
)

LOG = "solver.log"
"""The log of the solver, kept in the folder of every case."""

PAUSE = 0.5
"""s, between two looks at how far it is."""


def has_solver() -> bool:
    """Whether the solver is installed, and what its scripts need."""
    return bool(shutil.which(PROGRAM)) and bool(shutil.which("sh"))


def solve_cases(folder: Path, tell: Callable[[float, str], None]) -> None:
    """Solve all cases of a folder by its `run.sh`.

    Parameters
    ----------
    folder : Path
    tell : callable
        Called with the part of the cases that is done, and the next case.

    Raises
    ------
    DeploymentError
        The solver ends early in one of them; with its last words and where its log is.
    """
    names = list(CASES.values())
    with subprocess.Popen(
        ["sh", "run.sh"],
        cwd=folder,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        # A group of its own, so that the solver ends with it.
        start_new_session=True,
    ) as process:
        try:
            # Ends: with the script, which is ended where this one is interrupted.
            while process.poll() is None:
                begun = [name for name in names if (folder / name / LOG).exists()]
                tell(max(len(begun) - 1, 0) / len(names), begun[-1] if begun else names[0])
                with suppress(subprocess.TimeoutExpired):
                    process.wait(PAUSE)
        except BaseException:
            os.killpg(process.pid, signal.SIGTERM)
            raise
    for name in names:
        log = folder / name / LOG
        has_results = any((folder / name / RESULTS).glob("result_*.vtu"))
        if not log.exists() or not has_results or (process.returncode and name == _last(folder)):
            raise DeploymentError(
                f"svMultiPhysics: expected the flow in {folder / name}, got none; it said last: "
                f"{_last_words(log)}. Its log is {log}; halve Time_step_size in solver.xml there, "
                "or mesh finer, and run sh run.sh again."
            )


def _last(folder: Path) -> str:
    """Name of the case begun last; empty without one."""
    begun = [name for name in CASES.values() if (folder / name / LOG).exists()]
    return begun[-1] if begun else ""


def _last_words(log: Path) -> str:
    try:
        lines = log.read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return "nothing"
    return next((line.strip() for line in reversed(lines) if line.strip()), "nothing")


UNSTEADY = 0.02
"""Part of the inlet pressure beyond which flow is called unsteady."""


class Simulated(NamedTuple):
    """Results of a solver, and the document of its cases, which has those of the network."""

    document: dict[str, Any]
    """The document as `write_cases` wrote it."""
    along: Floats
    """(k,) arc length along the way, mm."""
    fine: dict[str, CaseResult]
    """Results by state,"""
    coarse: dict[str, CaseResult]
    """and results on the coarser mesh where that was solved."""


def read_results(folder: Path) -> Simulated:
    """Read what a solver has left in a folder.

    Raises
    ------
    InputError
        No folder of a simulation, a state without results, or files that do not fit.
    DeploymentError
        A solver that did not converge.
    """
    document = read_document(folder)
    try:
        way = np.array(document["way_mm"], dtype=np.float64).reshape(-1, 3)
        states, is_wave = document["states"], bool(document["is_wave"])
        walls = {name: list(state["walls"]) for name, state in states.items()}
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise InputError(
            f"{folder}: expected a whole simulation.json, got one without {error}; write the "
            "folder again."
        ) from error
    found: dict[str, dict[str, CaseResult]] = {"fine": {}, "coarse": {}}
    for (name, size), place in CASES.items():
        case = folder / place
        if size == "coarse" and not any((case / RESULTS).glob("result_*.vtu")):
            continue
        found[size][name] = SolvedCase(case, way, walls[name]).result(is_wave=is_wave)
    return Simulated(document, Line(way).arc_lengths, found["fine"], found["coarse"])
