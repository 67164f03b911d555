"""Plans: their document, its strict reader, and carrying them out."""

import copy
import json
import re
from dataclasses import replace

import numpy as np
import pytest
from tube_files import write_line, write_vessel

from benchmarks.phantoms import branching_pulmonary_artery, stenosed_tube
from SDFStentLib.deformation import DeploymentSettings
from SDFStentLib.files import (
    encode_vtp,
    polydata_from_arrays,
    set_frame_of_polydata,
)
from SDFStentLib.plan import (
    Plan,
    load_plan,
    method_parameters,
    plan_from_document,
    plan_schema,
    plan_text,
    run_plan,
    save_plan,
    scaled,
    turned,
)
from SDFStentLib.plan.json_document import unscaled
from SDFStentLib.report import plan_report
from SDFStentLib.stent import (
    AlongAxis,
    AtCenter,
    AtDistalEnd,
    AtProximalEnd,
    BetweenPoints,
    InputFile,
    Stent,
)
from SDFStentLib.treatment import Treatment, size_cautions
from SDFStentLib.validation import DeploymentError, InputError

SCHEMA = plan_schema()
RANDOM = np.random.default_rng(20)
QUICK = DeploymentSettings(certify=False)


def a_point():
    return RANDOM.normal(size=3) * 100 / 3


def every_placement():
    return [
        (AtCenter(a_point()), 20.0),
        (AtDistalEnd(a_point()), 0.1 + 0.2),
        (AtProximalEnd(a_point()), 10.0),
        (BetweenPoints(a_point(), a_point()), None),
        (AlongAxis(np.array([a_point() for _ in range(5)])), None),
        (AlongAxis(np.array([a_point() for _ in range(5)])), 12.5),
    ]


def a_plan(tmp_path, units="mm"):
    stents = [
        Stent(1 / 3 + n, placement=place, length=length, name=f"ä {n}", enabled=n % 2 == 0)
        for n, (place, length) in enumerate(every_placement())
    ]
    return Plan(
        stents=stents,
        surface=InputFile(tmp_path / "vessel" / "a.vtp", "0" * 64),
        centerline=InputFile(tmp_path / "b.vtp"),
        units=units,
        frame="LPS",
        settings=DeploymentSettings(step=0.1, smoothing_width=1 / 7, falloff="cosine"),
        straightening_fraction=0.25,
    )


def a_document(**stent):
    return {
        "schema": "sdfstent-plan",
        "version": 2,
        "inputs": {"units": "cm", "surface": {"file": "a.vtp"}},
        "stents": [{"diameter": 6, "length": 20, "placement": {"center": [1, 2, 3.5]}, **stent}],
        "settings": {"influence_distance": 5},
    }


@pytest.fixture(scope="module")
def a_patient(tmp_path_factory):
    """A folder with the branching phantom as files."""
    folder = tmp_path_factory.mktemp("patient")
    vessel = branching_pulmonary_artery(edge_length=1.1)
    write_vessel(folder, vessel, "surface.vtp", "centerline.vtp", per_mm=1)
    write_line(folder / "axis.vtp", vessel.axis_at(np.arange(20.0, 41.0)))
    return folder, vessel


@pytest.mark.parametrize("units", ["mm", "cm", "m"])
def test_a_plan_comes_back_from_its_file_exactly(tmp_path, units):
    plan = a_plan(tmp_path, units)
    save_plan(plan, tmp_path / "plan.json")
    again = load_plan(tmp_path / "plan.json")
    assert again == plan
    assert hash(again) == hash(plan)
    for one, other in zip(again.stents, plan.stents, strict=True):
        for name, value in vars(other.placement).items():
            np.testing.assert_array_equal(getattr(one.placement, name), value)


