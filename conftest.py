"""What is costly and comes out the same each time is made once per process: vessels, pictures."""

from __future__ import annotations

import gc
import os
import pickle
import subprocess
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import lru_cache, wraps
from hashlib import sha256
from pathlib import Path
from types import SimpleNamespace

from SDFStentLib import phantoms
from SDFStentLib.phantoms import phantoms as makers
from SDFStentLib.report import painting


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


PAINTER = """
import os, pickle, sys
sys.path.insert(0, sys.argv[1])
from SDFStentLib.report import painter
while True:  # Ends: the tests do, and close its stdin.
    try:
        data = pickle.load(sys.stdin.buffer)
    except EOFError:
        break
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        with open(writing, "wb") as out:
            out.write(painter.png(*pickle.loads(data)))
        os._exit(0)
    os.close(writing)
    with open(reading, "rb") as said:
        png = said.read()
    os.waitpid(child, 0)
    pickle.dump(png, sys.stdout.buffer)
    sys.stdout.buffer.flush()
"""
"""Paints in forks of a process that has loaded VTK, which takes ten times as long as a picture."""


class Painter:
    """That process, begun with the first picture."""

    process: subprocess.Popen | None = None

    def png(self, data: bytes) -> bytes:
        if self.process is None:
            self.process = subprocess.Popen(
                [sys.executable, "-c", PAINTER, str(Path(__file__).parent)],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
            )
        pickle.dump(data, self.process.stdin)
        self.process.stdin.flush()
        return pickle.load(self.process.stdout)


def painted_once() -> Callable[..., subprocess.CompletedProcess]:
    """Paints each picture once; what cannot be painted fails in a process of its own, as ever."""
    known, painter = {}, Painter()
    usual = [sys.executable, "-c", painting.PROGRAM]

    def run(arguments: Sequence[str], *, input: bytes, **named):
        key = (*arguments, sha256(input).digest())
        if key not in known and list(arguments[:3]) == usual and hasattr(os, "fork"):
            with suppress(OSError, EOFError):
                known[key] = subprocess.CompletedProcess(arguments, 0, painter.png(input), b"")
        done = known.get(key)
        if done is None or not done.stdout:
            done = subprocess.run(arguments, input=input, **named)
        if done.returncode == 0:
            known[key] = done
        return done

    return run


def pytest_collection_finish() -> None:
    """Tests and modules stay to the end: who looks for garbage need not look at them each time."""
    gc.enable()
    gc.collect()
    gc.freeze()


gc.disable()  # nothing is thrown away while test files are collected
# Before the test files import them.
for name in set(phantoms.__all__) - {"Opening", "Phantom", "Throat", "TrueVessel"}:
    once = made_once(getattr(phantoms, name))
    for module in (phantoms, makers):
        if hasattr(module, name):
            setattr(module, name, once)
painting.subprocess = SimpleNamespace(run=painted_once(), TimeoutExpired=subprocess.TimeoutExpired)
