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
from .sampling import Parameters, samples
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


def cases_of(sweep: Sweep) -> Iterator[Case]:
    """All cases in order: every patient has the same samples."""
    rows = samples(sweep.axes, sweep.sampling)
    number = 0
    for patient, one in enumerate(sweep.patients):
        base = _base(sweep, one)
        for parameters in rows:
            number += 1
            yield Case(number, _id(base, parameters), patient, parameters)


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
