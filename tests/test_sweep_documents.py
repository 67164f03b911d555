"""Sweep documents, their schema, and the samples that are drawn from them."""

import numpy as np
import pytest
from child_processes import python
from cohort_cases import PLAN, document, sweep_in, tube_folder, write_sweep

from benchmarks.phantoms import branching_pulmonary_artery
from SDFStentLib import InputError
from SDFStentLib.cohort import Cases, load_sweep, sweep_from_document, sweep_schema
from SDFStentLib.cohort.axes import NAMES
from SDFStentLib.cohort.cases import Samples
from SDFStentLib.cohort.constraints import Excluded
from SDFStentLib.cohort.varied import plan_of_case
from SDFStentLib.geometry import Line
from SDFStentLib.plan import read_plan_inputs, treatment_of
from SDFStentLib.treatment import axis_in_vessel

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


# What the parameters of a sweep mean in a vessel: places, ratios, shapes and constraints.


class Swept:
    """The first case of a sweep, and the patient that it is for."""

    def __init__(self, folder, **changes):
        self.sweep = sweep_in(folder, **changes)
        self.patient = self.sweep.patients[0]
        self.inputs = read_plan_inputs(self.patient.plan)
        self.cases = list(Cases(self.sweep))

    def plan(self, at=0, inputs=None):
        sweep = self.sweep
        return plan_of_case(
            self.patient.plan,
            sweep.stent,
            self.cases[at].parameters,
            sweep.constraints,
            inputs or self.inputs,
        )

    def axis(self, at=0):
        vessel = self.inputs.vessel
        stent = vessel.placed(self.plan(at).stents[0])
        return axis_in_vessel(stent, vessel.centerline, vessel.surface).points


def middle_of(axis):
    lengths = np.append(0, np.cumsum(np.linalg.norm(np.diff(axis, axis=0), axis=1)))
    return np.array([np.interp(lengths[-1] / 2, lengths, column) for column in axis.T])


def test_a_fraction_is_that_of_the_branch(folder):
    swept = Swept(folder, axes={"branch": [1], "fraction": [0.25, 0.6]})
    line = swept.inputs.vessel.centerline
    for at, share in enumerate((0.25, 0.6)):
        assert middle_of(swept.axis(at))[2] == pytest.approx(
            share * line.arc_length.max(), abs=1e-6
        )


def test_numbers_and_parts_of_a_stent_are_swept_by_their_paths(folder):
    axes = {
        "length": [10.0, 12.0],
        "foreshortening_fraction": [0.0, 0.2],
        "shape.end.diameter": [7.0],
        "shape.end.length": [2.0],
    }
    swept = Swept(folder, axes=axes)
    found = [swept.plan(at).stents[0] for at in range(4)]
    assert [(one.length, one.foreshortening) for one in found] == [
        (10.0, 0.0), (10.0, 0.2), (12.0, 0.0), (12.0, 0.2),
    ]  # fmt: skip
    assert {(one.shape.end.diameter, one.shape.end.length) for one in found} == {(7.0, 2.0)}
    whole = {"name": "own", "lengths": [[4.0, 11.0], [9.0, 9.0]], "nominal_length": 12.0}
    device = {"device": [{**whole, "source": "a table"}], "foreshortening_fraction": [0.3]}
    with pytest.raises(InputError, match="foreshortening_fraction: expected none with own"):
        Swept(folder, axes=device).plan()


def test_a_place_in_a_sweep_is_that_of_a_plan(folder):
    """Also where the base plan has none, and no length."""
    from cohort_cases import PLAN

    from SDFStentLib.stent import AtLesion, OnBranch

    plan = {**PLAN, "stents": [{"name": "varied"}]}
    for place, expected in (
        ({"lesion": [1], "offset": [-2, 3]}, [AtLesion(1, -2.0), AtLesion(1, 3.0)]),
        ({"lesion": [1]}, [AtLesion(1, 0.0)]),
        ({"branch": [1], "distance": [9, 12]}, [OnBranch(1, 9.0), OnBranch(1, 12.0)]),
    ):
        swept = Swept(folder, plan=plan, axes={"diameter": [6], "length": [9], **place})
        stents = [swept.plan(at).stents[0] for at in range(len(swept.cases))]
        assert [one.placement for one in stents] == expected
        assert swept.patient.plan.stents[0].placement is None


def test_a_diameter_over_the_reference_is_that_of_the_lesion(folder):
    swept = Swept(folder, axes={"lesion": [1], "diameter_over_reference": [0.9]})
    # The tube is 6 mm wide beside its throat; the wall is a polygon in it.
    assert swept.plan().stents[0].diameter == pytest.approx(0.9 * 6, rel=0.02)


def test_whole_shapes_and_parts_of_one_reach_the_stent(folder):
    whole = Swept(folder, axes={"shape": [None, {"cap_height": 0.5}]})
    assert whole.plan(0).stents[0].shape is None
    assert whole.plan(1).stents[0].shape.cap_height == 0.5
    parts = Swept(folder, axes={"shape.waist.diameter": [5], "shape.waist.position": [0.4]})
    waist = parts.plan().stents[0].shape.waist
    assert (waist.diameter, waist.position) == (5, 0.4)


def test_a_device_brings_its_length_and_keeps_its_name(folder):
    row = {"name": "long one", "nominal_length": 12.0, "foreshortening_fraction": 0.05}
    row |= {"source": "here", "source_date": "2026"}
    swept = Swept(folder, axes={"device": [row], "diameter": [6]})
    stent = swept.plan().stents[0]
    assert (stent.device.name, stent.length, stent.diameter) == ("long one", 12.0, 6)


