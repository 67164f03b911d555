"""Small cohorts that the tests share: stents in a stenosed tube, and in one of twice its size."""

import json
import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from child_processes import PATIENCE, PROJECT
from tube_files import plan_of, write_tube

from SDFStentLib.cohort import sweep_from_document

PLAN = plan_of({"diameter": 6, "length": 10, "placement": {"center": [0, 0, 2]}})


def tube_folder(folder: Path) -> Path:
    """The files of the tube, its centerline and an axis, in cm."""
    write_tube(folder)
    return folder


def document(**changes):
    """The document of a sweep of 6 cases; `changes` replace its parts, None removes one."""
    found = {
        "schema": "sdfstent-sweep",
        "version": 1,
        "plan": PLAN,
        "axes": {"diameter": [6, 6.5, 7], "branch": 1, "distance": [18, 22]},
        **changes,
    }
    return {key: value for key, value in found.items() if value is not None}


def sweep_in(folder: Path, **changes):
    """A sweep over the files of a folder."""
    return sweep_from_document(document(**changes), str(folder))


def write_sweep(folder: Path, name: str = "sweep.json", **changes) -> Path:
    """Write the document of a sweep to a file."""
    path = folder / name
    path.write_text(json.dumps(document(**changes)), encoding="utf-8")
    return path


_HOLDING = """
import os, sys, time
from pathlib import Path

def wait(event, arguments):
    if event == "tempfile.mkdtemp" and "cases" in str(arguments[0]):
        hold = Path(__file__).with_name("hold")
        while True:
            try:
                count = int(hold.read_text(encoding="utf-8"))
            except FileNotFoundError:  # let go; asking first whether it is there would be a race
                break
            whole = hold.with_name("out").glob("cases/*/[!.]*/case.json")
            if len(list(whole)) < count:
                break
            hold.with_name(f"held-{os.getpid()}").touch()
            time.sleep(0.05)

sys.addaudithook(wait)
"""


def hold_at(folder: Path, count: int) -> dict[str, str]:
    """From now on sweeps into `out` store no case after the first `count`, until `let_go`.

    Returns the environment for their processes and workers: Python executes `sitecustomize` first,
    whose audit hook hears of every folder made for a case. So a test need not be fast. A process
    that waits leaves a file `held-PID`.
    """
    (folder / "sitecustomize.py").write_text(_HOLDING, encoding="utf-8")
    part = folder / "hold.part"
    part.write_text(str(count), encoding="utf-8")
    part.replace(folder / "hold")
    return {**os.environ, "PYTHONPATH": f"{folder}{os.pathsep}{PROJECT}", "OMP_NUM_THREADS": "1"}


def let_go(folder: Path) -> None:
    """End what `hold_at` began."""
    (folder / "hold").unlink()


def whole_cases(folder: Path) -> list[Path]:
    """The complete cases of the cohort in `out`."""
    return list((folder / "out").glob("cases/*/[!.]*/case.json"))


def wait_for(condition: Callable[[], Any], seconds: float = PATIENCE) -> None:
    """Wait until a condition is true; a machine may be busy."""
    end = time.monotonic() + seconds
    # Ends after those seconds at the latest.
    while not condition():
        assert time.monotonic() < end, "it did not happen"
        time.sleep(0.02)


def bytes_of(folder: Path) -> dict[str, bytes]:
    """The content of all files of a cohort except those with times, counts and the lock."""
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
        and path.name not in ("times.json", "times.csv", "progress.json", ".sdfstent-lock")
    }
