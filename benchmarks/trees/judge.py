"""Judgment of the lesions that the product reports in a tree, against the truth."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from .layout import VesselTree
from .surface import Wall
from .truth import Truth, degree_beside

PLACE = 3.0
"""Largest error of a lesion's narrowest place, mm."""

MINIMUM = 3.0
"""Largest error of its minimum, percent."""

PERCENT = 5.0
"""Largest error of its degree, percentage points."""

INVENTED = (15.0, 10.0)
"""Degree from which on a lesion is invented, %, and the true degree below which it is."""

AS_LIMB = "as a limb"
"""Words for a narrowing that is told as it is, but as a limb of the lesion in whose throat it
is."""

FILES = ("surface", "centerline")
"""Names of the files of a saved case, .vtp."""

_ZONE = 2.0
"""Distance beyond the extent of a narrowing up to which a lesion belongs to it, mm."""


@dataclass(frozen=True)
class Reported:
    """A lesion as the product reports it; lengths in mm."""

    place: np.ndarray
    minimum: float
    percent: float
    reference: float
    length: float
    name: str
    limbs: tuple[Reported, ...] = ()
    """Other vessels that it tells to be narrowed in the same throat."""

    @classmethod
    def from_section(cls, section: Mapping[str, Any]) -> Reported:
        """The lesion of a section of the JSON of `sdfstent measure`."""
        return cls(
            np.array(section["place_mm"], dtype=float),
            float(section["minimum"]["diameter_mm"]),
            float(section["percent_diameter"]),
            float(section["reference"]["diameter_mm"]),
            float(section["extent"]["length_mm"]),
            str(section.get("branch_name", section.get("vessel_name", ""))),
            tuple(map(cls._limb, section["limbs"])),
        )

    @classmethod
    def _limb(cls, section: Mapping[str, Any]) -> Reported:
        names = ("minimum_mm", "percent_diameter", "reference_mm")
        minimum, percent, reference = (float(section[name]) for name in names)
        place = np.array(section["place_mm"], dtype=float)
        return cls(place, minimum, percent, reference, np.nan, str(section["branch_name"]))


@dataclass(frozen=True)
class Answer:
    """The reported lesions, the time in seconds, and the reason if the product failed."""

    reported: list[Reported]
    seconds: float
    failure: str = ""


def asked(folder: Path, by_command: bool) -> Answer:
    """The lesions of a saved case, by the installed command or by the same public functions."""
    surface, line = (folder / f"{name}.vtp" for name in FILES)
    start = time.perf_counter()
    try:
        sections = _of_command(surface, line) if by_command else _in_process(surface, line)
    except Exception as error:  # whatever ends the product is counted, the bench goes on
        return Answer([], time.perf_counter() - start, f"{type(error).__name__}: {error}"[:200])
    spent = time.perf_counter() - start
    return Answer([Reported.from_section(one) for one in sections], spent)