@pytest.mark.parametrize(
    ("axes", "constraints", "sentence"),
    [
        ({"diameter": 6, "branch": 1, "distance": 6}, {"distance_to_ends": 3}, "ends: 1.5 mm"),
        ({"diameter": 6, "branch": 1, "distance": 33}, {"distance_to_ends": 3}, "ends: 2.5 mm"),
        ({"diameter": 6, "lesion": 1}, {"diameter_over_reference": [1.1, 2]}, "reference: 1.0"),
        ({"diameter": 6, "lesion": 1}, {"diameter_over_lumen": [0.5, 1.2]}, "lumen: [12]"),
    ],
)
def test_what_is_beyond_a_constraint_is_excluded_and_says_by_what(
    folder, axes, constraints, sentence
):
    swept = Swept(folder, axes=axes, constraints=constraints)
    with pytest.raises(Excluded, match=sentence):
        swept.plan()


def test_what_keeps_to_the_constraints_is_not_excluded(folder):
    rules = {
        "distance_to_ends": 10,
        "diameter_over_reference": [0.9, 1.1],
        "diameter_over_lumen": [1, 3],
    }
    assert Swept(folder, axes={"diameter": 6, "lesion": 1}, constraints=rules).plan()


@pytest.mark.parametrize(
    ("axes", "sentence"),
    [
        ({"lesion": [7]}, "lesion: expected 1, for so many there are, got 7"),
        ({"branch": [4], "distance": 1}, "branch: expected 1 to 1 or one of"),
        ({"branch": ["LPA"], "distance": 1}, "got 'LPA'"),
        ({"branch": [1], "distance": [400]}, "distance: expected a number at least 0 and at most"),
        ({"lesion": [1], "offset": [90]}, "offset: expected a number at least"),
        ({"shape.waist.diameter": [7]}, "waist: expected at most the 6 mm of the stent"),
    ],
)
def test_what_the_patient_has_not_is_refused_in_one_sentence(folder, axes, sentence):
    with pytest.raises(InputError, match=sentence):
        Swept(folder, axes=axes).plan()


def test_a_place_needs_a_centerline(folder):
    from cohort_cases import PLAN

    plan = {**PLAN, "inputs": {"units": "cm", "surface": {"file": "tube.vtp"}}}
    with pytest.raises(InputError, match="expected a centerline for a place"):
        Swept(folder, plan=plan).plan()


def test_a_place_in_a_plan_of_the_other_frame_is_the_same_place(folder, tmp_path):
    """The surface tells RAS, the plan is in LPS: x and y of its points are negated."""
    from SDFStentLib.files import (
        add_arrays,
        encode_vtp,
        polydata_from_arrays,
        polydata_from_lines,
        set_frame_of_polydata,
    )

    vessel = branching_pulmonary_artery()
    wall = polydata_from_arrays(vessel.points, vessel.triangles)
    set_frame_of_polydata(wall, "RAS")
    tree = vessel.centerline
    lines = [tree.ancestry(int(leaf)) for leaf in tree.leaves]
    line = polydata_from_lines(tree.points, lines)
    add_arrays(line, {"MaximumInscribedSphereRadius": tree.inscribed_radius}, {})
    (tmp_path / "wall.vtp").write_bytes(encode_vtp(wall))
    (tmp_path / "line.vtp").write_bytes(encode_vtp(line))
    axes, places = {"branch": [2], "distance": [15], "diameter": 7.5, "length": 12}, []
    for frame in (None, "RAS", "LPS"):
        people = [{"name": "a", "surface": "wall.vtp", "centerline": "line.vtp", "frame": frame}]
        swept = Swept(tmp_path, patients=people, axes=axes)
        treatment = treatment_of(swept.plan(), swept.inputs)
        places.append(treatment.result.stents[0].axis.points)
    np.testing.assert_allclose(places[1], places[0], atol=1e-9)
    np.testing.assert_allclose(places[2], places[0], atol=1e-9)
    expected = swept.inputs.vessel.centerline.point_at(1, 15)
    np.testing.assert_allclose(middle_of(places[0]), expected, atol=0.05)


def test_a_lesion_across_a_junction_is_stented_into_its_own_branch(data_dir):
    """With an offset the middle lies above the junction, and two branches lead down from there."""
    inputs = {
        "name": "artery",
        "units": "cm",
        "surface": str(data_dir / "pulmonary_surface_cm.vtp"),
        "centerline": str(data_dir / "pulmonary_centerline_cm.vtp"),
    }
    axes = {"lesion": [1, 2], "offset": [-55, -45, 0], "diameter": 8, "length": 25}
    swept = Swept(data_dir, patients=[inputs], axes=axes)
    tree, above = swept.inputs.vessel.centerline, 0
    for at, case in enumerate(swept.cases):
        lesion = swept.inputs.vessel.lesions[case.parameters["lesion"] - 1]
        branch = tree.branches[lesion.branch]
        way = tree.points[tree.ancestry(int(branch[-1]))]
        axis = swept.axis(at)
        # The stents are shorter than the rest of their branches: all of them is on the way there.
        assert Line(way).nearest(axis).distances.max() < 0.1, case
        above += tree.project(middle_of(axis)).arc_length < tree.arc_length[branch[0]]
    assert above
