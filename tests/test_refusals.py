"""What each command refuses: one sentence that names what was expected, and nothing is written."""

import json
import shlex
import shutil

import numpy as np
import pytest
from cohort_cases import document, tube_folder, write_sweep
from test_devices import ROW, SHORT, a_table
from tube_files import INPUTS, write_wall
from vtkmodules.util.numpy_support import vtk_to_numpy

from benchmarks.phantoms import stenosed_tube, straight_tube
from SDFStentLib.files import encode_vtp, polydata_from_arrays, polydata_from_lines

CENTERLINE = "--centerline line.vtp"
LENGTH = "--center 0 0 2 --length 20"
LONG = "a" * 300
HUGE = 10**308


def deploy(
    more="", surface="tube.vtp", line=CENTERLINE, place=LENGTH, size="--diameter 6", out="out.vtp"
):
    """The words of a deployment in the tube."""
    return f"deploy {surface} --units cm {line} {place} {size} -o {out} {more}".strip()


def made(folder):
    """The tube with whatever the commands below name."""
    tube_folder(folder)
    big = "x" * 140_000
    for name, data in {
        "cr.csv": b"fraction,diameter\r0,6\r1,7\r",
        "crlf.csv": b"fraction,diameter\r\n0,6\r\n1,7\r\n",
        "mixed.csv": b"fraction,diameter\r0,6\n\r\n1,7",
        "quoted.csv": b'fraction,diameter\r"0","6"\r1,7',
        "field.csv": f"fraction,diameter\n0,{big}\n1,7\n".encode(),
        "text.csv": f'fraction,diameter\n0,"{big}\n1,7\n'.encode(),
        "header.csv": f"{big},diameter\n0,6\n1,7\n".encode(),
        "nul.csv": b"fraction,diameter\n0,\x006\n1,7\n",
    }.items():
        (folder / name).write_bytes(data)
    for name, axes in {
        "uniform": {"diameter": {"uniform": [-HUGE, HUGE]}},
        "normal": {"diameter": {"normal": [6, HUGE]}},
        "within": {"lesion": 1, "offset": {"normal": [0, 1], "within": [-HUGE, HUGE]}},
        "listed": {"diameter": [6, HUGE]},
        "steps": {"diameter": {"from": -HUGE, "to": HUGE, "steps": 5}},
    }.items():
        sampling = {"method": "sobol", "count": 4}
        changes = {} if name in ("listed", "steps") else {"sampling": sampling}
        text = json.dumps(document(axes={"length": 10, **axes}, **changes))
        (folder / f"{name}.json").write_text(text, encoding="utf-8")
    stent = {"diameter": 0.1, "length": 55, "placement": {"center": [0, 0, 2]}}
    plan = document()["plan"] | {"stents": [stent]}
    (folder / "thin.json").write_text(json.dumps(plan), encoding="utf-8")
    shutil.copy(folder / "thin.json", folder / "same.json")
    plan = document()["plan"] | {"flow": {"mean": 1, "peak": HUGE}}
    (folder / "flow.json").write_text(json.dumps(plan), encoding="utf-8")
    for name, other in {
        "wall": {"surface": {"file": "healthy.vtp"}},
        "root": {"root": [0, 0, 4]},
    }.items():
        plan = document()["plan"] | {"inputs": INPUTS | other}
        (folder / f"{name}.json").write_text(json.dumps(plan), encoding="utf-8")


def bad_files(folder):
    (folder / "empty.vtp").touch()
    (folder / "short.vtp").write_bytes((folder / "tube.vtp").read_bytes()[:900])
    (folder / "noise.stl").write_bytes(bytes(range(256)) * 20)
    (folder / "folder").mkdir()
    (folder / "others").mkdir()
    (folder / "others" / "thesis.txt").touch()
    vessel = stenosed_tube(edge_length=1.0)
    broken = polydata_from_arrays(vessel.points / 10, vessel.triangles)
    vtk_to_numpy(broken.GetPoints().GetData())[7] = np.nan
    one = [[0.0, 0, 2.0], [0.0, 0, 2.0]]
    shifted = vessel.centerline.points / 10 + np.array([20.0, 0, 0])
    for name, data in (
        ("nan", broken),
        ("wider", polydata_from_arrays(vessel.points / 10 * [1.3, 1.3, 1], vessel.triangles)),
        ("one", polydata_from_lines(one, [np.arange(2)])),
        ("away", polydata_from_lines(shifted, [np.arange(len(shifted))])),
        (
            "millimeters",
            polydata_from_lines(shifted * 10 - np.array([200.0, 0, 0]),
                                         [np.arange(len(shifted))]),
        ),
    ):  # fmt: skip
        (folder / f"{name}.vtp").write_bytes(encode_vtp(data))
    (folder / "p.csv").write_text("fraction,diameter\n0,6\n1,6\n0.5,5\n", encoding="utf-8")
    (folder / "own.json").write_text(a_table(ROW, SHORT), encoding="utf-8")
    write_sweep(folder)
    healthy = straight_tube(edge_length=1.0)
    write_wall(folder / "healthy.vtp", healthy.points / 10, healthy.triangles)


