"""`sdfstent views`, as the installed command and within this process."""

import json
import re

import numpy as np
import pytest
from child_processes import installed

VIEWS = ["views", "tube.vtp", "--centerline", "line.vtp", "--units", "cm"]
FRAMED = [*VIEWS, "--frame", "LPS"]


def test_the_installed_command_tells_draws_and_writes(a_folder):
    done = installed(
        *FRAMED, "--at-lesion", "1", "-o", "v.png", "--json", "v.json", folder=a_folder
    )
    assert done.returncode == 0, done.stderr
    best, second, worst, wrote = done.stdout.splitlines()
    # A straight tube along z, whatever the angle LAO: upright in the picture, nothing else there.
    assert best.startswith("Best view LAO 0, CRA 0: foreshortened 0 %, nothing over it, ")
    assert re.search(r"stenosis 40 % in the picture \(40 % in 3D\)\.$", best)
    assert second.startswith("Second view ")
    assert worst.startswith("Worst view ")
    assert wrote == "Wrote v.png and v.json"
    assert (a_folder / "v.png").read_bytes().startswith(b"\x89PNG")
    document = json.loads((a_folder / "v.json").read_text(encoding="utf-8"))
    assert document["schema"] == "sdfstent-views"
    assert document["frame"] == "LPS"
    assert [one["role"] for one in document["views"]] == ["best view", "second view", "worst view"]
    grid = document["map"]
    lost = np.array(grid["foreshortening_percent"])
    assert lost.shape == (len(grid["lao_deg"]), len(grid["cra_deg"])) == (45, 21)
    # 1 - cos CRA, at every LAO.
    expected = 100 * (1 - np.cos(np.deg2rad(grid["cra_deg"])))
    assert lost == pytest.approx(np.broadcast_to(expected, lost.shape), abs=0.06)


def test_a_surface_without_a_frame_has_no_angles_until_one_is_named(a_folder, shell):
    done = shell(*VIEWS, folder=a_folder)
    assert done.returncode == 2
    assert "frame" in done.stderr
    assert "(--frame RAS or LPS)" in done.stderr
    one, other = (shell(*VIEWS, "--frame", name, folder=a_folder) for name in ("RAS", "LPS"))
    assert one.returncode == other.returncode == 0


def said_to_be_ras(path):
    """Write the frame into a file, as Slicer does."""
    text = path.read_bytes()
    tag = b'<FieldData><Array type="String" Name="SPACE" NumberOfTuples="1" format="ascii">'
    tag += b"82 65 83 0</Array></FieldData>"
    place = text.index(b"<PolyData>") + len(b"<PolyData>")
    path.write_bytes(text[:place] + tag + text[place:])


def test_a_deployment_draws_its_stent_before_and_after(a_folder, shell):
    stent = ["--center", "0", "0", "2", "--length", "20", "--diameter", "6"]
    placed = ["deploy", "tube.vtp", "--units", "cm", "--centerline", "line.vtp", *stent]
    made = [*placed, "-o", "after.vtp", "--angiogram", "seen.svg"]
    refused = shell(*made, folder=a_folder)
    assert refused.returncode == 2
    assert "frame" in refused.stderr
    assert not (a_folder / "after.vtp").exists()
    said_to_be_ras(a_folder / "tube.vtp")
    done = shell(*made, folder=a_folder)
    assert done.returncode == 0, done.stderr
    drawn = (a_folder / "seen.svg").read_text(encoding="utf-8")
    assert drawn.count("<image") == 2
    bare = shell(*made, "--hide-device", folder=a_folder)
    assert bare.returncode == 0
    assert drawn.count("stroke-width='0.8'") > 50
    assert (a_folder / "seen.svg").read_text(encoding="utf-8").count("stroke-width='0.8'") == 0


