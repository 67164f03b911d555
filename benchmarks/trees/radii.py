"""The makings of trees by their radii alone: no surface is made, no sphere searched on one.

python -m benchmarks.trees.radii [--making hourglass made bare] [--count 100] [--seed S]

A place is as wide as the largest of the tree's spheres that holds it lets it be. That takes half a
second a tree where a surface takes a minute, so rules can be tried on hundreds; what surfaces make
uneven is missing. `bare` are trees that nobody narrowed. Radii half a millimeter apart tell no
minimum to 3 %: errors of it do not count.
"""

from __future__ import annotations

import argparse
import secrets
import sys
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from SDFStentLib.centerline import BranchLumen, Centerline
from SDFStentLib.vessel import find_lesions

from ..sweep import DATA_FOLDER
from . import case, hourglass
from .judge import Reported, judged
from .layout import VesselTree
from .narrowing import SHAPES, MadeNarrowing, narrowings
from .narrowing import narrowed as narrowed_by_shape
from .truth import Truth, truths, width_in

_FINE = 0.1
"""Spacing of the places between stations, mm."""

_ROOM = find_lesions.__module__.rpartition(".")[0]


class RadiiTree(NamedTuple):
    """A tree with its vessels, and the truth about its narrowings."""

    name: str
    tree: VesselTree
    runs: list[Any]
    truths: list[Truth]


def made(making: str, seed: int, number: int, data: Path) -> RadiiTree:
    """The tree of a number, as `MAKINGS` of the bench has it but for the surface."""
    tree, after, chosen = _LAYOUTS[making](seed, number, data)
    found: list[Truth] = []
    for one in chosen:
        try:
            found += truths((tree, None), (after, None), one)
        except ValueError:
            continue
    return RadiiTree(f"{making} {seed} {number}", after, runs_of(after), found)


def runs_of(tree: VesselTree) -> list[Any]:
    """The vessels of a tree of radii."""
    line = Centerline(points=tree.points, inscribed_radius=tree.radius, parent=tree.parent)
    lumens = line.lumens
    branch_lumen = sys.modules[f"{_ROOM}.branch_lumen"]
    to_ends = branch_lumen._distances_to_ends(lumens)
    told: list[BranchLumen] = []
    for lumen, to_end in zip(lumens, to_ends, strict=True):
        diameter = width_in(tree, lumen.points)
        diameter[branch_lumen.END_REACH * diameter / 2 > to_end] = np.nan
        told.append(lumen._replace(diameter=diameter))
    runs: list[Any] = sys.modules[f"{_ROOM}.runs"].vessel_runs(told)
    return runs


def reported(tree: VesselTree, runs: list[Any]) -> list[Reported]:
    """The lesions of vessels, narrowest between the stations beside their narrowest one."""
    found, rule = [], sys.modules[f"{_ROOM}.found_narrowings"]
    least = 100 * sys.modules[f"{_ROOM}.narrowings"].SMALLEST_DEGREE
    for one in rule.found_narrowings(runs, range(len(runs))):
        limbs = tuple(_told(tree, each) for each in one.limbs)
        told = replace(_told(tree, one), limbs=limbs)
        if told.percent >= least:
            found.append(told)
    return found


def _told(tree: VesselTree, one: Any) -> Reported:
    """A narrowing as it is told."""
    at, last = one.narrowest, len(one.run.along) - 1
    ends = one.run.line.arc_lengths[[max(at - 1, 0), min(at + 1, last)]]
    places = one.run.line.cut(*ends).resampled(_FINE).points
    widths = width_in(tree, places)
    place, width = places[widths.argmin()], float(widths.min())
    degree, length = 100 * (1 - width / one.healthy), one.narrow.end - one.narrow.start
    return Reported(place, width, degree, one.healthy, length, str(one.vessel))


_Layout = tuple[VesselTree, VesselTree, list[MadeNarrowing]]


def _hourglass(seed: int, number: int, data: Path) -> _Layout:
    random = np.random.default_rng([seed, number, 2])
    tree = hourglass.bare_tree(number, data, random)
    chosen = [] if number % 10 == 4 else hourglass.hourglasses(tree, 4, random)
    return tree, hourglass.narrowed(tree, chosen), chosen


def _made(seed: int, number: int, data: Path) -> _Layout:
    random = np.random.default_rng([seed, number])
    tree, _ = case.bare_tree(random, number, data)
    chosen = narrowings(tree, list(random.permutation(SHAPES)[:4]), random)
    return tree, narrowed_by_shape(tree, chosen), chosen


def _bare(seed: int, number: int, data: Path) -> _Layout:
    random = np.random.default_rng([seed, number, 3])
    make = case.bare_tree(random, number, data)[0] if number % 2 else None
    tree = make or hourglass.bare_tree(number // 2, data, random)
    return tree, tree, []


_LAYOUTS = {"hourglass": _hourglass, "made": _made, "bare": _bare}


def verdicts(one: RadiiTree) -> tuple[list[str], list[str]]:
    """Words on every narrowing of a tree, and sentences on what is invented in it."""
    mine, invented = judged(one.tree, None, one.truths, reported(one.tree, one.runs))
    words = [verdict.words.replace("minimum, ", "") for verdict in mine]
    return ["as it is" if one == "minimum" else one for one in words], invented


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--making", nargs="+", choices=list(_LAYOUTS), default=list(_LAYOUTS))
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--seed", type=int, default=secrets.randbelow(10**6))
    chosen = parser.parse_args()
    for making in chosen.making:
        words: Counter[str] = Counter()
        invented = told = 0
        for number in range(chosen.count):
            one = made(making, chosen.seed, number, DATA_FOLDER)
            mine, more = verdicts(one)
            words.update(mine)
            invented += len(more)
            told += len(reported(one.tree, one.runs))
        total = sum(words.values())
        print(
            f"{making}, seed {chosen.seed}, {chosen.count} trees: {words.pop('as it is', 0)} of "
            f"{total} as they are, {dict(words)}; {told} told, {invented} of them invented."
        )


if __name__ == "__main__":
    main()
