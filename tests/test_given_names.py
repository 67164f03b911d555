"""What the user calls vessels comes first, wherever they are spoken of."""

import csv
import io
import json

import numpy as np
import pytest
from deployment_cases import ANATOMIES, anatomy
from tube_files import write_vessel

from benchmarks import phantoms
from SDFStentLib.cli import main
from SDFStentLib.files import read_surface
from SDFStentLib.files.formats.mdl_faces import LARGEST, mdl_face_names
from SDFStentLib.plan import load_plan, save_plan
from SDFStentLib.validation import InputError
from SDFStentLib.vessel import VesselName, branch_names, find_lesions, given_names

LEFT, RIGHT, MAIN = 3, 4, 2
"""Faces of the phantom's ends."""


@pytest.fixture(scope="module")
def artery():
    return phantoms.branching_pulmonary_artery()


@pytest.fixture(scope="module")
def a_tree():
    return phantoms.vascular_tree(4, 1.0)


@pytest.fixture
def a_patient(tmp_path, artery, monkeypatch):
    write_vessel(tmp_path, artery)
    monkeypatch.chdir(tmp_path)
    return tmp_path


FILES = ("pa.vtp", "--centerline", "line.vtp", "--units", "cm", "--names", "names.json")


def write_names(folder, names):
    text = names if isinstance(names, str) else json.dumps(names)
    (folder / "names.json").write_text(text, encoding="utf-8")


def at(artery, along=40.0):
    return (artery.axis_at(along)[0] / 10).tolist()