def test_a_frame_that_is_named_once_is_that_of_the_plan(a_folder, shell):
    stent = ["--center", "0", "0", "2", "--length", "20", "--diameter", "6"]
    placed = ["deploy", "tube.vtp", "--units", "cm", "--centerline", "line.vtp", *stent]
    named = [*placed, "-o", "after.vtp", "--frame", "LPS", "--save-plan", "plan.json"]
    done = shell(*named, "--angiogram", "one.svg", folder=a_folder)
    assert done.returncode == 0, done.stderr
    plan = json.loads((a_folder / "plan.json").read_text(encoding="utf-8"))
    assert plan["inputs"]["frame"] == "LPS"
    again = shell("run", "plan.json", "-o", "made", "--angiogram", "two.svg", folder=a_folder)
    assert again.returncode == 0, again.stderr
    assert (a_folder / "one.svg").read_bytes() == (a_folder / "two.svg").read_bytes()
    other = shell("run", "plan.json", "-o", "made", "--frame", "RAS", folder=a_folder)
    assert other.returncode == 2
    assert "expected LPS, which plan.json says" in other.stderr
    plan["inputs"]["frame"] = None
    (a_folder / "plan.json").write_text(json.dumps(plan), encoding="utf-8")
    silent = shell("run", "plan.json", "-o", "made", "--angiogram", "3.svg", folder=a_folder)
    assert silent.returncode == 2
    assert "(--frame RAS or LPS)" in silent.stderr
    named = ["run", "plan.json", "-o", "made", "--angiogram", "3.svg", "--frame", "LPS"]
    assert shell(*named, folder=a_folder).returncode == 0
    assert (a_folder / "one.svg").read_bytes() == (a_folder / "3.svg").read_bytes()


def test_a_frame_that_the_file_contradicts_is_refused(a_folder, shell):
    said_to_be_ras(a_folder / "tube.vtp")
    assert shell(*VIEWS, folder=a_folder).returncode == 0
    done = shell(*FRAMED, folder=a_folder)
    assert done.returncode == 2
    assert "RAS" in done.stderr


def test_views_that_are_asked_for_are_told_and_drawn(a_folder, shell):
    done = shell(
        *FRAMED, "--view", "-30", "20", "--view", "90", "0", "-o", "v.svg", folder=a_folder
    )
    assert done.returncode == 0, done.stderr
    told = [one for one in done.stdout.splitlines() if one.startswith("View ")]
    assert [one.split(":")[0] for one in told] == ["View RAO 30, CRA 20", "View LAO 90, CRA 0"]
    assert "foreshortened 6 %" in told[0]  # 1 - cos 20
    drawn = (a_folder / "v.svg").read_text(encoding="utf-8")
    assert drawn.count("<image") == 4
    assert "RAO 30, CRA 20" in drawn


def test_the_treated_vessel_is_told_and_drawn_beside_it(a_folder, shell):
    stent = ["--center", "0", "0", "2", "--length", "20", "--diameter", "6"]
    placed = ["deploy", "tube.vtp", "--units", "cm", "--centerline", "line.vtp", *stent]
    assert shell(*placed, "-o", "after.vtp", folder=a_folder).returncode == 0
    done = shell(*FRAMED, "--after", "after.vtp", "-o", "v.svg", folder=a_folder)
    assert done.returncode == 0, done.stderr
    assert "stenosis after treatment none in the picture" in done.stdout.splitlines()[0]
    drawn = (a_folder / "v.svg").read_text(encoding="utf-8")
    assert drawn.count("<image") == 4


def test_any_part_can_be_looked_at(a_folder, shell):
    for place in (["--axis", "axis.vtp"], ["--from", "0", "0", "1", "--to", "0", "0", "3"]):
        done = shell(*FRAMED, *place, folder=a_folder)
        assert done.returncode == 0, done.stderr
        assert "of 16.0 mm long" in done.stdout or "of 20.0 mm long" in done.stdout
        assert "stenosis" not in done.stdout


def test_the_table_of_a_patient_limits_the_arm(a_folder, shell):
    (a_folder / "own.csv").write_text("LAO,CRA,CAU\n20,10,0\n40,10,0\n", encoding="utf-8")
    done = shell(*FRAMED, "--limits", "own.csv", "--json", "v.json", folder=a_folder)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("Best view LAO 20, CRA 0:")
    assert "no second view" in done.stdout
    document = json.loads((a_folder / "v.json").read_text(encoding="utf-8"))
    assert np.array(document["map"]["is_reached"]).sum() == 5 * 3


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (["--at-lesion", "7"], "--at-lesion"),
        (["--view", "200", "0"], "--view"),
        (["--lao-rao", "-3"], "LAO/RAO"),
        (["--limits", "none.csv"], "none.csv"),
        (["--limits", "line.vtp"], "line.vtp"),
        (["-o", "v.txt"], ".png"),
        (["--reach", "0"], "--reach"),
        (["--apart", "91"], "angle between both views"),
        (["--json", "tube.vtp"], "tube.vtp"),
    ],
)
def test_what_cannot_be_is_refused_in_a_sentence_and_nothing_is_written(
    a_folder, shell, more, said
):
    before = sorted(a_folder.iterdir())
    done = shell(*FRAMED, *more, folder=a_folder)
    assert done.returncode == 2
    assert said in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
    assert sorted(a_folder.iterdir()) == before