def test_changing_the_unit_rounds_nothing():
    for value in RANDOM.normal(size=500):
        for factor in (1.0, 10.0, 1000.0):
            assert scaled(unscaled(value, factor), factor) == value
    assert scaled(1.1, 10.0) == 11.0  # 1.1 * 10 in floats is 11.000000000000002


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"placement": {"center": [1, 2, 3], "foo": 1}}, "stents[0].placement: unknown key 'foo'"),
        ({"placement": {"center": [1, 2]}}, "stents[0].placement.center: expected three numbers"),
        ({"placement": {"center": [1, 2, "x"]}}, "placement.center[2]: expected a number, got 'x'"),
        ({"placement": {"center": 3}}, "placement.center: expected a list, got 3"),
        ({"placement": {"center": [1, 2, 1e999]}}, "stents[0].placement: center: expected finite"),
        ({"placement": {"from": [1, 2, 3]}}, "or branch with distance or fraction, got from"),
        (
            {"placement": {}},
            "axis, stent, lesion (with an offset), or branch with distance or fraction, got no",
        ),
        ({"placement": {"axis": {}}}, "stents[0].placement.axis: expected either points or a file"),
        (
            {"placement": {"lesion": 0}},
            "stents[0].placement: lesion: expected a number of the list",
        ),
        ({"placement": {"lesion": 1.5}}, "lesion: expected a number of the list, from 1, got 1.5"),
        ({"placement": {"lesion": 1, "offset": "x"}}, "placement.offset: expected a number, got"),
        ({"placement": {"lesion": 1, "fraction": 0.5}}, "beside a lesion but offset, got fraction"),
        ({"placement": {"branch": 1}}, "a distance along it, mm, or a fraction, got neither"),
        ({"placement": {"branch": 1, "distance": 1, "fraction": 1}}, "or a fraction, got both"),
        ({"placement": {"branch": "a", "fraction": 2}}, "fraction: expected a number at least 0"),
        ({"placement": {"branch": [1], "distance": 1}}, "branch: expected its number, from 1"),
        ({"placement": {"branch": 1, "offset": 1}}, "but distance or fraction, got offset"),
        ({"placement": {"axis": {"file": "x.vtp"}}}, "load the plan from its file"),
        ({"placement": {"axis": {"points": [[1, 2, 3]]}}}, "axis: stent axis: expected a curve"),
        ({"diameter": -1}, "stents[0]: stent diameter: expected a number greater than 0"),
        ({"diameter": True}, "stents[0].diameter: expected a number, got true"),
        ({"length": None}, "stents[0]: stent length: expected a length"),
        ({"name": 4}, "stents[0].name: expected a text, got 4"),
        ({"enabled": 1}, "stents[0].enabled: expected true or false, got 1"),
        ({"foo": "x"}, "stents[0]: unknown key 'foo'; expected diameter, placement"),
        ({"balloon": {"diameter": 8}}, "balloon: expected the key 'recoil_fraction', got none"),
        ({"balloon": {"diameter": 8, "recoil_fraction": 2}}, "balloon: recoil: expected a number"),
        ({"balloon": {"diameter": 8, "recoil_fraction": 0.1}}, "expected 7.2 mm, the lumen that"),
        ({"keeps": "top"}, "expected what it keeps as one of center, proximal, distal, got 'top'"),
        ({"placement": {"stent": 0}}, "stents[0].placement: redilation: expected the number"),
        ({"shape": {"wast": {}}}, "stents[0].shape: unknown key 'wast'"),
        ({"shape": {"waist": {}}}, "stents[0].shape.waist: expected the key 'diameter', got none"),
        ({"shape": {"waist": {"diameter": 7}}}, "stents[0]: waist: expected at most the 6 mm of"),
        ({"shape": {"waist": {"diameter": -7}}}, "stents[0].shape.waist: waist: expected a numb"),
        ({"shape": {"table": [[0, 6], [1]]}}, "stents[0].shape: profile: expected rows of a fr"),
        (
            {"shape": {"table": [[1, 6], [0, 5]]}},
            "fractions that rise from 0 to 1, each once, got 1",
        ),
        ({"shape": {"cap_height": "x"}}, "stents[0].shape.cap_height: expected a number, got 'x'"),
    ],
)
def test_what_does_not_belong_in_a_stent_is_named_with_its_place(change, words):
    with pytest.raises(InputError, match=re.escape(words)):
        plan_from_document(a_document(**change))


