"""The results of all cases of a folder, before and after, fine and coarse."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..geometry import Line
from ..validation import Floats, InputError
from .folder import CASES, read_document
from .results import Case, CaseResult
from .solver_file import RESULTS

UNSTEADY = 0.02
"""Part of the inlet pressure from which on flow is told to be unsteady."""


class Simulated(NamedTuple):
    """What a solver found, beside what the network tells."""

    document: dict[str, Any]
    """As `write_cases` wrote it."""
    along: Floats
    """(k,) arc length along the way, mm."""
    fine: dict[str, CaseResult]
    """By state."""
    coarse: dict[str, CaseResult]
    """Where it was solved."""


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
        found[size][name] = Case(case, way, walls[name]).result(is_wave=is_wave)
    return Simulated(document, Line(way).arc_lengths, found["fine"], found["coarse"])
