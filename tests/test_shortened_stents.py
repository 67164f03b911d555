"""Stents of which less than half can lie on the vessel are refused, unless that is asked for."""

from __future__ import annotations

import json

import pytest
from child_processes import installed

SIZES = ["--units", "cm", "--diameter", "6", "--foreshortening", "0"]
ALONG_LINE = ["--centerline", "line.vtp"]
# The tube is 40 mm long, from z = 0 to 4 cm, the curve 16 mm.
PLACES = {
    "below the end": ([*ALONG_LINE, "--distal", "0", "0", "0.02", "--length", "35.2"], 35.2, 0.2),
    "beyond the end": ([*ALONG_LINE, "--proximal", "0", "0", "3.5", "--length", "20"], 20.0, 5.0),
    "round the end": ([*ALONG_LINE, "--center", "0", "0", "0", "--length", "90"], 90.0, 40.0),
    "a short curve": (["--axis", "axis.vtp", "--length", "40"], 40.0, 16.0),
}


def deployed(folder, place, *more):
    return installed("deploy", "tube.vtp", *SIZES, *place, "-o", "out.vtp", *more, folder=folder)


@pytest.mark.parametrize("name", PLACES)
def test_a_stent_of_which_less_than_half_fits_is_refused_unless_asked_for(a_folder, name):
    place, prescribed, available = PLACES[name]
    before = {path.name for path in a_folder.iterdir()}
    refused = deployed(a_folder, place)
    assert refused.returncode == 2, refused.stderr
    assert f"at least half of its {prescribed:.1f} mm" in refused.stderr
    assert f"got {available:.1f} mm" in refused.stderr
    assert "--shortened" in refused.stderr
    assert {path.name for path in a_folder.iterdir()} == before

    asked = deployed(a_folder, place, "--shortened", "--save-plan", "plan.json")
    assert asked.returncode == 0, asked.stderr
    assert f"shortened: {prescribed:.1f} mm were prescribed, {available:.1f}" in asked.stderr

    plan = json.loads((a_folder / "plan.json").read_text(encoding="utf-8"))
    assert plan["stents"][0]["may_be_shortened"] is True
    again = installed("run", "plan.json", "-o", "again", folder=a_folder)
    assert again.returncode == 0, again.stderr
    del plan["stents"][0]["may_be_shortened"]
    (a_folder / "plan.json").write_text(json.dumps(plan), encoding="utf-8")
    without = installed("run", "plan.json", "-o", "never", folder=a_folder)
    assert without.returncode == 2, without.stderr
    assert f"at least half of its {prescribed:.1f} mm" in without.stderr


@pytest.mark.parametrize(
    "place",
    [
        ["--proximal", "0", "0", "3", "--length", "19"],
        ["--center", "0", "0", "4", "--length", "20"],
        ["--distal", "0", "0", "1.01", "--length", "20"],
    ],
)
def test_half_a_stent_on_the_vessel_is_enough(a_folder, place):
    run = deployed(a_folder, [*ALONG_LINE, *place])
    assert run.returncode == 0, run.stderr
    assert "is shortened" in run.stderr


def test_a_stent_that_is_dilated_again_is_not_refused_twice(a_folder):
    place, *_ = PLACES["a short curve"]
    run = deployed(a_folder, place, "--shortened", "--redilate", "7")
    assert run.returncode == 0, run.stderr


def test_a_part_to_measure_may_reach_beyond_the_vessel(a_folder):
    run = installed(
        "measure", "tube.vtp", "--units", "cm", *ALONG_LINE, "--proximal", "0", "0", "3.5",
        "--length", "20", folder=a_folder,
    )  # fmt: skip
    assert run.returncode == 0, run.stderr
