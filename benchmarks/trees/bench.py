"""A case of the bench from its making to its verdict, and the table of many."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from ..common import Found, markdown
from .case import NONE, load, made_case, read_wall, save
from .hourglass import hourglass_case
from .judge import AS_LIMB, asked, judged, outlets_told
from .narrowing import AT_FORK, HOURGLASS, SHAPES
from .pressed import pressed_case

TOTAL = "all"

COUNT = 25
"""Number of trees of every making in a whole run: they have some 80 narrowings each."""

MAKINGS = {"made": made_case, "hourglass": hourglass_case, "pressed": pressed_case}
"""Ways to make a case: a tree of even vessels; hourglasses anywhere in trees of patients' radii;
narrowings pressed into the surfaces of patients."""


def of_case(folder: Path, by_command: bool = False) -> Found:
    """The lesions that the product reports in a saved case, judged."""
    tree, truths, facts = load(folder)
    answer = asked(folder, by_command)
    verdicts, invented = judged(tree, read_wall(folder / "surface.vtp"), truths, answer.reported)
    return {
        "case": folder.name, "facts": facts, "failure": answer.failure,
        "seconds": round(answer.seconds, 3), "told": len(answer.reported), "invented": invented,
        "outlets": outlets_told(folder),
        "verdicts": [asdict(one) for one in verdicts],
    }  # fmt: skip


def of_number(
    seed: int,
    number: int,
    data: Path,
    only: str | None = None,
    keep: Path | None = None,
    by_command: bool = False,
    making: str = "made",
) -> Found:
    """The same for a case that is made now; kept in a folder of its own if `keep` says where.

    `making` is one of `MAKINGS`.
    """
    with TemporaryDirectory() as made:
        case = MAKINGS[making](seed, number, data, only)
        folder = Path(made if keep is None else keep) / case.name
        save(case, folder)
        return of_case(folder, by_command)


def sentences(found: Found) -> list[str]:
    """Sentences about what is wrong in a case."""
    lines = [f"ended in an error: {found['failure']}"] if found["failure"] else []
    lines += [f"invented: {one}" for one in found["invented"]]
    if found["outlets"] != found["facts"]["outlets"]:
        lines.append(f"flow: {found['outlets']} outlets, not {found['facts']['outlets']}")
    for number, one in enumerate(found["verdicts"]):
        if one["words"] not in ("as it is", AS_LIMB):
            errors = "".join(
                f", {name} {one[name]:+.1f}"
                for name in ("place", "minimum", "percent", "reference", "extent")
                if one[name] is not None
            )
            lines.append(f"narrowing {number} ({one['shape']}): {one['words']}{errors}")
    return [f"{found['case']} ({found['facts']['tree']}): {line}" for line in lines]


def summary(cases: Sequence[Found]) -> Found:
    """Rows by shape and for all; `invented` counts by the shape `NONE` in trees without one."""
    rows = []
    verdicts = [one for case in cases for one in case["verdicts"]]
    for shape in (*SHAPES, HOURGLASS, AT_FORK, NONE, TOTAL):
        mine = [one for one in verdicts if shape in (one["shape"], TOTAL)]
        about = [case for case in cases if _is_about(case, shape)]
        if not about:
            continue
        words = [one["words"] for one in mine]
        row: Found = {
            "shape": shape,
            "trees": len(about),
            "narrowings": len(mine),
            "as_they_are": words.count("as it is"),
            "as_limbs": words.count(AS_LIMB),
            "missed": words.count("missed"),
            "split": words.count("split"),
            "invented": sum(len(case["invented"]) for case in about),
            "failed": sum(bool(case["failure"]) for case in about),
            "seconds": float(np.median([case["seconds"] for case in about])),
        }
        for name in ("place", "minimum", "percent", "reference", "extent"):
            errors = [abs(one[name]) for one in mine if one[name] is not None]
            row[name] = [float(np.percentile(errors, at)) for at in (50, 95)] if errors else None
        rows.append(row)
    return {"rows": rows, "wrong": [line for case in cases for line in sentences(case)]}


def _is_about(case: Found, shape: str) -> bool:
    shapes = [one["shape"] for one in case["verdicts"]] or [NONE]
    return shape == TOTAL or shape in shapes


def table(found: Found) -> str:
    """Tables of the makings, the worst of which is the figure."""
    parts = [
        f"{name}, seed {found['seed']}\n\n{_table(one)}" for name, one in found["makings"].items()
    ]
    shares = {
        name: one["rows"][-1]["as_they_are"] / max(one["rows"][-1]["narrowings"], 1)
        for name, one in found["makings"].items()
    }
    worst = min(shares, key=lambda name: shares[name])
    return "\n\n".join([*parts, f"Worst making: {worst}, {100 * shares[worst]:.1f} % as they are."])


def _table(found: Found) -> str:
    header = [
        "narrowing", "trees", "count", "as it is", AS_LIMB, "missed", "split", "invented", "errors",
        "place, mm", "minimum, %", "percent, points", "reference, %", "extent, mm", "time",
    ]  # fmt: skip
    rows = []
    for one in found["rows"]:
        count = one["narrowings"]
        right = f"{one['as_they_are']} ({100 * one['as_they_are'] / count:.1f} %)" if count else "-"
        errors = [
            f"{one[name][0]:.1f}, {one[name][1]:.1f}" if one[name] else "-"
            for name in ("place", "minimum", "percent", "reference", "extent")
        ]
        rows.append(
            [
                one["shape"], one["trees"], count, right, one["as_limbs"], one["missed"],
                one["split"], one["invented"], one["failed"], *errors, f"{one['seconds']:.2f} s",
            ]
        )  # fmt: skip
    return markdown(header, rows) + "\n\nErrors: median and 95th percentile of those found once."
