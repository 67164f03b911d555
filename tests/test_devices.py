"""Devices: their table, what follows from their numbers, and what is refused for want of one."""

import json
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
from test_plan import SCHEMA, a_document
from trees import unbranched
from tube_files import deploy

from SDFStentLib.cli import main
from SDFStentLib.geometry import Line
from SDFStentLib.plan import (
    device_named,
    device_table,
    from_document,
    load_plan,
    plan_from_document,
    run_plan,
    to_document,
)
from SDFStentLib.report import device_sentence, device_sentences
from SDFStentLib.stent import AlongAxis, AtCenter, Balloon, BetweenPoints, Device, Stent, stent_axis
from SDFStentLib.validation import InputError

ROW = {
    "name": "bench-34",
    "nominal_length": 34,
    "lengths": [[12, 32], [16, 30], [20, 27.2]],
    "maximum_diameter": 22,
    "source": "own bench",
}
"""A device that loses 2, 4 and 6.8 of its 34 mm."""

SHORT = {**ROW, "name": "bench-16", "nominal_length": 16, "lengths": [[4, 16], [8, 12]]}
"""One that fits the tube of the command line's tests."""

CENTER = AtCenter([0.0, 0, 50])


def a_device(**changes) -> Device:
    device = from_document(Device, {**ROW, **changes}, "row")
    assert device is not None
    return device


def a_plan_with(row) -> dict:
    return a_document(device=row)


def a_table(*rows) -> str:
    return json.dumps({"schema": "sdfstent-devices", "version": 1, "devices": list(rows)})


@pytest.fixture
def a_table_file(tmp_path):
    path = tmp_path / "own.json"
    path.write_text(a_table(ROW, SHORT), encoding="utf-8")
    return path


# ---- the table that comes along


def test_every_number_of_a_named_row_has_a_source_and_generic_rows_are_no_product():
    for device in device_table():
        assert device.generic or (device.source and device.source_date), device.name
        assert device.has_numbers, device.name
        assert not device.verified, device.name
        assert device.note.endswith("."), device.name
    generic = device_named("generic")
    assert generic.generic
    assert generic.foreshortening_at(7.3) == 0.1


def test_no_shipped_row_says_how_a_product_shortens_but_the_one_whose_source_does():
    named = [device for device in device_table() if not device.generic]
    known = [d for d in named if d.lengths or d.foreshortening_fraction is not None]
    assert [(d.name, d.foreshortening_fraction) for d in known] == [("gore-vbx", 0.0)]
    assert [d.name for d in named if d.maximum_diameter is not None] == []


# ---- what is refused


def test_a_shortening_that_is_not_known_is_asked_for_and_never_made_up():
    device = device_named("numed-cp")
    with pytest.raises(InputError, match="device numed-cp: its shortening is not known; say how"):
        Stent(15.0, placement=CENTER, length=34, device=device)
    said = Stent(15.0, placement=CENTER, length=34, device=device, foreshortening_fraction=0.15)
    assert said.foreshortening == 0.15
    between = Stent(15.0, placement=BetweenPoints([0, 0, 0], [0, 0, 9]), device=device)
    assert between.foreshortening == 0
    assert Stent(15.0, placement=AlongAxis([[0, 0, 0], [0, 0, 9]]), device=device).length is None


