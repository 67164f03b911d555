"""A case in a worker: read the patient unless that was the last one, deploy, measure, write."""

from __future__ import annotations

import gzip
import json
import math
import os
import platform
import threading
from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import replace
from datetime import datetime, timezone
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from time import perf_counter
from typing import Any, NamedTuple

from ..plan import InputFiles, Plan, PlanResult, plan_text, read_plan_inputs, treatment_of
from ..report import flow_columns, flow_section, no_views, plan_report, stent_rows
from ..units import reason_of
from ..validation import DeploymentError, InputError
from ..version import VERSION
from .axes import label
from .cases import SweepCase
from .constraints import Constraints, Excluded
from .moved import encoded
from .store import REPORT, SURFACES, Store
from .value import Sweep
from .varied import plan_of_case
from .watch import begin

NO_VIEWS = "A sweep tells views only where its plan has `views`."
"""Reason for a report without views."""

KEPT = 2
"""Number of patients whose vessels a worker keeps: cases come patient by patient."""


class Task(NamedTuple):
    """A case with all that a worker needs to know."""

    case: SweepCase
    patient: str
    plan: Plan
    """The patient's base plan."""
    stent: int
    constraints: Constraints
    surface: str
    """Way to store the surface: `vtp` or `moved`."""
    folder: str
    """Folder of the store."""


def task_of(sweep: Sweep, case: SweepCase, store: Store) -> Task:
    """The task of carrying out a case of a sweep."""
    patient, folder = sweep.patients[case.patient], os.fspath(store.folder)
    return Task(
        case, patient.name, patient.plan, sweep.stent, sweep.constraints, sweep.store, folder
    )


class Outcome(NamedTuple):
    """The outcome of a case; everything else is in the store."""

    id: str
    status: str
    """`done`, `excluded` or `failed`."""
    certified: bool | None = None
    reason: str = ""
    """Reason why it is not done, or not certified."""


def run_case(task: Task) -> Outcome:
    """Carry out a case and put it into the store.

    Raises
    ------
    StoreError
        The store cannot be written. Any other error is the outcome of the case.
    """
    begin(task.case.id)
    clock, started = perf_counter(), datetime.now(timezone.utc)
    store = Store(task.folder)
    result: PlanResult | None = None
    status, reason, report = "done", "", b""
    try:
        inputs = _inputs_of(task.plan)
        result = _carried_out(task, inputs)
        report = _report(result, task.plan)
        certificate = result.treatment.certificate
        if certificate is not None and not certificate.passed:
            reason = certificate.sentence(inputs.surface.units)
    except Excluded as error:
        status, reason = "excluded", str(error)
    except (InputError, DeploymentError) as error:
        result = None
        status, reason = "failed", reason_of(error, task.plan.units)
    except Exception as error:  # of whatever kind, the other cases go on
        result = None
        status, reason = "failed", f"unexpected error ({type(error).__name__}: {error})"
    reason = _without_folders(reason, task.plan)
    seconds = {} if result is None else dict(result.treatment.timings)
    with store.writing(task.case.id) as folder:
        if result is not None:
            _write_surface(result, folder, task.surface)
            (folder / REPORT).write_bytes(report)
        times = _times(started, seconds, perf_counter() - clock)
        store.write_case(folder, _known(task, status, reason, result), times)
    certified = None if result is None or result.treatment.certificate is None else not reason
    return Outcome(task.case.id, status, certified, reason)


def write_failure(store: Store, task: Task, reason: str) -> Outcome:
    """Write a case that no worker survived into the store."""
    with store.writing(task.case.id) as folder:
        times = _times(datetime.now(timezone.utc), {}, 0.0)
        store.write_case(folder, _known(task, "failed", reason, None), times)
    return Outcome(task.case.id, "failed")


def _carried_out(task: Task, inputs: InputFiles) -> PlanResult:
    plan = plan_of_case(task.plan, task.stent, task.case.parameters, task.constraints, inputs)
    return PlanResult(plan, inputs, treatment_of(plan, inputs).result)


