"""Cohorts: what is stored, that it is the same on every executor, tables, and arrays."""

import csv
import gzip
import json
import random
from concurrent.futures import Executor, Future

import numpy as np
import pytest
from cohort_cases import PLAN, bytes_of, sweep_in, tube_folder

from SDFStentLib import InputError, Plan, Stent, plan_report, read_surface, run_plan
from SDFStentLib.cohort import Cases, Cohort, run_sweep, write_manifest
from SDFStentLib.cohort.moved import decoded
from SDFStentLib.cohort.store import Store
from SDFStentLib.cohort.worker import NO_VIEWS
from SDFStentLib.stent import AtCenter, InputFile


class Inline(Executor):
    """Every case at once, in this process."""

    def submit(self, fn, /, *args, **kwargs):
        future = Future()
        future.set_running_or_notify_cancel()
        try:
            future.set_result(fn(*args, **kwargs))
        except BaseException as error:
            future.set_exception(error)
        return future


class Shuffled(Inline):
    """All cases that it got, in an order of its own."""

    def __init__(self):
        self.got = []

    def submit(self, fn, /, *args, **kwargs):
        future = Future()
        self.got.append((future, fn, args))
        if len(self.got) == 6:
            random.Random(4).shuffle(self.got)
            for one, function, values in self.got:
                one.set_result(function(*values))
        return future


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tube_folder(tmp_path_factory.mktemp("cohorts"))


@pytest.fixture(scope="module")
def whole(folder):
    """A cohort with whole surfaces, done in this process, case by case."""
    run_sweep(sweep_in(folder), folder / "whole", executor=Inline())
    return folder / "whole"


@pytest.fixture(scope="module")
def moved(folder):
    """The same with the points that moved."""
    tally = run_sweep(sweep_in(folder, store="moved"), folder / "moved", executor=Inline())
    assert (tally.certified, tally.total) == (6, 6)
    return folder / "moved"


def test_a_case_holds_what_the_plan_gives_by_itself(folder, whole):
    """The third case, carried out as a plan: the same surface byte for byte, the same report."""
    case = list(Cases(sweep_in(folder)))[2]
    assert case.parameters == {"diameter": 6.5, "branch": 1, "distance": 18}
    files = [InputFile(folder / name) for name in ("tube.vtp", "line.vtp")]
    stent = Stent(6.5, placement=AtCenter([0, 0, 18.0]), length=10)
    result = run_plan(Plan((stent,), *files, units="cm"))
    result.write_surface(folder / "alone.vtp")
    stored = Store(whole).path(case.id)
    assert (stored / "surface.vtp").read_bytes() == (folder / "alone.vtp").read_bytes()
    report = json.loads(gzip.decompress((stored / "report.json.gz").read_bytes()))
    alone = plan_report(result).as_dict()
    for part in ("diameters", "certificate", "lesions", "branches"):
        assert report[part] == alone[part]
    assert not {"created", "timings"} & set(report)
    assert [file["file"] for file in report["inputs"]] == ["tube.vtp", "line.vtp"]


def test_an_executor_in_any_order_gives_the_same_bytes(folder, whole):
    """Processes do, too: see `test_sweep_faults.py`."""
    out = folder / "shuffled"
    run_sweep(sweep_in(folder), out, executor=Shuffled())
    found, wanted = bytes_of(out), bytes_of(whole)
    assert sorted(found) == sorted(wanted)
    assert [name for name in wanted if found[name] != wanted[name]] == []


def test_the_whole_surface_comes_back_from_its_moved_points_bit_by_bit(folder, whole, moved):
    kept, full = Cohort(moved), Cohort(whole)
    for case in kept.cases():
        kept.write_surface(case, folder / "restored.vtp")
        original = Store(whole).path(case) / "surface.vtp"
        assert (folder / "restored.vtp").read_bytes() == original.read_bytes()
        stored = read_surface(original, "cm")
        np.testing.assert_array_equal(kept.points(case), stored.points)
        np.testing.assert_array_equal(full.points(case), stored.points)


def test_damaged_moved_points_are_refused(moved):
    data = (Store(moved).path(Cohort(moved).cases()[0]) / "moved.npz").read_bytes()
    for damaged in (b"", data[:40], b"no zip file"):
        with pytest.raises(InputError, match=r"expected an \.npz of a cohort"):
            decoded(damaged)


