"""Sweep documents, their schema, and the samples that are drawn from them."""

from __future__ import annotations

import numpy as np
import pytest
from child_processes import python
from cohort_cases import PLAN, document, sweep_in, tube_folder, write_sweep

from SDFStentLib import InputError
from SDFStentLib.cohort import Cases, load_sweep, sweep_from_document, sweep_schema
from SDFStentLib.cohort.axes import NAMES
from SDFStentLib.cohort.cases import Samples

SCHEMA = sweep_schema()


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tube_folder(tmp_path_factory.mktemp("sweeps"))


def drawn(axes, method="random", count=4000, seed=3):
    sweep = sweep_from_document(
        document(axes=axes, sampling={"method": method, "count": count, "seed": seed}), "."
    )
    rows = Samples(sweep.axes, sweep.sampling)
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


def test_a_grid_has_every_combination_once_in_the_order_of_the_document(folder):
    axes = {"diameter": [6, 7], "branch": 1, "distance": {"from": 18, "to": 22, "steps": 3}}
    rows = [case.parameters for case in Cases(sweep_in(folder, axes=axes))]
    assert [(row["diameter"], row["distance"]) for row in rows] == [
        (6, 18), (6, 20), (6, 22), (7, 18), (7, 20), (7, 22),
    ]  # fmt: skip
    assert {row["branch"] for row in rows} == {1}


@pytest.mark.parametrize("method", ["random", "latin-hypercube", "sobol"])
def test_drawn_values_have_their_distribution(method):
    from scipy import stats  # takes a second to import

    axes = {
        "diameter": {"uniform": [6, 8]},
        "length": {"normal": [20, 3]},
        "distance": {"normal": [20, 5], "within": [15, 22]},
        "branch": [1, 2, 3],
    }
    found = drawn(axes, method)
    assert stats.kstest(found["diameter"], stats.uniform(6, 2).cdf).pvalue > 1e-3
    assert stats.kstest(found["length"], stats.norm(20, 3).cdf).pvalue > 1e-3
    kept = stats.truncnorm(-1, 0.4, loc=20, scale=5)
    assert stats.kstest(found["distance"], kept.cdf).pvalue > 1e-3
    counts = np.bincount(found["branch"])[1:]
    assert stats.chisquare(counts).pvalue > 1e-3
    # No axis tells of another one.
    columns = np.array([found[name] for name in axes], dtype=float)
    assert np.abs(np.corrcoef(columns) - np.eye(4)).max() < 0.06


@pytest.mark.parametrize("method", ["random", "sobol"])
def test_more_samples_begin_with_the_fewer(method):
    axes = {"diameter": {"uniform": [6, 8]}, "length": {"normal": [20, 3]}}
    few, many = drawn(axes, method, 10), drawn(axes, method, 33)
    for name in few:
        np.testing.assert_array_equal(few[name], many[name][:10])


def test_names_of_cases_are_the_same_in_another_process_and_another_folder(folder, tmp_path):
    names = [case.id for case in Cases(sweep_in(folder))]
    assert len(set(names)) == 6
    assert all(len(name) == 20 for name in names)
    other = tube_folder(tmp_path)
    path = write_sweep(other)
    program = (
        "import sys; from SDFStentLib.cohort import Cases, load_sweep\n"
        "print(*[case.id for case in Cases(load_sweep(sys.argv[1]))])"
    )
    assert python(program, path).stdout.split() == names


@pytest.mark.parametrize(
    "changes",
    [
        {"constraints": {"distance_to_ends": 1}},
        {"plan": {**PLAN, "settings": {"influence_distance": 7}}},
        {"plan": {**PLAN, "inputs": {**PLAN["inputs"], "units": "mm"}}},
        {"plan": {**PLAN, "inputs": {"units": "cm", "surface": {"file": "tube.vtp"}}}},
    ],
)
def test_whatever_changes_the_result_changes_the_names(folder, changes):
    before = {case.id for case in Cases(sweep_in(folder))}
    assert not before & {case.id for case in Cases(sweep_in(folder, **changes))}


def test_what_is_kept_and_how_the_patient_is_called_changes_no_name(folder):
    before = [case.id for case in Cases(sweep_in(folder))]
    inputs = {"name": "Ann", "units": "cm", "surface": "tube.vtp", "centerline": "line.vtp"}
    other = sweep_in(folder, store="moved", patients=[inputs])
    assert [case.id for case in Cases(other)] == before


