"""Lesions on the command line: as `measure` lists them, and as `deploy` treats them."""

import csv
import json
import re
from functools import cache
from html import unescape

import numpy as np
import pytest
from deployment_cases import ANATOMIES, anatomy
from tube_files import write_line, write_vessel, write_wall

from benchmarks.phantoms import branching_pulmonary_artery, stenosed_tube, straight_tube
from SDFStentLib.cli import main
from SDFStentLib.files import encode_vtp, polydata_from_lines, read_surface
from SDFStentLib.geometry import Line
from SDFStentLib.lumen import inscribed_spheres
from SDFStentLib.stent import AtDistalEnd, Stent, stent_axis
from SDFStentLib.treatment import placement_at
from SDFStentLib.vessel import find_lesions, lesions_within

LENGTHS = (8.0, 12.0, 20.0, 30.0, 40.0)


def written(folder, name, vessel):
    """A vessel and its centerline in files, cm; the options that name them."""
    write_vessel(folder, vessel, f"{name}.vtp", f"{name}_line.vtp", radii=True)
    return [str(folder / f"{name}.vtp"), "--centerline", str(folder / f"{name}_line.vtp"),
            "--units", "cm"]  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("vessels")


@pytest.fixture(scope="module")
def tube(folder):
    return written(folder, "tube", stenosed_tube(edge_length=0.8, length=60.0))


@pytest.fixture(scope="module")
def healthy(folder):
    return written(folder, "healthy", straight_tube(edge_length=1.0))


@pytest.fixture(scope="module")
def pulmonary(data_dir):
    surface, line, units = ANATOMIES["pulmonary"]
    return [str(data_dir / surface), "--centerline", str(data_dir / line), "--units", units]


def said_of(arguments, capsys, code=0):
    assert main([str(word) for word in arguments]) == code
    said = capsys.readouterr()
    return said.out if code == 0 else said.err


def document_of(arguments, capsys):
    return json.loads(said_of([*arguments, "--json"], capsys))


# measure


def test_measure_says_of_a_lesion_all_that_was_built(tube, capsys):
    said = said_of(["measure", *tube], capsys)
    assert re.search(
        r"^Lesion 1: 40 % by diameter, 64 % by area; main vessel \(1 outlet\), (29|30)\.\d mm",
        said,
        re.MULTILINE,
    )
    x, y, z = map(float, re.search(r"proximal end, at \((.*?)\) cm", said).group(1).split(", "))
    np.testing.assert_allclose([x, y, z], [0, 0, 3], atol=0.03)
    widths = re.search(r"minimum (\S+) mm against (\S+) mm", said).groups()
    # Facets of 0.8 mm lie inside of the circle.
    np.testing.assert_allclose(np.array(widths, dtype=float), [3.6, 6.0], atol=0.05)
    sides = re.search(r"vessel proximal to it \((\S+) mm\) and distal to it \((\S+) mm\)", said)
    np.testing.assert_allclose(np.array(sides.groups(), dtype=float), [6.0, 6.0], atol=0.11)
    assert "inscribed (mm)" not in said


def test_a_vessel_without_lesions_says_so(healthy, capsys):
    said = said_of(["measure", *healthy], capsys)
    assert said.splitlines()[1:] == ["No lesion of 15 % or more was found."]
    assert document_of(["measure", *healthy], capsys)["lesions"] == []


def test_without_a_centerline_no_lesions_are_claimed(tube, folder, capsys):
    axis = folder / "tube_line.vtp"
    document = document_of(["measure", tube[0], "--axis", axis, "--units", "cm"], capsys)
    assert document["lesions"] is None


def test_the_table_of_lesions_has_the_numbers_of_the_document(pulmonary, tmp_path, capsys):
    path = tmp_path / "lesions.csv"
    lesions = document_of(["measure", *pulmonary, "--csv", path], capsys)["lesions"]
    rows = list(csv.DictReader(path.open(encoding="utf-8")))
    assert len(rows) == len(lesions) == 3
    for row, lesion in zip(rows, lesions, strict=True):
        assert int(row["lesion"]) == lesion["number"]
        assert float(row["percent_diameter"]) == pytest.approx(lesion["percent_diameter"], rel=1e-5)
        assert float(row["percent_area"]) == pytest.approx(lesion["percent_area"], rel=1e-5)
        filed = [float(row[axis]) for axis in "xyz"]
        np.testing.assert_allclose(np.multiply(filed, 10), lesion["place_mm"], rtol=1e-4)
        assert row["units"] == "cm"