def _of_command(surface: Path, line: Path) -> Sequence[Mapping[str, Any]]:
    command = Path(sys.executable).with_name("sdfstent")
    run = subprocess.run(
        [command, "measure", surface, "--centerline", line, "--json"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    if run.returncode:
        raise RuntimeError(f"exit {run.returncode}: {run.stderr.strip()}")
    found: Sequence[Mapping[str, Any]] = json.loads(run.stdout)["lesions"]
    return found


def _in_process(surface: Path, line: Path) -> Sequence[Mapping[str, Any]]:
    from SDFStentLib.plan import read_input_files
    from SDFStentLib.report import lesion_facts

    lesions = read_input_files(str(surface), str(line)).vessel.lesions
    told = (lesion_facts(number, one) for number, one in enumerate(lesions or (), start=1))
    return [one.as_dict() for one in told]


def outlets_told(folder: Path) -> int | str:
    """Number of outlets of the flow's network of a saved case, or the reason why there is none."""
    from SDFStentLib.flow import FlowModel, known_flow
    from SDFStentLib.plan import read_input_files

    vessel = read_input_files(*(str(folder / f"{name}.vtp") for name in FILES)).vessel
    try:
        answer = FlowModel(vessel.channels, known_flow(10.0)).answer()
    except Exception as error:  # as above
        return f"{type(error).__name__}: {error}"[:200]
    return len(answer.networks[0].tree.outlets)


@dataclass(frozen=True)
class NarrowingVerdict:
    """The verdict on a narrowing: "as it is", `AS_LIMB` or the fault, and errors if found once.

    `place` and `extent` in mm, `minimum` and `reference` in percent, `percent` in points.
    """

    shape: str
    words: str
    place: float | None = None
    minimum: float | None = None
    percent: float | None = None
    reference: float | None = None
    extent: float | None = None

    @property
    def is_right(self) -> bool:
        return self.words == "as it is"


def judged(
    tree: VesselTree, wall: Wall | None, truths: Sequence[Truth], reported: Sequence[Reported]
) -> tuple[list[NarrowingVerdict], list[str]]:
    """A verdict for every narrowing, and sentences about lesions that were invented."""
    left = list(reported)
    verdicts = []
    for truth in truths:
        mine = [one for one in left if _belongs(truth, one.place)]
        left = [one for one in left if not any(one is other for other in mine)]
        verdicts.append(_or_as_limb(truth, _verdict(truth, mine), reported))
    invented = []
    for one in left:
        if one.percent >= INVENTED[0]:
            degree = degree_beside(tree, wall, one.place)
            if degree < INVENTED[1]:
                place = ", ".join(f"{x:.1f}" for x in one.place)
                invented.append(
                    f"{one.percent:.0f} % at ({place}), {one.minimum:.2f} against "
                    f"{one.reference:.2f} mm, {one.name}; true: {degree:.0f} %"
                )
    return verdicts, invented


def _or_as_limb(
    truth: Truth, verdict: NarrowingVerdict, reported: Sequence[Reported]
) -> NarrowingVerdict:
    """A verdict, or that a narrowing which is not told as it is by a lesion is by its limb."""
    limbs = [limb for one in reported for limb in one.limbs if _belongs(truth, limb.place)]
    if verdict.is_right or len(limbs) != 1:
        return verdict
    as_limb = _verdict(truth, limbs)
    words = {"as it is": AS_LIMB, "minimum": f"minimum, {AS_LIMB}"}.get(as_limb.words)
    return replace(as_limb, words=words) if words else verdict


def _belongs(truth: Truth, place: np.ndarray) -> bool:
    """Whether a place lies near the middle of a vessel where, or beside where, it is narrowed."""
    along = np.array(truth.along)
    inner = (along >= along[truth.begin] - _ZONE) & (along <= along[truth.end] + _ZONE)
    # A sphere beside a line, as in a throat at a fork, is the truth's own.
    middles = np.vstack([np.array(truth.stations)[inner], truth.place])
    widths = np.append(np.array(truth.diameter)[inner], truth.minimum)
    # Farther aside it is in a branch that leaves there, narrowed at its ostium by the same wall.
    return bool((np.linalg.norm(middles - place, axis=1) <= widths / 4 + 0.25).any())


def _off(percent: float, truth: Truth) -> float:
    """By how many points a degree is off, or 0 between those against the two sides."""
    sides = [side for side in (truth.proximal, truth.distal) if side is not None]
    degrees = [truth.percent, *(100 * (1 - truth.minimum / side) for side in sides)]
    if min(degrees) <= percent <= max(degrees):
        return 0.0
    return percent - truth.percent


def _verdict(truth: Truth, mine: Sequence[Reported]) -> NarrowingVerdict:
    if not mine:
        return NarrowingVerdict(truth.shape, "missed")
    if len(mine) > 1:
        return NarrowingVerdict(truth.shape, "split")
    one = mine[0]
    # A long throat has no single narrowest place.
    wide = np.array(truth.diameter)
    narrow = np.flatnonzero(wide <= 1.05 * truth.minimum)
    narrow = narrow[(narrow >= truth.begin) & (narrow <= truth.end)]
    places = np.vstack([np.array(truth.stations)[narrow], truth.place])
    place = float(np.linalg.norm(places - one.place, axis=1).min())
    minimum = 100 * (one.minimum / truth.minimum - 1)
    percent = _off(one.percent, truth)
    wrong = [
        word
        for word, error, limit in (
            ("place", place, PLACE), ("minimum", minimum, MINIMUM), ("percent", percent, PERCENT),
        )
        if abs(error) > limit
    ]  # fmt: skip
    return NarrowingVerdict(
        truth.shape, ", ".join(wrong) or "as it is", place, minimum, percent,
        100 * (one.reference / truth.reference - 1), one.length - truth.length,
    )  # fmt: skip
