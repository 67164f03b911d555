"""The report on treated narrowings, held against spheres that brute force finds in the result.

Every narrowing that was found is sized by `suggest` and treated by `run`, as installed commands.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from ..common import Found, markdown
from .case import load, read_wall
from .judge import FILES, MINIMUM, PERCENT, PLACE, asked
from .surface import Wall
from .truth import Spheres, Truth, VesselCourse, profile

ERRORS = {
    "lumen": (MINIMUM, "narrowest lumen over the stent, %"),
    "left": (MINIMUM, "sphere at the narrowest place left, %"),
    "lesion": (PERCENT, "lesion after, points"),
}
"""Compared numbers: the largest error that counts as none, and words."""


def of_case(folder: Path) -> list[Found]:
    """A treatment for each narrowing of a saved case; `failure` if a command ended otherwise."""
    _, truths, _ = load(folder)
    reported = asked(folder, by_command=False).reported
    found = []
    for number, truth in enumerate(truths):
        apart = [float(np.linalg.norm(one.place - truth.place)) for one in reported]
        if min(apart, default=np.inf) > PLACE:
            continue
        with TemporaryDirectory() as made:
            one = _treated(folder, Path(made), int(np.argmin(apart)), truth)
        found.append({"case": folder.name, "narrowing": number, "shape": truth.shape, **one})
    return found


def _treated(folder: Path, made: Path, lesion: int, truth: Truth) -> Found:
    surface, line = (folder / f"{name}.vtp" for name in FILES)
    plan, out = made / "plan.json", made / "out"
    command = Path(sys.executable).with_name("sdfstent")
    size = [
        command, "suggest", surface, "--centerline", line, "--lesion", str(lesion + 1), "-o", plan
    ]  # fmt: skip
    for one in (size, [command, "run", plan, "-o", out]):
        run = subprocess.run(one, capture_output=True, text=True, check=False)
        if run.returncode not in (0, 3):
            return {"failure": f"{one[1]}: exit {run.returncode}: {run.stderr.strip()[-200:]}"}
    report = json.loads((out / "report.json").read_text(encoding="utf-8"))
    (stent,) = report["stents"]
    wall = read_wall(out / "surface_stented.vtp")
    stations = np.array(truth.stations)
    wide = _inscribed(wall, truth, stent["lumen_diameter_mm"])
    ends = [np.array(stent["axis"][f"{end}_mm"]) for end in ("start", "end")]
    first, last = sorted(int(np.linalg.norm(stations - one, axis=1).argmin()) for one in ends)
    lumen = stent["diameters"]["over_stented_length"]["after"]["minimum_mm"]
    left, lesions = report["left"], report["lesions"]
    after = next(one["after"] for one in lesions if one["number"] == lesion + 1)
    if left is None or left["minimum_mm"] is None or after is None:
        return {"failure": "what is left is not told"}
    place = np.array(left["place_mm"])
    there = 2 * Spheres(wall, place[None], 2 * left["minimum_mm"] + 3).radius_at(place)
    return {
        "failure": "",
        "is_certified": report["certificate"]["passed"],
        "lumen": 100 * (lumen / wide[first : last + 1].min() - 1),
        "left": 100 * (left["minimum_mm"] / there - 1),
        "lesion": after["percent_diameter"] - _degree(truth, wide),
    }


def _inscribed(wall: Wall, truth: Truth, lumen: float) -> np.ndarray:
    """Diameters (n,) of the largest spheres across a vessel with a stent of some lumen, mm."""
    stations, wide = np.array(truth.stations), np.maximum(truth.own, lumen)
    ways = np.gradient(stations, axis=0)
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    spheres = Spheres(wall, stations, 1.4 * float(wide.max()) + 1)
    return profile(spheres, VesselCourse(np.array(truth.along), stations, ways, wide / 2))[1]


def _degree(truth: Truth, wide: np.ndarray) -> float:
    """Percent by diameter that diameters (n,) leave of a narrowing, from the interpolated truth.

    The truth is nowhere wider than the vessel before narrowing, as it spans both of two in tandem.
    """
    inner = slice(truth.begin, truth.end + 1)
    along, sides = np.array(truth.along)[inner], (truth.proximal, truth.distal)
    known = [one for one in sides if one is not None]
    healthy = np.interp(along, along[[0, -1]], [known[0], known[-1]])
    healthy = np.minimum(healthy, np.array(truth.own)[inner])
    return float(100 * (1 - wide[inner] / healthy).max())


def sentences(treatments: Sequence[Found]) -> Iterator[str]:
    """Sentences about what is wrong in treatments."""
    for one in treatments:
        start = f"{one['case']}, narrowing {one['narrowing']} ({one['shape']}): "
        if one["failure"]:
            yield start + one["failure"]
            continue
        if not one["is_certified"]:
            yield start + "not certified"
        for name, (most, words) in ERRORS.items():
            if abs(one[name]) > most:
                yield f"{start}{words}: {one[name]:+.1f}"


def table(treatments: Sequence[Found]) -> str:
    """The number of correct reports, and the errors."""
    done = [one for one in treatments if not one["failure"]]
    rows = []
    for name, (most, words) in ERRORS.items():
        errors = np.abs([one[name] for one in done])
        median, high = np.percentile(errors, [50, 95])
        right = f"{(errors <= most).sum()} of {len(done)}"
        rows.append([words, f"{most:g}", right, f"{median:.2f}, {high:.2f}"])
    certified = sum(one["is_certified"] for one in done)
    return (
        markdown(["told after treatment", "at most", "right", "median, 95th percentile"], rows)
        + f"\n\n{len(treatments)} treatments, {certified} certified, "
        f"{len(treatments) - len(done)} that ended in an error or a refusal."
    )
