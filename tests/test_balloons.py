"""From the balloon to the lumen, what a stent keeps when it shortens, and the same stent again."""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from test_devices import ROW, a_device, a_table
from test_lattice import read as device_file
from trees import unbranched
from tube_files import deploy

from benchmarks.phantoms import stenosed_tube, straight_tube
from SDFStentLib.deformation import DeploymentSettings
from SDFStentLib.geometry import Line
from SDFStentLib.report import stent_facts, stent_lines
from SDFStentLib.stent import (
    AtCenter,
    AtDistalEnd,
    AtProximalEnd,
    OfStent,
    Stent,
    balloon_by_rule,
    stent_axis,
)
from SDFStentLib.treatment import Treatment
from SDFStentLib.validation import InputError

CENTER = AtCenter([0.0, 0, 50])


def a_tube():
    points = Line([[0, 0, 0], [0, 0, 100]]).resampled(2.0).points
    return unbranched(points, np.full(len(points), 5.0))


def reported(*more, **others):
    """The stents of the report of a deployment that is certified."""
    assert deploy(*more, "--report", "r.json", "--save-plan", "p.json", **others) == 0
    return json.loads(Path("r.json").read_text(encoding="utf-8"))["stents"]


# ---- recoil


@pytest.mark.parametrize(
    ("balloon", "native", "recoil"),
    [
        (8.0, 5.0, 0.07),
        (8.0, 3.0, 0.07),
        (8.0, 2.99, 0.10),
        (9.0, 3.0, 0.07),
        (9.1, 3.0, 0.10),
        (24.0, 8.0, 0.07),
        (24.1, 8.0, 0.10),
        (8.0, math.nan, 0.07),
    ],
)
def test_recoil_is_7_percent_and_10_in_a_narrow_lumen_or_with_a_wide_balloon(
    balloon, native, recoil
):
    found = balloon_by_rule(balloon, native)
    assert found.recoil_fraction == recoil
    assert found.lumen_diameter == pytest.approx(balloon * (1 - recoil))
    usual = "the mean in great vessels (7 ± 4 %)"
    assert balloon_by_rule(8.2, 5.0).lumen_diameter == pytest.approx(7.7, abs=0.1)  # its source
    assert found.reason.startswith(usual if recoil == 0.07 else "more than that was seen where the")


# ---- what is kept


def ends(placement, keeps, centerline=None):
    stent = Stent(6.0, placement=placement, length=20, foreshortening_fraction=0.25, keeps=keeps)
    return stent_axis(stent, centerline).points[[0, -1], 2].tolist()


def test_an_end_by_which_a_stent_is_placed_is_kept_and_the_other_refused():
    for place, end in ((AtDistalEnd, "distal"), (AtProximalEnd, "proximal")):
        other = {"distal": "proximal", "proximal": "distal"}[end]
        assert ends(place([0, 0, 50]), end, a_tube()) == ends(place([0, 0, 50]), "center", a_tube())
        with pytest.raises(InputError, match=f"expected its {end} end to be kept, by which it is"):
            ends(place([0, 0, 50]), other, a_tube())
    with pytest.raises(InputError, match="expected what it keeps as one of center, proximal, di"):
        ends(CENTER, "middle", a_tube())


# ---- redilation


def a_redilation(keeps="center", device=None, second=9.0, **first):
    vessel = stenosed_tube(edge_length=0.8)
    values = {"length": 16.0, "device": device, **first}
    stents = [
        Stent(6.2, placement=AtCenter([0.0, 0, 20]), **values),
        Stent(second, placement=OfStent(1), keeps=keeps),
    ]
    return Treatment(vessel.surface, stents, vessel.centerline)


def a_short_device():
    return a_device(name="own", nominal_length=16, lengths=[[6, 15], [10, 11]])


def test_a_stent_that_is_dilated_again_lies_in_the_vessel_once():
    result = a_redilation("distal", a_short_device()).result
    first, second = result.stents
    assert (first.again, second.again) == (2, None)
    assert result.final_stents == (second,)
    # Its first size, 3 mm narrower than the lumen by now, is told as free nowhere.
    assert first.apposition is None
    assert second.apposition.free_length == 0
    assert np.isnan(stent_facts(first, None).columns()["free_length_mm"])
    assert stent_lines(first, ())[-2] == (
        "It is dilated again as stent 2, and lies in the vessel as that."
    )


def test_only_a_length_that_the_second_dilatation_loses_is_warned_of():
    # 13.5 of 18 mm are left between the middle and the end of the tube at 40 mm.
    vessel = straight_tube(edge_length=1.2)
    for again, expected in (({}, []), ({"foreshortening_fraction": 0.0}, [2])):
        stents = [
            Stent(7.0, placement=AtCenter([0.0, 0, 35.5]), length=20.0),
            Stent(8.0, placement=OfStent(1), **again),
        ]
        treatment = Treatment(
            vessel.surface, stents, vessel.centerline, DeploymentSettings(certify=False)
        )
        first, second = treatment.result.stents
        assert first.axis.deployed_length == pytest.approx(13.5)
        assert first.axis.prescribed_length == pytest.approx(18.0)
        assert second.axis.deployed_length == first.axis.deployed_length
        told = [w.stent for w in treatment.result.warnings if w.kind == "shortened"]
        assert told == [1, *expected]