def test_the_place_and_the_minimum_are_those_of_spheres_on_the_path(pulmonary, data_dir, capsys):
    vessel = anatomy(data_dir, "pulmonary")
    for lesion in document_of(["measure", *pulmonary], capsys)["lesions"]:
        path = np.array(lesion["path_mm"])
        spheres = inscribed_spheres(vessel.points, vessel.triangles, path)
        at = spheres.radii.argmin()
        assert lesion["minimum"]["diameter_mm"] == pytest.approx(2 * spheres.radii[at], abs=0.15)
        np.testing.assert_allclose(np.multiply(lesion["place"], 10), lesion["place_mm"])
        branch = vessel.centerline.branches[lesion["branch"] - 1]
        away = np.linalg.norm(vessel.centerline.points[branch] - lesion["place_mm"], axis=1)
        along = vessel.centerline.arc_length[branch] - vessel.centerline.arc_length[branch[0]]
        assert along[away.argmin()] == pytest.approx(lesion["along_branch_mm"], abs=1.5)


def test_the_marked_reference_stands_for_the_lesion_beside_it_only(pulmonary, capsys):
    before = document_of(["measure", *pulmonary], capsys)["lesions"]
    wide = before[0]["reference"]["proximal"]
    marked = [f"{value / 10:.5f}" for value in wide["place_mm"]]
    after = document_of(["measure", *pulmonary, "--reference", *marked], capsys)["lesions"]
    assert "marked" in after[0]["reference"]["words"]
    expected = 100 * (1 - before[0]["minimum"]["diameter_mm"] / wide["diameter_mm"])
    # That it is told with is the usual one about the place.
    assert after[0]["percent_diameter"] == pytest.approx(expected, abs=2)
    assert after[1:] == before[1:]


# deploy


def deployed(arguments, tmp_path, capsys, code=0):
    report = tmp_path / "report.json"
    said = said_of(
        ["deploy", *arguments, "-o", tmp_path / "out.vtp", "--report", report], capsys, code
    )
    return said, json.loads(report.read_text(encoding="utf-8")) if code == 0 else None


@cache
def branching_vessels(data_dir):
    """An artery and a phantom with the lesions of each."""
    vessels = anatomy(data_dir, "pulmonary"), branching_pulmonary_artery(edge_length=0.8)
    return [(one, find_lesions(one.surface, one.centerline)) for one in vessels]


@pytest.mark.parametrize("length", LENGTHS)
def test_a_placement_covers_its_lesion_whatever_the_length_and_the_branch(data_dir, length):
    """Lesions of the artery lie in both branches, in the one that is not the widest, too."""
    for vessel, lesions in branching_vessels(data_dir):
        assert lesions
        for lesion in lesions:
            placement = placement_at(lesion, vessel.centerline, length)
            stent = Stent(8.0, placement=placement, length=length)
            axis = stent_axis(stent, vessel.centerline)
            assert lesion in lesions_within(lesions, axis.points)
            is_shortened = axis.deployed_length < axis.prescribed_length - 1e-6
            if isinstance(placement, AtDistalEnd) or is_shortened or length < 2 * lesion.length:
                continue
            middle = Line(axis.points).resampled_to(101).points[50]
            assert np.linalg.norm(middle - lesion.line.resampled_to(101).points[50]) < 1.0


def test_what_a_short_stent_leaves_is_said_to_lie_beyond_it(pulmonary, tmp_path, capsys):
    """A lesion of 35 mm under a stent of 18 mm; of 20 % that are left the stent is not to blame."""
    place = ["--at-lesion", 1, "--length", 20, "--diameter", 9]
    said, report = deployed([*pulmonary, *place], tmp_path, capsys)
    assert re.search(
        r"Left in the treated vessel: \d+ % .*, \d+ mm (before|beyond) stent 1\.", said
    )
    assert "Lesion 1 is not wholly covered: " in " ".join(report["warnings"])
    assert report["lesions"][0]["is_left_beyond"]
    page = ["-o", tmp_path / "o.vtp", "--report", tmp_path / "page.html", "--quiet"]
    said_of(["deploy", *pulmonary, *place, *page], capsys)
    told = unescape((tmp_path / "page.html").read_text(encoding="utf-8"))
    assert "What is left is narrowest beyond the stent's ends." in told
    treated = read_surface(tmp_path / "out.vtp", units="cm")
    lesion, stent = report["lesions"][0], report["stents"][0]
    path = np.array(lesion["path_mm"])
    radii = inscribed_spheres(treated.points, treated.triangles, path).radii
    sides = [lesion["reference"][side] for side in ("proximal", "distal")]
    at = lesion["extent"]["start_mm"] + np.linspace(0, lesion["extent"]["length_mm"], len(path))
    wanted = np.interp(at, *([s[k] for s in sides] for k in ("arc_length_mm", "diameter_mm")))
    left = path[np.argmax(1 - 2 * radii / wanted)]
    ends = np.array([stent["axis"][end] for end in ("start_mm", "end_mm")])
    assert np.linalg.norm(ends - left, axis=1).max() > stent["deployed_length_mm"]


