"""Which end is proximal, and points that lie beside the vessel."""

from __future__ import annotations

import json

import numpy as np
import pytest
from deployment_cases import ANATOMIES, anatomy

from SDFStentLib.cli import main
from SDFStentLib.files import encode_vtp, polydata_from_arrays, polydata_from_lines
from SDFStentLib.lumen import winding_numbers
from SDFStentLib.phantoms import stenosed_tube
from SDFStentLib.plan import load_plan
from SDFStentLib.stent import AtDistalEnd, BetweenPoints, Stent
from SDFStentLib.treatment import axis_in_vessel
from SDFStentLib.validation import InputError


@pytest.fixture(scope="module")
def tube(tmp_path_factory):
    """A tube and its centerline, stored either way; nothing tells which end is proximal."""
    folder = tmp_path_factory.mktemp("tube")
    made = stenosed_tube(edge_length=1.0)
    points = made.centerline.points
    for name, data in (
        ("tube", polydata_from_arrays(made.points, made.triangles)),
        ("down", polydata_from_lines(points, [np.arange(len(points))])),
        ("up", polydata_from_lines(points[::-1], [np.arange(len(points))])),
    ):
        (folder / f"{name}.vtp").write_bytes(encode_vtp(data))
    return folder


@pytest.mark.parametrize("root", [(0, 0, 0), (0, 0, 40)])
def test_the_root_that_is_named_counts_for_lines_stored_either_way(tube, tmp_path, capsys, root):
    starts = []
    for line in ("down", "up"):
        out, plan, report = (str(tmp_path / name) for name in ("o.vtp", "p.json", "r.json"))
        place = ["--centerline", str(tube / f"{line}.vtp"), "--distal", 0, 0, 20, "--length", 10]
        more = ["--root", *root, "-o", out, "--save-plan", plan, "--report", report]
        arguments = ["deploy", str(tube / "tube.vtp"), "--diameter", 5, *place, *more]
        assert main([str(word) for word in arguments]) == 0
        document = json.loads((tmp_path / "r.json").read_text(encoding="utf-8"))
        (entry,) = [one for one in document["inputs"] if one["role"] == "centerline"]
        np.testing.assert_allclose(entry["root_mm"], root, atol=1e-6)
        starts.append(document["stents"][0]["axis"]["start_mm"])
        np.testing.assert_allclose(load_plan(plan).root, root)
    # The last one again, of lines stored the other way.
    assert main(["run", plan, "-o", str(tmp_path / "again")]) == 0
    again = json.loads((tmp_path / "again" / "report.json").read_text("utf-8"))
    assert again["stents"][0]["axis"] == document["stents"][0]["axis"]
    np.testing.assert_allclose(starts[0], starts[1], atol=1e-6)
    assert starts[0][2] == pytest.approx(11 if root[2] == 0 else 29, abs=0.01)


def test_measure_names_the_root_and_how_to_name_another(tube, capsys):
    arguments = ["measure", str(tube / "tube.vtp"), "--centerline", str(tube / "up.vtp")]
    assert main(arguments) == 0
    assert "Proximal is the end at (0, 0, 40) mm; --root X Y Z" in capsys.readouterr().out
    assert main([*arguments, "--root", "0", "0", "1"]) == 0
    assert "Proximal is the end at (0, 0, 0) mm" in capsys.readouterr().out


@pytest.mark.parametrize("name", list(ANATOMIES))
def test_points_outside_of_the_lumen_are_refused_and_those_inside_are_taken(data_dir, name):
    """Outside and inside by the winding number; both at the same distances from the centerline."""
    vessel = anatomy(data_dir, name)
    line = vessel.centerline
    rng = np.random.default_rng(7)
    tried = {True: 0, False: 0}
    for index in rng.choice(len(line.points), 25):
        shift = rng.normal(size=3)
        radius = line.inscribed_radius[index]
        point = line.points[index] + rng.uniform(0.9, 1.9) * radius * shift / np.linalg.norm(shift)
        inside = winding_numbers(point[None], vessel.points, vessel.triangles)[0] > 0.5
        wall = np.linalg.norm(vessel.points - point, axis=1).min()
        if wall < 2.0:
            continue
        stent = Stent(5, placement=AtDistalEnd(point), length=10)
        tried[bool(inside)] += 1
        try:
            axis_in_vessel(stent, line, vessel.surface)
            refused = ""
        except InputError as error:
            refused = str(error)
        if "stent axis: expected some length" in refused or "at least half of its" in refused:
            continue
        assert bool(refused) == (not inside), refused
        assert inside or "distal end: expected a point" in refused
    assert tried[False] >= 3


def test_both_points_of_a_stent_are_looked_at_and_a_click_on_the_wall_counts():
    made = stenosed_tube(edge_length=1.0)
    surface = made.centerline, made.surface
    on_wall = Stent(5, placement=BetweenPoints([0, 0, 5], [3.2, 0, 35]))
    (beside_end,) = axis_in_vessel(on_wall, *surface).warnings
    assert "stent end lies 3.2 mm beside" in beside_end.sentence()
    assert "The part end lies 3.2 mm beside" in beside_end.sentence("part")
    beside = Stent(5, placement=BetweenPoints([0, 0, 5], [5.0, 0, 35]))
    with pytest.raises(
        InputError, match=r"stent end: .* 5.0 mm from the centerline and 2.0 mm out"
    ):
        axis_in_vessel(beside, *surface)
