"""What is costly and comes out the same each time is made once per process: vessels, pictures."""

from __future__ import annotations

import inspect
import subprocess
from collections.abc import Callable, Sequence
from functools import lru_cache, wraps
from hashlib import sha256
from types import SimpleNamespace

import pytest

from SDFStentLib import phantoms
from SDFStentLib.phantoms import phantoms as makers
from SDFStentLib.report.picture import painting


def made_once(make: Callable[..., phantoms.Phantom]) -> Callable[..., phantoms.Phantom]:
    """The same call gives the same phantom, which nobody can change: some take a second."""
    known = lru_cache(maxsize=None, typed=True)(make)

    @wraps(make)
    def once(*arguments, **named):
        try:
            hash((arguments, tuple(named.values())))
        except TypeError:
            return make(*arguments, **named)
        return known(*arguments, **named)

    return once


def painted_once() -> Callable[..., subprocess.CompletedProcess]:
    """Runs a painter of its own for every picture, but none for one that there was already."""
    known = {}

    def run(arguments: Sequence[str], *, input: bytes, **named):
        key = (*arguments, sha256(input).digest())
        done = known.get(key) or subprocess.run(arguments, input=input, **named)
        if done.returncode == 0:
            known[key] = done
        return done

    return run


LONGEST = (
    "test_app_page", "test_documented_commands", "test_sweep_faults", "test_extract_command",
    "test_cli", "test_panel_looks", "test_panel_device", "test_segments", "test_panel",
    "test_unexpected_errors", "test_sweep_clusters", "test_long_inputs", "test_outside_judges",
    "test_panel_exports", "test_ostia", "test_logic", "test_memory", "test_compare", "test_cohorts",
    "test_dragging_in_trees", "test_balloons", "test_panel_flow", "test_lesions",
    "test_event_steps",
)  # fmt: skip
"""Files that take longest go first, so that at the end no process waits for another."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    rank = {name: number for number, name in enumerate(LONGEST)}
    items.sort(key=lambda item: rank.get(item.path.stem, len(LONGEST)))


# Before the test files import them.
for name, maker in inspect.getmembers(phantoms, inspect.isfunction):
    once = made_once(maker)
    for module in (phantoms, makers):
        if hasattr(module, name):
            setattr(module, name, once)
painting.subprocess = SimpleNamespace(run=painted_once(), TimeoutExpired=subprocess.TimeoutExpired)