def test_a_report_has_lesions_of_other_vessels_when_it_is_asked(pulmonary, tmp_path, capsys):
    """Those of the treated vessel are told likewise in both, by the numbers that `measure` has."""
    measured = document_of(["measure", *pulmonary], capsys)["lesions"]
    for number in (1, len(measured)):
        place = ["--at-lesion", number, "--length", 12, "--diameter", 7]
        _, report = deployed([*pulmonary, *place], tmp_path, capsys)
        _, whole = deployed([*pulmonary, *place, "--whole-tree"], tmp_path, capsys)
        told = {one["number"]: one for one in report["lesions"]}
        every = {one["number"]: one for one in whole["lesions"]}
        assert number in told
        assert len(told) < len(every) == len(measured)
        assert whole["whole_tree"]
        assert not report["whole_tree"]
        assert told == {one: every[one] for one in told}
        vessels = {one["vessel"] for one in every.values() if one["stents"]}
        assert {one for one in every if every[one]["vessel"] in vessels} <= told.keys()
        for known in measured:
            if known["number"] in told:
                lesion = told[known["number"]]
                assert {key: lesion[key] for key in known} == known


def test_a_page_says_whether_it_may_leave_lesions_out(pulmonary, tmp_path, capsys):
    page = tmp_path / "page.html"
    place = ["--at-lesion", 1, "--length", 20, "--diameter", 9, "--quiet"]
    for more, is_told in ((), True), (("--whole-tree",), False):
        deploy = ["deploy", *pulmonary, *place, "-o", tmp_path / "o.vtp", "--report", page, *more]
        said_of(deploy, capsys)
        page_text = page.read_text(encoding="utf-8")
        assert ("Lesions of other vessels, if any, are not listed." in page_text) == is_told


def test_what_a_stent_leaves_within_itself_is_not_said_to_lie_beyond(tube, tmp_path, capsys):
    place = ["--at-lesion", 1, "--length", 40, "--diameter", 5.4]
    said, _ = deployed([*tube, *place], tmp_path, capsys)
    assert " -> 9 %." in said
    assert "beyond" not in said


# the same number whatever stent is tried


def test_one_lesion_reads_the_same_for_stents_of_8_to_40_mm(pulmonary, tmp_path, capsys):
    """Against the mean of the stents' two ends it read 9, 28, 47 %."""
    surface = read_surface(pulmonary[0], units="cm")
    told = []
    for length in (LENGTHS[0], LENGTHS[-1]):
        place = ["--at-lesion", 1, "--length", length, "--diameter", 8]
        _, report = deployed([*pulmonary, *place], tmp_path, capsys)
        (number,) = report["stents"][0]["lesions"]
        lesion = report["lesions"][number - 1]
        told.append(lesion["percent_diameter"])
        treated = read_surface(tmp_path / "out.vtp", units="cm")
        path = np.array(lesion["path_mm"])
        for side, values in ((surface, lesion), (treated, lesion["after"])):
            radii = inscribed_spheres(side.points, side.triangles, path).radii
            assert values["minimum"]["diameter_mm"] <= 2 * radii.min() + 0.02
        assert lesion["stents"] == [1]
        assert lesion["after"]["percent_diameter"] < 45
    assert np.ptp(told) < 1e-9
    # By hand: 4.95 mm against the healthy lumen on both sides, 9.8 and 10.6 mm.
    assert told[0] == pytest.approx(100 * (1 - 4.95 / 10.2), abs=2)


