"""Whether the tests notice faults: the library with one place changed, over and over.

pytest -m "not bench" --cov=SDFStentLib --cov-context=test       (pytest-cov; writes .coverage)
python -m benchmarks.mutants .coverage [--count 40] [--seed 1] [--seconds 300]
python -m benchmarks.mutants [--count 40] [--first 0] [--seed 1] [--seconds 60]

A mutant has an operator, a comparison, a number or a return changed. It runs in a copy of the tree,
with the tests that have run its line, beginning with those that run the least of the library; or,
without a file of coverage, with the files of tests that import its file or its room, one after the
other, beginning with those that import the least. The same seed takes the same mutants as long as
their lines stay as they are, whatever else changes; `--first` goes on where a run was ended.
"""

from __future__ import annotations

import argparse
import ast
import copy
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from functools import cache
from hashlib import sha256
from itertools import accumulate
from pathlib import Path
from typing import NamedTuple

from .sweep import DATA_FOLDER, PROJECT

ROOMS = ("field", "deformation", "certificate", "lumen", "treatment")
PAIRS = "Add Sub, Mult Div, Lt LtE, Gt GtE, Eq NotEq, And Or"
TYPES = [[getattr(ast, name) for name in pair.split()] for pair in PAIRS.split(", ")]
SWAPPED = dict([*TYPES, *(pair[::-1] for pair in TYPES)])


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


def mutants_of(path: Path) -> Iterator[Mutant]:
    """All mutants of a file."""
    source = path.read_bytes()
    starts = [0, *accumulate(map(len, source.splitlines(keepends=True)))]
    for statement, node in ((x, y) for x in ast.parse(source).body for y in ast.walk(x)):
        made = changed(node)
        if made is not None:
            first = starts[node.lineno - 1] + node.col_offset
            last = starts[node.end_lineno - 1] + node.end_col_offset
            new = ast.unparse(made) if isinstance(made, ast.Return) else f"({ast.unparse(made)})"
            name, old = path.relative_to(PROJECT).as_posix(), source[first:last].decode()
            if new == old:  # nothing is returned already
                continue
            parts = source[starts[node.lineno - 1] : first], source[last : starts[node.end_lineno]]
            around = new.join(part.decode() for part in parts)
            is_global = not isinstance(statement, ast.FunctionDef | ast.ClassDef)
            yield Mutant(name, node.lineno, first, last, old, new, around, is_global)


def tests_by_line(name: str) -> dict[str, dict[int, set[str]]]:
    """The tests that have run each line, by file of the library."""
    from coverage import CoverageData  # late: the other way needs none

    data = CoverageData(name)
    data.read()
    return {
        "SDFStentLib" + file.rpartition("SDFStentLib")[2]: {
            line: {name.rpartition("|")[0] for name in names if name}
            for line, names in data.contexts_by_lineno(file).items()
        }
        for file in data.measured_files()
    }


@cache
def imports_of_tests() -> dict[str, set[str]]:
    """The modules of the library that every file of tests imports from."""
    return {
        path.relative_to(PROJECT).as_posix(): {
            node.module
            for node in ast.walk(ast.parse(path.read_bytes()))
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("SDFStentLib.")
        }
        for path in sorted((PROJECT / "tests").glob("test_*.py"))
        if not path.stem.startswith("test_app_")
    }


def files_of_tests(mutant: Mutant) -> list[str]:
    """The files of tests that import the file of a mutant, or names from its room.

    Those that import the file itself come first, then those that import from the fewest rooms.
    """
    parts = Path(mutant.path).with_suffix("").parts
    found = []
    for name, modules in imports_of_tests().items():
        rooms = {module.split(".")[1] for module in modules}
        if parts[1] in rooms:
            size = (PROJECT / name).stat().st_size
            found.append((".".join(parts) not in modules, len(rooms), size, name))
    return [name for *_, name in sorted(found)]


def verdict(tree: Path, mutant: Mutant, batches: list[list[str]], seconds: float) -> str:
    """The verdict of the tests on a mutant in a copy of the tree, which is restored afterward."""
    place, end = tree / mutant.path, time.monotonic() + seconds
    source = place.read_bytes()
    place.write_bytes(source[: mutant.first] + mutant.new.encode() + source[mutant.last :])
    given = {**os.environ, "SDFSTENT_DATA": str(DATA_FOLDER), "PYTHONPATH": str(tree)}
    words = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider"]
    words += ["-m", "not bench"]
    try:
        for some in filter(None, batches):
            wait = {"timeout": max(end - time.monotonic(), 1), "capture_output": True}
            done = subprocess.run([*words, *some], cwd=tree, env=given, text=True, **wait)
            if done.returncode:
                by = re.search(r"^(?:FAILED|ERROR) (\S+::.+?)(?: - |$)", done.stdout, re.M)
                return f"killed by {by[1] if by else 'an error at the start'}"
    except subprocess.TimeoutExpired:
        return "not killed in time"
    finally:
        place.write_bytes(source)
    return "survived"


def by_line(mutant: Mutant, lines: dict[int, set[str]], seen: Counter[str]) -> list[list[str]]:
    """The tests that have run the line of a mutant: few are found at once."""
    begun = max(line for line in lines if line <= mutant.line)  # an expression may be long
    there = set().union(*lines.values()) if mutant.is_global else lines[begun]
    # Those of pages see the library in other processes, which would outlive them.
    names = [name for name in there if "test_app_" not in name]
    names.sort(key=lambda name: (seen[name], name))
    return [names[:10], names[10:50], names[50:]]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("data", nargs="?", help="what coverage wrote, with its contexts")
    for name, usual in (("count", 40), ("first", 0), ("seed", 1), ("seconds", 300)):
        parser.add_argument(f"--{name}", type=int, default=usual)
    chosen = parser.parse_args()
    tests = tests_by_line(chosen.data) if chosen.data else {}
    seen = Counter(name for file in tests.values() for line in file.values() for name in line)
    files = [path for room in ROOMS for path in (PROJECT / "SDFStentLib" / room).rglob("*.py")]
    found = [mutant for path in sorted(files) for mutant in mutants_of(path)]
    found.sort(key=lambda one: one.rank(chosen.seed))
    with tempfile.TemporaryDirectory() as folder:
        tree = Path(folder) / "tree"
        shutil.copytree(PROJECT, tree, ignore=shutil.ignore_patterns(".*", "__pycache__", "build"))
        for mutant in found[chosen.first : chosen.first + chosen.count]:
            if tests:
                batches = by_line(mutant, tests[mutant.path], seen)
            else:
                batches = [[name] for name in files_of_tests(mutant)]
            said = verdict(tree, mutant, batches, chosen.seconds) if any(batches) else "never run"
            print(f"{mutant.path}:{mutant.line}: {mutant.old!r}, {mutant.new!r}", said, flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
