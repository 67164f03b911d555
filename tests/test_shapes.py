"""Stents that are no cylinders: one profile over the axis, measured against what is prescribed."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from deployment_cases import anatomy, phantom
from test_plan import SCHEMA
from tube_files import deploy

from SDFStentLib.deformation import DeploymentSettings
from SDFStentLib.deformation import deploy as deployed
from SDFStentLib.field import RadiusShares
from SDFStentLib.geometry import Line
from SDFStentLib.plan import Plan, load_plan, plan_from_document, plan_text, read_profile, run_plan
from SDFStentLib.stent import AlongAxis, AtCenter, Shape, Stent, StentEnd, Waist
from SDFStentLib.treatment import Treatment
from SDFStentLib.validation import InputError

HOURGLASS = Shape(waist=Waist(6.6))
"""Of the paper's first patient with tetralogy of Fallot, whose stent has 8.0 mm and 6.6 mm."""

SHAPES = {
    "hourglass": HOURGLASS,
    "short waist": Shape(waist=Waist(6.0, position=0.3, length=8.0)),
    "flare and taper": Shape(start=StentEnd(9.5, 4.0), end=StentEnd(7.0, 5.0)),
    "all": Shape(waist=Waist(6.8, 0.5, 6.0), start=StentEnd(9.0, 4.0), end=StentEnd(9.0, 4.0)),
    "table": Shape(table=((0, 7.0), (0.3, 8.0), (0.5, 6.5), (1, 8.0))),
    "taper": Shape(table=((0, 8.0), (1, 6.0))),
    "flat caps": Shape(cap_height=0.35),
}

ENOUGH = 0.1
"""Largest difference of measured and prescribed diameters, mm, that is asked for."""


def treated(shape, vessel=None, ends=(12.0, 28.0), diameter=8.0) -> Treatment:
    vessel = vessel or phantom("stenosed_tube", edge_length=0.4)
    axis = vessel.axis_at(np.linspace(*ends, 200))
    stent = Stent(diameter, placement=AlongAxis(axis), shape=shape)
    return Treatment(vessel.surface, [stent], vessel.centerline)


def errors(stent) -> np.ndarray:
    """Measured minus prescribed diameter across the axis, by the area of the section, mm."""
    profile, after = stent.axis.profile, stent.after
    prescribed = profile.at(after.arc_length / stent.axis.deployed_length)
    return after.equivalent_diameter - prescribed


# ---- the profile


def test_a_profile_is_that_of_its_parts():
    at = np.linspace(0, 1, 9)
    flat = Shape().along(8.0, 16.0)
    assert flat.at(at).tolist() == [8.0] * 9
    waist = Shape(waist=Waist(6.6)).along(8.0, 16.0, narrowest=0.5)
    assert waist.at(at)[[0, 4, 8]] == pytest.approx([8.0, 6.6, 8.0])
    assert waist.at(at) == pytest.approx(waist.at(at[::-1]))
    shifted = Shape(waist=Waist(6.6, length=8.0)).along(8.0, 16.0, narrowest=0.25)
    assert shifted.at(np.array([0.0, 0.25, 0.5, 0.75])) == pytest.approx([8.0, 6.6, 8.0, 8.0])
    ends = Shape(start=StentEnd(9.0, 4.0), end=StentEnd(6.0, 8.0)).along(8.0, 16.0)
    assert ends.at(np.array([0.0, 0.25, 0.5, 1.0])) == pytest.approx([9.0, 8.0, 8.0, 6.0])
    assert ends.widest == 9.0
    assert (np.diff(ends.at(np.linspace(0, 1, 500))) <= 1e-12).all()
    table = Shape(table=((0, 7.0), (0.5, 8.0), (1, 6.0))).along(8.0, 16.0)
    assert table.at(np.array([0.25, 0.75])) == pytest.approx([7.5, 7.0])


# ---- measured


@pytest.mark.parametrize("name", ["hourglass", "flare and taper", "all", "flat caps"])
def test_the_lumen_has_the_prescribed_profile(name):
    treatment = treated(SHAPES[name])
    (stent,) = treatment.result.stents
    assert treatment.result.certificate.passed
    found = np.abs(errors(stent))
    assert found.mean() < 0.02
    # Most at an end that is no wider than the vessel, whose wall the rest of the stent drags along.
    assert found.max() < ENOUGH