def a_flow(time, flow):
    return {"mean": 5, "wave": {"time": time, "flow": flow}}


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        (("schema",), "other", "schema: expected 'sdfstent-plan', got 'other'"),
        (("version",), 3, "version: expected 2, got 3; use the version of sdfstent that wrote"),
        (("foo",), 1, "plan: unknown key 'foo'; expected schema, version, stents"),
        (("stents",), {}, "stents: expected a list, got an object"),
        (("stents",), [3], "stents[0]: expected an object with diameter"),
        (("inputs", "units"), "inch", "inputs.units: expected mm, cm or m, got 'inch'"),
        (("inputs", "frame"), "ABC", "inputs.frame: expected RAS, LPS or null, got 'ABC'"),
        (("inputs", "x"), 0, "inputs: unknown key 'x'"),
        (("inputs", "surface"), {}, "inputs.surface: expected the key 'file', got none"),
        (("inputs", "surface"), {"file": ""}, "inputs.surface: input file: expected a path"),
        (("settings", "k"), 0, "settings: unknown key 'k'; expected influence_distance"),
        (("settings", "rule"), "x", "settings: rule: expected one of events, published"),
        (("settings", "rule"), 1, "settings.rule: expected a text, got 1"),
        (("settings", "finish"), "yes", "settings.finish: expected true or false, got 'yes'"),
        (("settings", "step"), [], "settings.step: expected a number, got a list of 0"),
        (("settings", "straightening_fraction"), 2, "straightening fraction: expected a number"),
        (("flow",), [5, 20], "flow: expected an object with mean"),
        (("flow",), {}, "flow: expected the key 'mean'"),
        (("flow",), {"mean": 0}, "flow: mean flow: expected a number greater than 0"),
        (("flow",), {"mean": "5"}, "flow.mean: expected a number"),
        (("flow",), {"mean": 5, "peak": 4}, "peak flow: expected a number at least 5"),
        (("flow",), {"mean": 5, "inlet": 9}, "that of the inlet alone"),
        (("flow",), {"mean": 5, "inlet": 9, "wedge": 12}, "contradict each other"),
        (("flow",), {"mean": 5, "split_right": 1}, "expected a share below 1"),
        (("flow",), {"mean": 5, "right": [1, 2]}, "flow.right: expected three numbers"),
        (("flow",), a_flow([0, 1], [1, 1]), "at least 4"),
        (("flow",), a_flow([0, 1, 2, 3], [1, 9, 1, 4]), "one that closes"),
        (("flow",), a_flow([0, 2, 1, 3], [1, 9, 1, 1]), "times that go up"),
        (("flow",), a_flow([0, 1, 2, 3], [1, -9, 1, 1]), "is positive"),
    ],
)
def test_what_does_not_belong_in_a_plan_is_named_with_its_place(path, value, words):
    document = a_document()
    section = document
    for key in path[:-1]:
        section = section[key]
    section[path[-1]] = value
    with pytest.raises(InputError, match=re.escape(words)):
        plan_from_document(document)


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", "got an empty file"),
        (b"\xff\xfe\x00", "got no text in UTF-8"),
        (b"{", "expected a JSON document"),
        (b"[" * 100000, "nested too deeply"),
        (b"[]", "schema: expected 'sdfstent-plan', got a list of 0; this is no plan"),
        (b'{"schema": NaN}', "NaN is no number"),
        (b'{"schema": 1, "schema": 2}', "the key 'schema' stands twice"),
    ],
)
def test_a_file_that_is_no_plan_is_said(tmp_path, data, words):
    path = tmp_path / "plan.json"
    path.write_bytes(data)
    with pytest.raises(InputError, match=re.escape(words)) as caught:
        load_plan(path)
    assert str(path) in str(caught.value)


def test_the_schema_knows_the_same_keys_as_the_reader(tmp_path):
    document = json.loads(plan_text(a_plan(tmp_path)))
    assert set(SCHEMA["properties"]) == set(document)
    assert set(SCHEMA["properties"]["inputs"]["properties"]) == set(document["inputs"])
    settings = SCHEMA["properties"]["settings"]["properties"]
    assert set(settings) == set(method_parameters()) == set(document["settings"])
    stent = SCHEMA["properties"]["stents"]["items"]
    assert set(stent["properties"]) == set(document["stents"][0])
    for key in stent["required"]:
        lacking = a_document()
        del lacking["stents"][0][key]
        with pytest.raises(InputError, match=f"expected the key '{key}', got none"):
            plan_from_document(lacking)


def test_the_schema_accepts_what_the_reader_accepts_and_refuses_what_it_refuses(tmp_path):
    jsonschema = pytest.importorskip("jsonschema")
    validator = jsonschema.Draft7Validator(SCHEMA)
    validator.check_schema(SCHEMA)
    for units in ("mm", "cm"):
        validator.validate(json.loads(plan_text(a_plan(tmp_path, units))))
    validator.validate(a_document())
    for change in ({"diameter": -1}, {"device": "x"}, {"placement": {}}, {"enabled": 1}):
        assert not validator.is_valid(a_document(**change))


