"""Whether the tests notice faults: the library with one place changed, over and over.

pytest -m "not bench" --cov=SDFStentLib --cov-context=test --durations=0 -vv > durations.txt
python -m benchmarks.mutants .coverage durations.txt [--count 40] [--first 0] [--seed 1]
                                                     [--seconds 60] [--project PATH]

A mutant has an operator, a comparison, a number or a return changed. It runs in a copy of the tree,
with the tests that have run its line (pytest-cov wrote which, and pytest how long each took),
beginning with the shortest, as many as take `--seconds` together. It counts as killed, too, when
they take the processor more than five times as long and half a minute. So a busy machine decides as
a quiet one does. The same seed takes the same mutants as long as their lines stay as they are,
whatever else changes: that of an older checkout is compared by `--project`, mutant by mutant.
`--first` goes on where a run was ended.
"""

from __future__ import annotations

import argparse
import ast
import copy
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from hashlib import sha256
from itertools import accumulate
from pathlib import Path
from typing import NamedTuple

from coverage import CoverageData

from .sweep import DATA_FOLDER, PROJECT

ROOMS = ("field", "deformation", "certificate", "lumen", "treatment")
PAIRS = "Add Sub, Mult Div, Lt LtE, Gt GtE, Eq NotEq, And Or"
TYPES = [[getattr(ast, name) for name in pair.split()] for pair in PAIRS.split(", ")]
SWAPPED = dict([*TYPES, *(pair[::-1] for pair in TYPES)])

LASTED = re.compile(r"([0-9.]+)s (?:setup|call|teardown) +(\S.*?)\s*$")


class Mutant(NamedTuple):
    path: str
    line: int
    first: int
    last: int
    old: str
    new: str
    around: str  # the whole line as it shall be
    is_global: bool  # run with the import, for all tests that have been in the file

    def rank(self, seed: int) -> bytes:
        """Its rank in a random order that does not depend on where the line is."""
        return sha256(f"{seed} {self.path} {self.old} {self.around}".encode()).digest()


def changed(node: ast.AST) -> ast.AST | None:
    """The node with a fault, or None if it has nothing to change."""
    made = copy.deepcopy(node)
    if isinstance(made, ast.BinOp | ast.BoolOp) and type(made.op) in SWAPPED:
        made.op = SWAPPED[type(made.op)]()
    elif isinstance(made, ast.Compare) and type(made.ops[0]) in SWAPPED:
        made.ops[0] = SWAPPED[type(made.ops[0])]()
    elif isinstance(made, ast.Constant) and type(made.value) in (int, float):
        made.value = made.value + 1 if type(made.value) is int else 1.1 * made.value + 1e-3
    elif isinstance(made, ast.Return) and made.value is not None:
        made.value = ast.Constant(None)
    else:
        return None
    return made


def mutants_of(path: Path, project: Path) -> Iterator[Mutant]:
    """All mutants of a file of a checkout."""
    source = path.read_bytes()
    starts = [0, *accumulate(map(len, source.splitlines(keepends=True)))]
    for statement, node in ((x, y) for x in ast.parse(source).body for y in ast.walk(x)):
        made = changed(node)
        if made is not None:
            first = starts[node.lineno - 1] + node.col_offset
            last = starts[node.end_lineno - 1] + node.end_col_offset
            new = ast.unparse(made) if isinstance(made, ast.Return) else f"({ast.unparse(made)})"
            name, old = path.relative_to(project).as_posix(), source[first:last].decode()
            if new == old:  # nothing is returned already
                continue
            parts = source[starts[node.lineno - 1] : first], source[last : starts[node.end_lineno]]
            around = new.join(part.decode() for part in parts)
            is_global = not isinstance(statement, ast.FunctionDef | ast.ClassDef)
            yield Mutant(name, node.lineno, first, last, old, new, around, is_global)


def tests_by_line(name: str) -> dict[str, dict[int, set[str]]]:
    """The tests that have run each line, by file of the library."""
    data = CoverageData(name)
    data.read()
    return {
        "SDFStentLib" + file.rpartition("SDFStentLib")[2]: {
            line: {name.rpartition("|")[0] for name in names if name}
            for line, names in data.contexts_by_lineno(file).items()
        }
        for file in data.measured_files()
    }


