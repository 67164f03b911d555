"""Narrowings of known place and depth in trees of 20 to 100 outlets: are they reported as they
are?

python -m benchmarks.trees [--making NAME ...] [--count 25] [--first 0] [--seed S] [--only SHAPE]
[--jobs 2] [--save FOLDER | --cases FOLDER [--treat]] [--command] [--quick] [--json FILE]

A tree has up to four narrowings, every tenth none. One is reported as it is if once, its place
within 3 mm, its minimum within 3 %, its percent by diameter within 5 points or between the percents
of its two sides; one so told as a limb of the lesion in whose throat it is, at a fork, counts by
itself. There are three makings (`bench.MAKINGS`), of which the worst is the figure, and
the seed is drawn anew where none is given: nothing can be fitted to them. Every tree is made anew
unless --cases names a folder that --save filled. With --treat each narrowing is treated, and the
report of the result is judged. `truth.py` says how the truth is measured.
"""

from __future__ import annotations

import argparse
import json
import secrets
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from itertools import starmap
from pathlib import Path

from ..common import load_average, progress
from ..sweep import DATA_FOLDER
from . import treated
from .bench import COUNT, MAKINGS, of_case, of_number, sentences, summary, table
from .case import NONE
from .narrowing import SHAPES


def options(arguments: Sequence[str] | None = None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, help=f"trees; {COUNT}, or all that are saved")
    parser.add_argument("--making", nargs="+", choices=list(MAKINGS), default=list(MAKINGS))
    parser.add_argument("--seed", type=int, default=secrets.randbelow(10**6))
    parser.add_argument("--only", choices=(*SHAPES, NONE), metavar="SHAPE", help=", ".join(SHAPES))
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--save", type=Path, metavar="FOLDER", help="keep the cases here")
    parser.add_argument("--cases", type=Path, metavar="FOLDER", help="judge what --save kept")
    parser.add_argument("--treat", action="store_true", help="judge what is told after treatment")
    parser.add_argument("--first", type=int, default=0, help="number of the first tree")
    parser.add_argument("--command", action="store_true", help="ask the installed command")
    parser.add_argument("--quick", action="store_true", help="one tree each")
    parser.add_argument("--largest", type=int, help=argparse.SUPPRESS)
    parser.add_argument("--json", type=Path, metavar="FILE", help="also write the numbers here")
    return parser.parse_args(arguments)


def cases(chosen: argparse.Namespace, making: str) -> Iterator[dict]:
    """The findings in every case of a making, in order."""
    if chosen.cases is not None:
        work, calls = of_case, [(folder, chosen.command) for folder in saved(chosen)]
    else:
        work, count = of_number, 1 if chosen.quick else chosen.count or COUNT
        calls = [
            (
                chosen.seed,
                number,
                DATA_FOLDER,
                chosen.only,
                chosen.save,
                chosen.command,
                making,
            )
            for number in range(chosen.first, chosen.first + count)
        ]
    if chosen.jobs == 1:
        yield from starmap(work, calls)
        return
    with ProcessPoolExecutor(chosen.jobs) as workers:
        yield from workers.map(work, *zip(*calls, strict=True))


def saved(chosen: argparse.Namespace) -> list[Path]:
    """The folders of saved cases from the first on, in order."""
    found = sorted(path.parent for path in chosen.cases.glob("*/truth.json"))[chosen.first :]
    return found[: chosen.count]


def treat(chosen: argparse.Namespace) -> None:
    """Treat the narrowings of saved cases, and print how correctly the results are reported."""
    done = []
    with ProcessPoolExecutor(chosen.jobs) as workers:
        for found in workers.map(treated.of_case, saved(chosen)):
            done += found
            for line in treated.sentences(found):
                progress(line)
    print(treated.table(done))
    if chosen.json:
        chosen.json.write_text(json.dumps(done, indent=1) + "\n", encoding="utf-8")


def main() -> None:
    chosen = options()
    if chosen.treat:
        treat(chosen)
        return
    before, found = load_average(), {}
    for making in ["saved"] if chosen.cases else chosen.making:
        judged = []
        for one in cases(chosen, making):
            judged.append(one)
            for line in sentences(one):
                progress(line)
        found[making] = summary(judged)
    result = {"seed": chosen.seed, "makings": found, "load_average": [before, load_average()]}
    print(table(result))
    if chosen.json:
        chosen.json.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
