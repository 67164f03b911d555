"""What is costly and comes out the same each time is made once per process."""

from __future__ import annotations

import inspect
import pickle
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from functools import cached_property, wraps
from hashlib import sha256
from types import SimpleNamespace
from typing import Any

import pytest

from benchmarks import phantoms
from benchmarks.phantoms import phantoms as makers
from SDFStentLib.report.picture import painting
from SDFStentLib.treatment import vessel
from SDFStentLib.vessel import Lesion, TreeLesions

Done = subprocess.CompletedProcess
USUAL = (sys.executable, "-c", painting.PROGRAM)
PAINTER = """
import pickle, sys
sys.path.insert(0, sys.argv[1])
from SDFStentLib.report.picture.painter import png
while sys.stdin.buffer.peek(1):
    picture = png(*pickle.load(sys.stdin.buffer))
    sys.stdout.buffer.write(b"%d\\n" % len(picture) + picture)
    sys.stdout.buffer.flush()
"""


def made_once(make: Callable[..., phantoms.Phantom]) -> Callable[..., phantoms.Phantom]:
    """The same call gives the same phantom, which nobody can change: some take a second."""
    known: dict[bytes, phantoms.Phantom] = {}

    @wraps(make)
    def once(*arguments, **named):
        try:
            key = pickle.dumps((arguments, named))
        except (pickle.PicklingError, AttributeError):  # a function within a test
            return make(*arguments, **named)
        if key not in known:
            known[key] = make(*arguments, **named)
        return known[key]

    return once


@pytest.fixture(scope="session", autouse=True)
def known_lesions() -> Iterator[dict[bytes, tuple]]:
    """Lesions of each vessel are looked for once: that takes as long as a deployment.

    A test that needs the search clears what is known.
    """
    search, known = vessel.TreeLesions, {}

    def found(surface, centerline, faces=None, given=()):
        tree = centerline.points, centerline.parent, centerline.inscribed_radius
        walls = surface.points, surface.triangles
        key = sha256(pickle.dumps((walls, tree, faces, given))).digest()
        if key not in known:
            known[key] = search(surface, centerline, faces, given)
        return Again(known[key])

    vessel.TreeLesions = found
    yield known
    vessel.TreeLesions = search


class Again:
    """Lesions that were found before: other tuples for every search, as without this."""

    def __init__(self, tree: TreeLesions) -> None:
        self._tree = tree

    @cached_property
    def first(self) -> tuple[Lesion, ...]:
        return tuple([*self._tree.first])

    @cached_property
    def every(self) -> tuple[Lesion, ...]:
        return tuple([*self._tree.every])

    @property
    def others(self) -> Iterator[Lesion]:
        return self._tree.others


class Painter:
    """A painter as every picture has one, but for all pictures of this process, each once.

    Where nobody looks at them the first of a size stands for all.
    """

    def __init__(self) -> None:
        self.process: subprocess.Popen | None = None
        self.known: dict[Any, bytes] = {}
        self.is_looked_at = True

    def run(self, arguments: Sequence[str], *, input: bytes, **named: Any) -> Done:
        """As `subprocess.run`; the same where a test has put another program in its place."""
        if tuple(arguments[:-1]) != USUAL:
            return subprocess.run(arguments, input=input, **named)
        drawing, panels = pickle.loads(input)
        size = drawing.width, drawing.height, len(panels)
        key = sha256(input).digest() if self.is_looked_at else size
        picture = self.known.get(key) or self.painted(input, arguments[-1])
        if not picture:  # what a painter of its own says of that
            return subprocess.run(arguments, input=input, **named)
        self.known[key] = picture
        return Done(arguments, 0, picture, b"")

    def painted(self, drawing: bytes, above: str) -> bytes:
        """The PNG, or nothing where the painter has ended."""
        if self.process is None:
            command = [sys.executable, "-c", PAINTER, above]
            self.process = subprocess.Popen(
                command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
            )
        try:
            self.process.stdin.write(drawing)
            self.process.stdin.flush()
            return self.process.stdout.read(int(self.process.stdout.readline() or 0))
        except OSError:
            return b""


@pytest.fixture(scope="session")
def painter() -> Iterator[Painter]:
    made = Painter()
    yield made
    if made.process is not None:
        made.process.communicate()


@pytest.fixture(scope="module", autouse=True)
def _pictures(painter: Painter, request: pytest.FixtureRequest) -> Iterator[None]:
    """To import VTK takes longer than to paint."""
    painter.is_looked_at = request.path.stem in LOOKED_AT
    with pytest.MonkeyPatch.context() as patch:
        beside = SimpleNamespace(run=painter.run, TimeoutExpired=subprocess.TimeoutExpired)
        patch.setattr(painting, "subprocess", beside)
        yield


LOOKED_AT = ("test_cli", "test_compare", "test_panel_plans", "test_picture")
"""Files that look at pictures."""

LONGEST = (
    "test_app_page", "test_documented_commands", "test_sweep_faults", "test_app_server",
    "test_cli", "test_simulation", "test_segments", "test_extract_command", "test_fast_measuring",
    "test_panel_plans", "test_panel_looks", "test_stuck_spheres", "test_cohort_documents",
    "test_lesions", "test_ostia", "test_release",
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
