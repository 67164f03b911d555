"""Stents of which less than half can lie on the vessel are refused, unless that is asked for."""

from __future__ import annotations

import json

import pytest

from SDFStentLib.cli import main

SIZES = ["--units", "cm", "--diameter", "6", "--foreshortening", "0"]
ALONG_LINE = ["--centerline", "line.vtp"]
# The tube is 40 mm long, from z = 0 to 4 cm, the curve 16 mm.
PLACES = {
    "below the end": ([*ALONG_LINE, "--distal", "0", "0", "0.02", "--length", "35.2"], 35.2, 0.2),
    "a short curve": (["--axis", "axis.vtp", "--length", "40"], 40.0, 16.0),
}


@pytest.fixture
def said(a_folder, capsys):
    """Exit code of a command in the folder of the tube, and what it says as warning or error."""

    def run(*words):
        return main([*words]), capsys.readouterr().err

    return run


def deployed(said, place, *more):
    return said("deploy", "tube.vtp", *SIZES, *place, "-o", "out.vtp", *more)


@pytest.mark.parametrize("name", PLACES)
def test_a_stent_of_which_less_than_half_fits_is_refused_unless_asked_for(said, a_folder, name):
    place, prescribed, available = PLACES[name]
    before = {path.name for path in a_folder.iterdir()}
    code, error = deployed(said, place)
    assert code == 2, error
    assert f"at least half of its {prescribed:.1f} mm" in error
    assert f"got {available:.1f} mm" in error
    assert "--shortened" in error
    assert {path.name for path in a_folder.iterdir()} == before

    code, error = deployed(said, place, "--shortened", "--save-plan", "plan.json")
    assert code == 0, error
    assert f"shortened: {prescribed:.1f} mm were prescribed, {available:.1f}" in error

    plan = json.loads((a_folder / "plan.json").read_text(encoding="utf-8"))
    assert plan["stents"][0]["may_be_shortened"] is True
    code, error = said("run", "plan.json", "-o", "again")
    assert code == 0, error
    del plan["stents"][0]["may_be_shortened"]
    (a_folder / "plan.json").write_text(json.dumps(plan), encoding="utf-8")
    code, error = said("run", "plan.json", "-o", "never")
    assert code == 2, error
    assert f"at least half of its {prescribed:.1f} mm" in error


def test_half_a_stent_on_the_vessel_is_enough(said):
    code, error = deployed(said, [*ALONG_LINE, "--center", "0", "0", "4", "--length", "20"])
    assert code == 0, error
    assert "is shortened" in error


def test_a_stent_that_is_dilated_again_is_not_refused_twice(said):
    place, *_ = PLACES["a short curve"]
    code, error = deployed(said, place, "--shortened", "--redilate", "7")
    assert code == 0, error