_lock = threading.Lock()
_patients: OrderedDict[str, InputFiles | InputError] = OrderedDict()


def _inputs_of(plan: Plan) -> InputFiles:
    """The files of a plan, read once for as long as its patient is swept; a failure
    is kept, too."""
    key = plan_text(replace(plan, stents=()))
    with _lock:  # threads of one worker wait rather than read twice
        if key not in _patients:
            try:
                _patients[key] = read = read_plan_inputs(plan)
                _ = read.vessel.lesions
                if plan.flow is not None and read.vessel.centerline is not None:
                    _ = read.vessel.channels
            except InputError as error:
                _patients[key] = error
            if len(_patients) > KEPT:
                _patients.popitem(last=False)
        found = _patients[key]
    if isinstance(found, InputError):
        raise InputError(str(found))
    return found


def _known(task: Task, status: str, reason: str, result: PlanResult | None) -> dict[str, Any]:
    """The record of a case that the manifest is made from, without times."""
    rows = [] if result is None else _rows(result)
    parameters = {name: label(value) for name, value in task.case.parameters.items()}
    return {
        "case": task.case.id,
        "patient": task.patient,
        "parameters": parameters,
        "status": status,
        "reason": reason,
        "sdfstent_version": VERSION,
        "rows": rows,
    }


def _rows(result: PlanResult) -> list[dict[str, Any]]:
    """A row for each stent, with the flow if the plan has it."""
    counts = {"warnings": len(result.warnings) + len(result.size_warnings)}
    rows = [_row(row) | counts for row in stent_rows(result.told)]
    if result.flow is None:
        return rows
    flow = flow_section(result.flow)
    return [row | _row(flow_columns(flow, row["stent"])) for row in rows]


def _row(row: Mapping[str, Any]) -> dict[str, Any]:
    """A row without times, with null where a number is not known."""
    return {
        name: None if isinstance(value, float) and not math.isfinite(value) else value
        for name, value in row.items()
        if not name.endswith("_s")
    }


def _write_surface(result: PlanResult, folder: Path, kind: str) -> None:
    treatment, path = result.treatment, folder / SURFACES[kind]
    if kind == "vtp":
        result.write_surface(path)
    else:
        surface = result.inputs.surface
        path.write_bytes(encoded(surface, treatment.indices, treatment.coordinates))


def _report(result: PlanResult, plan: Plan) -> bytes:
    """The report without anything that differs from run to run, and with the views of a plan that
    asks for some: in others they would take a share of every case for what few look at."""
    views = no_views(plan.views, NO_VIEWS) if plan.views is None else None
    report = plan_report(result, views=views).as_dict()
    del report["created"], report["timings"]
    text = _without_folders(json.dumps(report, ensure_ascii=False, allow_nan=False), plan)
    return gzip.compress(text.encode("utf-8", "backslashreplace"), mtime=0)


def _without_folders(text: str, plan: Plan) -> str:
    """A text with only the names of the patient's files: where these lie changes no result."""
    for file in (plan.surface, plan.centerline, *(stent.axis_file for stent in plan.stents)):
        if file is not None:
            for path in (file.path, json.dumps(file.path)[1:-1]):
                text = text.replace(path, os.path.basename(file.path))
    return text


def _times(started: datetime, seconds: Mapping[str, float], total: float) -> dict[str, Any]:
    return {
        "host": platform.node(),
        "process": os.getpid(),
        "started": started.isoformat(timespec="milliseconds"),
        **{f"{name}_s": round(value, 6) for name, value in seconds.items()},
        "total_s": round(total, 6),
        **_versions(),
    }


@cache
def _versions() -> dict[str, str]:
    found = {"python": platform.python_version()}
    for name in ("numpy", "scipy", "vtk"):
        try:
            found[name] = version(name)
        except PackageNotFoundError:  # an application's own, such as Slicer's vtk
            found[name] = ""
    return found