def test_a_stent_that_covers_no_lesion_says_so_and_gives_no_percentage(tube, tmp_path, capsys):
    place = ["--center", 0, 0, 0.8, "--length", 8, "--diameter", 6.5]
    said, report = deployed([*tube, *place, "--report", tmp_path / "r.html"], tmp_path, capsys)
    assert "This stent covers no lesion of 15 % or more." in said
    assert report["stents"][0]["lesions"] == []
    assert report["lesions"][0]["stents"] == []
    assert "covers no lesion of 15 % or more" in (tmp_path / "r.html").read_text(encoding="utf-8")
    assert "stenosis" not in json.dumps(report["stents"])


# the user's own reference


def test_the_marked_reference_gives_the_same_numbers_in_measure_deploy_and_run(
    pulmonary, data_dir, tmp_path, capsys
):
    vessel = anatomy(data_dir, "pulmonary")
    first = find_lesions(vessel.surface, vessel.centerline)[0]
    places = [first.proximal.point, first.distal.point]
    words = [w for place in places for w in ("--reference", *(f"{x / 10:.6f}" for x in place))]
    plan = tmp_path / "plan.json"
    place = ["--at-lesion", 1, "--length", 20, "--diameter", 8, "--save-plan", plan]
    told = document_of(["measure", *pulmonary, *words[:4]], capsys)["lesions"]
    _, report = deployed([*pulmonary, *place, *words[:4], "--whole-tree"], tmp_path, capsys)
    said_of(["run", plan, "-o", tmp_path / "run", "--whole-tree"], capsys)
    again = json.loads((tmp_path / "run" / "report.json").read_text(encoding="utf-8"))
    for lesions in (report["lesions"], again["lesions"]):
        for known, lesion in zip(told, lesions, strict=True):
            assert {key: lesion[key] for key in known} == known
    marked = report["lesions"][0]
    assert "the vessel marked proximal to it" in marked["reference"]["words"]
    # By hand: spheres at the place that was marked and along the lesion.
    width = (
        2
        * inscribed_spheres(
            vessel.points, vessel.triangles, [places[0], first.line.points[0]]
        ).radii[0]
    )
    assert marked["reference"]["diameter_mm"] == pytest.approx(width, rel=0.01)
    left = marked["after"]
    assert left["percent_diameter"] == pytest.approx(
        100 * (1 - left["minimum"]["diameter_mm"] / marked["reference"]["diameter_mm"])
    )


def test_an_axis_that_is_half_outside_gets_its_sentence_in_deploy_and_run(tube, tmp_path, capsys):
    """Of 60 mm of tube; `run` dropped the sentence."""
    axis, plan = tmp_path / "axis.vtp", tmp_path / "plan.json"
    line = np.linspace([0, 0, 2.0], [0, 0, 9.0], 71)
    write_line(axis, line)
    words = ["deploy", tube[0], "--units", "cm", "--axis", axis, "--diameter", 6]
    assert main([str(w) for w in [*words, "-o", tmp_path / "o.vtp", "--save-plan", plan]]) in (0, 3)
    assert "42 % of its points lie outside of" in capsys.readouterr().err
    assert main(["run", str(plan), "-o", str(tmp_path / "run")]) in (0, 3)
    assert "42 % of its points lie outside of" in capsys.readouterr().err
    report = json.loads((tmp_path / "run" / "report.json").read_text(encoding="utf-8"))
    assert any("42 % of its points lie outside of" in said for said in report["warnings"])


def test_lesions_in_small_vessels_are_counted_in_one_line_and_listed_on_request(tube, capsys):
    """The lesion's healthy vessel is 6.0 mm wide."""
    said = said_of(["measure", *tube, "--smallest-vessel", 7], capsys)
    assert "1 in vessels below 7 mm; --smallest-vessel 0 lists them." in said
    assert "Lesion 1" not in said
    assert "Lesion 1" in said_of(["measure", *tube, "--smallest-vessel", 0], capsys)
    document = document_of(["measure", *tube, "--smallest-vessel", 7], capsys)
    assert document["lesions"] == []
    (small,) = document["lesions_of_small_vessels"]
    assert small["number"] == 1


