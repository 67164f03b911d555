"""Lines that begin at the rim or at the wall of a vessel: nothing narrow is made up of them."""

import json
from functools import lru_cache

import numpy as np
import pytest
from seeds import seeds

from benchmarks.phantoms import vascular_tree
from SDFStentLib.centerline import Centerline
from SDFStentLib.cli import main
from SDFStentLib.files import encode_vtp, polydata_from_arrays, polydata_from_lines
from SDFStentLib.geometry import Surface
from SDFStentLib.lumen import LineEnds, with_ends_in_middle
from SDFStentLib.lumen.line_ends import IN_MIDDLE
from SDFStentLib.vessel import find_lesions, lumen_left

TRUNK = 12.0
"""Diameter of the first branch, mm; straight for 54 mm."""

DEPTH = 0.5
"""That the branch after it is narrowed by, in its middle."""


class Tree:
    """A vessel of four outlets, and its exact lines from inlet to outlets."""

    def __init__(self) -> None:
        made = vascular_tree(4, 0.7, {1: DEPTH})
        scale = TRUNK / 10
        self.surface = Surface(scale * made.points, made.triangles)
        self.open = Surface(scale * made.points, made.triangles[made.face_ids == 1])
        self.outlet_radius = scale * made.openings[-1].radius
        tree = made.centerline
        self.lines = [scale * tree.points[tree.ancestry(leaf)] for leaf in tree.leaves]
        narrowed = made.vessels[1]
        half = narrowed.axis.length / 2
        self.throat = scale * narrowed.axis.point([half])[0]
        self.throat_diameter = 2 * scale * float(narrowed.radius(np.array([half]))[0])


@lru_cache
def a_tree() -> Tree:
    return Tree()


def from_wall(line, reach, turn, share=0.97, radius=TRUNK / 2):
    """The same line, but it begins at the wall and comes to the middle so many mm farther on."""
    along = np.r_[0, np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))]
    inward = (line[8] - line[0]) / np.linalg.norm(line[8] - line[0])
    first = np.cross(inward, np.eye(3)[np.abs(inward).argmin()])
    first /= np.linalg.norm(first)
    aside = np.cos(turn) * first + np.sin(turn) * np.cross(inward, first)
    return line + (share * radius * np.clip(1 - along / reach, 0, 1))[:, None] * aside


def indexed(lines):
    """Points (n, 3) and the lines of them, each with points of its own."""
    ends = np.cumsum([len(line) for line in lines])
    return np.concatenate(lines), np.split(np.arange(ends[-1]), ends[:-1])


def read(surface, lines):
    how = {"wall": surface.points, "widths": LineEnds(surface).widths}
    return with_ends_in_middle(surface, Centerline.from_lines(*indexed(lines), **how))


def assert_only_the_true_lesion(surface, tree):
    (lesion,) = find_lesions(surface, tree)
    known = a_tree()
    assert lesion.percent_diameter == pytest.approx(100 * DEPTH, abs=3)
    assert np.linalg.norm(np.subtract(lesion.point, known.throat)) < 2
    assert lesion.minimum_diameter == pytest.approx(known.throat_diameter, rel=0.03)


def assert_in_the_middle(tree, lines):
    """Every point of a tree is on the exact lines, but for a tenth of the radius."""
    exact = np.concatenate(lines)
    for point in tree.points:
        assert np.linalg.norm(exact - point, axis=1).min() < IN_MIDDLE * TRUNK / 2


def test_lines_in_the_middle_stay_as_they_are():
    known = a_tree()
    for surface in (known.surface, known.open):
        tree, told = read(surface, known.lines)
        assert told == ()
        plain = Centerline.from_lines(*indexed(known.lines), wall=surface.points)
        np.testing.assert_array_equal(tree.points, plain.points)
        assert_only_the_true_lesion(surface, tree)


@pytest.mark.parametrize("kind", ["surface", "open"])
@pytest.mark.parametrize("seed", seeds(6, 200))
def test_a_line_that_begins_at_the_rim_of_a_trunk_invents_no_lesion(kind, seed):
    random = np.random.default_rng(seed)
    reach, turn, share = random.uniform((1, 0, 0.9), (15, 2 * np.pi, 1.0))
    known = a_tree()
    surface = getattr(known, kind)
    lines = [from_wall(line, reach, turn, share) for line in known.lines]
    tree, (told,) = read(surface, lines)
    assert told.kind == "begins-at-wall"
    np.testing.assert_allclose([told.numbers[axis] for axis in "xyz"], lines[0][0])
    assert reach - 1 < told.numbers["length_mm"] < reach + TRUNK
    np.testing.assert_allclose(tree.points[tree.roots], [[0, 0, 0]], atol=IN_MIDDLE * TRUNK / 2)
    assert_in_the_middle(tree, known.lines)
    assert_only_the_true_lesion(surface, tree)


# A sphere at a line that leaves the cap at a slant touched the cap, and was taken for the lumen's.
@pytest.mark.parametrize(
    ("reach", "turn", "share"), [(8.2, 342, 0.91), (6.9, 228, 1), (6.1, 188, 0.9)]
)
def test_what_touches_the_cap_tells_nothing_of_the_middle(reach, turn, share):
    known = a_tree()
    tree, told = read(
        known.surface, [from_wall(line, reach, np.radians(turn), share) for line in known.lines]
    )
    assert len(told) == 1
    assert_in_the_middle(tree, known.lines)
    assert_only_the_true_lesion(known.surface, tree)


