"""What is known of the patient: flow, pressures, and how the lungs share the flow."""

from __future__ import annotations

import csv
import math
import os
import re
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..parameter import check_parameters, parameter
from ..units import MOST_FLOW
from ..validation import Floats, InputError, Place, as_number, as_path

UNITS = {"ml/s": 1.0, "l/min": 1000 / 60}
"""Milliliters a second in the units that a flow may have."""

MOST_PRESSURE = 300.0
"""mmHg, above what any artery has."""

CLOSED = 0.05
"""Share of a wave's range by which its last flow may differ from its first."""

LEAST_ROWS = 4
"""Of a wave."""

_FLOW = re.compile(r"\s*([-+]?[\d.]+(?:e[-+]?\d+)?)\s*([a-z]+/[a-z]+)?\s*", re.IGNORECASE)


@dataclass(frozen=True)
class Wave:
    """Flow over one cycle; the last time is the first of the next one."""

    time: tuple[float, ...]
    """s, from 0."""
    flow: tuple[float, ...]
    """mL/s; the last one is the first."""

    def __post_init__(self) -> None:
        time, flow = np.array(self.time), np.array(self.flow)
        if len(time) != len(flow) or len(time) < LEAST_ROWS:
            raise InputError(
                f"wave: expected as many times as flows, at least {LEAST_ROWS}, got {len(time)} "
                f"and {len(flow)}; correct them."
            )
        if not np.isfinite([time, flow]).all() or (np.diff(time) <= 0).any():
            raise InputError("wave: expected times that go up, got others; sort the rows.")
        if abs(flow[-1] - flow[0]) > CLOSED * np.ptp(flow):
            raise InputError(
                f"wave: expected one that closes, got {flow[0]:g} at its begin and {flow[-1]:g} "
                "at its end; end it with the flow with which it begins."
            )
        flow[-1] = flow[0]
        object.__setattr__(self, "time", tuple((time - time[0]).tolist()))
        object.__setattr__(self, "flow", tuple(flow.tolist()))
        if self.mean <= 0:
            raise InputError(
                f"wave: expected one whose mean flow is positive, got {self.mean:g}; flow into "
                "the vessel is positive."
            )

    @property
    def mean(self) -> float:
        """mL/s."""
        time, flow = np.array(self.time), np.array(self.flow)
        return float((flow[1:] + flow[:-1]) @ np.diff(time) / (2 * time[-1]))

    @property
    def peak(self) -> float:
        """mL/s."""
        return max(self.flow)

    def scaled(self, mean: float) -> Wave:
        """The same shape with another mean flow, mL/s."""
        factor = mean / self.mean
        return Wave(self.time, tuple(factor * one for one in self.flow))

    def sampled(self, count: int) -> Floats:
        """So many flows (count,) at even times of the cycle, mL/s."""
        at = np.arange(count) * self.time[-1] / count
        return np.interp(at, self.time, self.flow)


def _flow(does: str, which: str, **more: Any) -> Any:
    more |= {"unit": "mL/s", "above": 0, "most": MOST_FLOW, "called": f"{which} flow"}
    return parameter(does, **more)


def _pressure(does: str, where: str, **more: Any) -> Any:
    more |= {"unit": "mmHg", "most": MOST_PRESSURE, "called": f"{where} pressure"}
    return parameter(does, default=None, **more)


@dataclass(frozen=True)
class Known:
    """Of a patient before treatment. Immutable; `InputError` for values that contradict."""

    mean: float = _flow("flow into the vessel", "mean")
    peak: float | None = _flow("not below the mean; none beside a wave", "peak", default=None)
    wave: Wave | None = parameter(
        "in place of the peak; it is scaled to the mean flow", default=None
    )
    inlet: float | None = _pressure(
        "mean pressure at the inlet, with the wedge pressure", "inlet", above=0
    )
    wedge: float | None = _pressure(
        "mean pressure beyond the outlets, below the inlet's", "wedge", least=0
    )
    split_right: float | None = parameter(
        "share of the flow to the right", default=None, above=0, most=1, called="split to the right"
    )
    right: Place | None = parameter(
        "a place in the right main branch, where the frame does not tell where right is",
        default=None,
    )

    def __post_init__(self) -> None:
        check_parameters(self)
        wave = self.wave
        if wave is not None and not math.isclose(wave.mean, self.mean, rel_tol=1e-12):
            object.__setattr__(self, "wave", wave.scaled(self.mean))
        if self.peak is not None:
            if wave is not None:
                raise InputError("flow: expected a peak flow or a wave, got both; leave one out.")
            as_number(self.peak, "peak flow", unit="mL/s", minimum=self.mean, maximum=MOST_FLOW)
        _check_pressures(self.inlet, self.wedge)
        if self.split_right == 1:
            raise InputError(
                "split to the right: expected a share below 1, got 1; leave it out where only "
                "one lung has flow."
            )

    @property
    def has_pressures(self) -> bool:
        """Without them the outlets take fixed shares."""
        return self.inlet is not None

    @property
    def most(self) -> float | None:
        """The peak flow, mL/s, as given or of the wave; None where it is not known."""
        return self.peak if self.wave is None else self.wave.peak


def _check_pressures(inlet: float | None, wedge: float | None) -> None:
    if (inlet is None) != (wedge is None):
        given, lacks = ("inlet", "wedge") if wedge is None else ("wedge", "inlet")
        raise InputError(
            f"pressures: expected those at the inlet and beyond the lungs, got that of the {given} "
            f"alone; give that of the {lacks}, too, or none."
        )
    if inlet is not None and wedge is not None and inlet <= wedge:
        raise InputError(
            f"pressures: expected more at the inlet than beyond the lungs, got {inlet:g} and "
            f"{wedge:g} mmHg, which contradict each other; correct one of them."
        )


def flow_value(text: str, name: str = "flow") -> float:
    """A flow with its unit, such as 41.7mL/s or 2.5L/min, in mL/s.

    Raises
    ------
    InputError
        No number, no unit, another unit, or a flow that is not positive.
    """
    text = text.strip()
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


def known_flow(mean: float | None = None, wave: Wave | None = None, **more: Any) -> Known:
    """What is known, by a mean flow, a wave, or a wave that is scaled to the mean flow.

    `more` as of `Known`, and its errors; `InputError` without a flow.
    """
    if mean is None:
        if wave is None:
            raise InputError("flow: expected a mean flow or a wave, got neither; give one.")
        mean = wave.mean
    return Known(mean, wave=wave, **more)


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
    if len(values) < LEAST_ROWS or None in values:
        raise InputError(
            f"{path}: expected rows of two numbers, time in s and flow, at least four of them, got "
            "others; correct the file."
        )
    scale = 1.0 if unit is None else UNITS[unit]
    time, flow = zip(*(row for row in values if row is not None), strict=True)
    try:
        return Wave(time, tuple(scale * one for one in flow))
    except InputError as error:
        raise error.labeled(f"{path}: ") from error


def _numbers(row: list[str]) -> tuple[float, float] | None:
    try:
        time, flow = (float(cell) for cell in row)
    except ValueError:
        return None
    return (time, flow) if np.isfinite([time, flow]).all() else None
