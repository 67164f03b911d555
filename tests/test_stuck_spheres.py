"""Spheres in pockets of rough walls: seen by their neighbors, and searched anew."""

import numpy as np
import plain_measuring as plainly
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order, minimum_spanning_tree
from scipy.spatial import cKDTree

from benchmarks.judges import wall_distances
from benchmarks.phantoms import (
    TrueOpening,
    TrueVessel,
    branching_pulmonary_artery,
    stenosed_tube,
    straight_tube,
)
from benchmarks.phantoms.axis import narrowing, planar_axis
from benchmarks.phantoms.field import TubeField, TubeUnion
from benchmarks.phantoms.junction import branching_tube
from benchmarks.phantoms.mesh import swept_tube
from benchmarks.phantoms.value import assembled
from benchmarks.trees.surface import Wall
from benchmarks.trees.truth import Spheres
from SDFStentLib.geometry import Line, Surface, across
from SDFStentLib.lumen import (
    LocalSurface,
    diameter_profile,
    inscribed_spheres,
    widest_passing,
    with_own_spheres,
)
from SDFStentLib.lumen.spheres.climb import InscribedSpheres, Until, climbed, exact_spheres
from SDFStentLib.lumen.spheres.own import largest_in_disks
from SDFStentLib.plan import read_input_files
from SDFStentLib.vessel import find_lesions

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


