"""Flow data of a patient: flow, pressures, and how the lungs share the flow."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..parameter import check_parameters, parameter
from ..units import MOST_FLOW
from ..validation import Floats, InputError, Place, as_number
from .wave import RATES, Wave, on_common_steps

MOST_PRESSURE = 300.0
"""mmHg, above what any artery has."""

MOST_BSA = 4.0
"""m2, above any man's."""

SAME = 1e-6
"""Share by which flows of inlets may miss the mean flow: they are written with a few digits."""

MOST_MEAN = 26.8
"""L/min, what trained men have at their most (Grimby, Nilsson and Saltin, J Appl Physiol 1966;
21:1150): who lies in a laboratory has less."""

L_PER_MIN = 0.06
"""Liters per minute in one mL/s."""


@dataclass(frozen=True)
class Inflow:
    """Flow into the vessel at one of several inlets; 0 where it is closed."""

    name: str
    """The name of the end, or of the vessel there, as a report has it."""
    mean: float = parameter(
        "flow into the vessel there", unit="mL/s", least=0, most=MOST_FLOW, called="mean flow"
    )
    wave: Wave | None = parameter("over a cycle, scaled to the mean flow", default=None)

    def __post_init__(self) -> None:
        check_parameters(self, f"inlet {self.name!r}: ")
        if self.wave is not None and not math.isclose(self.wave.mean, self.mean, rel_tol=1e-12):
            object.__setattr__(self, "wave", self.wave.scaled(self.mean) if self.mean else None)

    def at(self, times: Floats) -> Floats:
        """Flows (t,) at times of the cycle, s; mL/s."""
        if self.wave is None:
            return np.full(len(times), self.mean)
        return np.interp(times, self.wave.time, self.wave.flow)


def _flow(does: str, which: str, **more: Any) -> Any:
    more |= {"unit": "mL/s", "above": 0, "most": MOST_FLOW, "called": f"{which} flow"}
    return parameter(does, **more)


def _pressure(does: str, where: str, **more: Any) -> Any:
    more |= {"unit": "mmHg", "most": MOST_PRESSURE, "called": f"{where} pressure"}
    return parameter(does, default=None, **more)


@dataclass(frozen=True)
class Known:
    """The known flow of a patient before treatment; `InputError` for values that contradict."""

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
    inlets: tuple[Inflow, ...] = parameter(
        "flow at every inlet where there are several; the inlet pressure is that at the first one",
        default=(),
    )
    bsa: float | None = parameter(
        "body surface area, for indices", unit="m2", default=None, above=0, most=MOST_BSA
    )
    unusual: bool = parameter(
        "a heart rate or a mean flow beyond the usual ones is meant so", default=False
    )

    def __post_init__(self) -> None:
        check_parameters(self)
        _check_inlets(self.inlets, self.mean)
        if any(one.wave is not None for one in self.inlets):
            inlets, whole = _together(self.inlets)
            object.__setattr__(self, "inlets", inlets)
            object.__setattr__(self, "wave", whole)
        wave = self.wave
        if wave is not None and not math.isclose(wave.mean, self.mean, rel_tol=1e-12):
            object.__setattr__(self, "wave", wave.scaled(self.mean))
        if self.peak is not None:
            if wave is not None:
                raise InputError("flow: expected a peak flow or a wave, got both; leave one out.")
            as_number(self.peak, "peak flow", unit="mL/s", minimum=self.mean, maximum=MOST_FLOW)
        _check_pressures(self.inlet, self.wedge)
        if not self.unusual:
            _check_usual(self.mean, self.wave)
        if self.split_right == 1:
            raise InputError(
                "split to the right: expected a share below 1, got 1; leave it out where only "
                "one lung has flow."
            )

    @property
    def fractions(self) -> tuple[float, ...]:
        """The fraction of the flow at each inlet."""
        return tuple(one.mean / self.mean for one in self.inlets) or (1.0,)

    @property
    def is_uneven(self) -> bool:
        """Whether several inlets have waves of their own; `wave` is that of all together then."""
        flowing = [one for one in self.inlets if one.mean]
        return len(flowing) > 1 and any(one.wave is not None for one in flowing)

    def spread(self, inlets: int = 1) -> tuple[Floats, Floats]:
        """Flows (t,), mL/s, with weights (t,), for means over time: one flow, or those of a wave.

        Where waves of inlets differ, flows (t, i) at two times between every two rows, by Gauss'
        quadrature: exact for losses that go with the square of flow.
        """
        if self.wave is None:
            return np.array([self.mean]), np.ones(1)
        if not self.is_uneven:
            return self.wave.spread()
        rows = np.array(self.wave.time)
        step, middle = np.diff(rows)[:, None], (rows[1:] + rows[:-1])[:, None] / 2
        times = (middle + step / math.sqrt(12) * np.array([-1, 1])).ravel()
        return self.through(times, inlets), np.repeat(step / (2 * self.wave.cycle), 2)

    def through(self, times: Floats, inlets: int) -> Floats:
        """Flows (t, i) at times of a wave, s, through inlets, closed ones last, mL/s."""
        flowing = sorted(self.inlets, key=lambda one: not one.mean)
        found = np.zeros((len(times), inlets))
        for number, one in enumerate(flowing):
            found[:, number] = one.at(times)
        return found

    def at_peak(self, inlets: int = 1) -> float | Floats:
        """The peak flow, or those (i,) through inlets with waves of their own, mL/s."""
        if self.wave is None or not self.is_uneven:
            return self.most or self.mean
        at = self.wave.time[int(np.argmax(self.wave.flow))]
        return self.through(np.array([at]), inlets)[0]

    @property
    def has_pressures(self) -> bool:
        """Whether pressures are known; without them the outlets take fixed shares."""
        return self.inlet is not None

    @property
    def most(self) -> float | None:
        """The peak flow, mL/s, as given or of the wave; None where it is not known."""
        return self.peak if self.wave is None else self.wave.peak


