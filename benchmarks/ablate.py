"""Numbers of the rule for lesions, halved and doubled in turn: the difference that each makes.

python -m benchmarks.ablate FOLDER [--count N] [--only NAME ...] [--json FILE]

The folder holds trees that `benchmarks.trees --save` kept. The caliber along their vessels does not
depend on the rule: each tree is measured once, and the rule runs in milliseconds on its stations.
So degrees are those of stations, not of the spheres between them.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

from SDFStentLib.plan import read_input_files
from SDFStentLib.vessel import find_lesions

from .common import Found, markdown, progress
from .trees.case import load, read_wall
from .trees.judge import Reported, judged
from .trees.layout import VesselTree
from .trees.surface import Wall
from .trees.truth import Truth

_ROOM = find_lesions.__module__.rpartition(".")[0]

VESSEL = {
    name: sys.modules[f"{_ROOM}.{name}"]
    for name in ("caliber", "narrowings", "found_narrowings", "branch_lumen", "runs", "tree_around")
}
"""Modules from inside of the room of vessels, by name: no public function changes their numbers."""

MODULES = (VESSEL["caliber"], VESSEL["narrowings"], VESSEL["found_narrowings"])
"""Modules of the rule."""

FACTORS = (0.5, 2.0)


class MeasuredTree(NamedTuple):
    """A saved tree with its vessels, measured exactly."""

    runs: list[Any]
    tree: VesselTree
    wall: Wall
    truths: list[Truth]


def measured_tree(folder: Path) -> MeasuredTree:
    """The tree of a folder."""
    files = (str(folder / f"{name}.vtp") for name in ("surface", "centerline"))
    vessel = read_input_files(*files).vessel
    lumen = VESSEL["branch_lumen"].tree_lumen(vessel.surface, vessel.centerline)
    limbs = VESSEL["tree_around"].limbs_of(vessel.centerline)
    runs, wall = VESSEL["runs"].vessel_runs(lumen.rough, limbs), lumen.spheres.surface
    spheres = [lumen.spheres.exact(lumen.stations_of(run)) for run in runs]
    tree, truths, _ = load(folder)
    return MeasuredTree(
        VESSEL["found_narrowings"].own_runs(wall, runs, spheres),
        tree,
        read_wall(folder / "surface.vtp"),
        truths,
    )


def reported(runs: Sequence[Any]) -> list[Reported]:
    """The lesions of vessels by their stations."""
    found = []
    for one in VESSEL["found_narrowings"].found_narrowings(runs, range(len(runs))):
        place, width = one.run.points[one.narrowest], float(one.run.diameter[one.narrowest])
        degree, length = 100 * (1 - width / one.healthy), one.narrow.end - one.narrow.start
        if degree >= 100 * VESSEL["narrowings"].SMALLEST_DEGREE:
            found.append(Reported(place, width, degree, one.healthy, length, str(one.vessel)))
    return found


def counts(trees: Sequence[MeasuredTree]) -> Found:
    """How many narrowings are reported as they are, and how many lesions besides."""
    verdicts, others = [], 0
    for one in trees:
        given = reported(one.runs)
        mine, _ = judged(one.tree, one.wall, one.truths, [g for g in given if _is_near(g, one)])
        verdicts += mine
        others += sum(not _is_near(g, one) for g in given)
    words = [verdict.words for verdict in verdicts]
    return {
        "narrowings": len(words), "as_they_are": words.count("as it is"),
        "missed": words.count("missed"), "split": words.count("split"), "others": others,
    }  # fmt: skip


def _is_near(given: Reported, one: MeasuredTree) -> bool:
    stations = [np.array(truth.stations) for truth in one.truths]
    return any((np.linalg.norm(each - given.place, axis=1) < 3.0).any() for each in stations)


def numbers(only: Sequence[str] | None) -> Iterator[tuple[ModuleType, str, float]]:
    """The named numbers of the rule, each in the module that owns it."""
    seen = set()
    for module in MODULES:
        for name, value in vars(module).items():
            if isinstance(value, float) and name.isupper() and name not in seen:
                seen.add(name)
                if not only or name in only:
                    yield module, name, value


@contextmanager
def changed(name: str, value: float) -> Iterator[None]:
    """Give a number another value in every module of the rule that knows it."""
    before = {module: getattr(module, name) for module in MODULES if hasattr(module, name)}
    try:
        for module in before:
            setattr(module, name, value)
        yield
    finally:
        for module, old in before.items():
            setattr(module, name, old)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--count", type=int)
    parser.add_argument("--only", nargs="+", metavar="NAME")
    parser.add_argument("--json", type=Path, metavar="FILE")
    chosen = parser.parse_args()
    folders = sorted(path.parent for path in chosen.folder.glob("*/truth.json"))[: chosen.count]
    trees = []
    for folder in folders:
        progress(folder.name)
        trees.append(measured_tree(folder))
    found = [{"name": "", "value": None, **counts(trees)}]
    for _, name, value in numbers(chosen.only):
        for factor in FACTORS:
            # A quantile ends at 1.
            tried = min(factor * value, 1.0) if name == "USUAL" else factor * value
            with changed(name, tried):
                found.append({"name": name, "value": tried, **counts(trees)})
    print(table(found))
    if chosen.json:
        chosen.json.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


def table(found: Sequence[Found]) -> str:
    """Rows of numbers and what is reported with them."""
    columns = ("name", "value", "as_they_are", "missed", "split", "others")
    header = ["number", "value", "as they are", "missed", "split", "others"]
    return markdown(header, [[one[column] for column in columns] for one in found])


if __name__ == "__main__":
    main()
