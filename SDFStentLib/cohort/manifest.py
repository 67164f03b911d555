"""Tables of a cohort: every case with its outcome, and separately its time and place."""

from __future__ import annotations

import csv
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from itertools import islice
from pathlib import Path
from typing import Any

from ..files import atomic_path
from ..stent import InputFile
from ..validation import InputError
from ..version import VERSION
from .axes import label
from .cases import SweepCase
from .store import Store, StoreError
from .value import Sweep

SCHEMA, SCHEMA_VERSION = "sdfstent-cohort", 1
CSV, PARQUET, TIMES_CSV = "manifest.csv", "manifest.parquet", "times.csv"

PARAMETER = "parameter_"
"""Prefix of the column of an axis."""

FIRST = ("case", "patient", "status", "reason")
SAMPLED = ("method", "seed")
LAST = ("surface_sha256", "centerline_sha256", "sdfstent_version")
TEXTS = {*FIRST, "method", *LAST, "name", "device", "branches"}
WHOLE_NUMBERS = {"seed", "stent", "moved_points", "warnings"}
TRUTHS = {"certified"}

TIMES = (
    *("case", "host", "process", "started", "setup_s", "deploy_s", "measure_s", "certify_s"),
    *("total_s", "python", "numpy", "scipy", "vtk"),
)
_BATCH = 10_000
"""Number of rows in memory at a time."""


def cohort_document(sweep: Sweep, cases: Iterable[SweepCase], folder: Path) -> dict[str, Any]:
    """The document of a cohort as JSON values: enough to read its folder without the sweep."""
    return {
        "schema": SCHEMA,
        "version": SCHEMA_VERSION,
        "sdfstent_version": VERSION,
        "store": sweep.store,
        "method": sweep.sampling.method,
        "seed": None if sweep.sampling.method == "grid" else sweep.sampling.seed,
        "axes": [{"name": axis.name, "is_number": axis.is_number} for axis in sweep.axes],
        "patients": [
            {
                "name": patient.name,
                "units": patient.plan.units,
                "surface": _file(patient.plan.surface, folder),
                "centerline": _file(patient.plan.centerline, folder),
            }
            for patient in sweep.patients
        ],
        "cases": [
            [case.id, case.patient, [label(value) for value in case.parameters.values()]]
            for case in cases
        ],
    }


def write_manifest(folder: str | os.PathLike[str]) -> list[str]:
    """Write the tables of a cohort from its cases; missing cases are `open`.

    `manifest.csv` has a row per case and stent, in the order of the sweep, and the same bytes
    however often the sweep was interrupted; `manifest.parquet` is the same where pyarrow is
    installed. `times.csv` has everything that differs from run to run.

    Returns
    -------
    list of str
        The names of the files.

    Raises
    ------
    InputError
        The folder is not that of a cohort.
    StoreError
        The files cannot be written.
    """
    store = Store(folder)
    cohort = store.cohort()
    names = columns_of(store, cohort)
    try:
        _write_csv(store.folder / CSV, names, _rows(store, cohort))
        written = [CSV]
        if _has_pyarrow():
            _write_parquet(store.folder / PARQUET, names, cohort, _rows(store, cohort))
            written.append(PARQUET)
        _write_csv(store.folder / TIMES_CSV, TIMES, _times(store, cohort))
    except InputError as error:
        raise StoreError(str(error)) from error
    return [*written, TIMES_CSV]


def columns_of(store: Store, cohort: Mapping[str, Any]) -> list[str]:
    """Names of the columns; those of a treatment come from the first case that has one."""
    own: Iterable[str] = ()
    for case, _, _ in cohort["cases"]:
        known = store.case(case)
        if known is not None and known["rows"]:
            own = known["rows"][0]
            break
    axes = [PARAMETER + axis["name"] for axis in cohort["axes"]]
    return [*FIRST, *axes, *SAMPLED, *own, *LAST]


def text_columns(cohort: Mapping[str, Any]) -> set[str]:
    """Names of the columns that hold text, even if it looks like numbers."""
    axes = cohort["axes"]
    return TEXTS | {PARAMETER + axis["name"] for axis in axes if not axis["is_number"]}


def _rows(store: Store, cohort: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    axes = [PARAMETER + axis["name"] for axis in cohort["axes"]]
    for case, patient, values in cohort["cases"]:
        person = cohort["patients"][patient]
        common = {
            "case": case,
            "patient": person["name"],
            **dict(zip(axes, values, strict=True)),
            "method": cohort["method"],
            "seed": cohort["seed"],
            **{
                f"{role}_sha256": person[role] and person[role]["sha256"]
                for role in ("surface", "centerline")
            },
            "sdfstent_version": cohort["sdfstent_version"],
        }
        known = store.case(case) or {"status": "open", "reason": "", "rows": []}
        found = {"status": known["status"], "reason": known["reason"]}
        for row in known["rows"] or [{}]:
            yield {**common, **found, **row}


def _times(store: Store, cohort: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    for case, _, _ in cohort["cases"]:
        yield {"case": case, **store.times(case)}


def _write_csv(path: Path, names: Sequence[str], rows: Iterable[Mapping[str, Any]]) -> None:
    with atomic_path(path) as temporary, temporary.open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(names)
        for row in rows:
            table.writerow([_cell(row.get(name)) for name in names])


def _cell(value: Any) -> Any:
    if isinstance(value, bool):
        return "true" if value else "false"
    return "" if value is None else value


def _has_pyarrow() -> bool:
    try:
        import pyarrow.parquet  # noqa: F401
    except ImportError:
        return False
    return True


def _write_parquet(
    path: Path,
    names: Sequence[str],
    cohort: Mapping[str, Any],
    rows: Iterator[Mapping[str, Any]],
) -> None:
    import pyarrow
    from pyarrow import parquet

    texts = text_columns(cohort)
    types = {name: pyarrow.string() for name in texts}
    types |= {name: pyarrow.int64() for name in WHOLE_NUMBERS}
    types |= {name: pyarrow.bool_() for name in TRUTHS}
    schema = pyarrow.schema([(name, types.get(name, pyarrow.float64())) for name in names])
    with atomic_path(path) as temporary, parquet.ParquetWriter(temporary, schema) as writer:
        # Ends: with the rows.
        while batch := list(islice(rows, _BATCH)):
            columns = {
                name: [_typed(row.get(name), name in texts) for row in batch] for name in names
            }
            writer.write_table(pyarrow.table(columns, schema=schema))


def _typed(value: Any, is_text: bool) -> Any:
    """A value as Parquet has it: null if missing, and text in text columns even if
    it is a number."""
    if value is None:
        return None
    if is_text:
        return str(value)
    return None if value == "" else value


def _file(file: InputFile | None, folder: Path) -> dict[str, Any] | None:
    if file is None:
        return None
    path = file.path
    with suppress(ValueError):  # another drive, on Windows
        path = os.path.relpath(path, folder)
    return {"file": Path(path).as_posix(), "sha256": file.sha256}