def test_the_hourglass_of_the_paper_has_8_mm_at_its_ends_and_6_6_at_its_waist():
    (stent,) = treated(HOURGLASS).result.stents
    for measured in (stent.after.equivalent_diameter, stent.after.inscribed_diameter):
        assert measured[[0, len(measured) // 2, -1]] == pytest.approx([8.0, 6.6, 8.0], abs=0.03)
    # The cylinder of 7.3 mm that the authors took for it misses both by 0.7 mm.
    cylinder = treated(None, diameter=7.3).result.stents[0].after.equivalent_diameter
    assert np.nanmax(np.abs(cylinder - stent.after.equivalent_diameter)) == pytest.approx(
        0.7, abs=0.05
    )


def test_in_a_bend_the_profile_is_that_across_the_axis():
    vessel = phantom("helix_tube", edge_length=0.4)
    (stent,) = treated(HOURGLASS, vessel, (10.0, 26.0)).result.stents
    assert np.nanmax(np.abs(errors(stent))) < ENOUGH


def test_in_a_patients_vessel_the_waist_is_certified_and_where_it_was_narrowest(data_dir):
    vessel = anatomy(data_dir, "pulmonary")
    tree = vessel.centerline
    path = tree.path(tree.points[tree.roots[0]], tree.points[np.sort(tree.leaves)[0]])
    center = path.points[np.searchsorted(np.linspace(0, path.length, len(path.points)), 25.0)]
    wide = 2.6 * float(tree.project(center).inscribed_radius)
    stent = Stent(
        wide, placement=AtCenter(center), length=20.0, shape=Shape(waist=Waist(0.85 * wide))
    )
    result = Treatment(vessel.surface, [stent], tree).result
    assert result.certificate.passed
    (done,) = result.stents
    at = done.axis.profile.fractions[done.axis.profile.diameters.argmin()]
    radius = done.axis.inscribed_radius
    assert at == pytest.approx(np.nanargmin(radius) / (len(radius) - 1), abs=0.1)


def test_a_wide_hourglass_in_a_bent_vessel_is_certified(data_dir):
    """Its ends are as wide as its waist is near: spheres there do not have the ends' diameter.

    The centerline has a kink of 23 degrees there, so that the place of it nearest to the wall
    outside of the bend is 2 mm beside the one across the axis.
    """
    vessel = anatomy(data_dir, "vmtk_aorta")
    path = vessel.centerline.path(
        vessel.centerline.points[vessel.centerline.roots[0]],
        vessel.centerline.points[vessel.centerline.leaves[0]],
    )
    center = path.points[len(path.points) // 3]
    wide = 2.6 * float(vessel.centerline.project(center).inscribed_radius)
    shape = Shape(waist=Waist(0.75 * wide))
    stent = Stent(wide, placement=AtCenter(center), length=25.0, shape=shape)
    for settings in (None, DeploymentSettings(axis_smoothing=1.0)):
        treatment = Treatment(vessel.surface, [stent], vessel.centerline, settings)
        assert treatment.result.certificate.passed


def test_the_caps_of_radius_shares_are_ellipsoids():
    nodes = np.array([[0.0, 0, 0], [0, 0, 10.0]])
    shares = RadiusShares(np.array([0.0, 1.0]), np.array([1.0, 0.5]), 0.4)
    points = np.array([[0, 0, -3.0], [3.0, 0, 0], [3.0, 0, 5], [0, 0, 13.0], [2.0, 0, -2.0]])
    found = shares.at(points, Line(nodes))
    assert found[:4] == pytest.approx([0.4, 1.0, 0.75, 0.5 * 0.4])
    # On an ellipse with half axes 1 and 0.4 in the direction of 45 degrees.
    assert found[4] == pytest.approx(1 / np.sqrt(0.5 + 0.5 / 0.16))
    np.testing.assert_allclose(shares.reversed.at(points, Line(nodes[::-1])), found)


def test_the_sphere_that_fits_is_limited_by_narrow_places_beside_it_and_by_bends():
    shares = RadiusShares(np.linspace(0, 1, 3), np.array([1.0, 0.5, 1.0]))
    at = np.linspace(0, 20, 41)
    line = np.column_stack([0 * at, 0 * at, at])
    found = shares.inscribed(Line(line), 6.0, line, in_caps=False)
    fine = np.linspace(0, 20, 4001)
    for place, radius in zip(at, found, strict=True):
        profile = 6 * (0.5 + np.abs(fine - 10) / 20)
        assert radius == pytest.approx(np.hypot(fine - place, profile).min(), abs=0.03)
    angle = at / 8
    bent = np.column_stack([8 - 8 * np.cos(angle), 0 * at, 8 * np.sin(angle)])
    inside = shares.inscribed(Line(bent), 6.0, bent, in_caps=False)
    assert (inside <= found + 0.01).all()
    assert inside[[0, -1]].max() < found[0] - 0.3
    assert inside[20] == pytest.approx(3.0, abs=0.03)


def test_an_axis_the_other_way_round_with_its_profile_gives_the_same():
    vessel = phantom("bent_tube", edge_length=0.8)
    axis, settings = vessel.axis_at(np.linspace(12, 28, 100)), DeploymentSettings()
    profile = SHAPES["flare and taper"].along(8.0, 16.0, 0.3)
    back = profile._replace(
        fractions=1 - profile.fractions[::-1], diameters=profile.diameters[::-1]
    )
    results = [
        deployed(vessel.surface, settings.chain(line, shares), profile.widest / 2).points
        for line, shares in ((axis, profile), (axis[::-1], back))
    ]
    np.testing.assert_allclose(results[0], results[1], rtol=0, atol=1e-9)


def test_the_certificate_notices_a_lumen_that_is_not_the_profile():
    treatment = treated(HOURGLASS, phantom("stenosed_tube", edge_length=0.8))
    for _ in treatment:
        pass
    deployment = treatment._stages[0].deployment
    (check,) = deployment.lumen_checks(treatment.surface, deployment.result.surface)
    assert check.passed
    for factor in (0.95, 1.08):
        points = deployment.result.surface.points.copy()
        waist = np.abs(points[:, 2] - 20) < 2.5
        points[waist, :2] *= factor
        wrong = deployment.result.surface.with_points(points)
        (check,) = deployment.lumen_checks(treatment.surface, wrong)
        assert check.is_narrow == (factor < 1)
        assert check.is_wide == (factor > 1)


@pytest.mark.parametrize(("wider", "half", "is_wide"), [(0.3, 1.5, False), (0.9, 2.5, True)])
def test_wide_parts_may_drag_free_wall_beside_a_waist_along_but_no_farther(wider, half, is_wide):
    """By 0.4 mm of radius here: ends 0.7 mm wider, less by the way to them."""
    vessel = phantom("straight_tube", edge_length=0.6, radius=3.8)
    treatment = treated(Shape(waist=Waist(6.6, 0.5, 6.0)), vessel)
    for _ in treatment:
        pass
    deployment = treatment._stages[0].deployment
    points = deployment.result.surface.points.copy()
    waist = np.abs(points[:, 2] - 20) < half
    points[waist, :2] *= (3.8 + wider) / np.linalg.norm(points[waist, :2], axis=1)[:, None]
    dragged = deployment.result.surface.with_points(points)
    (check,) = deployment.lumen_checks(treatment.surface, dragged)
    assert check.is_wide == is_wide


def test_the_contact_with_the_wall_is_that_of_the_profile():
    """A waist hangs as little free as the ends: the wall follows it."""
    (stent,) = treated(HOURGLASS).result.stents
    assert stent.apposition.stretches == ()
    wide = phantom("straight_tube", edge_length=0.5, radius=3.8)
    (stent,) = treated(HOURGLASS, wide).result.stents
    (stretch,) = stent.apposition.stretches
    assert stretch.largest_gap == pytest.approx(0.5, abs=0.05)  # 7.6 against 6.6 mm


# ---- what is refused


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "expected rows of fraction,diameter, got an empty file"),
        ("a,b\n0,8\n1,7\n", "expected the header fraction,diameter in its first row, got 'a,b'"),
        ("0,8\n1,7\n", "expected the header fraction,diameter in its first row, got '0,8'"),
        ("fraction,diameter\n0,8\n", "expected two rows of fraction,diameter at least, got 1"),
        ("fraction,diameter\n0,8\nx,7\n", "row 2: expected two numbers, fraction,diameter, got"),
        ("fraction,diameter\n0,8\n1\n", "row 2: expected two numbers, fraction,diameter, got '1'"),
    ],
)
def test_a_file_that_is_no_profile_is_said(tmp_path, text, words):
    path = tmp_path / "profile.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=words):
        read_profile(path)
    assert read_profile.__doc__


