"""The same answers: the output of the installed command, kept and compared with an earlier one.

python -m benchmarks.same_answers FOLDER                    keep (two cores: 3.5 minutes) python -m
benchmarks.same_answers OLD NEW [--but KEY ...]   compare

Points, cells and arrays have to be the same bit for bit; tables, sentences (key `said`) and JSON
the same but for times and for keys that are named. Pages and pictures are not looked at.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shlex
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

import vtk

from SDFStentLib.files import add_arrays, encode_vtp, polydata_from_arrays, polydata_from_lines

from . import phantoms
from .sweep import DATA_FOLDER

PLACES = {
    "stenosed_tube": ("mm", "0 0 20", "0 0 12", "0 0 28", 5.4),
    "bent_tube": ("mm", "4.393 0 20.607", "0.315 0 13.047", "11.953 0 24.685", 6.9),
    "helix_tube": ("mm", "-0.24 -7.996 10.433", "-7.551 -2.641 7.75", "7.379 -3.089 13.117", 5.8),
    "hairpin_tube": ("mm", "4 0 37.633", "-1.972 0 31.056", "9.972 0 31.056", 6.9),
    "arch_with_coarctation": ("mm", "-16.1 -32.2 15.8", "-16.1 -32.2 26", "-16.1 -32.2 5.8", 14),
    "branching_pulmonary_artery": ("mm", "-2.69 0 27.47", "-2.4 0 27", "-9.99 0 34.12", 7),
    "tube_with_neighbor": ("mm", "0 0 20", "0 0 12", "0 0 28", 5.4),
    "vascular_tree": ("mm", "28.66 3.83 69.05", "22.37 0 63.77", "33.58 11.49 73.18", 9.1),
    "pulmonary": ("cm", "-1.211 -2.064 6.041", "-.538 -2.634 6.419", "-1.987 -1.582 5.688", 8.7),
    "aorta_iliac": ("cm", ".411 2.857 -9.448", ".589 3.171 -8.6", ".202 2.126 -10.08", 18.4),
    "su0243": ("mm", "-39.5 -85.4 -73.3", "-32.36 -88.1 -68.6", "-44.9 -87.36 -81.05", 6.5),
    "vmtk_aorta": ("mm", "228.25 127.5 24", "227 130 23.7", "230.5 117.9 25.4", 14),
    "tree_narrowed": ("mm", "-40.2 -275.3 -127.3", "-31.3 -279.6 -126.2", "-49.2 -272.4 -130.2", 5),
}
"""Unit of the files; middle of the stent; its ends in another run; its diameter, mm."""
EVERYWHERE = {
    "deploy": "deploy {wall} --center {center} --length 12 --diameter {diameter} -o o.vtp --arrays"
    " --output-centerline l.vtp --report r.json --save-plan first.json --verbose",
    "between": "deploy {wall} --from {start} --to {end} --diameter {diameter} -o o.vtp"
    " --report r.json --mean-flow 9mL/s --export-0d networks --export-device d.vtp",
    "twice": "deploy {wall} --center {center} --length 14 --balloon {diameter} --redilate {wider}"
    " --keep proximal -o o.vtp --report r.json",
    "measure": "measure {wall} --tables --from {start} --to {end} --json",
    "lesions": "measure {wall} --verbose --csv lesions.csv",
    "suggest": "suggest {wall} -o p.json --json",
    "extract": "extract {wall} --from {start} --to {end} -o cut --close-branches",
}
STENT = (
    "deploy {wall} --center {center} --length 12 --diameter {diameter} -o o.vtp --report r.json "
)
OPTIONS = (
    "--waist 5 --waist-position .4 --waist-length 3", "--flare-start 8 3 --flare-end 6 4",
    "--cap-height .4", "--recoil .1", "--foreshortening .2 --keep distal", "--device generic",
    "--influence 4 --smoothing 0", "--smoothing 1 --capsule .5", "--tissue-gap 0", "--step .3",
    "--falloff wendland --blend quadratic", "--falloff cosine --blend exponential",
    "--rule published", "--rule published --step .2 --tissue-gap 0", "--smooth-axis 6",
    "--straighten .5", "--no-compensation", "--steps steps --every 1", "--root -9.99 0 34.12",
    "--reference 0 0 10", "--length 28", "--length 90 --shortened", "--length 90", "--units cm",
)  # fmt: skip
LATER = {
    "run": "run ../{vessel}-deploy/first.json -o o",
    "compare": "compare ../{vessel}-deploy/first.json ../{vessel}-suggest/p.json -o o",
    "after": "extract {wall} --from {start} --to {end} -o cut --after ../{vessel}-between/o.vtp",
    "sweep": "sweep ../inputs/sweep.json -o o --workers 1",
    "check": "check ../{vessel}-deploy/o.vtp --json",
    "axis": "deploy {surface} --axis ../inputs/stenosed_tube_line.vtp --diameter 7 -o o.vtp",
    "along": "measure {surface} --axis ../inputs/stenosed_tube_line.vtp --json",
    "lesion": "deploy {wall} --at-lesion 1 --length 14 --balloon 7 -o o.vtp --report r.json",
    "devices": "devices --json",
    "demo": "demo -o o",
}
"""Runs with the branching artery, once the others are done."""
SWEEP = {
    **{"schema": "sdfstent-sweep", "version": 1},
    "plan": "../branching_pulmonary_artery-deploy/first.json",
    "axes": {"diameter": {"uniform": [6, 8]}, "lesion": 1, "offset": {"uniform": [-2, 2]}},
    "sampling": {"method": "sobol", "count": 4, "seed": 1},
}
VARY = {"created", "timings", "seconds", "sdfstent_version", "process", "started", "host"}
"""Keys of JSON, beside those that end in `_s`, that differ from run to run or with the version."""


def runs() -> tuple[dict[str, str], dict[str, str]]:
    """Folder and words of every run: independent ones, and those that need files of others."""
    first, later = {}, {}
    for vessel, (units, *places, diameter) in PLACES.items():
        parts = [DATA_FOLDER / f"{vessel}_{part}_{units}.vtp" for part in ("surface", "centerline")]
        if hasattr(phantoms, vessel):
            parts = [Path("../inputs") / f"{vessel}{part}.vtp" for part in ("", "_line")]
        words = dict(zip(("center", "start", "end"), places, strict=True))
        words |= {"diameter": diameter, "wider": diameter + 1, "vessel": vessel}
        words["surface"] = f"{parts[0]} --units {units}"
        words["wall"] = f"{words['surface']} --centerline {parts[1]}"
        first |= {f"{vessel}-{run}": EVERYWHERE[run].format(**words) for run in EVERYWHERE}
        if vessel == "branching_pulmonary_artery":
            more = [(STENT + options).format(**words) for options in OPTIONS]
            first |= {f"option {number}": words for number, words in enumerate(more)}
            later = {run: LATER[run].format(**words) for run in LATER}
    return first, later


def write_inputs(folder: Path) -> None:
    """Write surfaces with face ids, and centerlines as VMTK gives them."""
    folder.mkdir(parents=True)
    (folder / "sweep.json").write_text(json.dumps(SWEEP), encoding="utf-8")
    for vessel in filter(partial(hasattr, phantoms), PLACES):
        made = getattr(phantoms, vessel)(**({"outlets": 8} if vessel == "vascular_tree" else {}))
        faces = {"ModelFaceID": made.face_ids}
        wall = polydata_from_arrays(made.points, made.triangles, cell_arrays=faces)
        tree = made.centerline
        root = tree.roots[0]
        ways = [way for way in map(tree.ancestry, tree.leaves.tolist()) if root in way]
        lines = polydata_from_lines(tree.points, ways)
        add_arrays(lines, {"MaximumInscribedSphereRadius": tree.inscribed_radius}, {})
        (folder / f"{vessel}.vtp").write_bytes(encode_vtp(wall))
        (folder / f"{vessel}_line.vtp").write_bytes(encode_vtp(lines))


def keep(folder: Path) -> None:
    """Carry out all runs, each in a folder of its own, as many at a time as there are cores."""
    write_inputs(folder / "inputs")

    def run(name: str, words: str) -> None:
        (folder / name).mkdir()
        command = [str(Path(sys.executable).with_name("sdfstent")), *shlex.split(words)]
        done = subprocess.run(command, cwd=folder / name, capture_output=True, text=True)
        said = re.sub(r"\d[\d.]* s\b", "... s", done.stdout + done.stderr)
        found = {"words": words, "code": done.returncode, "said": said.splitlines()}
        (folder / name / "said.json").write_text(json.dumps(found, indent=1), encoding="utf-8")

    for wave in runs():
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            list(pool.map(run, wave, wave.values()))


def content(path: Path, top: Path) -> Any:
    """The contents of a file that have to be the same."""
    if path.suffix == ".json":
        return json.loads(path.read_text(encoding="utf-8").replace(str(top), ""))
    if path.suffix != ".vtp":
        return None if path.suffix in (".html", ".png") else path.read_bytes()
    reader = vtk.vtkXMLPolyDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    data = reader.GetOutput()
    parts = {"points": data.GetPoints().GetData()}
    for cells in ("Lines", "Polys"):
        parts[cells] = getattr(data, f"Get{cells}")().GetConnectivityArray()
    for kind in (data.GetPointData(), data.GetCellData()):
        for at in range(kind.GetNumberOfArrays()):
            parts[kind.GetArrayName(at)] = kind.GetArray(at)
    return {name: bytes(memoryview(array)) for name, array in parts.items() if array}


def differences(old: Any, new: Any, where: str, but: set[str]) -> list[str]:
    """Places where two contents differ."""
    if isinstance(old, dict) and isinstance(new, dict):
        keys = {key for key in old | new if key not in but and not key.endswith("_s")}
        pairs = [(old.get(key), new.get(key), f"{where} {key}") for key in sorted(keys)]
    elif isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        pairs = [(*both, f"{where}[{at}]") for at, both in enumerate(zip(old, new, strict=True))]
    else:
        return [] if old == new else [where]
    return [found for pair in pairs for found in differences(*pair, but)]


def compare(tops: list[Path], but: set[str]) -> list[str]:
    """Files that are in one folder only, and places in files that differ."""
    found = []
    for name in sorted({path.relative_to(top) for top in tops for path in top.rglob("*.*")}):
        if all((top / name).is_file() for top in tops):
            both = [content(top / name, top) for top in tops]
            found += [] if name.stem == "times" else differences(*both, f"{name}:", but | VARY)
        else:
            found.append(f"{name}: in one folder only")
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folders", nargs="+", type=lambda name: Path(name).absolute())
    parser.add_argument("--but", nargs="+", default=[], help="keys that may differ")
    chosen = parser.parse_args()
    if len(chosen.folders) == 1:
        keep(chosen.folders[0])
        return 0
    found = compare(chosen.folders, set(chosen.but))
    print(*found, f"{len(found)} differences", sep="\n")
    return int(bool(found))


if __name__ == "__main__":
    sys.exit(main())
