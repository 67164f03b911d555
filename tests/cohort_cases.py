"""Small cohorts that the tests share: stents in a stenosed tube, and in its double."""

from __future__ import annotations

import json
from pathlib import Path

from tube_files import write_tube

from SDFStentLib.cohort import sweep_from_document

PLAN = {
    "schema": "sdfstent-plan",
    "version": 2,
    "inputs": {
        "units": "cm",
        "surface": {"file": "tube.vtp"},
        "centerline": {"file": "line.vtp"},
    },
    "stents": [{"diameter": 6, "length": 10, "placement": {"center": [0, 0, 2]}}],
}


def tube_folder(folder: Path) -> Path:
    """The files of the tube, its centerline and an axis, in cm."""
    write_tube(folder)
    return folder


def document(**changes):
    """A sweep of 6 cases; changes replace its parts, None takes them out."""
    found = {
        "schema": "sdfstent-sweep",
        "version": 1,
        "plan": PLAN,
        "axes": {"diameter": [6, 6.5, 7], "branch": 1, "distance": [18, 22]},
        **changes,
    }
    return {key: value for key, value in found.items() if value is not None}


def sweep_in(folder: Path, **changes):
    """A sweep on the files of a folder."""
    return sweep_from_document(document(**changes), str(folder))


def write_sweep(folder: Path, name: str = "sweep.json", **changes) -> Path:
    """The document of a sweep as a file."""
    path = folder / name
    path.write_text(json.dumps(document(**changes)), encoding="utf-8")
    return path


def bytes_of(folder: Path) -> dict[str, bytes]:
    """All files of a cohort but those that hold times, counts and the lock."""
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
        and path.name not in ("times.json", "times.csv", "progress.json", ".sdfstent-lock")
    }
