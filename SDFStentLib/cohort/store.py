"""The store of cases: a folder for each case that appears whole or not at all.

```
DIR/cohort.json            what the cohort is: patients, axes, every case
DIR/manifest.csv           a row per case and stent; .parquet where pyarrow is installed
DIR/times.csv              when, where and how long
DIR/cases/3f/3fa9.../      case.json, report.json.gz, surface.vtp or moved.npz, times.json
```
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import shutil
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from ..files import cannot_write, flush_to_disk, write_bytes
from ..validation import DeploymentError, InputError
from .lock import lock

CASE, TIMES, REPORT = "case.json", "times.json", "report.json.gz"
SURFACES = {"vtp": "surface.vtp", "moved": "moved.npz"}
COHORT, PROGRESS = "cohort.json", "progress.json"
WHOLE = ("done", "excluded")
"""Statuses of a case that need not be done again."""

_NAME = re.compile("[0-9a-f]{20}")
"""Name of a case, and of its folder, which is removed before the case is done again."""

_LOOKS, _LOOK = 4, 0.1
"""Number of attempts at the lock, and pause between them, s: a status query holds it
for a moment."""

_LOCK, _PREFIX = ".sdfstent-lock", ".sdfstent-"


class StoreError(DeploymentError):
    """Failure to write the store, without which no case can go on."""


class Store:
    """The folder of a cohort.

    Parameters
    ----------
    folder : path
    """

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        self.folder = Path(os.path.abspath(folder))

    def path(self, case: str) -> Path:
        """The folder of a case; it lies in one of 256 folders, so that each of these
        stays small."""
        return self.folder / "cases" / case[:2] / case

    @contextmanager
    def locked(self) -> Iterator[None]:
        """Hold the lock of the store: only one sweep at a time writes; it ends with its process.

        Raises
        ------
        InputError
            Another sweep is running here, or the folder cannot be written.
        """
        try:
            self.folder.mkdir(exist_ok=True)
            descriptor = os.open(self.folder / _LOCK, os.O_CREAT | os.O_RDWR, 0o600)
        except OSError as error:
            raise cannot_write(self.folder, error) from error
        try:
            if not _taken_soon(descriptor):
                raise InputError(
                    f"{self.folder}: expected a folder where no sweep is running, another one "
                    "is; wait for it, or name another folder."
                )
            yield
        finally:
            os.close(descriptor)

    def is_running(self) -> bool:
        """Whether a sweep is at work here."""
        try:
            descriptor = os.open(self.folder / _LOCK, os.O_RDWR)
        except OSError:
            return False
        try:
            return not _taken(descriptor)
        finally:
            os.close(descriptor)

    def case(self, case: str) -> dict[str, Any] | None:
        """The record of a case; None if it is missing or not whole.

        Its files have to be there in the size in which they were written.
        """
        folder = self.path(case)
        try:
            found: dict[str, Any] = json.loads((folder / CASE).read_text(encoding="utf-8"))
            for name, (size, _) in found["files"].items():
                if (folder / name).stat().st_size != size:
                    return None
            return found if _is_case(found) else None
        except (OSError, ValueError, KeyError, TypeError, AttributeError):
            return None

    def is_whole(self, case: str) -> bool:
        """Whether a case need not be done again."""
        known = self.case(case)
        return known is not None and known["status"] in WHOLE

    def remove(self, case: str) -> None:
        """Remove a case."""
        shutil.rmtree(self.path(case), ignore_errors=True)

    def times(self, case: str) -> dict[str, Any]:
        """Time and place at which a case was done; empty if not known."""
        try:
            found = json.loads((self.path(case) / TIMES).read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return {}
        return found if isinstance(found, dict) else {}

    def data(self, case: str, name: str) -> bytes:
        """The bytes of a file of a case; `InputError` if it is missing or damaged."""
        known = self.case(case)
        if known is None or name not in known["files"]:
            raise InputError(f"case {case}: expected a file {name}, there is none; run it again.")
        data = (self.path(case) / name).read_bytes()
        if hashlib.sha256(data).hexdigest() != known["files"][name][1]:
            raise InputError(f"case {case}: {name} is damaged; remove its folder, run it again.")
        return data

    @contextmanager
    def writing(self, case: str) -> Iterator[Path]:
        """A folder into which the files of a case are written; it then takes its place as a whole.

        If a case is done twice, the second result is dropped: the bytes are the same.

        Raises
        ------
        StoreError
            The case cannot be written, as on a full disk; nothing of it is left.
        """
        target = self.path(case)
        temporary: Path | None = None
        try:
            target.parent.mkdir(parents=True, exist_ok=True)
            temporary = Path(tempfile.mkdtemp(prefix=_PREFIX, dir=target.parent))
            os.chmod(temporary, 0o777 & ~_umask())
            yield temporary
            for path in temporary.iterdir():
                flush_to_disk(path)
            self._put(temporary, target, case)
        except (OSError, InputError) as error:
            raise _stopped(self.folder, error) from error
        finally:
            if temporary is not None:
                shutil.rmtree(temporary, ignore_errors=True)

    def write_case(self, folder: Path, known: Mapping[str, Any], times: Mapping[str, Any]) -> None:
        """Write the record of a case, with size and hash of the files in its folder."""
        files = {path.name: path.read_bytes() for path in sorted(folder.iterdir())}
        sums = {name: [len(data), hashlib.sha256(data).hexdigest()] for name, data in files.items()}
        (folder / CASE).write_bytes(as_json({**known, "files": sums}))
        (folder / TIMES).write_bytes(as_json(times))

    def write(self, name: str, data: bytes) -> None:
        """Write a file of the whole cohort; `StoreError` if it cannot be written."""
        try:
            write_bytes(self.folder / name, data)
        except InputError as error:
            raise _stopped(self.folder, error) from error

    def read(self, name: str) -> Any:
        """A document of the whole cohort.

        Raises
        ------
        InputError
            There is none, or it is damaged.
        """
        path = self.folder / name
        try:
            return json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise InputError(
                f"{self.folder}: expected the folder of a cohort, got one without {name} that can "
                "be read; name the folder that `sdfstent sweep -o` has written."
            ) from error

    def cohort(self) -> dict[str, Any]:
        """The document of the whole cohort.

        Raises
        ------
        InputError
            There is none, or it is not that of a cohort.
        """
        found: dict[str, Any] = self.read(COHORT)
        try:
            is_one = all(_fits(found))
        except (KeyError, TypeError, ValueError):
            is_one = False
        if not is_one:
            raise InputError(
                f"{self.folder}: expected the folder of a cohort, got one whose {COHORT} is none "
                "of a cohort; name the folder that `sdfstent sweep -o` has written."
            )
        return found

    def clear_leftovers(self) -> None:
        """Remove what killed workers have left half written; only to be called under the lock."""
        for path in self.folder.glob(f"cases/*/{_PREFIX}*"):
            shutil.rmtree(path, ignore_errors=True)

    def _put(self, temporary: Path, target: Path, case: str) -> None:
        try:
            os.rename(temporary, target)
        except OSError:
            if self.is_whole(case):
                return
            self.remove(case)
            os.rename(temporary, target)
        with suppress(OSError):  # folders cannot be flushed everywhere
            flush_to_disk(target.parent)


def _is_case(found: Mapping[str, Any]) -> bool:
    """Whether the record of a case is complete."""
    rows = found["rows"]
    return (
        isinstance(found["status"], str)
        and isinstance(found["reason"], str)
        and isinstance(rows, list)
        and all(isinstance(row, dict) for row in rows)
        and not (rows and rows[0].get("certified", "") not in (True, False, None, ""))
    )


def _fits(cohort: Mapping[str, Any]) -> Iterator[bool]:
    """Whether each thing that the tables need is in the document of a cohort, one by one."""
    axes, patients = cohort["axes"], cohort["patients"]
    for text in (cohort["method"], cohort["sdfstent_version"], cohort["store"]):
        yield isinstance(text, str)
    yield cohort["seed"] is None or isinstance(cohort["seed"], int)
    for axis in axes:
        yield isinstance(axis["name"], str) and isinstance(axis["is_number"], bool)
    for patient in patients:
        yield isinstance(patient["name"], str) and isinstance(patient["units"], str)
        for file in (patient["surface"], patient["centerline"]):
            yield file is None or (isinstance(file["file"], str) and "sha256" in file)
    for name, patient, values in cohort["cases"]:
        yield _NAME.fullmatch(name) is not None
        yield patient in range(len(patients)) and len(values) == len(axes)


def as_json(value: Any) -> bytes:
    """A line of JSON, always the same for the same values."""
    return json.dumps(value, sort_keys=True, ensure_ascii=False, allow_nan=False).encode() + b"\n"


def _taken(descriptor: int) -> bool:
    try:
        lock(descriptor, waits=False)
    except OSError:
        return False
    return True


def _taken_soon(descriptor: int) -> bool:
    for _ in range(_LOOKS):
        if _taken(descriptor):
            return True
        time.sleep(_LOOK)
    return False


def _stopped(folder: Path, error: Exception) -> StoreError:
    if isinstance(error, StoreError):
        return error
    if isinstance(error, OSError):
        error = cannot_write(folder, error)
    return StoreError(str(error))


def _umask() -> int:
    found = os.umask(0o022)
    os.umask(found)
    return found
