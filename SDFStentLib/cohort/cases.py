"""The cases of a sweep, each with a name that follows from what determines its result."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from dataclasses import asdict, replace
from typing import NamedTuple

from ..plan import plan_text
from ..version import VERSION
from .axes import plain
from .sampling import Parameters, Samples
from .value import Patient, Sweep

FORMAT = 1
"""Of the store; another one gives other cases."""

DIGITS = 20
"""Of a case's name, hexadecimal: 80 bits, one double name in 10^12 sweeps of a million cases."""


class Case(NamedTuple):
    """One deployment of a cohort."""

    number: int
    """In the sweep, from 1: patient by patient."""
    id: str
    """A hash of the plan, the parameters, the files, the constraints and the versions."""
    patient: int
    """Index into the sweep's patients."""
    parameters: Parameters


class Cases:
    """All cases of a sweep in order, made when asked for: every patient has the same samples."""

    def __init__(self, sweep: Sweep) -> None:
        self._samples = Samples(sweep.axes, sweep.sampling)
        self._bases = [_base(sweep, patient) for patient in sweep.patients]

    def __len__(self) -> int:
        return len(self._samples) * len(self._bases)

    def __getitem__(self, at: int) -> Case:
        index = range(len(self))[at]
        patient, row = divmod(index, len(self._samples))
        return self._case(index, patient, self._samples[row])

    def __iter__(self) -> Iterator[Case]:
        for patient in range(len(self._bases)):
            first = patient * len(self._samples)
            for index, parameters in enumerate(self._samples, start=first):
                yield self._case(index, patient, parameters)

    def _case(self, index: int, patient: int, parameters: Parameters) -> Case:
        return Case(index + 1, _id(self._bases[patient], parameters), patient, parameters)


def _base(sweep: Sweep, patient: Patient) -> bytes:
    """All that the cases of a patient share and that determines their results; no path."""
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
