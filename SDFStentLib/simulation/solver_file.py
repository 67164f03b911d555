"""Input of svMultiPhysics for a mesh: equations, time steps, and outputs.

Element names as its own test cases have them (github.com/SimVascular/svMultiPhysics,
tests/cases/fluid); all in cm, g and s.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np

from ..flow import ADULT
from ..validation import Floats, InputError
from .conditions import Conditions, End

RESULTS = "results"
"""Folder of what the solver writes, and the first part of its names."""

PRESSURES = f"{RESULTS}/B_NS_Pressure_average.txt"
"""Mean pressure on every face by step: number, time, then the faces, the inlet first."""

COURANT = 4.0
"""Edges that the fastest blood passes in a step; the scheme is implicit."""

RAMP, LONGEST, WINDOW = 0.5, 6.0, 0.5
"""Steady flow, in the time that it takes through the lumen: over how long it rises, after how long
it ends at the latest, and over how long the inlet pressure has to stay."""

FRAMES = 5
"""Frames that are saved in a window."""

LEAST_BETWEEN = 10
"""Steps from one frame to the next."""

MOST_STEPS = 200_000
"""The most steps of a solution: weeks of a large computer."""

CYCLES, CYCLE_FRAMES, MODES = 3, 20, 16
"""Numbers of a wave: cycles, saved frames of the last one, and the fewest harmonics."""

MODES_WITHIN = 0.01
"""Share of the range of a wave, within which its harmonics meet its rows."""

STEADY_WITHIN = 1e-6
"""Share of the flow: what varies by less at an end is steady there."""

RC_TIME, PROXIMAL = 0.75, 0.1
"""Values for a wave, whose outlets have compliance: resistance times compliance of the lungs, s,
the same in health and disease (Lankhaar, Eur Heart J 2008;29:1688), and the part of the resistance
before it, a choice."""

_LINEAR = {
    "Linear_algebra": {"@type": "fsils", "Preconditioner": "fsils"},
    "Max_iterations": 15,
    "NS_GM_max_iterations": 10,
    "NS_CG_max_iterations": 300,
    "Tolerance": 1e-3,
    "NS_GM_tolerance": 1e-3,
    "NS_CG_tolerance": 1e-3,
    "Absolute_tolerance": 1e-17,
    "Krylov_space_dimension": 250,
}
"""Linear solver of the solver's own cases; the preconditioner `rcs` diverges with resistances at
outlets."""


class TimeSteps(NamedTuple):
    """The steps of time."""

    length: float
    """s."""
    number: int
    ramp: float
    """s; 0 for a wave."""
    save_every: int
    save_from: int
    window: int
    """Steps over which the inlet pressure has to stay; 0 for a wave, which takes its time."""


def time_steps(conditions: Conditions, edge: float, radius: float, volume: float) -> TimeSteps:
    """Steps in which the fastest blood, in the throat, passes `COURANT` edges.

    Of a wave they are at least as many as meet its rows.

    Parameters
    ----------
    conditions : Conditions
    edge, radius : float
        Edge of the mesh and radius of the lumen in the throat, mm.
    volume : float
        Volume of the lumen, mm^3.

    Raises
    ------
    InputError
        More than `MOST_STEPS`.
    """
    steps = _time_steps(conditions, edge, radius, volume)
    if steps.number > MOST_STEPS:
        raise InputError(
            f"simulate: expected at most {MOST_STEPS:,} steps of time, got {steps.number:,}, each "
            f"{steps.length:.2g} s long, in which the fastest blood passes {COURANT:g} edges of "
            f"{edge:.2g} mm; check the units of flow and time, take longer edges, or a shorter "
            "segment."
        )
    return steps


def _time_steps(conditions: Conditions, edge: float, radius: float, volume: float) -> TimeSteps:
    cycle, flow = conditions.cycle, 1000 * conditions.most
    fastest = 2 * flow / (math.pi * radius**2)
    length = COURANT * edge / fastest
    if cycle is not None:
        period = float(cycle.time[-1])
        every = math.ceil(max(period / length, cycle.steps) / CYCLE_FRAMES)
        steps = every * CYCLE_FRAMES
        return TimeSteps(period / steps, CYCLES * steps, 0.0, every, (CYCLES - 1) * steps + 1, 0)
    through = volume / flow
    every = max(math.ceil(WINDOW * through / length / FRAMES), LEAST_BETWEEN)
    windows = math.ceil(LONGEST / WINDOW)
    window = every * FRAMES
    return TimeSteps(length, windows * window, RAMP * through, every, 1, window)


def solver_files(conditions: Conditions, steps: TimeSteps) -> dict[str, str]:
    """`solver.xml` and the files of flow that it names, by name."""
    texts, bounds = {}, []
    for number, end in enumerate(conditions.ends):
        if end.kind == "flow":
            texts[f"{end.name}.flow"] = _flow_file(conditions, number, steps)
            bounds.append(_flow_bound(end.name, f"{end.name}.flow", steps))
            continue
        if end.kind == "resistance" and conditions.cycle is not None:
            values = {"RCR_values": _windkessel(end, conditions.distal)}
            bounds.append(_bound(end.name, "Neu", "RCR", values))
            continue
        kind = "Resistance" if end.kind == "resistance" else "Steady"
        bounds.append(_bound(end.name, "Neu", kind, {"Value": end.value}))
    bounds.append(_bound("wall", "Dir", "Steady", {"Value": 0.0}))
    files = {one.name: f"mesh/mesh-surfaces/{one.name}.vtp" for one in conditions.ends}
    document = {
        "@version": "0.1",
        "GeneralSimulationParameters": _general(steps),
        "Add_mesh": {
            "@name": "lumen",
            "Mesh_file_path": "mesh/mesh-complete.mesh.vtu",
            "Add_face": [
                {"@name": name, "Face_file_path": file}
                for name, file in {**files, "wall": "mesh/walls_combined.vtp"}.items()
            ],
        },
        "Add_equation": _equation(bounds),
    }
    root = ElementTree.Element("svMultiPhysicsFile")
    if conditions.offset:
        words = (
            " A resistance has no distal pressure here: all pressures are above the wedge pressure "
            f"of {conditions.offset:g} dyn/cm2, which sdfstent adds where it reads the results. "
        )
        root.append(ElementTree.Comment(words))
    _fill(root, document)
    ElementTree.indent(root)
    text = ElementTree.tostring(root, encoding="unicode")
    return {"solver.xml": f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n', **texts}


def _general(steps: TimeSteps) -> dict[str, Any]:
    return {
        "Continue_previous_simulation": False,
        "Number_of_spatial_dimensions": 3,
        "Number_of_time_steps": steps.number,
        "Time_step_size": steps.length,
        "Spectral_radius_of_infinite_time_step": 0.5,
        "Searched_file_name_to_trigger_stop": "STOP_SIM",
        "Save_results_to_VTK_format": True,
        "Name_prefix_of_saved_VTK_files": "result",
        "Save_results_in_folder": RESULTS,
        "Increment_in_saving_VTK_files": steps.save_every,
        "Start_saving_after_time_step": steps.save_from,
        "Increment_in_saving_restart_files": steps.number,
        "Convert_BIN_to_VTK_format": False,
        "Verbose": True,
        "Warning": False,
        "Debug": False,
    }


def _equation(bounds: list[dict[str, Any]]) -> dict[str, Any]:
    """Blood as in `flow`, whose 1 Pa s are 10 g/(cm s)."""
    return {
        "@type": "fluid",
        "Coupled": True,
        "Min_iterations": 2,
        "Max_iterations": 5,
        "Tolerance": 1e-4,
        "Backflow_stabilization_coefficient": 0.2,
        "Density": ADULT.density / 1000,
        "Viscosity": {"@model": "Constant", "Value": 10 * ADULT.viscosity},
        "Output": [
            {"@type": "Spatial", "Velocity": True, "Pressure": True, "WSS": True},
            {"@type": "B_INT", "Pressure": True, "Velocity": True},
        ],
        "LS": {"@type": "NS", **_LINEAR},
        "Add_BC": bounds,
    }


def _windkessel(outlet: End, pressure: float) -> dict[str, float]:
    """A windkessel of the same mean pressure as the resistance above a distal one."""
    distal = (1 - PROXIMAL) * outlet.value
    return {
        "Proximal_resistance": PROXIMAL * outlet.value,
        "Capacitance": RC_TIME / outlet.value,
        "Distal_resistance": distal,
        "Distal_pressure": pressure,
        "Initial_pressure": pressure + distal * outlet.flow,
    }


def _bound(name: str, kind: str, time: str, more: Mapping[str, Any]) -> dict[str, Any]:
    return {"@name": name, "Type": kind, "Time_dependence": time, **more}


def _flow_bound(name: str, file: str, steps: TimeSteps) -> dict[str, Any]:
    more = {
        "Temporal_values_file_path": file,
        "Ramp_function": steps.ramp > 0,
        "Profile": "Parabolic",
        "Impose_flux": True,
    }
    return _bound(name, "Dir", "Unsteady", more)


def _flow_file(conditions: Conditions, number: int, steps: TimeSteps) -> str:
    """Rows of time and flow through an end; into the vessel is negative there."""
    cycle = conditions.cycle
    if cycle is None:
        return f"2 1\n0.0 0.0\n{steps.ramp!r} {conditions.ends[number].value!r}\n"
    flow = cycle.flow[number]
    count = harmonics_of(cycle.time, flow, STEADY_WITHIN * conditions.most)
    rows = [f"{t!r} {q!r}" for t, q in zip(cycle.time.tolist(), flow.tolist(), strict=True)]
    return "\n".join([f"{len(rows)} {count}", *rows, ""])


def harmonics_of(time: Floats, flow: Floats, least: float) -> int:
    """Number of a wave's harmonics with which the solver meets its rows, the mean among them.

    Parameters
    ----------
    time, flow : (t,) arrays
        Wave from time 0; the last flow is the first.
    least : float
        Least tolerance, in the unit of the flow.
    """
    at, steps = time / time[-1], np.diff(time) / time[-1]
    slopes, count, more = np.diff(flow) / steps, 1, MODES
    found = np.full(len(at), (flow[1:] + flow[:-1]) @ steps / 2)
    within = max(MODES_WITHIN * np.ptp(flow), least)
    # Ends: a line without jumps is the sum of its harmonics.
    while np.abs(found - flow).max() > within or count < MODES:
        turns = 2 * np.pi * np.arange(count, more)
        turned = np.exp(-1j * turns[:, None] * at)
        parts = np.diff(turned, axis=1) @ slopes / turns**2
        found = found + 2 * np.real(parts @ turned.conj())
        count, more = more, 2 * more
    return count


def _fill(element: ElementTree.Element, values: Mapping[str, Any]) -> None:
    """Attributes begin with @; a list is a row of elements of one name."""
    for name, value in values.items():
        if name.startswith("@"):
            element.set(name[1:], value)
            continue
        for one in value if isinstance(value, list) else [value]:
            child = ElementTree.SubElement(element, name)
            if isinstance(one, Mapping):
                _fill(child, one)
            else:
                child.text = str(one).lower() if isinstance(one, bool) else str(one)
