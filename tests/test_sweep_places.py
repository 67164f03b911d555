"""What the parameters of a sweep mean in a vessel: places, ratios, shapes and constraints."""

from __future__ import annotations

import numpy as np
import pytest
from cohort_cases import sweep_in, tube_folder

from SDFStentLib import InputError
from SDFStentLib.cohort import Cases
from SDFStentLib.cohort.placing import Excluded, plan_of_case
from SDFStentLib.geometry import Line
from SDFStentLib.phantoms import branching_pulmonary_artery
from SDFStentLib.plan import read_plan_inputs, treatment_of
from SDFStentLib.treatment import axis_in_vessel


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tube_folder(tmp_path_factory.mktemp("places"))


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
        return axis_in_vessel(self.plan(at).stents[0], vessel.centerline, vessel.surface).points


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
        ({"lesion": [7]}, "lesion: expected one of the 1 there are, got 7"),
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
    with pytest.raises(InputError, match="expected a patient with a centerline"):
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
