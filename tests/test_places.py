"""Places at lesions and on branches in library, plan and shell; stents without a place."""

import json
from dataclasses import replace

import numpy as np
import pytest
from seeds import seeds
from tube_files import write_vessel

from benchmarks.phantoms import branching_pulmonary_artery, stenosed_tube
from SDFStentLib.cli import main
from SDFStentLib.files import read_surface
from SDFStentLib.plan import (
    Plan,
    load_plan,
    plan_from_document,
    plan_schema,
    plan_text,
    read_input_files,
    run_plan,
    save_plan,
    treatment_of,
    turned,
)
from SDFStentLib.stent import (
    AtCenter,
    AtDistalEnd,
    AtLesion,
    Device,
    InputFile,
    OnBranch,
    Stent,
    balloon_by_rule,
    stent_axis,
)
from SDFStentLib.treatment import Vessel, axis_in_vessel, placement_at
from SDFStentLib.validation import InputError


def a_vessel(phantom):
    return Vessel(phantom.surface, phantom.centerline)


@pytest.fixture(scope="module")
def artery():
    return a_vessel(branching_pulmonary_artery())


@pytest.fixture(scope="module")
def tube():
    return a_vessel(stenosed_tube())


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    found = tmp_path_factory.mktemp("places")
    write_vessel(
        found, branching_pulmonary_artery(), "wall.vtp", "line.vtp", per_mm=1.0, radii=True
    )
    return found


def middle_of(stent, vessel):
    axis = axis_in_vessel(vessel.placed(stent), vessel.centerline, vessel.surface).line
    return axis.at(np.array([axis.length / 2]))[0]


