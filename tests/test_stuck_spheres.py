"""Spheres in pockets of rough walls: seen by their neighbors, and searched anew."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.judges import wall_distances
from benchmarks.trees.surface import Wall
from benchmarks.trees.truth import Spheres
from SDFStentLib.geometry import resampled, tangents
from SDFStentLib.lumen import inscribed_spheres
from SDFStentLib.phantoms import branching_pulmonary_artery, straight_tube

SEED = 47
"""Of a tube in which a climb ends in a pocket."""


def rough_tube(seed):
    """A tube of radius 3 mm whose wall is uneven by a quarter of a mm, and a line beside its wall.

    The line's stations (n, 3) with directions.
    """
    tube = straight_tube(3.0, 24, 0.4)
    points = tube.points + np.random.default_rng(seed).normal(0, 0.28, tube.points.shape)
    along = np.linspace(points[:, 2].min() + 5, points[:, 2].max() - 5, 15)
    angle = np.deg2rad(37)
    aside = 2.4 * np.array([np.cos(angle), np.sin(angle)])
    stations = np.column_stack([np.tile(aside, (15, 1)), along])
    return points, tube.triangles, stations, np.tile([0.0, 0.0, 1.0], (15, 1))


def test_a_sphere_in_a_pocket_of_the_wall_is_searched_anew():
    points, triangles, stations, ways = rough_tube(SEED)
    judge = Spheres(Wall(points, triangles, np.zeros(len(triangles))), stations, 8.0)
    middle = stations * [0, 0, 1]
    truth = [judge.across(*one, 2.0)[1] for one in zip(middle, ways, strict=True)]
    alone = [
        inscribed_spheres(points, triangles, place[None], way[None]).radii[0]
        for place, way in zip(stations, ways, strict=True)
    ]
    assert min(np.array(alone) / truth) < 0.2, "no sphere of this tube is stuck any more"
    found = inscribed_spheres(points, triangles, stations, ways)
    assert found.radii == pytest.approx(truth, rel=0.02)
    assert found.radii == pytest.approx(wall_distances(points, triangles, found.centers), rel=1e-5)


def test_spheres_of_another_vessel_beyond_a_wall_change_none():
    large, small = straight_tube(3.0, 24, 0.4), straight_tube(0.5, 24, 0.2)
    beside = np.array([3.7, 0.0, 0.0])
    points = np.vstack([large.points, small.points + beside])
    triangles = np.vstack([large.triangles, small.triangles + len(large.points)])
    middle = large.centerline.points[len(large.centerline.points) // 2]
    stations = middle + np.array([[1.5, 0, -1], beside, [1.5, 0, 1]])
    ways = np.tile([0.0, 0.0, 1.0], (3, 1))
    found = inscribed_spheres(points, triangles, stations, ways)
    assert found.radii == pytest.approx([3.0, 0.5, 3.0], rel=0.02)


def test_an_ostium_keeps_its_sphere_beside_the_larger_one_of_the_parent():
    tree = branching_pulmonary_artery()
    line = tree.centerline
    for leaf in line.leaves:
        path = line.path(line.points[line.roots[0]], line.points[leaf]).points
        stations = resampled(path, 1.0)
        together = inscribed_spheres(tree.points, tree.triangles, stations)
        ways = tangents(stations)
        alone = [
            inscribed_spheres(tree.points, tree.triangles, place[None], way[None]).radii[0]
            for place, way in zip(stations, ways, strict=True)
        ]
        assert together.radii == pytest.approx(alone, abs=1e-6)