WRONG = [
    ({"schema": "sdfstent-plan"}, "schema: expected 'sdfstent-sweep'"),
    ({"version": 2}, "version: expected 1, got 2"),
    ({"foo": 1}, "sweep: unknown key 'foo'"),
    ({"axes": {}}, "axes: expected an object with at least one"),
    ({"axes": {"width": 1}}, "axes.width: unknown axis; expected one of diameter"),
    ({"axes": {"diameter": []}}, "axes.diameter: expected at least one value"),
    ({"axes": {"diameter": [6, "7"]}}, r"axes.diameter\[1\]: expected a number"),
    ({"axes": {"diameter": [6, 6.0]}}, "axes.diameter: expected every value once"),
    ({"axes": {"lesion": 0}}, "expected a number of the list, from 1, got 0"),
    ({"axes": {"diameter": {"uniform": [6, 8]}}}, "expected values or steps for a grid"),
    ({"axes": {"diameter": {"uniform": [8, 6]}}}, "expected two rising numbers, got 8 and 6"),
    ({"axes": {"diameter": {"normal": [8, 0]}}}, "a mean and an SD above 0"),
    ({"axes": {"diameter": {"normal": [8, 1], "uniform": [1, 2]}}}, "expected one of values"),
    ({"axes": {"diameter": {"from": 1, "to": 2, "steps": 1}}}, "steps: expected 2 to 100000"),
    ({"axes": {"lesion": {"uniform": [1, 2]}}}, "axes.lesion: expected a list of values"),
    ({"axes": {"branch": 1}}, "expected a distance or a fraction with branch"),
    ({"axes": {"distance": 1}}, "expected a branch with distance"),
    ({"axes": {"offset": 1}}, "expected a lesion with offset"),
    ({"axes": {"branch": 1, "distance": 1, "fraction": 0.5}}, "a branch with a distance or"),
    ({"axes": {"branch": 1, "distance": 1, "lesion": 1}}, "a branch with a distance or"),
    ({"axes": {"diameter": 6, "diameter_over_lumen": 1}}, "got several"),
    ({"axes": {"diameter_over_reference": 1}}, "expected a lesion with diameter_over_reference"),
    ({"axes": {"shape": None, "shape.cap_height": 1}}, "whole shapes or parts of one"),
    ({"axes": {"device": "No such"}}, "expected a known one"),
    ({"sampling": {"method": "best"}}, "sampling.method: expected one of grid"),
    ({"sampling": {"method": "grid", "count": 3}}, "neither count nor seed for a grid"),
    ({"sampling": {"method": "sobol"}}, "expected the key 'count'"),
    ({"sampling": {"method": "sobol", "count": 0}}, "sampling.count: expected a whole"),
    ({"sampling": {"method": "sobol", "count": 10**8}}, "expected at most 10000000"),
    ({"sampling": {"method": "sobol", "count": 1, "seed": -1}}, "sampling.seed: expected a whole"),
    ({"constraints": {"diameter_over_reference": [0, 1]}}, "expected the axis lesion"),
    ({"constraints": {"diameter_over_lumen": [1]}}, "expected two numbers, got a list of 1"),
    ({"plan": 3}, "plan: expected a plan or the name of its file, got 3"),
    ({"plan": {}}, "stent: expected 1 to 0"),
    ({"axes": {"diameter": {"normal": [8, float("inf")]}}}, r"at most 1e\+06, got inf"),
    ({"stent": 2}, "stent: expected 1 to 1, got 2"),
    ({"store": "stl"}, "store: expected one of vtp, moved"),
    ({"patients": []}, "patients: expected at least one"),
    ({"patients": [{"name": "", "surface": "a.vtp"}]}, "expected another name for everyone"),
    ({"patients": [{"name": "a", "surface": "a.vtp", "age": 3}]}, "unknown key 'age'"),
    ({"plan": {**PLAN, "inputs": {}}}, "expected a surface file, got none"),
    ({"plan": {**PLAN, "stents": []}}, "stent: expected 1 to 0"),
]  # fmt: skip


@pytest.mark.parametrize(("changes", "sentence"), WRONG, ids=lambda value: str(value)[:60])
def test_what_does_not_belong_there_is_refused_with_its_place(folder, changes, sentence):
    with pytest.raises(InputError, match=sentence):
        sweep_in(folder, **changes)


def test_a_file_that_is_no_sweep_is_refused_with_its_name(tmp_path):
    for data, sentence in (
        (b"{", "expected a JSON document"),
        (b"\xff\xfe", "got no text in UTF-8"),
        (b"[]", "got a list of 0; this is no sweep"),
    ):
        path = tmp_path / "sweep.json"
        path.write_bytes(data)
        with pytest.raises(InputError, match=sentence) as caught:
            load_sweep(path)
        assert "sweep.json" in str(caught.value)


def test_the_schema_knows_the_same_axes_as_the_reader():
    assert set(SCHEMA["properties"]["axes"]["properties"]) == set(NAMES)


def test_the_schema_accepts_what_the_reader_accepts_and_refuses_what_is_malformed(folder):
    jsonschema = pytest.importorskip("jsonschema")
    validator = jsonschema.Draft7Validator(SCHEMA)
    validator.check_schema(SCHEMA)
    good = [
        {},
        {"axes": {"diameter": {"values": [6, 7]}, "length": {"from": 8, "to": 9, "steps": 2}}},
        {
            "axes": {"lesion": [1], "offset": {"normal": [0, 2], "within": [-3, 3]}, "diameter": 6},
            "sampling": {"method": "sobol", "count": 4, "seed": 2},
            "constraints": {"diameter_over_reference": [0.5, 1.2], "distance_to_ends": 3},
            "store": "moved",
        },
        {"patients": [{"name": "a", "surface": "tube.vtp", "units": "cm", "root": [0, 0, 0]}]},
        {"axes": {"diameter": 6, "device": ["generic"], "shape": [None, {"cap_height": 0.5}]}},
        {"axes": {"diameter": 6, "shape.waist.diameter": [5, 5.5]}, "stent": 1},
        {"time_limit": 600},
    ]
    for changes in good:
        sweep_in(folder, **changes)
        validator.validate(document(**changes))
    assert sweep_in(folder, time_limit=600).time_limit == 600
    # Rules between several keys are the reader's alone; every other one is the schema's, too.
    refused = [changes for changes, _ in WRONG if not validator.is_valid(document(**changes))]
    assert len(refused) > 20
    malformed = [
        {"foo": 1}, {"version": 2}, {"axes": {"width": 1}}, {"axes": {"diameter": [6, "7"]}},
        {"axes": {"lesion": {"uniform": [1, 2]}}}, {"sampling": {"method": "sobol"}},
        {"store": "stl"}, {"constraints": {"diameter_over_lumen": [1]}}, {"stent": 0},
        {"time_limit": 0}, {"time_limit": "600"}, {"time_limit": True},
    ]  # fmt: skip
    for changes in malformed:
        assert not validator.is_valid(document(**changes)), changes
        with pytest.raises(InputError):
            sweep_in(folder, **changes)
