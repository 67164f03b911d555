"""What is known of the patient: flow, pressures, and how the lungs share the flow."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from ..parameter import check_parameters, parameter
from ..units import MOST_FLOW
from ..validation import InputError, Place, as_number
from .wave import RATES, Wave

MOST_PRESSURE = 300.0
"""mmHg, above what any artery has."""

MOST_MEAN = 26.8
"""L/min, what trained men have at their most (Grimby, Nilsson and Saltin, J Appl Physiol 1966;
21:1150): who lies in a laboratory has less."""

L_PER_MIN = 0.06
"""In one mL/s."""


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
    unusual: bool = parameter(
        "a heart rate or a mean flow beyond the usual ones is meant so", default=False
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
        if not self.unusual:
            _check_usual(self.mean, self.wave)
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


def _check_usual(mean: float, wave: Wave | None) -> None:
    """Ask about what comes of a wrong unit."""
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


def known_flow(mean: float | None = None, wave: Wave | None = None, **more: Any) -> Known:
    """What is known, by a mean flow, a wave, or a wave that is scaled to the mean flow.

    `more` as of `Known`, and its errors; `InputError` without a flow.
    """
    if mean is None:
        if wave is None:
            raise InputError("flow: expected a mean flow or a wave, got neither; give one.")
        mean = wave.mean
    return Known(mean, wave=wave, **more)