TOO_LONG = "csv: expected rows of fraction,diameter, got what is none (field larger than field"
RANGE = "expected a number at least -1e+06 and at most 1e+06, got "
FLOW = "peak flow: expected a number greater than 0 and at most 10000 (mL/s), got 1e+308"
DEVICE = "--device-table own.json"
SUGGEST = f"suggest tube.vtp --units cm {CENTERLINE}"
MEASURE = "measure tube.vtp --units cm"
EXTRACT = f"extract tube.vtp --units cm {CENTERLINE} -o seg"
FLOWING = f"flow tube.vtp --units cm {CENTERLINE} --json f.json"
SIMULATE = f"simulate tube.vtp --units cm {CENTERLINE} --after wider.vtp --mean-flow 20mL/s -o new"
REFUSED = {
    # Surfaces and lines.
    deploy(surface="none.vtp"): "none.vtp: no such file",
    deploy(surface="empty.vtp"): "empty.vtp: expected a mesh or a line, got an empty file",
    deploy(surface="short.vtp"): "short.vtp: ",
    deploy(surface="noise.stl"): "noise.stl: ",
    deploy(surface="folder"): "folder: expected a file, got a folder",
    deploy(surface="line.vtp"): "expected a surface of triangles, got none",
    deploy(surface="nan.vtp"): "expected finite coordinates, got NaN or infinity at 1",
    deploy(line="--centerline one.vtp"): "expected a line of at least two different points",
    deploy(line="--centerline tube.vtp"): "expected a centerline of lines",
    deploy(line="--centerline away.vtp"): "away.vtp: expected it inside tube.vtp",
    deploy(line="--centerline millimeters.vtp"): "different units",
    # Places.
    deploy(place="--center 9 9 9 --length 9"): "center: expected a point with",
    deploy(place="--center nan 0 0 --length 9"): "expected three finite",
    deploy(place="--center 0,0,2"): "expected three numbers with spaces between them",
    deploy(place="--center 0 0 2"): "expected --length L (mm) with --center",
    deploy(place=""): "expected where the stent goes, got nothing",
    deploy(place="--from 0 0 2"): "expected both --from and --to",
    deploy("--axis axis.vtp"): "expected one place, got --center and --axis",
    deploy(place="--from 0 0 1 --to 0 0 2 --length 9"): "expected no --length between two points",
    deploy(line=""): "expected --centerline FILE with --center",
    # Sizes.
    deploy(size="--diameter 0"): "stent diameter: expected a number greater than 0",
    deploy(size="--diameter nan"): "stent diameter: expected a number",
    deploy(size="--diameter 101"): "at most 100 (mm), got 101",
    deploy(size="--diameter 90"): "and the unit of the files (--units mm, cm or m).",
    deploy(size="--diameter wide"): "argument --diameter: expected a number, got 'wide'",
    deploy(size=""): "expected --diameter D of the lumen or --balloon D, got neither; give one",
    deploy("--balloon 7"): "expected either --diameter, of the lumen, or --balloon, got both",
    deploy("--recoil 7"): "recoil: expected a number at least 0 and at most 0.5, got 7",
    deploy(size="--balloon=-7"): "balloon diameter: expected a number greater than 0",
    deploy("--redilate 5"): "redilation: expected more than the 6 mm of stent 1, got 5 mm",
    deploy("--keep top"): "invalid choice: 'top'",
    # Shapes.
    deploy("--waist 7"): "waist: expected at most the 6 mm of the stent, got 7 mm",
    deploy("--waist-position 0.5"): "expected --waist D with --waist-position, got none",
    deploy("--waist-length 5"): "expected --waist D with --waist-length, got none; give",
    deploy("--profile p.csv"): "expected --profile alone, which has all diameters, got it",
    deploy("--profile p.csv", size=""): "expected fractions that rise from 0 to 1, each once, got",
    deploy("--profile none.csv", size=""): "none.csv: no such file",
    deploy("--flare-start 9 30"): "expected at most its length of 18.0 mm, got 30 mm",
    deploy("--cap-height 2"): "cap height: expected a number at least 0.1 and at most 1",
    # Devices.
    deploy(f"--device bench {DEVICE}"): "expected a known one (such as bench-34, bench-16), got",
    deploy(f"--device bench-16 {DEVICE}"): "expected 16 mm, the length of bench-16, got 20 mm",
    deploy(f"--device numed-cp {DEVICE}"): "of its length it loses (--foreshortening F), or",
    deploy(f"--device bench-34 {DEVICE}", size="--diameter 23"): "expected at most 22 mm",
    deploy(DEVICE): "expected --device NAME with --device-table, got none; name one.",
    deploy("--device x --device-table none.json"): "none.json: no such file",
    deploy("--export-device d.stl"): "expected a device that ends in .vtp",
    deploy("--device-mesh tube.vtp"): "expected --export-device F with --device-mesh",
    deploy("--export-device d.vtp --device-mesh no.vtp"): "no.vtp: no such file",
    deploy("--export-device d.vtp --device-mesh line.vtp"): "line.vtp: ",
    deploy("--export-device tube.vtp"): "expected another file than the input",
    # The method and outputs.
    deploy("--influence=-1"): "influence_distance: expected a number at least 0.05",
    deploy("--tissue-gap=-1"): "tissue_gap: expected a number at least 0 and",
    deploy("--straighten 2"): "straightening fraction: expected a number",
    deploy("--falloff x"): "invalid choice: 'x'",
    deploy("--foreshortening 0.9"): "foreshortening: expected a number",
    deploy("--waists 3"): "unrecognized arguments: --waists 3",
    deploy("--output-centerline c.stl"): "c.stl: expected one of .vtp, .vtk",
    deploy(out="out.xyz"): "out.xyz: expected a surface that ends in .vtp, .vtk, .stl, .ply, .obj",
    deploy(out="none/out.vtp"): "expected an existing folder",
    deploy(out="tube.vtp"): "tube.vtp: expected another file than the input",
    deploy("--report r.txt"): "ends in .json, .html, got '.txt'; rename it.",
    deploy("--report r.json --report r.json"): "two outputs have this name",
    deploy("--figure f.gif"): "f.gif: expected a figure that ends in .png",
    deploy("--picture f.svg"): "f.svg: expected a picture that ends in .png",
    deploy("--every 1"): "expected --steps DIR with --every",
    deploy("--steps s --every 0"): "--every: expected a number greater than 0",
    deploy("--steps tube.vtp"): "tube.vtp: expected a folder, got a file",
    deploy("--steps no/s"): "no/s: expected an existing folder",
    # Flows.
    deploy("--mean-flow 0mL/s"): "--mean-flow: expected a number greater than 0",
    deploy("--mean-flow 5"): "--mean-flow: expected a flow with its unit",
    deploy("--wedge 5"): "expected --mean-flow Q",
    deploy("--right 0 0 2"): "expected --mean-flow Q",
    deploy("--export-0d nets"): "expected --mean-flow Q",
    deploy("--mean-flow 5mL/s", line="", place="--axis axis.vtp"): "flow: expected a centerline",
    deploy("--mean-flow 5mL/s --split-right 0.5"): "(--right X Y Z), or",
    FLOWING: "expected --mean-flow Q",
    f"{FLOWING} --mean-flow 50": "--mean-flow: expected a flow with its unit",
    f"{FLOWING} --mean-flow=-5mL/s": "greater than 0",
    f"{FLOWING} --mean-flow -.5L/min": "greater than 0",
    f"{FLOWING} --mean-flow -3": "such as 41.7mL/s or 2.5L/min, got '-3'",
    f"{FLOWING} --mean-flow 50mL/s --wedge 5": "that of the wedge alone",
    f"{FLOWING} --mean-flow 200mL/s --inlet-pressure 13 --wedge 12.9": (
        "expected more than the vessel itself costs"
    ),
    f"{FLOWING} --mean-flow 50mL/s --wave none.csv": "none.csv",
    f"{FLOWING} --mean-flow 50mL/s --report f.txt": "f.txt",
    "simulate tube.vtp -o new": "got no --after",
    "simulate --read sim --after wider.vtp": "got --after, too",
    f"{SIMULATE} --from 0 0 1": "got one; name both ends",
    f"{SIMULATE} --after tube.vtp": "expected a wall that moved",
    f"{SIMULATE} --mean-flow 0mL/s": "mean-flow",
    f"{SIMULATE} --edges-round 2": "--edges-round",
    f"{SIMULATE} --inlet-pressure 25 --wedge 8 --inlet-pressure 7": "contradict each other",
    # Lesions.
    deploy(place="--at-lesion 1"): "expected --length L (mm) with --at-lesion",
    deploy(place="--at-lesion 0 --length 9"): "--at-lesion: expected 1, as the vessel has",
    deploy(place="--at-lesion 2 --length 9"): "got 2; see",
    deploy(place="--at-lesion 1.5 --length 9"): "expected a whole number, got '1.5'",
    deploy(place="--at-lesion 1 --length 9", line=""): "expected --centerline FILE with",
    deploy("--at-lesion 1"): "expected one place, got --center and --at-lesion",
    deploy(place="--at-lesion 1 --length 9", surface="healthy.vtp"): "in which none of 15 %",
    deploy("--reference 2 0 1", place="--at-lesion 1 --length 9"): "expected a place inside of the",
    deploy(
        "--reference 2 0 1", line="", place="--axis axis.vtp"
    ): "FILE with --reference, got none",
    f"{SUGGEST} --lesion 2": "--lesion: expected 1, as the vessel has one lesion, got 2; see",
    f"{SUGGEST} --lesion 0": "--lesion: expected 1, as the vessel has one lesion, got 0; see",
    f"{SUGGEST} --ratio 5": "ratio to the adjacent vessel: expected a number at least 0.2 and at",
    f"{SUGGEST} --margin=-1": "margin: expected a number at least 0",
    f"{SUGGEST} --device numed-cp": "its shortening is not known; say how much of its length it",
    f"{SUGGEST} --device none": "device: expected a known one",
    f"{SUGGEST} --device-table x.json": "expected --device NAME with --device-table, got none",
    f"{SUGGEST} -o line.vtp": "expected another file than the input",
    SUGGEST.replace("tube", "healthy"): "none of 15 % or more was found; there is",
    # Other commands.
    MEASURE: "expected --axis FILE or --centerline FILE",
    f"{MEASURE} {CENTERLINE} --length 5": "expected a place with --length",
    f"{MEASURE} --axis axis.vtp --csv no.csv": "expected --centerline FILE with --csv, got none",
    f"{MEASURE} --axis axis.vtp --reference 0 0 1": "FILE with --reference, got none",
    f"measure healthy.vtp {CENTERLINE} --reference 0 0 1": "expected a vessel with a lesion to mea",
    f"{MEASURE} --axis axis.vtp --spacing 0": "--spacing: expected a number greater than 0",
    f"{MEASURE} {CENTERLINE} --tables --spacing 1e-9": "at least 0.002 (mm) on a line of 40 mm",
    f"{MEASURE} {CENTERLINE} --csv tube.vtp": "expected another file than the input",
    "run none.json -o new": "none.json: no such file",
    "run tube.vtp -o new": "tube.vtp: expected a",
    "run thin.json -o tube.vtp": "tube.vtp: expected a folder, got a file",
    "run thin.json -o new --export-0d nets": "expected a plan with a flow for --export-0d",
    "run thin.json -o a/b": "a/b: expected an existing folder",
    "measure x --axis y --root 0 0 1": "expected --centerline FILE with --root",
    "compare thin.json -o out": "expected two or more plans to compare, got 1",
    "compare thin.json wall.json -o out": "thin and wall: expected plans of one surface in one",
    "compare thin.json root.json -o out": "expected plans with one centerline, root and reference",
    f"{EXTRACT} --from 0 0 1": "the following arguments are required: --to",
    f"{EXTRACT} --from 0 0 0.8 --to 0 0 0.8": "expected two places apart",
    f"{EXTRACT} --from 0 0 8 --to 0 0 32": "their unit (mm, cm)",
    f"{EXTRACT} --from 2 0 1 --to 0 0 3": "got one 20.0 mm from its",
    f"{EXTRACT} --from nan 0 1 --to 0 0 3": "--from: expected three finite",
    f"{EXTRACT} --from 0 0 1 --to 0 0 3 --after none.vtp": "none.vtp: no such file",
    f"{EXTRACT} --from 0 0 1 --to 0 0 3 -o others": "got one that holds thesis.txt",
    f"{EXTRACT} --from 0 0 1 --to 0 0 3 -o tube.vtp": "expected a folder, got a file",
    "app no.vtp": "no.vtp: expected a file, got none",
    "app --folder nowhere": "nowhere: expected a folder, got none",
    "app --centerline c.vtp": "expected a surface beside it",
    "app --units cm": "--units: expected a surface beside it, got none",
    "app scan.nii.gz --units cm": "--units: expected a surface beside it, got none",
    "app scan.seg.nrrd --centerline c.vtp": "expected a surface beside it",
    "app tube.vtp --demo": "expected no file beside it",
    "app --port 70000": "expected 0 to 65535, got 70000",
    "app --pages 0": "expected at least 1, got 0",
    "app --keep -1": "expected 0 to 86400 s, got -1",
    "app own.json": "own.json",
    "sweep": "expected one of SWEEP, --table DIR and --status DIR",
    "sweep sweep.json --table out": "expected one of SWEEP",
    "sweep sweep.json": "expected -o DIR",
    "sweep none.json -o out": "none.json",
    "sweep sweep.json -o no/such": "no/such: cannot be written",
    "sweep sweep.json -o out --workers 0": "workers: expected a whole",
    "sweep sweep.json -o o --workers 1 --scheduler a": "got both",
    "sweep --status .": "expected the folder of a cohort",
    "sweep --table nowhere": "expected the folder of a cohort",
    # What once ended in "unexpected error".
    deploy("--profile field.csv", size=""): TOO_LONG,
    deploy("--profile text.csv", size=""): TOO_LONG,
    deploy("--profile header.csv", size=""): TOO_LONG,
    deploy("--profile nul.csv", size=""): "expected",
    "sweep uniform.json --dry-run": f"axes.diameter.uniform[0]: {RANGE}-1000",
    "sweep uniform.json -o out": f"axes.diameter.uniform[0]: {RANGE}-1000",
    "sweep normal.json --dry-run": f"axes.diameter.normal[1]: {RANGE}1000",
    "sweep within.json --dry-run": f"axes.offset.within[0]: {RANGE}-1000",
    "sweep listed.json --dry-run": f"axes.diameter[1]: {RANGE}1000",
    "sweep steps.json --dry-run": f"axes.diameter.from: {RANGE}-1000",
    deploy("--mean-flow 1mL/s --peak-flow 1e308mL/s"): "--peak-flow: expected a number",
    deploy("--mean-flow 1e308mL/s"): "at most 10000 (mL/s), got 1e+308; choose such a number",
    "run flow.json -o out": FLOW,
    f"demo -o {LONG}": "cannot be written (File name too long)",
    f"extract tube.vtp --units cm --centerline line.vtp --from 0 0 1 --to 0 0 3 -o {LONG}": (
        "cannot be written (File name too long)"
    ),
    deploy(f"--steps {LONG}"): "cannot be written (File name too long)",
    deploy(f"--report {LONG}.json"): "cannot be written (File name too long)",
    deploy(f"--report {LONG}/r.json"): "cannot be written (File name too long)",
    f"run thin.json -o {LONG}": "cannot be written (File name too long)",
    f"compare thin.json same.json -o {LONG}": "cannot be written (File name too long)",
    f"sweep listed.json -o {LONG}": "",
    f"sweep --status {LONG}": "expected the folder of a cohort",
    f"measure tube.vtp --units cm --centerline line.vtp --csv {LONG}.csv": (
        "cannot be written (File name too long)"
    ),
    f"check {LONG}.vtp": "cannot be read (File name too long)",
    f"app {LONG}.vtp": "expected a file",
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The tube with whatever the commands name."""
    folder = tmp_path_factory.mktemp("refusals")
    made(folder)
    bad_files(folder)
    return folder


@pytest.mark.parametrize("command", REFUSED, ids=lambda text: text.replace(LONG, "LONG")[-60:])
def test_what_cannot_be_done_is_one_sentence_and_nothing_is_written(folder, command, shell):
    before = sorted(folder.rglob("*"))
    done = shell(*shlex.split(command), folder=folder)
    assert (done.returncode, done.stdout) == (2, ""), done.stderr
    assert done.stderr.startswith(f"sdfstent {command.split()[0]}: ")
    assert REFUSED[command] in done.stderr
    assert done.stderr.count("\n") == 1
    assert sorted(folder.rglob("*")) == before
