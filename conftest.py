"""What is costly and comes out the same each time is made once per process, pictures where seen."""

from __future__ import annotations

import inspect
import pickle
import subprocess
from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache, wraps
from hashlib import sha256
from struct import pack
from types import SimpleNamespace
from typing import Any
from zlib import compress, crc32

import pytest

from SDFStentLib import phantoms
from SDFStentLib.phantoms import phantoms as makers
from SDFStentLib.report.picture import painting
from SDFStentLib.report.picture.drawing import Drawing

Done = subprocess.CompletedProcess
PAINTER = painting.PROGRAM
PAINTED: dict[tuple, Done] = {}


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


def blank(drawing: Drawing, seed: bytes) -> bytes:
    """A white PNG of its size, which is another one for another picture."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return pack(">I", len(data)) + kind + data + pack(">I", crc32(kind + data))

    size = pack(">2I5B", drawing.width, drawing.height, 1, 0, 0, 0, 0)
    rows = compress((b"\0" + b"\xff" * ((drawing.width + 7) // 8)) * drawing.height)
    chunks = ((b"IHDR", size), (b"tEXt", b"of\0" + seed.hex().encode()), (b"IDAT", rows))
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunk(*one) for one in (*chunks, (b"IEND", b"")))


def painted_once(arguments: Sequence[str], *, input: bytes, **named: Any) -> Done:
    """Runs a painter of its own for every picture, but none for one that there was already."""
    key = (*arguments, sha256(input).digest())
    done = PAINTED.get(key) or subprocess.run(arguments, input=input, **named)
    if done.returncode == 0:
        PAINTED[key] = done
    return done


def left_blank(arguments: Sequence[str], *, input: bytes, **named: Any) -> Done:
    """Runs no painter, unless a test has put another program in its place."""
    if arguments[2] != PAINTER:
        return subprocess.run(arguments, input=input, **named)
    drawing, _ = pickle.loads(input)
    return Done(arguments, 0, blank(drawing, sha256(input).digest()), b"")


@pytest.fixture(scope="module", autouse=True)
def _pictures(request: pytest.FixtureRequest) -> Iterator[None]:
    """Painted for the files that say so: a painter takes a second of the processor."""
    run = painted_once if getattr(request.module, "LOOKS_AT_PICTURES", False) else left_blank
    with pytest.MonkeyPatch.context() as patch:
        beside = SimpleNamespace(run=run, TimeoutExpired=subprocess.TimeoutExpired)
        patch.setattr(painting, "subprocess", beside)
        yield


LONGEST = (
    "test_app_page", "test_documented_commands", "test_extract_command", "test_tree_bench",
    "test_sweep_faults", "test_sweep_clusters", "test_vessel_followed", "test_scenes",
    "test_segments", "test_cli", "test_app_server", "test_cli_words", "test_long_inputs",
    "test_panel_plans", "test_fast_measuring", "test_panel_looks", "test_panel",
    "test_panel_device", "test_panel_placing", "test_ostia", "test_outside_judges",
    "test_lesion_commands", "test_strict_readers", "test_identities", "test_panel_shown",
    "test_tree_around", "test_recipes", "test_compare", "test_memory", "test_plan_exchange",
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
