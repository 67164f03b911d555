"""What is known of the patient: flow, pressures, and how the lungs share the flow."""

from __future__ import annotations

import csv
import os
import re
from typing import NamedTuple

import numpy as np

from ..units import MOST_FLOW
from ..validation import Floats, InputError, as_number, as_path
from .integral import integral_to

UNITS = {"ml/s": 1.0, "l/min": 1000 / 60}
"""Milliliters a second in the units that a flow may have."""

MOST_PRESSURE = 300.0
"""mmHg, above what any artery has."""

CLOSED = 0.05
"""Share of a wave's range by which its last flow may differ from its first."""

_FLOW = re.compile(r"\s*([-+]?[\d.]+(?:e[-+]?\d+)?)\s*([a-z]+/[a-z]+)?\s*", re.IGNORECASE)


class Wave(NamedTuple):
    """Flow over one cycle; the last time is the first of the next one."""

    time: Floats
    """(n,) s, from 0."""
    flow: Floats
    """(n,) mL/s; the last one is the first."""

    @property
    def mean(self) -> float:
        """mL/s."""
        return float(integral_to(self.flow, self.time)[-1] / self.time[-1])

    def sampled(self, count: int) -> Floats:
        """So many flows (count,) at even times of the cycle, mL/s."""
        at = np.arange(count) * self.time[-1] / count
        return np.interp(at, self.time, self.flow)


class Known(NamedTuple):
    """Of a patient before treatment; make it by `known_flow`."""

    mean: float
    """mL/s."""
    peak: float | None
    """mL/s."""
    wave: Wave | None
    inlet: float | None
    """Mean pressure in the main artery, mmHg."""
    wedge: float | None
    """Beyond the outlets, mmHg."""
    split_right: float | None
    """Share of the flow to the right, in (0, 1)."""

    @property
    def has_pressures(self) -> bool:
        """Without them the outlets take fixed shares."""
        return self.inlet is not None


def flow_value(text: str, name: str = "flow") -> float:
    """A flow with its unit, such as 41.7mL/s or 2.5L/min, in mL/s.

    Raises
    ------
    InputError
        No number, no unit, another unit, or a flow that is not positive.
    """
    found = _FLOW.fullmatch(text)
    unit = found[2].lower() if found and found[2] else ""
    if found is None or unit not in UNITS:
        raise InputError(
            f"{name}: expected a flow with its unit, such as 41.7mL/s or 2.5L/min, got {text!r}; "
            "write the unit behind the number, without a space."
        )
    try:
        value = float(found[1]) * UNITS[unit]
    except ValueError:
        value = float("nan")
    return as_number(value, name, unit="mL/s", above=0, maximum=MOST_FLOW)


def known_flow(
    mean: float | None = None,
    *,
    peak: float | None = None,
    wave: Wave | None = None,
    pressures: tuple[float | None, float | None] = (None, None),
    split_right: float | None = None,
) -> Known:
    """What is known, checked; a wave is scaled to a mean flow that is given as well.

    The `pressures` are those at the inlet and beyond the lungs.

    Raises
    ------
    InputError
        Neither a mean flow nor a wave, or values that contradict each other.
    """
    if mean is None and wave is None:
        raise InputError("flow: expected a mean flow or a wave, got neither; give one.")
    if wave is not None:
        wave = wave if mean is None else wave._replace(flow=wave.flow * mean / wave.mean)
        mean = wave.mean
    mean = as_number(mean, "mean flow", unit="mL/s", above=0, maximum=MOST_FLOW)
    if peak is not None:
        if wave is not None:
            raise InputError("flow: expected a peak flow or a wave, got both; leave one out.")
        peak = as_number(peak, "peak flow", unit="mL/s", minimum=mean, maximum=MOST_FLOW)
    inlet, wedge = pressures
    if (inlet is None) != (wedge is None):
        given, lacks = ("inlet", "wedge") if wedge is None else ("wedge", "inlet")
        raise InputError(
            f"pressures: expected those at the inlet and beyond the lungs, got that of the {given} "
            f"alone; give that of the {lacks}, too, or none."
        )
    if inlet is not None:
        wedge = as_number(wedge, "wedge pressure", unit="mmHg", minimum=0, maximum=MOST_PRESSURE)
        inlet = as_number(inlet, "inlet pressure", unit="mmHg", above=0, maximum=MOST_PRESSURE)
        if inlet <= wedge:
            raise InputError(
                f"pressures: expected more at the inlet than beyond the lungs, got {inlet:g} and "
                f"{wedge:g} mmHg, which contradict each other; correct one of them."
            )
    if split_right is not None:
        split_right = as_number(split_right, "split to the right", above=0, maximum=1)
        if split_right == 1:
            raise InputError(
                "split to the right: expected a share below 1, got 1; leave it out where only one "
                "lung has flow."
            )
    return Known(mean, peak, wave, inlet, wedge, split_right)


def read_wave(path: str | os.PathLike[str], *, needs_unit: bool = True) -> Wave:
    """A wave from CSV: a header with a unit of flow, then rows of time in s and flow.

    Parameters
    ----------
    path : path
    needs_unit : bool
        Without a unit its shape alone is known.

    Raises
    ------
    InputError
        A file that cannot be read, no unit, or rows that are no cycle.
    """
    path = as_path(path)
    try:
        with open(path, encoding="utf-8-sig", newline="") as file:
            rows = [row for row in csv.reader(file) if any(cell.strip() for cell in row)]
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: expected a CSV file, got {error}; correct the path.") from error
    header = "" if not rows or _numbers(rows[0]) else ",".join(rows[0]).lower().replace("_", "/")
    unit = next((one for one in UNITS if one in header), None)
    if unit is None and needs_unit:
        raise InputError(
            f"{path}: expected a header such as time_s,flow_mL/s that tells the unit of the flow, "
            "mL/s or L/min, got none; add it, or give the mean flow as well."
        )
    values = [_numbers(row) for row in rows[bool(header) :]]
    if len(values) < 4 or None in values:
        raise InputError(
            f"{path}: expected rows of two numbers, time in s and flow, at least four of them, got "
            "others; correct the file."
        )
    time, flow = np.array(values, dtype=float).T
    return _cycle(time, flow * (1.0 if unit is None else UNITS[unit]), str(path))


def _numbers(row: list[str]) -> tuple[float, float] | None:
    try:
        time, flow = (float(cell) for cell in row)
    except ValueError:
        return None
    return (time, flow) if np.isfinite([time, flow]).all() else None


def _cycle(time: Floats, flow: Floats, name: str) -> Wave:
    if (np.diff(time) <= 0).any():
        raise InputError(f"{name}: expected times that go up, got others; sort the rows.")
    gap = abs(flow[-1] - flow[0])
    if gap > CLOSED * np.ptp(flow):
        raise InputError(
            f"{name}: expected a wave that closes, got {flow[0]:g} at its begin and {flow[-1]:g} "
            "at its end; end it with the flow with which it begins."
        )
    flow[-1] = flow[0]
    wave = Wave(time - time[0], flow)
    if wave.mean <= 0:
        raise InputError(
            f"{name}: expected a wave whose mean flow is positive, got {wave.mean:g}; flow into "
            "the vessel is positive."
        )
    return wave