def test_a_vessel_is_called_as_the_user_does_in_every_command(a_patient, artery, capsys):
    write_names(a_patient, {"LPA": at(artery), "RPA": RIGHT})
    assert main(["measure", *FILES, "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert [lesion["branch_name"] for lesion in document["lesions"]] == ["LPA"]
    assert main(["measure", *FILES, "--tables"]) == 0
    titles = [
        line for line in capsys.readouterr().out.splitlines() if line.startswith(("LPA", "RPA"))
    ]
    assert [title.split(":")[0] for title in titles] == ["LPA", "RPA"]
    assert main(["suggest", *FILES, "-o", "plan.json"]) == 0
    plan = load_plan("plan.json")
    assert plan.names == (VesselName("LPA", tuple(10 * np.array(at(artery)))), VesselName("RPA", 4))
    assert main(["run", "plan.json", "-o", "results"]) == 0
    report = json.loads((a_patient / "results" / "report.json").read_text(encoding="utf-8"))
    assert [lesion["branch_name"] for lesion in report["lesions"]] == ["LPA"]
    assert [branch["name"] for branch in report["branches"]] == ["RPA"]
    assert load_plan("results/plan.json").names == plan.names
    where = ["--center", *map(str, at(artery, 30.0)), "--length", "14", "--diameter", "7.5"]
    told = ["-o", "out.vtp", "--report", "r.json", "--save-plan", "p.json"]
    assert main(["deploy", *FILES, *where, *told]) == 0
    report = json.loads((a_patient / "r.json").read_text(encoding="utf-8"))
    assert [branch["name"] for branch in report["branches"]] == ["RPA"]
    assert load_plan("p.json").names == plan.names
    ends = ["--from", *map(str, at(artery, 10.0)), "--to", *map(str, at(artery, 50.0))]
    assert main(["extract", *FILES, *ends, "--close-branches", "-o", "cut"]) == 0
    assert "RPA" in (a_patient / "cut" / "segment.json").read_text(encoding="utf-8")
    capsys.readouterr()
    assert main(["flow", *FILES, "--mean-flow", "40mL/s", "--json", "flow.json"]) == 0
    flow = json.loads((a_patient / "flow.json").read_text(encoding="utf-8"))
    assert "lesion 1, LPA" in json.dumps(flow)
    assert {"LPA", "RPA"} <= set(flow["before"]["mean"]["share"])
    assert main(["flow", *FILES[:-2], "--plan", "plan.json", "--mean-flow", "40mL/s"]) == 0
    assert "LPA" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("names", "said"),
    [
        ({"LPA": [9.0, 9.0, 9.0]}, "expected a place in a vessel, got (90, 90, 90) mm"),
        ({"LPA": 17}, "expected a face at an end of the centerline, [2, 3, 4], got 17"),
        ({"LPA": 1}, "expected a face at an end of the centerline"),  # the wall
        ({"LPA": LEFT, "left": "twice"}, "expected three numbers, a place in the vessel"),
        ({"LPA": LEFT, "left": [-1.1852, 0, 3.4917]}, "got a second one for that of 'LPA'"),
        ({"  ": LEFT}, "expected a name, got an empty one"),
        ({"LPA": LEFT, " LPA": RIGHT}, "got 'LPA' twice"),
        ('{"LPA": 3, "LPA": 4}', "'LPA'"),
        ({"LPA": [1.0, 2.0]}, "expected three numbers"),
        ({"LPA": [1.0, 2.0, "x"]}, "expected a number"),
        ({"LPA": True}, "expected three numbers"),
        ([["LPA", 3]], "expected names of vessels, such as"),
        ("LPA,3", "expected a JSON document"),
    ],
)
def test_names_that_cannot_be_meant_are_refused_in_a_sentence(a_patient, capsys, names, said):
    write_names(a_patient, names)
    before = set(a_patient.iterdir())
    assert main(["suggest", *FILES, "-o", "plan.json"]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert "names" in error
    assert len(error.strip().splitlines()) == 1
    assert set(a_patient.iterdir()) == before


def test_names_need_a_centerline_and_a_face_needs_ids(a_patient, artery, capsys):
    write_names(a_patient, {"LPA": LEFT})
    axis = ["--axis", "line.vtp", "--diameter", "7", "-o", "out.vtp"]
    assert main(["deploy", "pa.vtp", *axis, "--names", "names.json"]) == 2
    assert "expected --centerline FILE with --names" in capsys.readouterr().err
    with pytest.raises(InputError, match="has no face ids, got face 3"):
        given_names(artery.surface, artery.centerline, [VesselName("LPA", 3)])
    assert main(["measure", *FILES[:-1], "none.json"]) == 2


def test_a_name_holds_along_its_vessel_up_to_the_next_one(a_tree):
    """Held against the tree itself: what lies on the way from the root to a leaf."""
    tree, surface = a_tree.centerline, a_tree.surface
    for leaf in tree.leaves[::5].tolist():
        way = tree.ancestry(leaf)
        last = next(k for k, branch in enumerate(tree.branches) if branch[-1] == leaf)
        middle = tree.points[tree.branches[last][len(tree.branches[last]) // 2]]
        named = given_names(surface, tree, [VesselName("mine", tuple(middle.tolist()))])
        own = [k for k, name in enumerate(named) if name]
        assert last in own
        assert all(set(tree.branches[k].tolist()) <= set(way.tolist()) for k in own)
        start = tree.branches[last][0]
        above = next((k for k, b in enumerate(tree.branches) if b[-1] == start), None)
        if above not in own:
            continue
        upper = tree.points[tree.branches[above][len(tree.branches[above]) // 2]]
        both = [
            VesselName("upper", tuple(upper.tolist())),
            VesselName("lower", tuple(middle.tolist())),
        ]
        two = given_names(surface, tree, both)
        assert (two[above], two[last]) == ("upper", "lower")


def test_places_of_a_plan_are_turned_with_its_frame(a_patient, artery):
    write_names(a_patient, {"LPA": at(artery)})
    assert main(["suggest", *FILES, "-o", "plan.json"]) == 0
    plan = load_plan("plan.json")
    save_plan(plan, "again.json")
    assert load_plan("again.json") == plan
    (name,) = plan.names
    assert name.turned().turned() == name
    assert name.turned().at == (-name.at[0], -name.at[1], name.at[2])
    assert VesselName("RPA", 4).turned() == VesselName("RPA", 4)


def test_the_left_artery_of_the_patient_of_the_paper(data_dir):
    from SDFStentLib.plan import Marks, read_input_files

    files = [data_dir / f"su0243_{kind}_mm.vtp" for kind in ("surface", "centerline")]
    # As an operator would say it: at the tightest place, and in the trunk.
    names = (
        VesselName("LPA", (9.3, -77.5, -55.5)),
        VesselName("RPA", (-7.3, -95.6, -58.3)),
        VesselName("MPA", (17.6, -108.1, -55.2)),
    )
    vessel = read_input_files(*files, marks=Marks(names=names)).vessel
    first, *others = vessel.lesions
    assert first.branch_name == "LPA"
    assert first.minimum_diameter == pytest.approx(2.62, abs=0.03)
    assert not any(lesion.branch_name in ("LPA", "MPA") for lesion in others)
    tree = vessel.centerline
    for point, name in (((9.3, -77.5, -55.5), "LPA"), ((17.6, -108.1, -55.2), "MPA")):
        index = tree.project(point).index
        branch = next(k for k, one in enumerate(tree.branches) if index in one[1:])
        assert vessel.given_names[branch] == name


# One naming of branches everywhere, by the faces of the model where it names them.

MODEL = """<?xml version="1.0" encoding="UTF-8" ?>
<format version="1.0" />
<model type="PolyData">
    <timestep id="0">
        <model_element type="PolyData" num_sampling="0">
            <faces>
{faces}
            </faces>
            <blend_radii />
        </model_element>
    </timestep>
</model>
"""
"""As SimVascular writes it: two roots."""


def a_model(names):
    rows = (
        f'<face id="{number}" name="{name}" type="cap" visible="true" opacity="1" />'
        for number, name in names.items()
    )
    return MODEL.format(faces="\n".join(rows))


@pytest.mark.parametrize("name", ["pulmonary", "aorta_iliac"])
def test_every_branch_of_an_anatomy_is_named_by_a_cap_of_its_own(data_dir, name):
    vessel = anatomy(data_dir, name)
    surface_name, _, units = ANATOMIES[name]
    faces = read_surface(data_dir / surface_name, units=units).faces
    names = branch_names(vessel.surface, vessel.centerline, faces)
    middles = vessel.points[vessel.triangles].mean(axis=1)
    tree = vessel.centerline
    for branch, said in zip(tree.branches, names, strict=True):
        end = branch[0] if tree.parent[branch[0]] < 0 else branch[-1]
        nearest = np.linalg.norm(middles - tree.points[end], axis=1).argmin()
        assert said == f"branch to face {faces.ids[nearest]}"


def test_a_model_beside_the_surface_names_lesions_branches_and_tables(a_patient, artery, capsys):
    names = artery.faces.names
    own = {number: f"face &amp; {name}" for number, name in names.items()}
    (a_patient / "pa.mdl").write_text(a_model(own), encoding="utf-8")
    surface = read_surface(a_patient / "pa.vtp", units="cm")
    assert surface.faces.names == {n: f"face & {name}" for n, name in names.items()}
    files = [str(a_patient / "pa.vtp"), "--centerline", str(a_patient / "line.vtp")]
    assert main(["measure", *files, "--units", "cm", "--tables"]) == 0
    said = capsys.readouterr()
    first = find_lesions(artery.surface, artery.centerline, artery.faces)[0]
    assert f"; face & {first.branch_name}, " in said.out
    assert "Face & main pulmonary artery" in said.out
    assert all("equivalent diameter" in line for line in said.err.splitlines())
    table = a_patient / "lesions.csv"
    assert main(["measure", *files, "--units", "cm", "--csv", str(table)]) == 0
    row = next(csv.DictReader(io.StringIO(table.read_text(encoding="utf-8"))))
    assert row["branch_name"] == f"face & {first.branch_name}"

    report = a_patient / "report.json"
    place = [str(value / 10) for value in artery.throat.point]
    stent = ["--center", *place, "--length", "25", "--diameter", "8"]
    written = ["-o", str(a_patient / "out.vtp"), "--report", str(report)]
    page = ["--report", str(a_patient / "report.html")]
    assert main(["deploy", *files, "--units", "cm", *stent, *written, *page, "--quiet"]) in (0, 3)
    document = json.loads(report.read_text(encoding="utf-8"))
    assert document["lesions"][0]["branch_name"] == f"face & {first.branch_name}"
    branch_names_told = {branch["name"] for branch in document["branches"]}
    assert branch_names_told
    assert branch_names_told <= set(surface.faces.names.values())
    for branch in document["branches"]:
        assert branch["units"] == "cm"
        np.testing.assert_allclose(np.multiply(branch["ostium"], 10), branch["ostium_mm"])
    html = (a_patient / "report.html").read_text(encoding="utf-8")
    assert f"face &amp; {first.branch_name}" in html


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "an empty file"),
        ("<model>", "an error"),
        (a_model({1: "a"}).replace("<format", "<!DOCTYPE x [<!ENTITY a 'b'>]><format"), "error"),
        (a_model({1: "a"}) + a_model({1: "b"}).split("?>")[1], "two names of face 1"),
        (a_model({"one": "a"}), "a face with id 'one'"),
        (a_model({-1: "a"}), "a face with id '-1'"),
        (a_model({1: " "}), "a face with id '1'"),
        (a_model({"1" * 4000: "a"}), "a face with id '1111"),
        ("<model>" + "<a>" * 50 + "</a>" * 50 + "</model>", "levels"),
        ("<vtk/>", "no element model"),
        (" " * (LARGEST + 1), "bytes"),
    ],
)
def test_a_model_that_is_none_leaves_the_surface_as_it_is(a_patient, text, said):
    (a_patient / "pa.mdl").write_text(text, encoding="utf-8")
    surface = read_surface(a_patient / "pa.vtp", units="cm")
    assert surface.faces.names == {}
    (caution,) = [one for one in surface.warnings if one.kind == "face-names-not-read"]
    assert str(a_patient / "pa.mdl") in str(caution)
    assert said in str(caution)
    assert len(str(caution)) < 600


def test_damaged_models_are_refused_in_a_sentence_or_read():
    whole = a_model({1: "wall", 2: "inflow", 3: "left iliac"}).encode()
    assert mdl_face_names(whole, "m") == {1: "wall", 2: "inflow", 3: "left iliac"}
    dice = np.random.default_rng(11)
    outcomes = set()
    for _ in range(400):
        data = bytearray(whole)
        for _ in range(dice.integers(1, 4)):
            data[dice.integers(len(data))] = dice.integers(256)
        if dice.random() < 0.3:
            del data[dice.integers(len(data)) :]
        try:
            names = mdl_face_names(bytes(data), "m")
        except InputError as refused:
            outcomes.add("sentence" if "\n" not in str(refused) else "lines")
        else:
            outcomes.add("read")
            assert all(isinstance(n, int) and name for n, name in names.items())
    assert outcomes == {"read", "sentence"}