@pytest.mark.parametrize(
    ("second", "words"),
    [
        ({"diameter": 6.2}, "Stent 2: redilation: expected more than the 6.2 mm of stent 1, got 6"),
        ({"number": 2}, "expected an earlier stent that is switched on, got number 2; switch that"),
        ({"number": 3}, "expected an earlier stent that is switched on, got number 3; switch that"),
        ({"length": 20}, "redilation: expected no length of its own, for it is stent 1, got one"),
        ({"device": a_short_device()}, "redilation: expected no (length|device) of its own"),
        ({"diameter": 11}, "its length is known from 6 to 10 mm of diameter, not at 11 mm"),
    ],
)
def test_a_redilation_that_cannot_be_is_refused_before_anything_moves(second, words):
    values = {"diameter": 8.0, "number": 1, **second}
    number, diameter = values.pop("number"), values.pop("diameter")
    first = a_redilation(device=a_short_device()).stents[0]
    vessel = stenosed_tube(edge_length=1.2)
    stents = [first, Stent(diameter, placement=OfStent(number), **values)]
    with pytest.raises(InputError, match=words):
        Treatment(vessel.surface, stents, vessel.centerline)


def test_a_redilation_of_a_stent_that_is_switched_off_or_of_none_is_refused():
    treatment = a_redilation()
    off = replace(treatment.stents[0], enabled=False)
    with pytest.raises(InputError, match="expected an earlier stent that is switched on"):
        Treatment(treatment.surface, [off, treatment.stents[1]], treatment.centerline)
    for number in (0, -1, 1.0, True, "1"):
        with pytest.raises(InputError, match="expected the number of an earlier stent, from 1"):
            OfStent(number)
    with pytest.raises(InputError, match="expected stent 1 to lie in the vessel, got no axis"):
        stent_axis(treatment.stents[1], treatment.centerline)


# ---- documents


# ---- the shell


def test_redilate_deploys_the_same_stent_again_with_its_new_length(a_folder, capsys):
    table = a_folder / "own.json"
    row = {**ROW, "name": "own", "nominal_length": 16, "lengths": [[4, 16], [8, 12]]}
    table.write_text(a_table(row), encoding="utf-8")
    device = ["--device", "own", "--device-table", str(table)]
    place = ["--distal", "0", "0", "2.8"]
    first, second = reported(*device, "--redilate", "8", place=place)
    assert [s["deployed_length_mm"] for s in (first, second)] == pytest.approx([14, 12])
    assert first["axis"]["end_mm"] == pytest.approx(second["axis"]["end_mm"], abs=1e-6)
    assert "redilates" not in first
    assert second["redilates"] == 1
    assert "stent 2: own, 8 x 12.0 mm (16 mm as packed, 25 % shorter" in capsys.readouterr().out
    middle = reported(
        *device, "--redilate", "8", "--keep", "proximal", place=["--axis", "axis.vtp"]
    )
    starts = [stent["axis"]["start_mm"][2] for stent in middle]
    assert starts == pytest.approx([12.0, 12.0])


def test_a_staged_plan_gives_the_result_of_today_and_the_later_one(a_folder, capsys):
    """The shortening of the second is told as that of the first, which nobody gave."""
    first, second = reported("--redilate", "8", "--report", "r.html", diameter="5")
    said = capsys.readouterr().out
    document = json.loads(Path("r.json").read_text(encoding="utf-8"))
    today, (lesion,) = document["today"], document["lesions"]
    assert today["before_stent"] == 2
    (stent,), (left,) = today["stents"], today["lesions"]
    assert stent["number"] == left["number"] == 1
    assert stent["minimum_lumen_mm"] == pytest.approx(5.0, rel=0.01)
    assert left["percent_diameter"] == pytest.approx(100 / 6, abs=2)
    assert lesion["after"]["percent_diameter"] == pytest.approx(-100 / 3, abs=2)
    assert second["diameters"]["minimum_lumen"]["after_mm"] == pytest.approx(8.0, rel=0.01)
    sentence = "Today, before the redilation as stent 2: narrowest lumen stent 1 5.0"
    assert sentence in said
    assert sentence in Path("r.html").read_text(encoding="utf-8")
    assert first["foreshortening_reason"] == second["foreshortening_reason"] != "as given"
    (plain,) = reported()
    assert json.loads(Path("r.json").read_text(encoding="utf-8"))["today"] is None
    assert plain["balloon_diameter_mm"] is plain["recoil_fraction"] is None
    assert plain["lumen_diameter_mm"] == 6


def test_files_and_page_show_a_stent_that_is_dilated_again_once(a_folder, capsys):
    files = ["--export-device", "d.vtp", "--report", "r.html"]
    first, second = reported("--balloon", "6.5", "--redilate", "8", *files, diameter=None)
    assert (first["dilated_again_as"], second["redilates"]) == (2, 1)
    assert set(device_file("d.vtp")[2]["Stent"]) == {2}
    page = Path("r.html").read_text(encoding="utf-8")
    for words in (
        "<td>Balloon diameter</td><td>6.50 mm</td>",
        "<td>Recoil</td><td>7 % of the balloon: the mean in great vessels",
        "<td>Prescribed lumen diameter</td><td>6.04 mm</td>",
        "<td>Reference diameter of the lesion</td><td>5.9",
        "<td>Redilation</td><td>of stent 1</td>",
        "dilated again as stent 2.",
    ):
        assert words in page, words
    assert "Not in contact all round" not in page
    assert "Stent 1: The stent does not touch" not in capsys.readouterr().out