def test_a_file_that_was_changed_behind_the_store_is_noticed(folder, tmp_path):
    run_sweep(sweep_in(folder, axes={"diameter": 6}, store="moved"), tmp_path, executor=Inline())
    cohort = Cohort(tmp_path)
    (case,) = cohort.cases()
    path = Store(tmp_path).path(case) / "moved.npz"
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(data)
    with pytest.raises(InputError, match=r"moved\.npz is damaged"):
        cohort.points(case)


def test_the_manifest_has_a_row_per_case_with_what_came_of_it(folder, whole):
    with (whole / "manifest.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    cases = list(Cases(sweep_in(folder)))
    assert [row["case"] for row in rows] == [case.id for case in cases]
    for row, case in zip(rows, cases, strict=True):
        assert float(row["parameter_diameter"]) == case.parameters["diameter"]
        assert float(row["diameter_mm"]) == case.parameters["diameter"]
        assert (row["status"], row["certified"]) == ("done", "true")
        report = Cohort(whole).report(case.id)
        along = report["stents"][0]["diameters"]["along"]
        stented = [
            after
            for after, prescribed in zip(along["mis_after_mm"], along["prescribed_mm"], strict=True)
            if prescribed is not None
        ]
        assert float(row["lumen_after_mm"]) == min(stented)
        assert int(row["warnings"]) == len(report["warnings"])
        assert row["surface_sha256"] == report["inputs"][0]["sha256"]
        assert row["centerline_sha256"] == report["inputs"][1]["sha256"]


def test_parquet_holds_the_same_table(whole):
    parquet = pytest.importorskip("pyarrow.parquet")
    table = parquet.read_table(whole / "manifest.parquet").to_pydict()
    columns = Cohort(whole).columns
    assert list(table) == list(columns)
    for name, values in columns.items():
        if values.dtype.kind == "f":
            found = np.array([np.nan if value is None else value for value in table[name]], float)
            np.testing.assert_array_equal(found, values)
        else:
            assert [value or "" for value in table[name]] == values.tolist()


def test_parameters_and_displacements_come_as_arrays(folder, whole, moved):
    found = Cohort(moved).training_set()
    assert found.names == ("diameter", "branch", "distance")
    wanted = [list(case.parameters.values()) for case in Cases(sweep_in(folder))]
    np.testing.assert_array_equal(found.parameters, wanted)
    assert found.displacements.dtype == np.float32
    assert found.displacements.shape == (6, len(found.points), 3)
    for case, shift in zip(found.cases, found.displacements, strict=True):
        after = read_surface(Store(whole).path(case) / "surface.vtp", "cm").points
        np.testing.assert_allclose(found.points + shift, after, atol=1e-6)
        assert np.abs(shift).max() > 0.5
    other = Cohort(whole).training_set()
    np.testing.assert_array_equal(other.displacements, found.displacements)
    np.testing.assert_array_equal(other.triangles, read_surface(folder / "tube.vtp").triangles)


def test_what_is_excluded_and_what_fails_is_in_the_manifest_with_its_reason(folder, tmp_path):
    sweep = sweep_in(
        folder,
        axes={"diameter": [6, 40], "branch": 1, "distance": [5, 20]},
        constraints={"distance_to_ends": 4},
    )
    tally = run_sweep(sweep, tmp_path / "out", executor=Inline())
    assert (tally.certified, tally.excluded, tally.failed) == (1, 2, 1)
    columns = Cohort(tmp_path / "out").columns
    assert columns["status"].tolist() == ["excluded", "done", "excluded", "failed"]
    assert "distance to the ends: 0.5 mm, below 4" in columns["reason"][0]
    assert "expected at most 4 times the lumen" in columns["reason"][3]
    assert np.isnan(columns["lumen_after_mm"][[0, 2, 3]]).all()


def test_a_plan_that_asks_for_no_certificate_is_not_called_certified(folder, tmp_path):
    plan = {**PLAN, "settings": {"certify": False}}
    sweep = sweep_in(folder, plan=plan, axes={"diameter": [6]})
    for _ in range(2):
        tally = run_sweep(sweep, tmp_path / "out", executor=Inline())
        assert (tally.certified, tally.unjudged) == (0, 1)
    assert np.isnan(Cohort(tmp_path / "out").columns["certified"]).all()


def test_texts_stay_texts_whatever_they_look_like(folder, tmp_path):
    person = {"name": "007", "units": "cm", "surface": "tube.vtp", "centerline": "line.vtp"}
    sweep = sweep_in(folder, patients=[person], axes={"diameter": 6, "device": ["generic"]})
    run_sweep(sweep, tmp_path / "out", executor=Inline())
    columns = Cohort(tmp_path / "out").columns
    assert columns["patient"].tolist() == ["007"]
    assert columns["parameter_device"].tolist() == ["generic"]
    assert Cohort(tmp_path / "out").training_set("007").names == ("diameter",)


def test_several_stents_are_several_rows_of_one_case(folder, tmp_path):
    stents = [
        {"name": "first", "diameter": 6, "length": 8, "placement": {"center": [0, 0, 1.6]}},
        {"name": "second", "length": 8, "placement": {"center": [0, 0, 2.4]}},
    ]
    sweep = sweep_in(folder, plan={**PLAN, "stents": stents}, stent=2, axes={"diameter": [6, 7]})
    run_sweep(sweep, tmp_path / "out", executor=Inline())
    cohort = Cohort(tmp_path / "out")
    assert cohort.columns["stent"].tolist() == [1, 2, 1, 2]
    assert cohort.columns["diameter_mm"].tolist() == [6, 6, 6, 7]
    assert len(cohort.cases()) == 2


def test_a_plan_that_knows_a_flow_adds_columns_of_it(folder, tmp_path):
    flow = {"mean": 8.0, "inlet": 20.0, "wedge": 8.0}
    sweep = sweep_in(folder, plan=PLAN | {"flow": flow}, axes={"diameter": [6, 6.5]})
    run_sweep(sweep, tmp_path / "out", executor=Inline())
    cohort = Cohort(tmp_path / "out")
    columns = cohort.columns
    assert columns["inlet_pressure_before_mmhg"] == pytest.approx([20, 20])
    after = columns["inlet_pressure_after_mmhg"]
    drop = columns["pressure_drop_after_mmhg"]
    assert (after < 20).all()
    assert (drop < 0.5 * columns["pressure_drop_before_mmhg"]).all()
    for case, at, lost in zip(columns["case"], after, drop, strict=True):
        told = cohort.report(str(case))["flow"]["after"]["mean"]
        assert told["inlet_mmhg"]["value"] == pytest.approx(at)
        assert told["narrowings"][0]["recovered_mmhg"]["value"] == pytest.approx(lost)


def test_a_sweep_may_grow_in_its_folder_and_keeps_what_is_there(folder, tmp_path):
    out, axes = tmp_path / "out", {"diameter": {"uniform": [6, 7]}}
    for count, new in ((2, 2), (4, 2)):
        sampling = {"method": "sobol", "count": count, "seed": 1}
        tally = run_sweep(sweep_in(folder, axes=axes, sampling=sampling), out, executor=Inline())
        assert tally.finished - tally.found == new
    assert len(Cohort(out).cases()) == 4


def test_another_sweep_is_refused_where_its_cases_would_be_lost_from_the_manifest(folder, whole):
    before = bytes_of(whole)
    with pytest.raises(InputError, match="got one with 6 other cases; name another folder"):
        run_sweep(sweep_in(folder, axes={"diameter": 6}), whole, executor=Inline())
    assert bytes_of(whole) == before


def test_a_folder_that_is_no_cohort_is_refused(tmp_path):
    for use in (Cohort, write_manifest):
        with pytest.raises(InputError, match="expected the folder of a cohort"):
            use(tmp_path)


@pytest.mark.parametrize("views", [None, {"lao_rao": 90.0}])
def test_views_are_worked_out_for_every_case_only_where_the_plan_has_some(folder, tmp_path, views):
    inputs = {"inputs": PLAN["inputs"] | {"frame": "LPS"}}
    plan = PLAN | inputs | ({} if views is None else {"views": views})
    sweep = sweep_in(folder, plan=plan, axes={"diameter": [6]})
    run_sweep(sweep, tmp_path / "out", executor=Inline())
    cohort = Cohort(tmp_path / "out")
    told = cohort.report(str(cohort.columns["case"][0]))["views"]
    assert len(told["stents"]) == (views is not None)
    assert told["reason"] == (NO_VIEWS if views is None else None)