def test_a_sphere_that_begins_beyond_a_wall_is_as_if_it_had_been_followed(monkeypatch):
    tube = straight_tube(3.0, 24, 0.4)
    stations = tube.centerline.points[len(tube.centerline.points) // 2] + [[1.0, 0, 0], [0, 1, 1]]
    axes = across(np.tile([0.0, 0.0, 1.0], (2, 1)))
    aside = np.array([[2.5, 0, 0], [0.5, 0, 0]])
    beyond = InscribedSpheres(stations + aside, np.array([1.0, 3.0]))

    def found():
        wall = LocalSurface(tube.points, tube.triangles, stations)
        ends = climbed(wall, beyond, axes, Until()).radii
        places = zip(stations, beyond.centers, axes, strict=True)
        parted = [wall.parts(*three) for three in places]
        return exact_spheres(wall, stations, axes, beyond, Until()), parted, np.isnan(ends)

    quick, parted, is_lost = found()
    assert parted == is_lost.tolist() == [True, False]
    monkeypatch.setattr(LocalSurface, "parts", lambda *_: False)
    plain, parted, leads_out = found()
    assert parted == [False, False]
    assert leads_out.tolist() == [True, False]
    for one, other in zip(quick, plain, strict=True):
        assert np.array_equal(one, other)
    assert quick.radii == pytest.approx([3.0, 3.0], rel=0.02)


def test_an_ostium_keeps_its_sphere_beside_the_larger_one_of_the_parent():
    tree = branching_pulmonary_artery()
    line = tree.centerline
    for leaf in line.leaves:
        path = line.path(line.points[line.roots[0]], line.points[leaf]).points
        stations = Line(path).resampled(1.0).points
        together = inscribed_spheres(tree.points, tree.triangles, stations)
        ways = Line(stations).directions
        alone = [
            inscribed_spheres(tree.points, tree.triangles, place[None], way[None]).radii[0]
            for place, way in zip(stations, ways, strict=True)
        ]
        assert together.radii == pytest.approx(alone, abs=1e-6)


def a_throat_beside_a_branch():
    """A tube of 6 mm along z, its throat of 2.4 mm at 29.5 mm; a branch of 4.4 mm leaves at 26.

    The branch rises so steeply that a plane across the throat meets both.
    """
    main = planar_axis([(60.0, 0.0)])
    side = planar_axis([(20.0, 0.0)], start=(0, 0, 26.0), heading=(1.0, 0, 1.2), toward=(0, 1, 0))
    vessels = (
        TrueVessel("main", main, lambda along: 3.0 * narrowing(along, 29.5, 4.0, 0.6)),
        TrueVessel("side", side, lambda along: np.full(np.shape(along), 2.2), joint=26.0),
    )
    tubes = [TubeField(vessel.axis, vessel.radius) for vessel in vessels]
    union = TubeUnion(tubes, blend_width=0.5, beyond=1.4)
    patch = branching_tube(union, 0.35)
    ends = [
        TrueOpening(str(number), number, rim.center, rim.outward, rim.radius)
        for number, rim in enumerate(union.rims(), start=2)
    ]
    return assembled("throat beside a branch", patch, vessels, ends, 29.5)


@pytest.fixture(scope="module")
def a_throat():
    """A vessel that is narrow where a branch leaves, and a judge of its spheres."""
    made = a_throat_beside_a_branch()
    stations = np.arange(20.0, 36.1, 0.5)[:, None] * [0.0, 0.0, 1.0]
    return made, Spheres(Wall(made.points, made.triangles, np.zeros(1)), stations, 10.0)


def test_a_throat_beside_which_a_branch_leaves_is_told_as_it_is(a_throat):
    """Its spheres are those of the branch, 4.4 mm wide, over 1.5 mm: no healthy vessel."""
    phantom, judge = a_throat
    points, triangles = phantom.points, phantom.triangles
    along = np.arange(26.0, 33.0, 0.2)
    stations, ways = along[:, None] * [0.0, 0.0, 1.0], np.tile([0.0, 0.0, 1.0], (len(along), 1))
    own = 3.0 * narrowing(along, 29.5, 4.0, 0.6)
    disks = zip(stations, ways, 0.9 * own, strict=True)
    truth = np.array([2 * judge.across(*one)[1] for one in disks])

    found = inscribed_spheres(points, triangles, stations, ways)
    astray = np.linalg.norm(found.centers - stations, axis=1) >= found.radii
    assert (2 * found.radii[astray] / truth[astray]).max() > 1.4, "no sphere leaves its vessel"
    told = with_own_spheres(
        LocalSurface(points, triangles, stations), stations, ways, found, [np.arange(len(along))]
    )
    assert told.radii == pytest.approx(wall_distances(points, triangles, told.centers), rel=1e-5)
    assert (told.radii[~astray] == found.radii[~astray]).all()
    excess = 2 * told.radii[astray] / truth[astray] - 1
    assert excess.max() < 0.2  # of up to 0.64
    assert (told.radii <= found.radii).all()

    (lesion,) = find_lesions(phantom.surface, phantom.centerline)
    assert lesion.minimum_diameter == pytest.approx(truth.min(), rel=0.03)
    assert lesion.reference_diameter == pytest.approx(6.0, rel=0.02)
    assert lesion.percent_diameter == pytest.approx(100 * (1 - truth.min() / 6.0), abs=2)
    assert lesion.start < 26.5
    assert lesion.end > 32.5


def test_a_stent_s_profile_beside_a_branch_is_that_of_its_own_vessel(a_throat):
    """At the throat 4.4 mm were told of 2.7, as wide as the branch: a stent seemed to be wide."""
    phantom, judge = a_throat
    along = np.arange(20.0, 36.1, 0.5)
    stations, ways = along[:, None] * [0.0, 0.0, 1.0], np.tile([0.0, 0.0, 1.0], (len(along), 1))
    radii = 3.0 * narrowing(along, 29.5, 4.0, 0.6)
    truth = [2 * judge.across(*one)[1] for one in zip(stations, ways, 0.9 * radii, strict=True)]
    found = diameter_profile(phantom.surface, stations, 0.5)
    told = found.inscribed_diameter
    beside = (along >= 28.5) & (along <= 30.5)
    assert told[~beside] == pytest.approx(np.array(truth)[~beside], rel=0.03)
    # Its middle is that of the stations beside it, not that of the largest sphere across.
    assert (np.abs(told / truth - 1)[beside] < 0.21).all()
    assert (told[along == 29.5] / np.array(truth)[along == 29.5] < 1.06).all()
    assert found.minimum == pytest.approx(min(truth), rel=0.01)


def test_a_patient_s_throat_beside_branches_is_as_wide_as_an_independent_search_finds_it(data_dir):
    names = [str(data_dir / f"su0243_{name}_mm.vtp") for name in ("surface", "centerline")]
    vessel = read_input_files(*names).vessel
    lesion = vessel.lesions[0]
    found = diameter_profile(vessel.surface, lesion.line, 1.0)
    line = lesion.line.resampled(1.0).points
    wall = Wall(vessel.surface.points, vessel.surface.triangles, np.zeros(1))
    judge = Spheres(wall, line, 10.0)
    told = found.inscribed_diameter
    disks = [*zip(found.centers, Line(line).directions, 0.3 * told, strict=True)]
    # In a disk round what was found, nothing wider fits beside it, and it fits itself.
    inner = slice(3, -3, 2)
    truth = 2 * np.array([judge.across(*one)[1] for one in disks[inner]])
    assert told[inner] == pytest.approx(truth, rel=0.03)
    assert found.minimum == pytest.approx(2.62, abs=0.03)


def test_neither_order_of_triangles_nor_frame_nor_rounding_changes_a_patient_s_lesions(data_dir):
    """One of 40 % became one of 49 %, and one of 20 % came and went."""
    names = [str(data_dir / f"su0243_{name}_mm.vtp") for name in ("surface", "centerline")]
    vessel = read_input_files(*names).vessel
    random = np.random.default_rng(5)
    turned, triangles = np.array([-1.0, -1.0, 1.0]), vessel.surface.triangles
    moved = random.permutation(len(vessel.surface.points))
    points = np.empty_like(vessel.surface.points)
    points[moved] = vessel.surface.points * turned * (1 + 1e-15)
    other = Surface(points, moved[np.roll(random.permutation(triangles), 1, axis=1)])
    line = vessel.centerline
    found = find_lesions(other, line.with_points(line.points * turned))
    for told in ("percent_diameter", "minimum_diameter", "reference_diameter", "length"):
        both = [[getattr(one, told) for one in every] for every in (vessel.lesions, found)]
        assert both[1] == pytest.approx(both[0], rel=1e-6), told


# The widest sphere that passes a throat, against the widest way through many random places.


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


@pytest.mark.parametrize("seed", range(3))
def test_the_sphere_that_passes_is_that_of_all_cells_of_the_grid(seed):
    random = np.random.default_rng(seed)
    artery, tube = branching_pulmonary_artery(0.8), stenosed_tube(3.0, 1.2, edge_length=0.4)
    branch, ways = artery.vessels[1], []
    ostium = artery.vessels[0].axis.point(branch.joint)[0]
    for away in (3.0, 7.0, 12.0):
        ways.append((artery, np.stack([ostium, branch.axis.point(away)[0]])))
        ways.append((tube, tube.throat.point + away * np.array([[0, 0, -1.0], [0, 0, 1.0]])))
    # One that leads out of the lumen, whose cells on the way are narrow.
    ways.append((tube, tube.throat.point + np.array([[0, 0, 0.0], [9.0, 0, 0]])))
    passed = set()
    for made, ends in ways:
        wall = LocalSurface(made.points, made.triangles, ends)
        ends = ends + random.normal(0.0, 0.3, ends.shape)
        radius = random.uniform(0.4, 2.5)
        found = widest_passing(wall, ends.mean(axis=0), radius, ends)
        assert np.array_equal(
            found, plainly.widest_passing(wall, ends.mean(axis=0), radius, ends), equal_nan=True
        )
        passed.add(bool(np.isfinite(found).all()))
    assert passed == {True, False}


def test_spheres_in_disks_are_those_of_all_places_that_are_tried():
    random = np.random.default_rng(5)
    points, triangles, stations, ways = rough_tube(SEED)
    wall = LocalSurface(points, triangles, stations)
    middles = stations * [0.5, 0.5, 1.0] + random.normal(0.0, 0.2, stations.shape)
    disks = random.uniform(0.2, 1.5, len(middles))
    found = largest_in_disks(wall, middles, across(ways), disks)
    for one, other in zip(
        found, plainly.largest_in_disks(wall, middles, across(ways), disks), strict=True
    ):
        assert np.array_equal(one, other)


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
