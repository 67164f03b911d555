"""The widest sphere that passes a throat, against the widest way through many random places."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order, minimum_spanning_tree
from scipy.spatial import cKDTree

from benchmarks.judges import wall_distances
from SDFStentLib.lumen import LocalSurface, widest_passing
from SDFStentLib.phantoms import (
    TrueVessel,
    branching_pulmonary_artery,
    stenosed_tube,
)
from SDFStentLib.phantoms.axis import narrowing, planar_axis
from SDFStentLib.phantoms.mesh import swept_tube
from SDFStentLib.phantoms.value import assembled
from SDFStentLib.vessel import find_lesions


def widest_way(points, triangles, ends, places):
    """The largest least distance to the wall of the ways between two places, by way of others.

    They begin where the spheres round the two are widest.
    """
    room, own = (wall_distances(points, triangles, some) for some in (places, ends))
    widest = [
        int(np.where(np.linalg.norm(places - end, axis=1) < held, room, 0.0).argmax())
        for end, held in zip(ends, own, strict=True)
    ]
    apart, near = cKDTree(places).query(places, 13)
    near, apart = near[:, 1:], apart[:, 1:]
    # Empty spheres that hold each other's middles have no wall between.
    one = np.repeat(np.arange(len(places)), near.shape[1])
    other = near.ravel()
    sees = apart.ravel() < np.maximum(room[one], room[other])
    # SciPy up to 1.15 takes no longer numbers here.
    one, other = one[sees].astype(np.int32), other[sees].astype(np.int32)
    weight = 1e3 - np.minimum(room[one], room[other])
    graph = coo_array((weight, (one, other)), shape=(len(places),) * 2).tocsr()
    tree = minimum_spanning_tree(graph)
    _, before = breadth_first_order(tree, widest[0], directed=False)
    at, least = widest[1], np.inf
    while at != widest[0]:
        least, at = min(least, room[at]), before[at]
        assert at >= 0, "no way"
    return float(min(least, room[at]))


@pytest.mark.parametrize("seed", range(1))
def test_it_is_as_wide_as_a_throat_wherever_the_way_begins(seed):
    random = np.random.default_rng(seed)
    tube = stenosed_tube(3.0, 1.2, edge_length=0.4)
    wall = LocalSurface(tube.points, tube.triangles, tube.centerline.points)
    throat = tube.throat.point
    ends = throat + np.array([[0, 0, -4.0], [0, 0, 4.0]]) + random.uniform(-0.8, 0.8, (2, 3))
    guess, radius = throat + random.uniform(-0.6, 0.6, 3), 1.2 * random.uniform(0.9, 1.1)
    *center, passes = widest_passing(wall, guess, radius, ends)
    assert passes == pytest.approx(1.2, rel=0.01)
    assert wall_distances(tube.points, tube.triangles, [center])[0] == pytest.approx(passes)


@pytest.mark.parametrize("seed", range(1))
def test_it_is_as_wide_as_the_widest_way_from_a_branch_into_its_parent(seed):
    random = np.random.default_rng(seed)
    artery = branching_pulmonary_artery(0.6)
    branch = artery.vessels[1]
    ostium = artery.vessels[0].axis.point(branch.joint)[0]
    begin, end = ostium, branch.axis.point(float(artery.vessels[0].radius(branch.joint)) + 4.0)[0]
    throat = (begin + end) / 2
    points, triangles = artery.points, artery.triangles
    wall = LocalSurface(points, triangles, np.stack([begin, end]))
    radius = float(branch.radius(4.0))
    *center, passes = widest_passing(wall, throat, radius, np.stack([begin, end]))
    places = begin + random.uniform(-0.2, 1.2, (4000, 1)) * (end - begin)
    places += random.normal(0.0, 0.1 * radius, (4000, 3))
    truth = widest_way(points, triangles, np.stack([begin, end]), places)
    # Random places lie a little beside the best way.
    assert truth * 0.995 <= passes <= truth * 1.03
    assert wall_distances(points, triangles, [center])[0] == pytest.approx(passes)


def test_where_the_way_is_wider_than_its_ends_the_narrower_one_passes():
    tube = stenosed_tube(3.0, 1.2, edge_length=0.4)
    wall = LocalSurface(tube.points, tube.triangles, tube.centerline.points)
    ends = tube.throat.point + np.array([[0, 0, 1.0], [0, 0, 5.0]])
    *center, passes = widest_passing(wall, ends.mean(axis=0), 1.0, ends)
    (held,) = wall_distances(tube.points, tube.triangles, [center])
    narrower = wall_distances(tube.points, tube.triangles, ends[:1])[0]
    assert narrower <= passes < 1.5 * narrower
    assert passes == pytest.approx(held)


def test_a_dip_of_a_long_throat_between_its_stations_is_its_minimum():
    """Of a wall of triangles: shorter than the stations of a line are apart."""
    axis = planar_axis([(36.0, 0.0)])
    for dip in (16.37,):

        def radius(at, dip=dip):
            throat = 2.0 - 1.1 * np.clip((8 - np.abs(np.asarray(at) - 18.0)) / 4, 0, 1)
            throat = throat + 0.01 * np.sin(at)
            return throat * narrowing(at, dip, 0.25, 0.04)

        tube = swept_tube(axis, radius, 0.1)
        made = assembled("tube", tube, (TrueVessel("tube", axis, radius),), [])
        (lesion,) = find_lesions(made.surface, made.centerline)
        along = np.linspace(14, 22, 401)
        truth = 2 * wall_distances(tube.points, tube.triangles, axis.point(along)).min()
        assert lesion.minimum_diameter == pytest.approx(truth, rel=0.005)