# ---- documents and the shell


@pytest.mark.parametrize("name", SHAPES)
def test_a_shape_comes_back_from_a_plan_exactly(name):
    jsonschema = pytest.importorskip("jsonschema")
    stent = Stent(8.0, placement=AtCenter([0.0, 0, 20]), length=16, shape=SHAPES[name])
    document = json.loads(plan_text(Plan((stent,))))
    jsonschema.Draft7Validator(SCHEMA).validate(document)
    again = plan_from_document(document)
    assert again == Plan((stent,))
    assert again != Plan((replace(stent, shape=None),))


def test_the_shell_deploys_a_waist_at_the_throat_and_reports_the_profile(a_folder, capsys):
    place = ["--center", "0", "0", "1.8", "--length", "20"]  # the throat is at 2.0 cm
    more = ["--waist", "5", "--waist-length", "8", "--report", "r.json", "--report", "r.html"]
    assert deploy(*more, "--save-plan", "p.json", place=place, diameter="6.4") == 0
    assert "prescribed 5.00 to 6.40 mm." in capsys.readouterr().out
    (stent,) = json.loads(Path("r.json").read_text(encoding="utf-8"))["stents"]
    along = stent["diameters"]["along"]
    known = [
        (at, wanted, found)
        for at, wanted, found in zip(
            along["arc_length_mm"],
            along["prescribed_mm"],
            along["equivalent_after_mm"],
            strict=True,
        )
        if wanted is not None
    ]
    at, wanted, found = np.array(known).T
    assert at[wanted.argmin()] == pytest.approx(11.0, abs=1.0)  # 9 mm of the stent lie proximal
    assert np.abs(found - wanted).max() < 0.15  # edges of 1 mm
    assert min(stent["shape"]["diameters_mm"]) == pytest.approx(5.0)
    page = Path("r.html").read_text(encoding="utf-8")
    assert "<td>Waist</td><td>5.00 mm</td>" in page
    assert "<td>Prescribed along it</td><td>5.00 to 6.40 mm</td>" in page
    again = run_plan(load_plan("p.json"))
    assert again.plan.stents[0].shape == Shape(Waist(5.0, None, 8.0))