def seconds_by_test(name: str) -> dict[str, float]:
    """The time that each test took, s, from what pytest printed."""
    taken: dict[str, float] = {}
    with open(name, encoding="utf-8") as file:
        for found in filter(None, map(LASTED.match, file)):
            taken[found[2]] = taken.get(found[2], 0.0) + float(found[1])
    return taken


def tests_of(mutant: Mutant, lines: dict[int, set[str]]) -> set[str]:
    """The tests that have run the line of a mutant."""
    begun = max(line for line in lines if line <= mutant.line)  # an expression may be long
    there = set().union(*lines.values()) if mutant.is_global else lines[begun]
    # Those of pages see the library in other processes, which would outlive them.
    return {name for name in there if "test_app_" not in name}


def shortest(names: set[str], taken: dict[str, float], seconds: float) -> list[str]:
    """The shortest of some tests, those that take so long together; at least one."""
    ordered = sorted(names, key=lambda name: (taken.get(name, 0.0), name))
    ends = list(accumulate(taken.get(name, 0.0) for name in ordered))
    return ordered[: max(1, sum(end <= seconds for end in ends))]


def verdict(tree: Path, mutant: Mutant, names: list[str], expected: float) -> str:
    """The verdict of some tests on a mutant in a copy of the tree, which is restored afterward.

    `expected` is the time that they take without it, s.
    """
    place, most = tree / mutant.path, int(30 + 5 * expected)
    source = place.read_bytes()
    place.write_bytes(source[: mutant.first] + mutant.new.encode() + source[mutant.last :])
    given = {**os.environ, "SDFSTENT_DATA": str(DATA_FOLDER), "PYTHONPATH": str(tree)}
    words = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider"]
    words += ["-m", "not bench", *names]
    resource.setrlimit(resource.RLIMIT_CPU, (most, resource.RLIM_INFINITY))  # of each child
    try:
        done = subprocess.run(words, cwd=tree, env=given, text=True, capture_output=True)
    finally:
        place.write_bytes(source)
    if done.returncode == -signal.SIGXCPU:
        return "killed by the time that it takes"
    if done.returncode:
        by = re.search(r"^(?:FAILED|ERROR) (\S+::.+?)(?: - |$)", done.stdout, re.M)
        return f"killed by {by[1] if by else 'an error at the start'}"
    return "survived"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("coverage", help="what coverage wrote, with its contexts")
    parser.add_argument("durations", help="what pytest printed")
    for name, usual in (("count", 40), ("first", 0), ("seed", 1), ("seconds", 60)):
        parser.add_argument(f"--{name}", type=int, default=usual)
    parser.add_argument("--project", type=Path, default=PROJECT, help="the checkout; usually this")
    chosen = parser.parse_args()
    project = chosen.project.resolve()
    tests, taken = tests_by_line(chosen.coverage), seconds_by_test(chosen.durations)
    files = [path for room in ROOMS for path in (project / "SDFStentLib" / room).rglob("*.py")]
    found = [mutant for path in sorted(files) for mutant in mutants_of(path, project)]
    found.sort(key=lambda one: one.rank(chosen.seed))
    with tempfile.TemporaryDirectory() as folder:
        tree = Path(folder) / "tree"
        shutil.copytree(project, tree, ignore=shutil.ignore_patterns(".*", "__pycache__", "build"))
        for mutant in found[chosen.first : chosen.first + chosen.count]:
            there = tests_of(mutant, tests[mutant.path])
            names = shortest(there, taken, chosen.seconds)
            expected = sum(taken.get(name, 0.0) for name in names)
            said = verdict(tree, mutant, names, expected) if names else "never run"
            whose = f"{len(names)} of {len(there)} tests"
            print(f"{mutant.path}:{mutant.line}: {mutant.old!r}, {mutant.new!r}", end=" ")
            print(f"{said} ({whose})", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