def _check_inlets(inlets: tuple[Inflow, ...], mean: float) -> None:
    names = [one.name.casefold() for one in inlets]
    twice = next((one.name for one in inlets if names.count(one.name.casefold()) > 1), None)
    if twice is not None:
        raise InputError(f"inlets: expected each once, got {twice!r} twice; leave one out.")
    whole = sum(one.mean for one in inlets)
    if inlets and not math.isclose(whole, mean, rel_tol=SAME):
        raise InputError(
            f"inlets: expected flows that add up to the mean flow, {mean:g} mL/s, got {whole:g}; "
            "leave the mean flow out, or correct one of them."
        )


def _together(inlets: tuple[Inflow, ...]) -> tuple[tuple[Inflow, ...], Wave]:
    """Inlets whose rows lie on the same steps, and the wave of all of them."""
    waves, times = on_common_steps([one.wave for one in inlets if one.wave is not None])
    moved = iter(waves)
    found = tuple(one if one.wave is None else replace(one, wave=next(moved)) for one in inlets)
    flow = np.sum([one.at(times) for one in found], axis=0)
    return found, Wave(tuple(times.tolist()), tuple(flow.tolist()))


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


def _check_usual(mean: float, wave: Wave | None) -> None:
    """Refuse values as of a wrong unit, unless they are meant so."""
    low, high = RATES
    if wave is not None and not low <= wave.rate <= high:
        raise InputError(
            f"wave: expected {low:g} to {high:g} beats/min, got a cycle of {wave.cycle:.4g} s, "
            f"which are {wave.rate:.4g} beats/min; correct the unit of the time, tell the length "
            "of one of several beats, or that it is meant so",
            "unusual",
            otherwise=' ("unusual": true in the flow of a plan)',
            end=".",
        )
    if mean * L_PER_MIN > MOST_MEAN:
        raise InputError(
            f"mean flow: expected at most {MOST_MEAN:g} L/min, which trained adults have at their "
            f"most, got {mean:.4g} mL/s, which are {mean * L_PER_MIN:.4g} L/min; correct its unit, "
            "or tell that it is meant so",
            "unusual",
            otherwise=' ("unusual": true in the flow of a plan)',
            end=".",
        )


def known_flow(
    mean: float | None = None,
    wave: Wave | None = None,
    inlets: tuple[Inflow, ...] = (),
    **more: Any,
) -> Known:
    """Flow data by a mean flow, a wave that may be scaled to it, or flows at all inlets.

    `more` as of `Known`, and its errors; `InputError` without a flow.
    """
    if mean is None and inlets:
        mean = sum(one.mean for one in inlets)
    if mean is None:
        if wave is None:
            raise InputError("flow: expected a mean flow or a wave, got neither; give one.")
        mean = wave.mean
    return Known(mean, wave=wave, inlets=inlets, **more)