def test_the_shell_takes_a_profile_from_a_table_and_flares(a_folder):
    Path("p.csv").write_text("fraction,diameter\n0,6\n0.5,6.8\n1,6.2\n", encoding="utf-8")
    page = ["--report", "r.html"]
    assert deploy("--profile", "p.csv", "--report", "r.json", *page, diameter=None) == 0
    assert "<td>Profile</td><td>a table of 3 diameters</td>" in Path("r.html").read_text("utf-8")
    (stent,) = json.loads(Path("r.json").read_text(encoding="utf-8"))["stents"]
    assert stent["lumen_diameter_mm"] == 6.8
    assert stent["shape"]["table"] == [[0, 6], [0.5, 6.8], [1, 6.2]]
    more = ["--flare-start", "7.5", "4", "--flare-end", "5.8", "3", "--cap-height", "0.4"]
    assert deploy(*more, "--report", "r.json", *page, diameter="6.4") == 0
    for words in (
        "<td>Proximal end of the stent</td><td>7.50 mm at the end, over 4.00 mm</td>",
        "<td>Distal end of the stent</td><td>5.80 mm at the end, over 3.00 mm</td>",
        "<td>Prescribed along it</td><td>5.80 to 7.50 mm</td>",
        "<td>Caps beyond its ends</td><td>0.40 of the radius</td>",
    ):
        assert words in Path("r.html").read_text("utf-8")
    (stent,) = json.loads(Path("r.json").read_text(encoding="utf-8"))["stents"]
    wanted = [one for one in stent["diameters"]["along"]["prescribed_mm"] if one is not None]
    assert wanted[0] == pytest.approx(7.5)
    assert wanted[-1] == pytest.approx(5.8)
    assert stent["shape"]["cap_height"] == 0.4
