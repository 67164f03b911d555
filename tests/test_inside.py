"""What lies inside of a surface: open or closed, in whatever winding, wherever its corners are."""

import numpy as np
import pytest
from mesh_files import octahedron, open_tube
from plain_measuring import winding_numbers
from scipy.spatial.transform import Rotation

from benchmarks.phantoms import stenosed_tube, vascular_tree
from SDFStentLib.geometry import Surface, boundary_edges
from SDFStentLib.geometry.closing import _rims, _rims_of_manifold
from SDFStentLib.geometry.exact import turn_signs, volume_signs


def a_tube(turn=None, around=24, capped=True, length=60.0):
    """A tube whose axis runs through corners, edges and fans, with its axis."""
    points, triangles = open_tube(around=around, length=length)
    if capped:
        surface = Surface(points, triangles).closed
        points, triangles = surface.points, surface.triangles
    axis = np.stack([0 * (z := np.linspace(0, length, 121)), 0 * z, z], axis=1)
    turn = np.eye(3) if turn is None else turn
    return Surface(points @ turn.T, triangles), axis @ turn.T


def turned(triangles, share=0.3, seed=1):
    """Some of the triangles wound the other way round."""
    found = triangles.copy()
    some = np.random.default_rng(seed).random(len(found)) < share
    found[some] = found[some][:, ::-1]
    return found


AXES = {
    "along z": np.eye(3),
    "along x": np.eye(3)[[2, 0, 1]],
    "along y": np.eye(3)[[1, 2, 0]],
    "in a plane": Rotation.from_euler("y", 45, degrees=True).as_matrix(),
    "oblique": Rotation.from_euler("xyz", [20, 31, 7], degrees=True).as_matrix(),
}


@pytest.mark.parametrize("capped", [True, False], ids=["capped", "open"])
@pytest.mark.parametrize("around", [3, 4, 16, 31, 64])
@pytest.mark.parametrize("axis", AXES)
def test_every_place_of_the_axis_of_a_tube_is_inside_and_every_one_beyond_is_not(
    axis, around, capped
):
    """A ray along it meets the middles of the fans, one across it corners and edges of the wall."""
    surface, line = a_tube(AXES[axis], around, capped)
    assert surface.contains(line).all()
    along = (line[-1] - line[0]) / 60
    beyond = np.concatenate([line[:1] - [[s] for s in (0.01, 1, 9)] * along, line[-1:] + along])
    assert not surface.contains(beyond).any()
    assert Surface(surface.points, turned(surface.triangles)).contains(line).all()


@pytest.mark.parametrize("seed", range(6))
def test_random_places_are_told_as_by_solid_angles(seed):
    """Also in the planes of corners, over edges and right over corners."""
    rng = np.random.default_rng(seed)
    made = vascular_tree(3, 1.5) if seed % 2 else stenosed_tube(edge_length=1.5)
    surface = made.surface
    points, low, high = surface.points, surface.points.min(axis=0), surface.points.max(axis=0)
    places = rng.uniform(low, high, (120, 3))
    corner, other = points[rng.integers(len(points), size=(2, 120))]
    places[:40, :2] = corner[:40, :2]
    places[40:80, 0] = corner[40:80, 0]
    places[80:] = 0.5 * (corner + other)[80:]
    known = winding_numbers(places, points, surface.triangles)
    sure = (known < 0.01) | (known > 0.99)
    for triangles in (surface.triangles, turned(surface.triangles, 0.5, seed)):
        found = Surface(points, triangles).contains(places)
        np.testing.assert_array_equal(found[sure], known[sure] > 0.5)


def test_a_place_on_the_surface_is_inside_wherever_on_it():
    points, triangles = octahedron(radius=1.0, rounds=1)
    surface = Surface(points, triangles)
    corners = points[triangles]
    for weights in ([1, 0, 0], [0.5, 0.5, 0], [0.2, 0.3, 0.5]):
        places = np.einsum("i,mij->mj", weights, corners)
        assert surface.contains(places).all()
        assert not surface.contains(places * (1 + 1e-9)).any()
    box = Surface(*a_box())
    assert box.contains(np.array([[0, 0, 0], [1, 0.5, 0.5], [0.5, 0.5, 1], [0, 1, 0.3]])).all()


def beside(places, x, z):
    return places + np.array([x, 0.0, z])


def a_box(size=1.0):
    points = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    triangles = np.array([t for a, b, c, d in quads for t in ([a, b, c], [a, c, d])])
    return size * points, triangles


@pytest.mark.parametrize("length", [1.0, 3.0, 60.0])
def test_an_open_tube_is_open_and_its_inside_ends_at_its_rims_however_short_it_is(length):
    """The winding number of the wall alone is 0.45 in the middle of one as long as its radius."""
    surface, line = a_tube(capped=False, length=length)
    assert not surface.topology.is_closed
    assert surface.contains(line).all()
    for end, out in ((0.0, -1.0), (length, 1.0)):
        places = np.array([[x, 0.3, end + out * 1e-6] for x in np.linspace(-4.5, 4.5, 19)])
        assert not surface.contains(places).any()
        assert surface.contains(places - [0, 0, out * 2e-6]).all()


