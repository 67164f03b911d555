"""One naming of branches everywhere, by the faces of the model where it names them."""

from __future__ import annotations

import csv
import io
import json

import numpy as np
import pytest
from deployment_cases import ANATOMIES, anatomy
from tube_files import write_vessel

from SDFStentLib import phantoms
from SDFStentLib.cli import main
from SDFStentLib.files import read_surface
from SDFStentLib.files.formats.mdl_faces import LARGEST, mdl_face_names
from SDFStentLib.validation import InputError
from SDFStentLib.vessel import branch_names, find_lesions

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


@pytest.fixture(scope="module")
def artery():
    return phantoms.branching_pulmonary_artery()


@pytest.fixture
def a_patient(tmp_path, artery):
    write_vessel(tmp_path, artery)
    return tmp_path


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
