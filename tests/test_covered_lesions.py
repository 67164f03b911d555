"""A stent that was placed at a lesion treats it, and what is narrowest is one number everywhere."""

import csv
import json
import re

import numpy as np
import pytest
from cohort_cases import document as sweep_document
from tube_files import plan_of, write_line, write_wall

from benchmarks.phantoms import stenosed_tube
from SDFStentLib.geometry import Surface
from SDFStentLib.report import measured_lines, result_tiles
from SDFStentLib.stent import Stent
from SDFStentLib.treatment import Treatment, treated_lesions, with_known_minima
from SDFStentLib.treatment.placing import placement_at
from SDFStentLib.vessel import find_lesions


def rough(seed, amount=0.3):
    """A throat whose wall lies beside a smooth line, as that of a coarse mesh or a scan does."""
    made = stenosed_tube(throat_radius=0.6, edge_length=0.5)
    random = np.random.default_rng(seed)
    points = made.points.copy()
    throat = np.abs(points[:, 2] - 20) < 3
    # The whole section aside, more than half of what is left of it.
    wave = amount * np.sin(points[:, 2] * random.uniform(1.5, 3) + random.uniform(0, 6))
    points[throat, 0] += wave[throat]
    points += 0.02 * random.normal(size=points.shape)
    return Surface(points, made.triangles), made.centerline


@pytest.mark.parametrize("seed", range(530, 536))
def test_a_stent_at_a_lesion_covers_it_however_long_it_is(seed):
    surface, centerline = rough(seed)
    random = np.random.default_rng(seed)
    lesions = find_lesions(surface, centerline)
    assert lesions[0].percent_diameter > 60
    for length in (3.0, 8.0, 15.0, 30.0):
        lost = float(random.choice([0.0, 0.1, 0.4]))
        place = placement_at(lesions[0], centerline, length, lost)
        stent = Stent(
            diameter=4.0, length=length, foreshortening_fraction=lost, placement=place
        )  # fmt: skip
        result = Treatment(
            surface, [stent], centerline, straightening_fraction=float(random.choice([0, 0.5]))
        )
        axis = result._first.axis
        one = result._first
        (treated, *_) = treated_lesions(lesions, [one], surface)
        assert treated.stents == (1,), (length, lost, axis.deployed_length)


@pytest.fixture(scope="module")
def a_rough_folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("rough")
    surface, centerline = rough(540)
    write_wall(folder / "tube.vtp", surface.points, surface.triangles)
    write_line(folder / "line.vtp", centerline.points)
    return folder


def test_every_door_has_the_minimum_of_measure(a_rough_folder, shell):
    folder = a_rough_folder
    asked = ["tube.vtp", "--centerline", "line.vtp"]
    document = json.loads(shell("measure", *asked, "--json", folder=folder).stdout)
    lesion = document["lesions"][0]
    minimum = lesion["minimum"]["diameter_mm"]
    told = f"{minimum:.2f}"
    place = [*asked, "--at-lesion", 1, "--diameter", 6, "--length", 12]
    run = shell(
        "deploy", *place, "-o", "out.vtp", "--report", "r.json", "--report", "r.html",
        "--save-plan", "plan.json", folder=folder,
    )  # fmt: skip
    assert f"Minimum lumen diameter: {told} ->" in run.stdout
    assert "covers no lesion" not in run.stdout
    report = json.loads((folder / "r.json").read_text(encoding="utf-8"))
    assert report["stents"][0]["diameters"]["minimum_lumen"]["before_mm"] == minimum
    assert report["stents"][0]["lesions"][0] == 1
    assert f"{told} mm" in (folder / "r.html").read_text(encoding="utf-8")
    run = shell("deploy", *place, "-o", "out.vtp", "--verbose", folder=folder)
    assert f"Minimum lumen diameter: {told} ->" in run.stdout
    (folder / "again.json").write_text((folder / "plan.json").read_text(encoding="utf-8"), "utf-8")
    shell("compare", "plan.json", "again.json", "-o", "both", folder=folder)
    (page,) = folder.glob("both/*.html")
    assert f"(before {told} mm)" in page.read_text(encoding="utf-8")
    # A sweep's own stent, at that place.
    plan = plan_of({"diameter": 6, "length": 12, "placement": {"center": lesion["place_mm"]}})
    plan["inputs"] = {**plan["inputs"], "units": "mm"}
    sweep = sweep_document(plan=plan, axes={"diameter": [6, 6.5]})
    (folder / "sweep.json").write_text(json.dumps(sweep), encoding="utf-8")
    shell("sweep", "sweep.json", "-o", "swept", "--workers", 1, folder=folder)
    with (folder / "swept" / "manifest.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["lumen_before_mm"]) for row in rows] == pytest.approx([minimum] * 2, rel=1e-5)


def test_the_panel_has_it_beside_the_stent_and_in_its_tile():
    surface, centerline = rough(541)
    lesions = find_lesions(surface, centerline)
    place = placement_at(lesions[0], centerline, 12.0)
    treatment = Treatment(
        surface, [Stent(diameter=6.0, length=12.0, placement=place)], centerline
    ).result
    treated = treated_lesions(lesions, treatment.stents, treatment.surface, surface)
    stents = with_known_minima(treatment.stents, treated)
    told = f"{lesions[0].minimum_diameter:.1f}"
    lines = measured_lines(stents[0], stents, treated, treatment.certificate)
    assert re.match(rf"narrowest {told} -> ", lines[1])
    tiles = {one.name: one for one in result_tiles(stents, treated, treatment.certificate)}
    assert tiles["Narrowest lumen"].beneath.startswith(f"before {told}, ")
    assert stents[0].after.minimum <= treatment.stents[0].after.minimum