@pytest.mark.parametrize(
    ("row", "words"),
    [
        ({"source": " "}, "bench-34, source: expected where its numbers are from, got nothing"),
        ({"name": " "}, "device name: expected a name, got ' '"),
        ({"cell": "woven"}, "cell: expected one of closed, open, hybrid, unknown, got 'woven'"),
        ({"nominal_length": None}, "lengths: expected a nominal_length with them, got none"),
        ({"nominal_length": -1}, "nominal_length: expected a number greater than 0"),
        ({"maximum_diameter": 19}, "lengths: expected at most the largest diameter of 19 mm"),
        ({"lengths": [[16, 30], [12, 32]]}, "expected rising diameters, each once, got 16, 12 mm"),
        ({"lengths": [[12, 32], [12, 30]]}, "expected rising diameters, each once, got 12, 12 mm"),
        ({"lengths": [[12, 16]]}, "expected between 0.5 and 1.2 times the nominal length of 34 mm"),
        ({"lengths": [[12]]}, "lengths: expected a diameter and a length, got 1 numbers"),
        ({"lengths": 12}, r"row.lengths: expected a list, got 12"),
        ({"foreshortening_fraction": 0.1}, "expected none beside a foreshortening_fraction"),
        ({"foreshortening_fraction": 0.6, "lengths": []}, "at least -0.2 and at most 0.5"),
        ({"nominal_diameters": [20, 12]}, "nominal_diameters: expected the smaller one first"),
        ({"nominal_diameters": [12]}, "expected a smallest and a largest, got 1 numbers"),
        ({"nominal_diameters": [12, 24]}, "expected at most the largest diameter of 22 mm"),
        ({"reported_lengths": [0, 24]}, "reported_lengths: expected a number greater than 0"),
        ({"maximum_diameter": "22"}, "row.maximum_diameter: expected a number, got '22'"),
        ({"generic": None}, "row.generic: expected true or false, got null"),
        ({"diameter": 4}, "row: unknown key 'diameter'; expected name, family"),
    ],
)
def test_a_row_that_cannot_be_is_refused_with_its_place(row, words):
    with pytest.raises(InputError, match=words):
        a_device(**row)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "own.json: expected a device table in JSON, got an empty file"),
        ("[]", "own.json: device table: expected an object with schema, version, devices; got a"),
        ("{", "own.json: expected a JSON document, got an error"),
        (a_table(ROW, ROW), r"devices\[1\]: expected a device of another name than those before"),
        (a_table(ROW, None), r"devices\[1\]: expected an object with name, .*; got null"),
        (a_table({**ROW, "source": ""}), r"own.json: devices\[0\]: device bench-34, source: exp"),
        (a_table(ROW).replace("-devices", "-plan"), "schema: expected 'sdfstent-devices', got"),
        (a_table(ROW).replace(": 1,", ": 3,"), "version: expected 1, got 3"),
    ],
)
def test_a_file_that_is_no_device_table_is_said(tmp_path, text, words):
    path = tmp_path / "own.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=words):
        device_table(path)


# ---- what is said


def test_sizes_beyond_what_is_known_of_a_device_are_said():
    tube = unbranched(Line([[0, 0, 0], [0, 0, 100]]).resampled(2.0).points, np.full(51, 8.0))

    def said(diameter, length, device, lost=0.0):
        stent = Stent(
            diameter, placement=CENTER, length=length, device=device, foreshortening_fraction=lost
        )
        return [str(caution) for caution in stent_axis(stent, tube).warnings]

    peripheral = device_named("begraft-besmooth-peripheral")
    assert said(8.0, 30, peripheral) == []
    assert said(12.0, 60, peripheral) == [
        "begraft-besmooth-peripheral: a diameter of 12 mm is outside of the 7 to 10 mm with which "
        "its source saw it used.",
    ]
    vbx = device_named("gore-vbx")
    assert said(8.0, 30, vbx, lost=None) == [
        "gore-vbx: its shortening is known at its nominal diameters only; 8 mm may be one of them "
        "or not, and its length extrapolated."
    ]
    assert said(8.0, 30, vbx) == []  # the user says how much it loses
    # It is opened as far as its balloon.
    wide = Stent(
        9.9,
        placement=CENTER,
        length=30,
        device=peripheral,
        foreshortening_fraction=0,
        balloon=Balloon(11.0, 0.1),
    )
    (told,) = stent_axis(wide, tube).warnings
    assert "a diameter of 11 mm is outside of the 7 to 10 mm" in str(told)
    own = a_device(lengths=(), foreshortening_fraction=0.05, nominal_diameters=[7, 10])
    assert list(own.cautions(8.0, 34)) == []
    assert [str(caution) for caution in own.cautions(12.0, 34)][1:] == [
        "bench-34: its shortening is known at its nominal diameters only; 12 mm is none of them, "
        "and its length extrapolated."
    ]
    assert said(8.0, 30, device_named("generic")) == []