def test_two_overlapping_stents_are_deployed_in_order_and_said(a_patient):
    _, vessel = a_patient
    stents = [Stent(7.5, placement=BetweenPoints(*vessel.axis_at(e))) for e in ((19, 40), (36, 46))]
    treatment = Treatment(vessel.surface, stents, vessel.centerline)
    fractions = [state.fraction for state in treatment]
    assert fractions == sorted(fractions)
    assert fractions[-1] == 1
    result = treatment.result
    assert result.certificate.passed
    (overlap,) = [caution for caution in result.warnings if caution.kind == "overlap"]
    assert overlap.numbers["length_mm"] == pytest.approx(4, abs=0.15)
    assert str(overlap).startswith("Stents 1 and 2 overlap over ")
    for stent in result.stents:
        # The median: at the inlet's side the vessel is wider than the stent from the start.
        assert np.median(stent.after.inscribed_diameter) == pytest.approx(7.5, rel=0.01)
    unmoved = np.setdiff1d(np.arange(len(vessel.points)), result.indices)
    np.testing.assert_array_equal(result.points[unmoved], vessel.points[unmoved])


def test_a_stent_that_is_switched_off_is_skipped_and_named():
    vessel = stenosed_tube()
    stent = Stent(6.0, length=15, placement=AtCenter(vessel.throat.point))
    on, off = stent, replace(stent, name="spare", enabled=False)
    result = Treatment(vessel.surface, [off, on], vessel.centerline, QUICK).result
    assert [treated.number for treated in result.stents] == [2]
    assert "Stent 1 (spare): it is switched off and was not deployed." in map(str, result.warnings)
    for stents, words in (([off], "all switched off"), ([], "at least one stent, got none")):
        with pytest.raises(InputError, match=words):
            Treatment(vessel.surface, stents, vessel.centerline)


def test_a_stent_far_wider_than_the_vessel_or_away_from_it_is_refused():
    vessel = stenosed_tube()
    wide = Stent(60.0, length=15, placement=AtCenter(vessel.throat.point))
    with pytest.raises(
        InputError, match=r"at most 4 times the lumen of .*the unit of the files\.$"
    ):
        Treatment(vessel.surface, [wide], vessel.centerline)
    away = Stent(60.0, placement=AlongAxis(np.array([[0, 0, 200.0], [0, 0, 210.0]])))
    inside = Stent(6.0, length=15, placement=AtCenter(vessel.throat.point))
    both = Treatment(vessel.surface, [inside, away], vessel.centerline, QUICK)
    with pytest.raises(DeploymentError, match="Stent 2: stent: expected the vessel's wall"):
        list(both)
    far = Stent(6.0, length=15, placement=AtCenter([300.0, 0, 0]))
    with pytest.raises(InputError, match="Stent 2: center: expected a point within"):
        Treatment(vessel.surface, [inside, far], vessel.centerline)


@pytest.mark.parametrize(("factor", "is_said"), [(1.15, False), (1.25, True)])
def test_a_stent_far_wider_than_the_native_lumen_is_said_with_both_numbers(factor, is_said):
    """Of lesions nothing is known here: the widest lumen within the stent stands for the vessel."""
    vessel = stenosed_tube()
    widest = 2 * np.nanmax(vessel.centerline.inscribed_radius)
    diameter = factor * widest
    stent = Stent(diameter, length=30, placement=AtCenter(vessel.throat.point))
    # Of the second one, too: native is the lumen before any stent.
    result = Treatment(vessel.surface, [stent, stent], vessel.centerline, QUICK).result
    told = [str(text) for text in size_cautions(result.stents, None, "Stent {}: ".format)]
    assert len(told) == (2 if is_said else 0)
    for number, text in enumerate(told, start=1):
        # The facets lie a little inside the round tube.
        found = re.match(
            rf"Stent {number}: The stent of {diameter:.3g} mm is ([\d.]+) times .*\(([\d.]+) mm\)",
            text,
        )
        assert float(found[1]) == pytest.approx(factor, abs=0.05)
        assert float(found[2]) == pytest.approx(widest, abs=0.2)