def test_what_another_stent_covers_is_not_told_as_uncovered(folder, tube, capsys):
    """15.7 of 29.8 mm were told, and to choose a longer one; 2.0 lay beyond both."""
    ends = [[0, 0, 1.6], [0, 0, 3.4], [0, 0, 4.4]]
    stents = [
        {"name": name, "diameter": 5.4, "placement": {"from": begin, "to": end}}
        for name, begin, end in (("P", *ends[:2]), ("D", *ends[1:]))
    ]
    files = {"units": "cm", "surface": {"file": tube[0]}, "centerline": {"file": tube[2]}}
    document = {"schema": "sdfstent-plan", "version": 2, "inputs": files, "stents": stents}
    plan = folder / "halves.json"
    said = []
    for part in (stents, stents[:1]):
        plan.write_text(json.dumps({**document, "stents": part}), encoding="utf-8")
        assert main(["run", str(plan), "-o", str(folder / f"halves_{len(part)}")]) == 0
        said.append("not wholly covered" in capsys.readouterr().err)
    assert said == [False, True]


@pytest.mark.parametrize(("noise", "is_told"), [(0.01, False), (0.2, True)])
def test_a_jagged_line_is_told_first(folder, capsys, noise, is_told):
    """A lesion of 32 mm was 123 mm long, and a stent of 30 mm lay over 5, with no word of why."""
    made = branching_pulmonary_artery()
    options, tree = written(folder, "jagged", made), made.centerline
    shifts = np.random.default_rng(0).normal(0, noise, tree.points.shape)
    lines = [tree.ancestry(int(leaf)) for leaf in tree.leaves]
    (folder / "noisy.vtp").write_bytes(
        encode_vtp(polydata_from_lines((tree.points + shifts) / 10, lines))
    )
    options[2] = str(folder / "noisy.vtp")
    stent = ["--at-lesion", "1", "--diameter", "6", "--length", "14"]
    for asked in (["measure"], ["deploy", *stent, "-o", str(folder / "jagged_deployed.vtp")]):
        assert main([asked[0], *options, *asked[1:]]) == 0
        said = capsys.readouterr().err
        assert said.startswith("warning: The centerline goes to and fro") == is_told


def test_triangles_that_share_no_points_are_refused_for_what_they_are(folder, tube, capsys):
    """It read "check that both are of one patient"."""
    surface = read_surface(tube[0], "cm").surface
    corners = surface.points[surface.triangles] / 10
    middles = corners.mean(axis=1, keepdims=True)
    corners = (middles + 0.9 * (corners - middles)).reshape(-1, 3)
    write_wall(folder / "apart.vtp", corners, np.arange(len(corners)).reshape(-1, 3))
    wanted = folder / "apart_out.vtp"
    stent = ["--at-lesion", "1", "--diameter", "5", "--length", "14", "-o", str(wanted)]
    for command in (["measure"], ["deploy", *stent]):
        assert main([command[0], str(folder / "apart.vtp"), *tube[1:], *command[1:]]) == 2
        assert "share none" in capsys.readouterr().err
    assert not wanted.exists()


def test_ends_to_which_no_line_leads_are_told(folder, capsys):
    """Else the main artery is the healthy vessel of the left one, and nothing is said of it."""
    made = branching_pulmonary_artery()
    options, tree = written(folder, "lines", made), made.centerline
    assert main(["measure", *options]) == 0
    assert "no line" not in capsys.readouterr().err
    path = tree.points[tree.ancestry(int(tree.leaves[0]))]
    write_line(folder / "one_line.vtp", path / 10)
    options[2] = str(folder / "one_line.vtp")
    assert main(["measure", *options]) == 0
    assert "To 1 of the 3 ends of the surface no line" in capsys.readouterr().err
    assert main(["suggest", *options, "-o", str(folder / "one_line.json")]) == 0
    assert "To 1 of the 3 ends" in capsys.readouterr().err
    assert main(["suggest", *options, "-o", str(folder / "one_line.json"), "--json"]) == 0
    assert "To 1 of the 3 ends" in json.loads(capsys.readouterr().out)["warnings"][0]
    stent = ["--at-lesion", "1", "--diameter", "6", "--length", "14"]
    deployed = str(folder / "one_line_deployed.vtp")
    assert main(["deploy", *options, *stent, "-o", deployed, "--verbose"]) == 0
    assert "To 1 of the 3 ends" in capsys.readouterr().err
    assert main(["measure", *options, "--json"]) == 0
    assert "To 1 of the 3 ends" in json.loads(capsys.readouterr().out)["warnings"][0]