def joined(*parts):
    """Surfaces as one, that share no points."""
    shifts = np.cumsum([0, *(len(part.points) for part in parts)])[:-1]
    triangles = [part.triangles + shift for part, shift in zip(parts, shifts, strict=True)]
    return Surface(np.concatenate([part.points for part in parts]), np.concatenate(triangles))


@pytest.mark.parametrize("ways", [(1, 1), (1, -1), (-1, 1)])
def test_the_inside_of_every_part_counts_however_the_others_are_wound(ways):
    """A lumen and its outer wall, and two tubes that reach into each other."""
    inner, line = a_tube()
    outer = Surface(inner.points * (1.4, 1.4, 1.1), inner.triangles)
    other = Surface(beside(inner.points, 0, 40), inner.triangles)
    for second in (outer, other):
        both = joined(*(Surface(part.points, part.triangles[:, ::way])
                        for part, way in zip((inner, second), ways, strict=True)))  # fmt: skip
        assert both.contains(line).all()
    assert joined(inner, other).contains(beside(line, 0, 40)).all()
    assert not joined(inner, other).contains(beside(line, 9, 40)).any()


def test_caps_that_share_no_point_with_the_wall_close_nothing_and_spoil_nothing():
    """As where normals are split at the rims."""
    whole, line = a_tube()
    is_cap = (whole.triangles >= len(whole.points) - 2).any(axis=1)
    parts = [whole.triangles[is_cap], whole.triangles[~is_cap]]
    apart = joined(*(Surface(whole.points, part) for part in parts))
    assert apart.contains(line[1:-1]).all()
    assert not apart.contains(beside(line, 6, 0)).any()


def test_a_membrane_across_the_lumen_leaves_both_sides_inside():
    whole, line = a_tube()
    ring = np.flatnonzero(whole.points[:, 2] == 30)
    middle = len(whole.points)
    fan = [[a, b, middle] for a, b in zip(ring, np.roll(ring, -1), strict=True)]
    with_membrane = Surface(
        np.vstack([whole.points, [[0, 0, 30]]]), np.vstack([whole.triangles, fan])
    )
    assert not with_membrane.topology.is_manifold
    assert with_membrane.contains(line).all()
    assert not with_membrane.contains(beside(line, 6, 0)).any()


def test_a_hole_in_the_wall_is_closed_like_an_end():
    surface, line = a_tube(AXES["oblique"])
    kept = np.delete(surface.triangles, [5, 600, 601, 602], axis=0)
    torn = Surface(surface.points, kept)
    assert torn.topology.boundary_edge_count
    assert torn.contains(line).all()
    assert torn.closed.topology.is_closed


@pytest.mark.parametrize("seed", range(4))
def test_the_rims_of_a_torn_surface_are_found_quickly_as_well(seed):
    whole, _ = a_tube(capped=seed % 2 == 0)
    keep = np.random.default_rng(seed).random(len(whole.triangles)) > (0.002, 0.05)[seed // 2]
    torn = Surface(whole.points, whole.triangles[keep])
    ways = (_rims_of_manifold, _rims) if torn.topology.is_vertex_manifold else (_rims, _rims)
    part = torn.closing.part
    quick, plain = (way(torn.triangles, part)[0].tolist() for way in ways)
    assert sorted(quick) == sorted(plain)
    assert sorted(plain) == sorted(boundary_edges(torn.triangles).tolist())
    assert torn.closed.topology.is_closed


def test_rays_through_corners_and_edges_are_counted_once():
    points, triangles = a_box(2.0)
    inside = [[1, 1, 1], [1, 1, 0.5], [0.5, 0.5, 1], [1.5, 0.5, 1]]
    outside = [[1, 1, -1], [1, 1, 3], [3, 1, 1], [-1, -1, -1], [1, 5, 1]]
    found = Surface(points, triangles).contains(np.array(inside + outside, dtype=float))
    assert found.tolist() == [True] * 4 + [False] * 5
    assert Surface(points, triangles).contains(np.empty((0, 3))).tolist() == []


def test_signs_are_exact_where_floats_are_not():
    """Held against whole numbers: corners and places of a grid, far from the origin."""
    rng = np.random.default_rng(4)
    whole = rng.integers(-2, 3, size=(4, 3, 400))
    far = 2.0**20 + whole * 2.0**-30
    a, b, c, p = whole
    turn = (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
    np.testing.assert_array_equal(turn_signs(*(far[[0, 1, 3], :2])), np.sign(turn))
    normal = np.cross(b - a, c - a, axis=0)
    volume = (normal * (p - a)).sum(axis=0)
    found = volume_signs((far[0], far[1], far[2]), far[3])
    np.testing.assert_array_equal(found, np.sign(volume))
    tiny = np.array([0.1, 0.2, 0.3])[:, None] * np.ones(3)
    nearly = tiny.copy()
    nearly[0, 0] = np.nextafter(0.1, 1)
    line = (np.zeros((2, 1)), np.array([[0.3], [0.3]]), nearly[[0, 1], :1])
    assert turn_signs(*line) == [1]
