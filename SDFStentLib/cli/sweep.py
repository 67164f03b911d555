"""The command `sweep`."""

from __future__ import annotations

import argparse
import json
import logging
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from itertools import islice
from multiprocessing import active_children
from threading import Timer

from ..cohort import (
    Cases,
    Sweep,
    Tally,
    duration_in_words,
    estimated,
    last_tally,
    load_sweep,
    run_sweep,
    worker_count,
    write_manifest,
)
from ..validation import DeploymentError, InputError, as_number
from .console import Console, error_line, ignored
from .signals import INTERRUPTED, at_second_signal

DONE, NOT_CERTIFIED, INCOMPLETE = 0, 3, 4

SILENCE = 60.0
"""Time without a finished case, s, before a report of it, which repeats after twice the time."""

LAST_SECONDS = 2.0
"""Time, s, until the process ends after a second interruption."""

SHOWN = 5
"""Number of cases that a dry run lists."""


def sweep_command(options: argparse.Namespace, console: Console) -> int:
    """Carry out a sweep, or report about one."""
    asked = [name for name in ("sweep", "table", "status") if getattr(options, name)]
    if len(asked) != 1:
        raise InputError("expected one of SWEEP, --table DIR and --status DIR; give one of them.")
    if options.table:
        written = write_manifest(options.table)
        console.say(f"Wrote {', '.join(written)} in {options.table}.")
        return DONE
    if options.status:
        tally, is_running = last_tally(options.status)
        console.say(_status(tally, is_running))
        return DONE
    if options.workers is not None and options.scheduler is not None:
        raise InputError("expected --workers or --scheduler, got both; leave one of them out.")
    sweep = load_sweep(options.sweep)
    if options.time_limit is not None:
        limit = as_number(options.time_limit, "--time-limit", unit="s", above=0)
        sweep = replace(sweep, time_limit=limit)
    if options.dry_run:
        return _dry_run(sweep, options, console)
    if options.output is None:
        raise InputError("expected -o DIR, the folder of the cohort, got none; add it.")
    return _run(sweep, options, console)


def _run(sweep: Sweep, options: argparse.Namespace, console: Console) -> int:
    watcher = _Watcher(console)
    try:
        with (
            console.progress("Sweeping") as draw,
            at_second_signal(_end_soon),
            _logs(options.debug),
        ):
            watcher.draw = draw
            tally = run_sweep(
                sweep,
                options.output,
                workers=options.workers,
                executor=options.scheduler,
                progress=watcher.show,
            )
    except KeyboardInterrupt:
        error_line(
            f"sdfstent: interrupted; {watcher.kept()} in {options.output}, run it again to go on."
        )
        return INTERRUPTED
    except DeploymentError as error:
        error_line(f"sdfstent sweep: {error}")
        return INCOMPLETE
    console.say(_counts(tally))
    console.say(f"Wrote {options.output} in {duration_in_words(tally.seconds)}.")
    if tally.failed:
        return INCOMPLETE
    return NOT_CERTIFIED if tally.uncertified or tally.unready else DONE


class _Watcher:
    """Shows the progress of a sweep, and warns when no case is finished for long."""

    def __init__(self, console: Console) -> None:
        self.console, self.draw = console, ignored
        self.tally: Tally | None = None
        self._since, self._said = 0.0, SILENCE

    def show(self, now: Tally) -> None:
        """Take the counts, which come twice a second."""
        if self.tally is None or now.finished != self.tally.finished:
            self._since, self._said = now.seconds, SILENCE
        self.tally = now
        self.draw(now.fraction, now.note())
        silent = now.seconds - self._since
        if silent >= self._said and not now.lacks_workers:
            self._said = 2 * silent
            self.console.complain(
                f"no case has come back for {duration_in_words(silent)}; a worker may not answer. "
                "Wait, or end the sweep by Ctrl-C, twice if need be: what is whole is kept. With "
                "--time-limit S cases that take longer are given up."
            )

    def kept(self) -> str:
        """Words for the rest of an interrupted sweep."""
        if self.tally is None:
            return "what was whole before is kept"
        return f"{self.tally.finished} of {self.tally.total} cases are kept"


@contextmanager
def _logs(are_shown: bool) -> Iterator[None]:
    """Mute the logs of packages: those of a cluster print tracebacks where one sentence will do."""
    logging.disable(logging.NOTSET if are_shown else logging.CRITICAL)
    try:
        yield
    finally:
        logging.disable(logging.NOTSET)


def _end_soon() -> None:
    """Kill the workers at a second interruption, and end soon even if tables are still written."""
    for child in active_children():
        child.kill()
    timer = Timer(LAST_SECONDS, _end_now)
    timer.daemon = True
    timer.start()


def _end_now() -> None:
    os.write(2, b"sdfstent: ended; what is whole is kept, run it again to go on.\n")
    os._exit(INTERRUPTED)


def _counts(tally: Tally) -> str:
    parts = tally.verdicts
    for count, words in (
        (tally.unjudged, "not judged, as the plan says"),
        (tally.excluded, "excluded by the constraints"),
        (tally.failed, "failed, the manifest says why"),
    ):
        if count:
            parts.append(f"{count} {words}")
    return f"{tally.finished} of {tally.total} cases: {', '.join(parts)}."


def _status(tally: Tally, is_running: bool) -> str:
    counts = _counts(tally)
    if not is_running:
        open_cases = tally.total - tally.finished
        return f"Finished: {counts}" if not open_cases else f"Stopped: {counts}"
    if tally.lacks_workers:
        return f"Running: {counts} The cluster has no workers: they are waited for."
    if tally.seconds_left is None:
        return f"Running: {counts}"
    return f"Running: {counts} About {duration_in_words(tally.seconds_left)} left."


def _dry_run(sweep: Sweep, options: argparse.Namespace, console: Console) -> int:
    cases = Cases(sweep)
    console.say(f"{len(cases)} cases, {len(sweep.patients)} patient(s).")
    for case in islice(cases, SHOWN):
        values = json.dumps(case.parameters, ensure_ascii=False)
        console.say(f"{case.number}: {case.id} {sweep.patients[case.patient].name} {values}")
    with console.progress("Trying") as _:
        found = estimated(sweep, cases)
    failed = f", {found.failed} of which failed" if found.failed else ""
    console.say(
        f"By {found.tried} cases carried out now{failed}: {found.case_seconds:.2f} s and "
        f"{found.case_bytes / 1e3:.0f} kB a case."
    )
    disk = found.case_bytes * len(cases) / 1e6
    if options.scheduler is not None:
        console.say(f"About {disk:.0f} MB of disk; the time depends on the cluster.")
        return DONE
    workers = worker_count(options.workers)
    seconds = found.seconds(len(cases), len(sweep.patients), workers)
    console.say(
        f"About {duration_in_words(seconds)} on {workers} process(es), {disk:.0f} MB of disk."
    )
    return DONE
