"""Centerlines of nothing but a surface, against the axes of phantoms and lines of other makers."""

import numpy as np
import pytest
from scipy.spatial import Delaunay, cKDTree

from benchmarks.phantoms import (
    arch_with_coarctation,
    branching_pulmonary_artery,
    cavopulmonary_connection,
    hairpin_tube,
    helix_tube,
    stenosed_tube,
    straight_tube,
    tube_with_neighbor,
    vascular_tree,
)
from SDFStentLib import extract_centerline
from SDFStentLib.centerline import inner_balls
from SDFStentLib.cli import main
from SDFStentLib.files import read_centerline, read_surface
from SDFStentLib.geometry import Surface, SurfaceIndex, distances_to_segments, norm
from SDFStentLib.treatment import Vessel
from SDFStentLib.validation import DeploymentError, InputError
from SDFStentLib.vessel import find_lesions

ASIDE = np.array([20.0, 0.0, 0.0])


def apart(found, tree):
    """Distance of points from the axes of a centerline, over its radius there."""
    below = np.flatnonzero(tree.parent >= 0)
    starts, ends = tree.points[tree.parent[below]], tree.points[below]
    near = [distances_to_segments(point, starts, ends)[0].min() for point in found]
    return np.sqrt(near) / tree.inscribed_radius[cKDTree(tree.points).query(found)[1]]


@pytest.mark.parametrize(
    "phantom",
    [
        straight_tube(edge_length=0.4),
        helix_tube(edge_length=0.4),
        hairpin_tube(edge_length=0.4),
        stenosed_tube(3.0, 1.2, edge_length=0.4),
    ],
    ids=lambda phantom: phantom.name,
)
def test_lines_of_tubes_lie_on_their_axes(phantom):
    found = extract_centerline(phantom.surface)
    assert found.warnings == ()
    assert len(found.lines.lines) == 1
    away = apart(found.lines.points, phantom.centerline)
    assert np.median(away) < 0.002
    assert away.max() < 0.01


@pytest.mark.parametrize(
    "phantom",
    [
        arch_with_coarctation(),
        branching_pulmonary_artery(),
        cavopulmonary_connection(),
        vascular_tree(16),
    ],
    ids=lambda phantom: phantom.name,
)
def test_every_end_of_a_tree_has_its_line(phantom):
    found = extract_centerline(phantom.surface)
    tree = found.centerline
    tips = tree.points[[*tree.roots, *tree.leaves]]
    assert len(tips) == len(phantom.openings)
    for opening in phantom.openings:
        assert norm(tips - opening.center).min() < 0.1 * opening.radius
    assert np.median(apart(found.lines.points, phantom.centerline)) < 0.03
    inside = SurfaceIndex(phantom.points, phantom.triangles).distances(tree.points).distance
    is_inner = ~np.isin(np.arange(len(tree.points)), [*tree.roots, *tree.leaves])
    # What is told of a point is the sphere beside it, and that is inside.
    assert (inside[is_inner] > 0.5 * tree.inscribed_radius[is_inner]).mean() > 0.9


@pytest.mark.parametrize("name", ["pulmonary", "aorta_iliac"])
def test_lines_of_an_anatomy_agree_with_those_that_came_with_it(data_dir, name):
    surface = read_surface(data_dir / f"{name}_surface_cm.vtp", "cm").surface
    known = read_centerline(data_dir / f"{name}_centerline_cm.vtp", "cm")
    found = extract_centerline(surface)
    assert len(found.lines.lines) == len(known.leaves)
    away = apart(found.lines.points, known)
    assert np.median(away) < 0.03
    assert np.quantile(away, 0.95) < 0.3


def away(one, other):
    return float(np.linalg.norm(np.subtract(one.point, other.point)))