@pytest.mark.parametrize("seed", seeds(4, 120))
def test_a_line_that_ends_at_the_wall_invents_no_lesion(seed):
    random = np.random.default_rng(seed)
    known = a_tree()
    turn, share, reach = random.uniform((0, 0.9, 0.3), (2 * np.pi, 1.0, 2.5))
    radius, number = known.outlet_radius, int(random.integers(4))
    lines = list(known.lines)
    lines[number] = from_wall(lines[number][::-1], reach * radius, turn, share, radius)[::-1]
    tree, (told,) = read(known.surface, lines)
    np.testing.assert_allclose([told.numbers[axis] for axis in "xyz"], lines[number][-1])
    np.testing.assert_allclose(tree.points[tree.roots], [[0, 0, 0]], atol=1e-9)
    assert_in_the_middle(tree, known.lines)
    assert_only_the_true_lesion(known.surface, tree)


def test_several_lines_that_end_at_the_wall_are_told_in_one_sentence():
    """A sentence for each hid in the panel what comes after them."""
    known, begins = a_tree(), []
    lines = list(known.lines)
    for number, reach in enumerate((1.5, 2.5, 2.0)):
        way = lines[number][::-1]
        lines[number] = from_wall(way, reach * known.outlet_radius, 2.0, 0.95, known.outlet_radius)[
            ::-1
        ]
        begins.append(lines[number][-1])
    tree, (told,) = read(known.surface, lines)
    place = [told.numbers[axis] for axis in "xyz"]
    np.testing.assert_allclose(place, begins[1])  # that one was moved farthest
    words = told.sentence()
    assert words.startswith("3 lines end at the wall, one at (")
    assert words.endswith(") mm; all were moved inward.")
    assert_in_the_middle(tree, known.lines)


def test_the_ends_of_a_vessel_are_as_wide_as_they_were_made():
    known = a_tree()
    ends = LineEnds(known.surface)
    widths = ends.widths([known.lines[0][:80], *(line[:-60:-1] for line in known.lines)])
    assert widths[0] == pytest.approx(TRUNK, rel=0.02)
    # Those that cannot be the widest need not be measured.
    narrow = widths[1:][np.isfinite(widths[1:])]
    np.testing.assert_allclose(narrow, 2 * known.outlet_radius, rtol=0.02)
    assert np.nanargmax(widths) == 0
    outside = known.lines[0][:80] + np.array([100.0, 0, 0])
    assert np.isnan(ends.widths([outside])).all()
    assert ends.stations([]) == []


def test_stations_are_put_along_a_way_once(monkeypatch):
    """They were to see whether it begins at the wall, and again to measure it."""
    known, ways = a_tree(), []
    lines = [from_wall(known.lines[0], 30.0, 1.0), *known.lines[1:]]
    tree = Centerline.from_lines(*indexed(lines), wall=known.surface.points)

    def counted(self, way):
        ways.append(way.tobytes())
        return put(self, way)

    put = LineEnds.line
    monkeypatch.setattr(LineEnds, "line", counted)
    with_ends_in_middle(known.surface, tree)
    assert len(ways) == len(set(ways)) >= len(lines)


def leaving(line, first, last, aside=20.0):
    """A line that is beside the vessel from one of its points to another."""
    moved = line.copy()
    moved[first:last] += (0, aside, 0)
    return moved


@pytest.mark.parametrize("seed", seeds(3, 60))
def test_a_line_that_goes_out_at_a_slant_invents_no_lesion(seed):
    random = np.random.default_rng(seed)
    known = a_tree()
    first, slope = int(random.integers(10, 40)), int(random.integers(1, 15))
    aside = np.interp(np.arange(212) - first, [0, slope, slope + 6, 2 * slope + 6], [0, 12, 12, 0])
    turn = random.uniform(0, 2 * np.pi)
    way = aside[:, None] * np.array([np.cos(turn), np.sin(turn), 0])
    tree, _ = read(known.surface, [line + way for line in known.lines])
    assert len(lumen_left(known.surface, tree)) == 1
    assert_only_the_true_lesion(known.surface, tree)


def test_a_line_that_leaves_the_lumen_is_told_with_its_place_and_nothing_is_invented():
    known = a_tree()
    lines = [leaving(line, 40, 44) for line in known.lines]
    tree, told = read(known.surface, lines)
    assert told == ()
    (left,) = lumen_left(known.surface, tree)
    assert left.kind == "line-leaves-lumen"
    place = np.array([left.numbers[axis] for axis in "xyz"])
    assert lines[0][38, 2] < place[2] < lines[0][46, 2]
    assert TRUNK / 2 < place[1] <= 20
    assert_only_the_true_lesion(known.surface, tree)
    assert lumen_left(known.surface, read(known.surface, known.lines)[0]) == []


def written(folder, lines):
    known = a_tree()
    points, index_lines = indexed(lines)
    wall = polydata_from_arrays(known.surface.points, known.surface.triangles)
    for name, data in (("wall", wall), ("lines", polydata_from_lines(points, index_lines))):
        (folder / f"{name}.vtp").write_bytes(encode_vtp(data))


@pytest.mark.parametrize("fault", ["begins at the wall", "leaves the lumen"])
def test_measure_tells_what_is_wrong_with_a_line_and_the_true_lesion_only(
    tmp_path, monkeypatch, capsys, fault
):
    monkeypatch.chdir(tmp_path)
    made, words = {
        "begins at the wall": (lambda line: from_wall(line, 7.0, 2.0), "A line ends at the wall"),
        "leaves the lumen": (lambda line: leaving(line, 40, 44), "A line leaves the lumen for"),
    }[fault]
    written(tmp_path, [made(line) for line in a_tree().lines])
    assert main(["measure", "wall.vtp", "--centerline", "lines.vtp", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    (lesion,) = document["lesions"]
    assert lesion["percent_diameter"] == pytest.approx(100 * DEPTH, abs=3)
    assert np.linalg.norm(np.subtract(lesion["place_mm"], a_tree().throat)) < 2
    assert words in str(document["warnings"])
