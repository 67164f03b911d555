"""The points of a sweep and its cases, which are named after everything that
determines a result."""

from __future__ import annotations

import hashlib
import json
import math
import warnings
from collections.abc import Callable, Iterator
from dataclasses import asdict, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..plan import plan_text
from ..validation import InputError
from ..version import VERSION
from .axes import SweepAxis, Value, plain
from .value import MOST_SAMPLES, Patient, Sampling, Sweep

Parameters = dict[str, Value]
"""Values of one sample, by the name of the axis."""

_BLOCK = 4096
"""Number of samples made at once."""


class Samples:
    """The samples of a sweep; the same axes, method, count and seed give the same ones.

    A random or Sobol sweep of more samples begins with those of fewer; a Latin hypercube does not.
    Samples are made when asked for: millions of them would take gigabytes.

    Raises
    ------
    InputError
        A grid of more than `MOST_SAMPLES` points.
    """

    def __init__(self, axes: tuple[SweepAxis, ...], sampling: Sampling) -> None:
        self._axes = axes
        self._shares: NDArray[np.float64] | None = None
        if sampling.method == "grid":
            self._count = math.prod(len(axis.values) for axis in axes)
            if self._count > MOST_SAMPLES:
                raise InputError(
                    f"axes: expected at most {MOST_SAMPLES} points of the grid, got {self._count}."
                )
        else:
            self._shares, self._count = _shares(sampling, len(axes)), sampling.count

    def __len__(self) -> int:
        return self._count

    def __getitem__(self, at: int) -> Parameters:
        return self._at(np.atleast_1d(range(self._count)[at]))[0]

    def __iter__(self) -> Iterator[Parameters]:
        for start in range(0, self._count, _BLOCK):
            yield from self._at(np.arange(start, min(start + _BLOCK, self._count)))

    def _at(self, places: NDArray[np.int64]) -> list[Parameters]:
        if self._shares is None:
            # The last axis varies fastest.
            digits = np.unravel_index(places, [len(axis.values) for axis in self._axes])
            columns = [
                [axis.values[digit] for digit in column.tolist()]
                for axis, column in zip(self._axes, digits, strict=True)
            ]
        else:
            columns = [axis.at(self._shares[places, at]) for at, axis in enumerate(self._axes)]
        names = [axis.name for axis in self._axes]
        return [dict(zip(names, row, strict=True)) for row in zip(*columns, strict=True)]


def _shares(sampling: Sampling, width: int) -> NDArray[np.float64]:
    """Shares (n, width) of the way through the distributions, in [0, 1)."""
    generator = np.random.default_rng(sampling.seed)
    if sampling.method == "random":
        return generator.random((sampling.count, width))
    # Late: scipy.stats costs more to import than most sweeps to write down.
    from scipy.stats import qmc

    kind = qmc.Sobol if sampling.method == "sobol" else qmc.LatinHypercube
    with warnings.catch_warnings():
        # Sobol's points are best in powers of two; any number of them is still a good spread.
        warnings.filterwarnings("ignore", "The balance properties", UserWarning)
        found: NDArray[np.float64] = _engine(kind, width, generator).random(sampling.count)
    return found


def _engine(kind: Callable[..., Any], width: int, generator: np.random.Generator) -> Any:
    """A sampler; its generator was called `seed` up to SciPy 1.14."""
    try:
        return kind(width, rng=generator)
    except TypeError:
        return kind(width, seed=generator)


FORMAT = 1
"""Format number of the store; another one gives other names of cases."""

DIGITS = 20
"""Hexadecimal digits of a case's name: 80 bits, one collision in 10^12 sweeps of a
million cases."""


class SweepCase(NamedTuple):
    """A case: one deployment of a cohort."""

    number: int
    """Number in the sweep, from 1, patient by patient."""
    id: str
    """Hash of the plan, the parameters, the files, the constraints and the versions."""
    patient: int
    """Index into the sweep's patients."""
    parameters: Parameters


class Cases:
    """The cases of a sweep in order, made when asked for; every patient has the same samples."""

    def __init__(self, sweep: Sweep) -> None:
        self._samples = Samples(sweep.axes, sweep.sampling)
        self._bases = [_base(sweep, patient) for patient in sweep.patients]

    def __len__(self) -> int:
        return len(self._samples) * len(self._bases)

    def __getitem__(self, at: int) -> SweepCase:
        index = range(len(self))[at]
        patient, row = divmod(index, len(self._samples))
        return self._case(index, patient, self._samples[row])

    def __iter__(self) -> Iterator[SweepCase]:
        for patient in range(len(self._bases)):
            first = patient * len(self._samples)
            for index, parameters in enumerate(self._samples, start=first):
                yield self._case(index, patient, parameters)

    def _case(self, index: int, patient: int, parameters: Parameters) -> SweepCase:
        return SweepCase(index + 1, _id(self._bases[patient], parameters), patient, parameters)


def _base(sweep: Sweep, patient: Patient) -> bytes:
    """Everything that the cases of a patient share and that determines their results, without
    paths."""
    plan = patient.plan
    files = [None if file is None else file.sha256 for file in (plan.surface, plan.centerline)]
    shared = {
        "format": FORMAT,
        "sdfstent_version": VERSION,
        "plan": plan_text(replace(plan, surface=None, centerline=None), sweep.folder),
        "files": files,
        "stent": sweep.stent,
        "constraints": asdict(sweep.constraints),
    }
    return json.dumps(shared, sort_keys=True).encode()


def _id(base: bytes, parameters: Parameters) -> str:
    text = json.dumps(plain(parameters), sort_keys=True)
    return hashlib.sha256(base + text.encode()).hexdigest()[:DIGITS]
