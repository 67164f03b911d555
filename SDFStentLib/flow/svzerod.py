"""A network as a document of SimVascular's 0D solver, and the solver in a process of its own."""

from __future__ import annotations

import csv
import json
import subprocess
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from shutil import rmtree
from tempfile import mkdtemp
from typing import Any

import numpy as np

from ..interpreter import interpreter
from ..validation import DeploymentError, Floats
from .known import Known
from .network import Network, Outlets
from .tree import Tree
from .wave import STEPS

CYCLES = 3
"""Cycles, of which the last counts; a network with rigid walls remembers no longer."""

TIME_LIMIT = 600.0
"""s, for a solver that takes less than one for a hundred outlets."""

NO_LEVEL = (
    "no pressures are known: outlets resist so much that they share the flow whatever the vessel "
    "costs; differences of pressure within the vessel are right, its level is not"
)

_RESIDUAL, _ROUNDING = 1e-8, 1e-12
"""Residuals of the equations, in cgs, and of the pressures in them, beyond which rounding would
decide."""

_BARYE, _R, _S = 10.0, 1e-5, 1e-11
"""Units of pressure, resistance and loss: one SI unit in cgs."""

_RUN = "import svzerod; svzerod.run_simulation_cli()"
"""Program of its command `svzerodsolver`; `svzerod.simulate` says the same by way of a table of
pandas, which takes three quarters of the time."""


def has_svzerod() -> bool:
    """Whether the solver is installed."""
    return find_spec("svzerod") is not None


def svzerod_document(
    network: Network, outlets: Outlets, known: Known, notice: str = ""
) -> dict[str, Any]:
    """Input of `svzerod.simulate`, in cgs: mL/s, dyn/cm^2, dyn s/cm^5; steady or a wave."""
    wave, tree = known.wave, network.tree
    steps = STEPS if wave is None else wave.steps
    time = [0.0, 1.0] if wave is None else list(wave.time)
    flow = [known.mean] * 2 if wave is None else list(wave.flow)
    each = np.outer(tree.fractions, flow)
    if known.is_uneven:
        each = known.through(np.array(time), len(each)).T
    ends = tree.outlets.tolist()
    level = _BARYE * outlets.pressure + _R * max(flow) / float((1 / outlets.resistance).sum())
    # A vessel on its own has no junctions; the solver takes an empty list.
    return {
        "description": {"notice": notice, "units": "cgs", "pressure": "total"},
        "simulation_parameters": {
            "number_of_cardiac_cycles": CYCLES,
            "number_of_time_pts_per_cardiac_cycle": steps + 1,
            "absolute_tolerance": max(_RESIDUAL, _ROUNDING * level),
        },
        "boundary_conditions": [
            *(
                {
                    "bc_name": name,
                    "bc_type": "FLOW",
                    "bc_values": {"Q": through, "t": time},
                }
                for name, through in zip(_inflows(tree), each.tolist(), strict=True)
            ),
            *(
                {
                    "bc_name": f"OUT{end}",
                    "bc_type": "RESISTANCE",
                    "bc_values": {"R": _R * resistance, "Pd": _BARYE * outlets.pressure},
                }
                for end, resistance in zip(ends, outlets.resistance.tolist(), strict=True)
            ),
        ],
        "junctions": list(_junctions(tree)),
        "vessels": list(_vessels(network)),
    }


def solved_by_svzerod(network: Network, outlets: Outlets, known: Known) -> tuple[Floats, Floats]:
    """Inlet pressures (t,), Pa, and flows (t, n), m^3/s, at even times of the last cycle.

    Raises
    ------
    DeploymentError
        The solver is missing, dies, takes too long, or does not converge; with its last words, and
        where its log and what it was asked are kept.
    """
    folder = Path(mkdtemp(prefix="sdfstent-flow-"))
    question, answer, log = (folder / name for name in ("network.json", "answer.csv", "solver.log"))
    document = svzerod_document(network, outlets, known)
    question.write_text(json.dumps(document, allow_nan=False), encoding="utf-8")
    command = [interpreter(), "-c", _RUN, str(question), str(answer)]
    with open(log, "wb") as said:
        try:
            done = subprocess.run(
                command, stdout=said, stderr=said, timeout=TIME_LIMIT, check=False
            )
        except subprocess.TimeoutExpired as error:
            raise _failed(f"no answer in {TIME_LIMIT:g} s", log) from error
    if done.returncode or not answer.is_file():
        words = log.read_text(encoding="utf-8", errors="replace").strip().splitlines()
        last = words[-1] if words else "nothing"
        raise _failed(f"exit code {done.returncode}, and it said: {last}", log)
    into: dict[str, list[tuple[float, float]]] = {}
    with open(answer, encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            both = float(row["flow_in"]), float(row["pressure_in"])
            into.setdefault(row["name"], []).append(both)
    each = np.array([into[_name(number)] for number in range(len(network.blocks))])
    flows, inlet = each[:, :, 0].T, each[network.tree.inlets[0], :, 1]
    if not (np.isfinite(flows).all() and np.isfinite(inlet).all()):
        raise _failed("numbers that are none: it did not converge", log)
    rmtree(folder, ignore_errors=True)
    # The end of a cycle is the begin of the next one.
    return inlet[:-1] / _BARYE, 1e-6 * flows[:-1]


def _inflows(tree: Tree) -> list[str]:
    return [f"INFLOW{number or ''}" for number in range(len(tree.inlets))]


def _junctions(tree: Tree) -> Iterator[dict[str, Any]]:
    """Junctions of vessels, by the first one that ends there."""
    ending: dict[int, list[int]] = {}
    starting: dict[int, list[int]] = {}
    for number, (start, end) in enumerate(tree.ends.tolist()):
        starting.setdefault(start, []).append(number)
        ending.setdefault(end, []).append(number)
    for node, coming in ending.items():
        if node in starting:
            yield {
                "junction_name": f"J{coming[0]}",
                "junction_type": "NORMAL_JUNCTION",
                "inlet_vessels": coming,
                "outlet_vessels": starting[node],
            }


def _vessels(network: Network) -> Iterator[dict[str, Any]]:
    tree = network.tree
    ends, coming = (
        set(tree.outlets.tolist()),
        dict(zip(tree.inlets.tolist(), _inflows(tree), strict=True)),
    )
    columns = (network.resistance, network.inertance, network.stenosis)
    each = zip(network.blocks, *(column.tolist() for column in columns), strict=True)
    for number, (block, resistance, inertance, stenosis) in enumerate(each):
        conditions = {"inlet": coming[number]} if number in coming else {}
        conditions |= {"outlet": f"OUT{number}"} if number in ends else {}
        yield {
            "vessel_id": number,
            "vessel_name": _name(number),
            "vessel_length": 100 * block.length,
            "zero_d_element_type": "BloodVessel",
            "zero_d_element_values": {
                "R_poiseuille": _R * resistance,
                "L": _R * inertance,
                "C": 0.0,
                "stenosis_coefficient": _S * stenosis,
            },
            **({"boundary_conditions": conditions} if conditions else {}),
        }


def _name(number: int) -> str:
    return f"vessel{number}"


def _failed(words: str, log: Path) -> DeploymentError:
    return DeploymentError(
        f"svzerod: expected an answer, got {words}. All that it said is in {log}, beside what it "
        "was asked. Install it anew (pip install svzerod), or give the mean and the peak flow in "
        "place of a wave, which need no solver."
    )
