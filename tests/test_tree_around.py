"""Ways from a stent's axis into its vessels, and which way is downstream."""

import json

import numpy as np
import pytest
from deployment_cases import ANATOMIES, anatomy
from plain_measuring import winding_numbers

from benchmarks.phantoms import stenosed_tube, vascular_tree
from SDFStentLib.centerline import Centerline
from SDFStentLib.cli import main
from SDFStentLib.files import encode_vtp, polydata_from_arrays, polydata_from_lines
from SDFStentLib.geometry import Line
from SDFStentLib.lumen import ExtendedAxis, extended_axis, through_lumen
from SDFStentLib.lumen.spheres import inscribed
from SDFStentLib.plan import load_plan, read_input_files
from SDFStentLib.stent import AtDistalEnd, BetweenPoints, Stent
from SDFStentLib.treatment import axis_in_vessel
from SDFStentLib.validation import InputError
from SDFStentLib.vessel import BranchWays, Ostium, find_ostia
from SDFStentLib.vessel.tree_around import LinesFromAxis, ends_around, place_of


def a_tree(seed: int) -> Centerline:
    """Lines from one root that part again and again, points 0.5 mm apart."""
    rng = np.random.default_rng(seed)
    lines, todo = [], [(np.zeros((1, 3)), np.array([0.0, 0, 1]), 0)]
    # Ends: four generations.
    while todo:
        way, heading, generation = todo.pop()
        steps = np.cumsum(np.repeat(0.5 * heading[None], rng.integers(12, 40), axis=0), axis=0)
        way = np.concatenate([way, way[-1] + steps])
        if generation == 3:
            lines.append(way)
            continue
        for _ in range(2):
            turned = heading + rng.normal(0, 0.5, 3)
            todo.append((way, turned / np.linalg.norm(turned), generation + 1))
    ends = np.cumsum([len(line) for line in lines])[:-1]
    rows = np.split(np.arange(sum(map(len, lines))), ends)
    return Centerline.from_lines(np.concatenate(lines), rows, inlet=lines[0][0])


@pytest.mark.parametrize("seed", range(4))
def test_ways_leave_an_axis_as_each_of_them_does_by_itself(seed):
    tree = a_tree(seed)
    rng = np.random.default_rng(seed)
    junction = tree.points[tree.junctions[1]]
    axis = tree.path_around(junction, 12.0).line
    reach, distance = 25.0, float(rng.uniform(0.3, 2.0))
    place = junction + rng.normal(0, 2, 3)
    stops = [tree.project(end) for end in axis.points[[0, -1]]]
    ends = sorted(set().union(*(ends_around(tree, stop, reach) for stop in stops)))
    expected = []
    for end in sorted(ends, key=lambda node: (tree.parent[node] < 0, node)):
        for stop in stops:
            line = tree.path(stop, place_of(tree, end)).points
            beside = np.flatnonzero(axis.nearest(line).distances < distance)
            own = Line(line[beside[-1] if len(beside) else 0 :]).without_repeats().points
            if len(own) > 1 and Line(own).nearest(place[None]).distances[0] < 5.0:
                expected.append(own)
    found = list(LinesFromAxis(tree, axis, reach).leaving(distance, place, 5.0))
    # What does not come so near may be among them.
    found = [own.points for own in found if own.nearest(place[None]).distances[0] < 5.0]
    assert 1 <= len(found) < len(expected)
    # Each is one of those expected; all others pass the place as one of them does.
    for own in found:
        same = [line for line in expected if line.shape == own.shape]
        assert any(np.allclose(own, line, rtol=0, atol=1e-12) for line in same)
    passed = [Line(own).nearest(place[None]).points for own in found]
    for line in expected:
        nearest = Line(line).nearest(place[None]).points
        assert min(np.abs(nearest - one).max() for one in passed) < 1e-12


def test_the_way_into_a_branch_is_that_to_most_outlets_and_not_into_the_next_small_one():
    """Of an artery of 11.7 mm to 37 outlets a stenosis of 2.6 mm was measured, which is not its."""
    corners = [
        [(0, 0, 0), (0, 0, 60)],
        [(0, 0, 0), (0, 0, 30), (22, 0, 30)],
        [(0, 0, 0), (0, 0, 30), (2, 0, 30), (12, 3, 30), (22, 3, 34)],
        [(0, 0, 0), (0, 0, 30), (2, 0, 30), (12, 3, 30), (22, 3, 26)],
    ]
    lines = [Line(np.array(corner, dtype=float)).resampled(0.5).points for corner in corners]
    rows = np.split(np.arange(sum(map(len, lines))), np.cumsum([len(one) for one in lines])[:-1])
    tree = Centerline.from_lines(np.concatenate(lines), rows, inlet=lines[0][0])
    axis = ExtendedAxis(Line(lines[0]), 20.0, 20.0)
    opening = Ostium("branch", np.array([5.0, 0, 30]), 6.0, 14.0, 16 * np.pi, 1.0)
    (way,) = BranchWays(vascular_tree(1, 1.0).surface, axis, tree).into([opening])
    assert abs(way.points[-1][1] - 3) < 0.1


def test_ways_through_a_lumen_side_by_side_are_those_found_one_after_the_other():
    made = vascular_tree(8, 1.0)
    tree = made.centerline
    branches = [tree.points[branch] for branch in tree.branches]
    axes = [line[: max(2, len(line) // 3)] for line in branches if Line(line).length > 5.0]
    axes += [axis[::-1] for axis in axes[:2]]
    together = through_lumen(made.surface, axes, 15.0)
    assert max(Line(way).length for way in together if len(way)) > 10.0
    for axis, way in zip(axes, together, strict=True):
        (alone,) = through_lumen(made.surface, [axis], 15.0)
        assert len(way) == len(alone)
        np.testing.assert_allclose(way, alone, atol=1e-2)
    assert through_lumen(made.surface, [], 15.0) == []


def test_no_step_of_a_way_leads_out_of_the_lumen(data_dir, monkeypatch):
    """From a branch into a far wider vessel: half of its radius on was outside."""
    inputs = read_input_files(
        *(data_dir / f"su0243_{name}_mm.vtp" for name in ("surface", "centerline"))
    )
    surface, tree = inputs.vessel.surface, inputs.vessel.centerline
    axis = extended_axis(surface, tree.path_around([9.3, -77.5, -55.5], 25.0).points)
    ostia, asked = find_ostia(surface, axis), []
    plain = inscribed.SphereSearch.spheres

    def noted(search, centers, directions, until):
        asked.append(centers)
        return plain(search, centers, directions, until)

    monkeypatch.setattr(inscribed.SphereSearch, "spheres", noted)
    assert any(way is not None for way in BranchWays(surface, axis, None).into(ostia))
    # The first ones are the middles of openings, in the lumen or not.
    assert surface.contains(np.concatenate(asked[1:])).all()


# Which end is proximal, and points that lie beside the vessel.


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
    for index in rng.choice(len(line.points), 40):
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
