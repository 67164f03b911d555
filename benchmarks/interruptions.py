"""Kills, double Ctrl-C and SIGTERM at random moments of a deployment with six outputs.

    python -m benchmarks.interruptions [--quick]

Every output exists before, with the text "old". A process, forked after the imports, deploys over
them and gets its signals at a random moment, three times of four while outputs are written. Then
another run writes other outputs to the same folders. After that either all six have the old text
or all are new, and no `.sdfstent-*` is left. Needs `fork`.
"""

from __future__ import annotations

import contextlib
import io
import os
import random
import signal
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import numpy as np

from SDFStentLib import Treatment, run_plan, write_surface  # noqa: F401  # before the forks
from SDFStentLib.__main__ import main
from SDFStentLib.files import encode_vtp, polydata_from_arrays, polydata_from_lines
from SDFStentLib.phantoms import straight_tube

from .common import Found, markdown, progress, run_alone

COUNTS = {"kill": 200, "double_interrupt": 100, "terminate": 100}
SIGNALS = {
    "kill": [signal.SIGKILL],
    "double_interrupt": [signal.SIGINT, signal.SIGINT],
    "terminate": [signal.SIGTERM],
}
SPREAD_S = 0.02  # between the two signals of a double interrupt, at most


def arguments(folder: Path, prefix: str) -> list[str]:
    """A deployment that writes into the folders a and b, and a folder of steps."""
    a, b = folder / "a", folder / "b"
    return [
        "deploy", str(folder / "tube.vtp"), "--centerline", str(folder / "line.vtp"),
        "--center", "0", "0", "20", "--length", "10", "--diameter", "11", "--step", "0.5",
        "-o", str(a / f"{prefix}out.vtp"), "--output-centerline", str(a / f"{prefix}line.vtp"),
        "--report", str(b / f"{prefix}report.html"), "--report", str(a / f"{prefix}report.json"),
        "--save-plan", str(a / f"{prefix}plan.json"), "--steps", str(b / f"{prefix}steps"),
        "--quiet",
    ]  # fmt: skip


def outputs_of(folder: Path) -> list[Path]:
    """The places of all outputs; of the steps, the folder."""
    names = arguments(folder, "")
    keys = ("-o", "--output-centerline", "--report", "--save-plan", "--steps")
    return [Path(names[at + 1]) for at, word in enumerate(names) if word in keys]


def prepare(folder: Path) -> None:
    """The inputs, and old outputs at every place."""
    for path in outputs_of(folder):
        path.parent.mkdir(exist_ok=True)
        if path.name == "steps":
            path.mkdir(exist_ok=True)
            for step in path.iterdir():
                step.unlink()
            path = path / "step_0000.vtp"
        path.write_text("old", encoding="utf-8")


def state_of(folder: Path) -> str:
    """ "old" or "new" where all outputs agree; otherwise what each is."""
    states = []
    for path in outputs_of(folder):
        if path.name == "steps":
            steps = sorted(path.glob("*")) if path.is_dir() else []
            states.append(_state(steps[0]) if steps else "lost")
        else:
            states.append(_state(path))
    left = [path.name for path in folder.rglob(".sdfstent-*")]
    text = states[0] if len(set(states)) == 1 and states[0] != "lost" else f"mixed {states}"
    return text + (f", left {left}" if left else "")


def _state(path: Path) -> str:
    if not path.exists():
        return "lost"
    data = path.read_bytes()
    whole = data.rstrip().endswith((b"</VTKFile>", b"}", b"</html>"))
    return "old" if data == b"old" else "new" if whole else "cut"


def forked(folder: Path, prefix: str) -> int:
    """Deploy in a child process; its id."""
    pid = os.fork()
    if pid:
        return pid
    with contextlib.suppress(BaseException):
        signal.signal(signal.SIGINT, signal.default_int_handler)
        sys.stdout = sys.stderr = io.StringIO()
        sys.argv = ["sdfstent", *arguments(folder, prefix)]
        os._exit(main())
    os._exit(99)


def wait_for_writing(folder: Path, pid: int) -> None:
    """Until the first staging folder is there, or the process has ended."""
    while not any((folder / "a").glob(".sdfstent-*")):
        with contextlib.suppress(ChildProcessError):
            if os.waitid(os.P_PID, pid, os.WEXITED | os.WNOHANG | os.WNOWAIT):
                return
        time.sleep(0.0005)


def trial(
    folder: Path, kind: str, delay: float, at_writing: bool, dice: random.Random
) -> tuple[str, int]:
    """One deployment that is disturbed; the state after the next run, and how the first ended."""
    prepare(folder)
    pid = forked(folder, "")
    if at_writing:
        wait_for_writing(folder, pid)
    time.sleep(delay)
    for number in SIGNALS[kind]:
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, number)
        time.sleep(dice.random() * SPREAD_S)
    code = os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
    os.waitpid(forked(folder, "other-"), 0)
    return state_of(folder), code


def measured(quick: bool, _largest: int | None = None) -> Found:
    """For every kind of signal: how many ended with the old, the new, another state."""
    dice = random.Random(11)
    found: Found = {"bad": []}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        tube = straight_tube(radius=5.0, length=40.0, edge_length=1.0)
        surface = polydata_from_arrays(tube.points, tube.triangles)
        (folder / "tube.vtp").write_bytes(encode_vtp(surface))
        line = np.array([[0, 0, z] for z in np.linspace(0, 40, 41)])
        (folder / "line.vtp").write_bytes(encode_vtp(polydata_from_lines(line, [np.arange(41)])))
        prepare(folder)
        start = time.perf_counter()
        pid = forked(folder, "")
        wait_for_writing(folder, pid)
        computed = time.perf_counter() - start
        code = os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
        whole = time.perf_counter() - start
        if code or state_of(folder) != "new":
            raise RuntimeError(f"the deployment itself fails: {code}, {state_of(folder)}")
        for kind, count in COUNTS.items():
            states: Counter[str] = Counter()
            for number in range(6 if quick else count):
                progress(f"{kind} {number}")
                # Three of four while outputs are written, or shortly after.
                at_writing = number % 4 > 0
                delay = dice.uniform(0, 1.2 * (whole - computed) if at_writing else whole)
                state, code = trial(folder, kind, delay, at_writing, dice)
                states[state] += 1
                wanted = {"old": (130, -9), "new": (0, -9)}.get(state, ())
                if code not in wanted:
                    found["bad"].append([kind, number, state, code])
            found[kind] = dict(states)
    found |= {"whole_s": round(whole, 3), "writing_s": round(whole - computed, 3)}
    return found


def table(found: Found) -> str:
    """A row for every kind of signal."""
    rows = [[kind, found[kind].get("old", 0), found[kind].get("new", 0)] for kind in COUNTS]
    text = markdown(("signal", "old state", "new state"), rows)
    return f"{text}\n\nother ends: {len(found['bad'])}"


if __name__ == "__main__":
    run_alone(__doc__, measured, table)