def test_an_axis_file_is_read_in_the_folder_of_the_plan_and_noticed_when_changed(a_patient):
    folder, _ = a_patient
    document = a_document(length=None, diameter=7.5, placement={"axis": {"file": "axis.vtp"}})
    document["inputs"] = {"surface": {"file": "surface.vtp"}}
    path = folder / "axis_plan.json"
    path.write_text(json.dumps(document), encoding="utf-8")
    result = run_plan(load_plan(path))
    assert result.treatment.stents[0].axis.deployed_length == pytest.approx(20, abs=0.05)
    assert plan_report(result).as_dict()["inputs"][-1]["role"] == "axis"
    save_plan(result.plan, path)
    assert load_plan(path) == result.plan

    changed = copy.deepcopy(document)
    changed["stents"][0]["placement"]["axis"]["sha256"] = "1" * 64
    path.write_text(json.dumps(changed), encoding="utf-8")
    with pytest.raises(InputError, match=r"axis.vtp: expected the file .*1{64}.*got another one"):
        load_plan(path)
    assert load_plan(path, accept_changed_inputs=True).stents


def test_a_changed_input_is_refused_naming_both_hashes_unless_accepted(a_patient):
    folder, vessel = a_patient
    plan = Plan(
        stents=(Stent(7.5, placement=AlongAxis(vessel.axis_at((20, 30, 40)))),),
        surface=InputFile(folder / "surface.vtp", "2" * 64),
        sdfstent_version="0.0.1",
    )
    with pytest.raises(InputError, match=rf"{'2' * 64}\), got another one \(sha256 [0-9a-f]"):
        run_plan(plan)
    result = run_plan(plan, accept_changed_inputs=True)
    assert any("accepted as asked" in str(text) for text in result.warnings)
    assert any("made by sdfstent 0.0.1" in str(text) for text in result.warnings)
    with pytest.raises(InputError, match="expected a centerline to write, the plan has none"):
        result.write_centerline(folder / "c.vtp")
    with pytest.raises(InputError, match=r"inputs.surface: expected a file, the plan names none"):
        run_plan(Plan(stents=plan.stents))


def test_a_plan_in_the_other_frame_is_turned(a_patient):
    folder, vessel = a_patient
    stent = Stent(7.5, placement=BetweenPoints(*vessel.axis_at((20, 40))))
    data = polydata_from_arrays(vessel.points, vessel.triangles)
    set_frame_of_polydata(data, "RAS")
    (folder / "ras.vtp").write_bytes(encode_vtp(data))
    files = {
        "surface": InputFile(folder / "ras.vtp"),
        "centerline": InputFile(folder / "centerline.vtp"),
    }
    same = run_plan(Plan(stents=(stent,), frame="RAS", **files))
    other = run_plan(Plan(stents=(turned(stent),), frame="LPS", **files))
    np.testing.assert_allclose(other.treatment.points, same.treatment.points, rtol=0, atol=1e-9)


ENDLESS = ["9" * 400, "1e400", "1e99999999999999999999", "1e999999999999999999", "-1e400"]


@pytest.mark.parametrize("number", [*ENDLESS, "9" * 5000, "1e-99999999999999999999"])
@pytest.mark.parametrize("key", ["diameter", "length", "center", "straightening_fraction", "step"])
def test_a_number_beyond_all_bounds_is_refused_in_a_sentence(tmp_path, number, key):
    document = a_document()
    if key in ("straightening_fraction", "step"):
        document["settings"] = {key: "HERE"}
    elif key == "center":
        document["stents"][0]["placement"] = {"center": [1, "HERE", 3]}
    else:
        document["stents"][0][key] = "HERE"
    path = tmp_path / "plan.json"
    path.write_text(json.dumps(document).replace('"HERE"', number), encoding="utf-8")
    with pytest.raises(
        InputError, match=r"a number up to 1.8e308|beyond all|is too long"
    ) as caught:
        load_plan(path)
    assert len(str(caught.value)) < 250 + len(str(path))


@pytest.mark.parametrize("name", ["a\0.vtp", "a\ud800.vtp", 4])
def test_what_cannot_be_the_name_of_a_file_is_refused_with_its_place(name):
    document = a_document()
    document["inputs"] = {"surface": {"file": name}}
    words = "inputs.surface.file: expected the name of a file, got"
    with pytest.raises(InputError, match=words) as caught:
        plan_from_document(document)
    assert str(caught.value).isprintable()
    document = a_document(placement={"axis": {"file": name}})
    with pytest.raises(InputError, match=r"placement.axis.file: expected the name of a file"):
        plan_from_document(document)


def test_half_of_a_character_is_no_text():
    words = re.escape(r"stents[0].name: expected a text, got half of a character in '\ud800'")
    with pytest.raises(InputError, match=words):
        plan_from_document(a_document(name="\ud800"))