@pytest.mark.parametrize(
    ("name", "size", "words"),
    [
        (
            "numed-cp",
            {"length": 34, "foreshortening_fraction": 0.15},
            "34 mm long as packed, 28.9 mm at 12 mm of diameter (length as given, shortening as "
            "given); from its source: used at 10 to 26 mm, in lengths of 11 to 80 mm (Ewert 2005",
        ),
        (
            "gore-vbx",
            {"length": 34},
            "34.0 mm at 12 mm of diameter (length as given, shortening as its row has it); from "
            "its source: keeps its length at its nominal diameters (Bismuth 2017",
        ),
        ("generic", {"length": 30}, "27.0 mm at 12 mm of diameter (length as given, shortening as "
         "its row has it); none: it is no product, its numbers are assumptions."),
    ],
)  # fmt: skip
def test_only_what_a_row_has_is_told_as_of_its_source(name, size, words):
    stent = Stent(12.0, placement=CENTER, device=device_named(name), **size)
    (told,) = device_sentences(stent)
    assert words in told


# ---- documents


def test_the_schema_knows_the_keys_and_the_rows_of_the_table():
    jsonschema = pytest.importorskip("jsonschema")
    definition = SCHEMA["properties"]["stents"]["items"]["properties"]["device"]["anyOf"][0]
    assert list(definition["properties"]) == [field.name for field in fields(Device)]
    validator = jsonschema.Draft7Validator(SCHEMA)
    for device in device_table():
        validator.validate(a_plan_with(to_document(device)))
    validator.validate(a_plan_with(ROW))
    for bad in ({}, {"name": 3}, {**ROW, "lengths": [[12]]}, {**ROW, "color": "red"}):
        assert not validator.is_valid(a_plan_with(bad))
        with pytest.raises(InputError):
            plan_from_document(a_plan_with(bad))


# ---- the shell


def test_devices_lists_the_table_and_tells_what_is_and_is_not_known(capsys, a_table_file):
    assert main(["devices"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split(":")[0] for line in lines] == [device.name for device in device_table()]
    assert lines[0] == (
        "generic: any balloon-expandable stent; loses 10 % of its length at any diameter."
    )
    assert device_sentence(Device("own", generic=True)) == "own: shortening not known."
    assert main(["devices", "NuMED-CP"]) == 0
    rows = dict(line.split(": ", 1) for line in capsys.readouterr().out.splitlines())
    assert rows["Length on expansion"] == rows["Largest diameter"] == "not known"
    assert rows["Diameters in the source"] == "10 to 26 mm"
    assert rows["Source"].endswith("(2005, 2014); unverified")
    assert main(["devices", "bench-34", "--device-table", str(a_table_file), "--json"]) == 0
    (row,) = json.loads(capsys.readouterr().out)["devices"]
    assert from_document(Device, row, "row") == a_device()
    assert main(["devices", "bench"]) == 2
    assert "see `sdfstent devices`, or give one of your own (--device-table F)." in (
        capsys.readouterr().err
    )


def test_deploy_takes_the_length_of_the_device_at_the_diameter(a_folder, a_table_file, capsys):
    center = ["--center", "0", "0", "2"]
    device = ["--device", "bench-16", "--device-table", str(a_table_file)]
    assert deploy(*device, "--report", "r.json", "--save-plan", "p.json", place=center) == 0
    said = capsys.readouterr().out
    assert said.startswith("Deployed: bench-16, 6 x 14.0 mm (16 mm as packed, 12.5 % shorter")
    (stent,) = json.loads(Path("r.json").read_text(encoding="utf-8"))["stents"]
    assert stent["nominal_length_mm"] == 16
    assert stent["deployed_length_mm"] == pytest.approx(14)
    assert stent["foreshortening_fraction"] == pytest.approx(0.125)
    assert stent["device"]["name"] == "bench-16"
    assert (stent["device"]["source"], stent["device"]["verified"]) == ("own bench", False)
    # The plan holds the device: it needs the table no more.
    a_table_file.unlink()
    plan = load_plan("p.json")
    assert plan.stents[0].device == a_device(**SHORT)
    again = run_plan(plan).treatment
    assert again.stents[0].axis.deployed_length == pytest.approx(14)


def test_the_page_names_the_device_its_source_and_that_it_is_unverified(a_folder, a_table_file):
    device = ["--device", "bench-16", "--device-table", str(a_table_file)]
    assert deploy(*device, "--report", "r.html", place=["--center", "0", "0", "2"]) == 0
    page = Path("r.html").read_text(encoding="utf-8")
    assert "<tr><td>Device</td><td>bench-16</td></tr>" in page
    assert "<tr><td>Source of its numbers</td><td>own bench; unverified</td></tr>" in page