@pytest.mark.parametrize("seed", seeds(8, 100))
def test_on_a_branch_the_middle_is_so_far_along_its_points(artery, seed):
    """Against the branch's own points, one by one."""
    random, tree = np.random.default_rng(seed), artery.centerline
    number = int(random.integers(1, len(tree.branches) + 1))
    points = tree.points[tree.branches[number - 1]]
    along = np.append(0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
    share = float(random.uniform(0.35, 0.65))
    at = share * along[-1]
    expected = np.array([np.interp(at, along, column) for column in points.T])
    stent = Stent(5.0, placement=OnBranch(number, at), length=float(random.uniform(2, 8)))
    np.testing.assert_allclose(middle_of(stent, artery), expected, atol=1e-6)
    by_share = stent.at(OnBranch(artery.branch_names[number - 1], fraction=share))
    np.testing.assert_allclose(middle_of(by_share, artery), expected, atol=1e-6)


@pytest.mark.parametrize("seed", seeds(8, 100))
def test_an_offset_is_the_way_from_the_middle_of_the_lesion(tube, seed):
    random, (lesion, *_) = np.random.default_rng(seed), tube.lesions
    offset, length = float(random.uniform(-8, 8)), float(random.uniform(3, 14))
    stent = Stent(5.0, placement=AtLesion(1, offset), length=length)
    # The tube is straight, along z.
    z = middle_of(stent, tube)[2]
    assert z == pytest.approx((lesion.start + lesion.end) / 2 + offset, abs=1e-6)


@pytest.mark.parametrize("length", [4.0, 8.0, 14.0, 30.0])
def test_without_an_offset_a_short_stent_moves_to_the_narrowest_place(artery, length):
    stent = artery.placed(Stent(7.0, placement=AtLesion(1), length=length))
    (lesion, *_) = artery.lesions
    expected = placement_at(lesion, artery.centerline, length, stent.foreshortening)
    assert stent.placement == expected
    axis = stent_axis(stent, artery.centerline)
    away = axis.line.nearest(np.array([lesion.point])).distances
    assert away < 0.3


def test_the_place_follows_the_length_that_the_device_has_at_its_diameter(tube):
    """A wider one is shorter: its distal end lies elsewhere, its middle where it was."""
    known = {"nominal_length": 16.0, "lengths": ((4.0, 16.0), (8.0, 12.0)), "source": "here"}
    device = Device("shortening", **known)
    for diameter, deployed in ((4.0, 16.0), (6.0, 14.0), (8.0, 12.0)):
        stent = Stent(diameter, placement=AtLesion(1, 0.0), device=device)
        axis = stent_axis(tube.placed(stent), tube.centerline)
        assert axis.deployed_length == pytest.approx(deployed)
        middle = (tube.lesions[0].start + tube.lesions[0].end) / 2
        ends = axis.points[[0, -1], 2]
        assert ends == pytest.approx([middle - deployed / 2, middle + deployed / 2], abs=1e-6)


@pytest.mark.parametrize("diameter", [6.0, 9.0, 20.0])
def test_a_balloon_recoils_by_the_rule_where_the_stent_lies_and_shortens_it(tube, diameter):
    known = {"nominal_length": 16.0, "lengths": ((3.0, 16.0), (20.0, 10.0)), "source": "here"}
    stent = Stent(5.0, placement=AtLesion(1), device=Device("shortening", **known))
    found = tube.inflated(stent, diameter)
    # By hand: placed with the usual recoil, measured, placed again.
    usual = balloon_by_rule(diameter, float("nan"))
    lying = tube.placed(replace(stent, diameter=usual.lumen_diameter))
    axis = axis_in_vessel(lying, tube.centerline, tube.surface)
    balloon = balloon_by_rule(diameter, tube.diameters(axis.line, 0.5).minimum)
    assert (found.balloon, found.diameter) == (balloon, balloon.lumen_diameter)
    assert found.foreshortening == pytest.approx((found.diameter - 3) * 6 / 17 / 16)
    assert found.placement == stent.placement  # symbolic still
    given = tube.inflated(stent, diameter, 0.2)
    assert (given.diameter, given.balloon.is_given) == (pytest.approx(0.8 * diameter), True)


@pytest.mark.parametrize(
    "placement",
    [
        AtLesion(2),
        AtLesion(1, -3.25),
        OnBranch(3, 12.5),
        OnBranch("left pulmonary artery", fraction=0.25),
        None,
    ],
)
@pytest.mark.parametrize(("units", "frame"), [("mm", None), ("cm", "LPS")])
def test_a_plan_keeps_places_and_stents_without_one(placement, units, frame, tmp_path):
    stents = Stent(6.0, placement=placement, length=12.0), Stent(7.0, name="nowhere")
    plan = Plan(stents=stents, units=units, frame=frame)
    save_plan(plan, tmp_path / "plan.json")
    assert load_plan(tmp_path / "plan.json") == plan
    assert turned(turned(stents[0])) == stents[0]
    document = json.loads(plan_text(plan))
    validate(document)
    del document["stents"][1]["placement"]  # as null
    assert plan_from_document(document) == plan


def validate(document):
    jsonschema = pytest.importorskip("jsonschema")
    jsonschema.validate(document, plan_schema())


def test_a_schema_tells_places_apart_from_what_is_none():
    jsonschema = pytest.importorskip("jsonschema")
    for wrong in ({"lesion": 0}, {"branch": 1}, {"lesion": 1, "distance": 2}, {"offset": 1}):
        document = json.loads(plan_text(Plan(stents=[Stent(6.0, length=12.0)])))
        document["stents"][0]["placement"] = wrong
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(document, plan_schema())


def shell(*arguments):
    return main([*map(str, arguments), "--quiet"])


def deployed(folder, out, *more):
    line = "--centerline", folder / "line.vtp", "--length", 12, "--diameter", 7
    assert shell("deploy", folder / "wall.vtp", *line, "-o", out, *more) == 0
    return read_surface(out).points


PLACES = [
    (("--at-lesion", 1), AtLesion(1)),
    (("--at-lesion", 1, "--offset", 2.5), AtLesion(1, 2.5)),
    (("--branch", 2, "--distance", 9), OnBranch(2, 9.0)),
]


@pytest.mark.parametrize(("options", "placement"), PLACES)
def test_shell_plan_and_points_give_the_same_wall(folder, tmp_path, options, placement):
    saved = tmp_path / "plan.json"
    wall = deployed(folder, tmp_path / "shell.vtp", *options, "--save-plan", saved)
    plan = load_plan(saved)
    assert plan.stents[0].placement == placement
    np.testing.assert_array_equal(run_plan(plan).treatment.points.astype(wall.dtype), wall)
    vessel = read_input_files(folder / "wall.vtp", folder / "line.vtp").vessel
    place = vessel.placed(plan.stents[0]).placement
    name = {AtCenter: "--center", AtDistalEnd: "--distal"}[type(place)]
    by_point = deployed(folder, tmp_path / "point.vtp", name, *map(repr, place.point.tolist()))
    np.testing.assert_array_equal(by_point, wall)


def test_a_branch_is_found_by_what_measure_calls_it(folder, tmp_path):
    vessel = read_input_files(folder / "wall.vtp", folder / "line.vtp").vessel
    name = vessel.branch_names[1]
    where = "--fraction", 0.4
    by_name = deployed(folder, tmp_path / "a.vtp", "--branch", name, *where)
    by_number = deployed(folder, tmp_path / "b.vtp", "--branch", 2, *where)
    np.testing.assert_array_equal(by_name, by_number)


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (("--at-lesion", 9), "--at-lesion: expected 1, as the vessel has one lesion, got 9"),
        (("--branch", 9, "--distance", 1), "branch: expected 1 to 3 or one of"),
        (("--branch", "x", "--distance", 1), "got 'x'"),
        (("--branch", 2), "expected --distance MM or --fraction S with --branch, got neither"),
        (("--branch", 2, "--distance", 999), "distance: expected a number at least 0 and at most"),
        (("--branch", 2, "--fraction", 2), "fraction: expected a number at least 0 and at most 1"),
        (("--at-lesion", 1, "--offset", 999), "offset: expected a number at least"),
        (("--center", 0, 0, 0, "--offset", 1), "expected --at-lesion with --offset, got none"),
        (("--center", 0, 0, 0, "--fraction", 1), "expected --branch with --fraction, got none"),
        (("--at-lesion", 1, "--branch", 1, "--distance", 1), "got --at-lesion and --branch"),
    ],
)
def test_what_the_vessel_has_not_is_refused_and_nothing_is_written(
    folder, tmp_path, capsys, options, sentence
):
    line = "--centerline", folder / "line.vtp", "--length", 12, "--diameter", 7
    out = tmp_path / "out.vtp"
    assert shell("deploy", folder / "wall.vtp", *line, "-o", out, *options) == 2
    assert sentence in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_a_stent_without_a_place_is_kept_when_off_and_refused_when_on(folder, tmp_path):
    files = {
        "surface": InputFile(folder / "wall.vtp"),
        "centerline": InputFile(folder / "line.vtp"),
    }
    on = Stent(7.0, placement=AtLesion(1), length=12.0)
    off = Stent(5.0, name="later", enabled=False)
    plan = Plan(stents=(on, off), **files)
    inputs = read_input_files(folder / "wall.vtp", folder / "line.vtp")
    result = treatment_of(plan, inputs).result
    assert [one.kind for one in result.warnings if one.stent == 2] == ["switched-off"]
    with pytest.raises(InputError, match=r"Stent 2 \(later\): stent placement: expected a place"):
        treatment_of(replace(plan, stents=(on, replace(off, enabled=True))), inputs)


def test_a_place_of_a_vessel_needs_its_centerline(folder):
    inputs = read_input_files(folder / "wall.vtp")
    with pytest.raises(InputError, match="expected a centerline for a place at a lesion or on a"):
        treatment_of(Plan(stents=[Stent(6.0, placement=AtLesion(1), length=9.0)]), inputs)


def test_the_same_stent_is_redilated_where_it_lies(folder, tmp_path):
    """By its distal end where the lesion begins at a junction: that stays where it is."""
    again = "--redilate", 9, "--foreshortening", 0.1
    saved = tmp_path / "plan.json"
    wall = deployed(folder, tmp_path / "a.vtp", "--at-lesion", 1, *again, "--save-plan", saved)
    np.testing.assert_array_equal(
        run_plan(load_plan(saved)).treatment.points.astype(wall.dtype), wall
    )