def test_lines_of_a_patient_tell_the_lesions_that_lines_of_vmtk_tell(data_dir):
    surface = read_surface(data_dir / "su0243_surface_mm.vtp").surface
    known = read_centerline(data_dir / "su0243_centerline_mm.vtp")
    found = extract_centerline(surface)
    assert len(found.lines.lines) == len(known.leaves) == 92
    assert np.median(apart(found.lines.points, known)) < 0.1
    wanted = Vessel(surface, known).lesions[:4]
    told = find_lesions(surface, found.centerline)
    for lesion in wanted:
        same = min(told, key=lambda one: away(one, lesion))
        assert away(same, lesion) < 1.0
        assert abs(same.percent_diameter - lesion.percent_diameter) < 1.5


def test_the_balls_are_those_of_a_plain_search():
    """Empty, through four points of the wall, inside; linked where they share three of them."""
    tube = stenosed_tube(3.0, 1.5, 20.0, 1.2)
    balls = inner_balls(tube.surface)
    nearest = cKDTree(tube.points).query(balls.centers, k=4)[0]
    np.testing.assert_allclose(nearest, balls.radii[:, None] * np.ones(4), rtol=0, atol=0.02)
    outside = Delaunay(tube.points).find_simplex(balls.centers) < 0
    assert not outside.any()
    near = norm(balls.centers[balls.links[:, 0]] - balls.centers[balls.links[:, 1]])
    reach = balls.radii[balls.links].sum(axis=1)
    assert (near < reach).all()  # two balls with points in common overlap


def test_vessels_side_by_side_are_not_mixed_up():
    made = tube_with_neighbor()
    first = made.vessels[0].axis
    ends = first.point(np.array([0.0, first.length]))
    found = extract_centerline(made.surface, ends[0], [ends[1]])
    assert len(found.lines.lines) == 1
    axis = first.point(np.linspace(0.0, first.length, 400))
    assert cKDTree(axis).query(found.lines.points)[0].max() < 0.1  # places are 0.1 mm apart


def test_a_part_that_hangs_free_is_left_out_and_an_end_of_it_that_is_named_refused():
    tube = straight_tube(radius=3.0, length=30.0)
    points = np.vstack([tube.points, tube.points + ASIDE])
    both = Surface(points, np.vstack([tube.triangles, tube.triangles + len(tube.points)]))
    found = extract_centerline(both)
    assert len(found.lines.lines) == 1
    (caution,) = found.warnings
    assert "hang free" in caution.sentence()
    near, far = tube.openings[0].center, tube.openings[1].center + ASIDE
    with pytest.raises(DeploymentError, match="does not lead to the end at"):
        extract_centerline(both, near, [far])


def test_a_rounded_end_is_named_and_ends_without_any_are_refused():
    tube = straight_tube(radius=3.0, length=30.0)
    squeezed = tube.points.copy()
    low, high = squeezed[:, 2].min(), squeezed[:, 2].max()
    for end, sign in ((low, 1.0), (high, -1.0)):
        depth = np.clip(1 - sign * (squeezed[:, 2] - end) / 3.0, 0, 1)
        squeezed[:, :2] *= np.sqrt(1 - np.minimum(depth, 0.995) ** 2)[:, None]
    round_one = Surface(squeezed, tube.triangles)
    tips = squeezed[squeezed[:, 2].argmin()], squeezed[squeezed[:, 2].argmax()]
    found = extract_centerline(round_one, tips[0], [tips[1]])
    inner = found.lines.points[np.abs(found.lines.points[:, 2] - (low + high) / 2) < 9.0]
    assert norm(inner[:, :2]).max() < 0.1
    with pytest.raises(InputError, match="expected open ends or flat caps"):
        extract_centerline(round_one)


def test_the_command_needs_no_other_package(tmp_path, capsys, monkeypatch):
    from tube_files import write_tube

    monkeypatch.chdir(tmp_path)
    write_tube(tmp_path)
    words = ["centerline", "tube.vtp", "--units", "cm", "-o", "own.vtp"]
    assert main(words) == 0
    assert "1 line to own.vtp" in capsys.readouterr().out
    made = read_centerline("own.vtp", "cm")
    known = read_centerline("line.vtp", "cm")
    assert apart(made.points, known).max() < 0.05
