"""The detector against exact rational arithmetic, by construction, and against MeshLab."""

import itertools
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from seeds import seeds

from SDFStentLib.certificate import check_surface, intersections
from SDFStentLib.certificate.triangle_contact import certain_contact, exact_contact
from SDFStentLib.geometry import Surface


def intersecting_pairs(points, triangles, among=None):
    return intersections.intersecting_pairs(np.asarray(points), np.asarray(triangles), among)


def self_intersecting_triangles(points, triangles, among=None):
    found = intersections.self_intersecting_triangles
    return found(np.asarray(points), np.asarray(triangles), among)


# ------------------------------------------------------------- the plain form, all in fractions


def _minus(one, other):
    return [a - b for a, b in zip(one, other, strict=True)]


def _dot(one, other):
    return sum(a * b for a, b in zip(one, other, strict=True))


def _cross(one, other):
    return [
        one[1] * other[2] - one[2] * other[1],
        one[2] * other[0] - one[0] * other[2],
        one[0] * other[1] - one[1] * other[0],
    ]


def _normal(triangle):
    return _cross(_minus(triangle[1], triangle[0]), _minus(triangle[2], triangle[0]))


def _part_inside(start, end, triangle):
    """End points of the part of a segment that lies in a closed triangle (none, or two)."""
    normal, along = _normal(triangle), _minus(end, start)
    half_spaces = [(normal, triangle[0]), ([-x for x in normal], triangle[0])]
    half_spaces += [
        (_cross(normal, _minus(triangle[(k + 1) % 3], triangle[k])), triangle[k]) for k in range(3)
    ]
    first, last = Fraction(0), Fraction(1)
    for direction, corner in half_spaces:
        value, rate = _dot(direction, _minus(start, corner)), _dot(direction, along)
        if rate > 0:
            first = max(first, Fraction(-value, rate))
        elif rate < 0:
            last = min(last, Fraction(-value, rate))
        elif value < 0:
            return []
    if first > last:
        return []
    return [[a + f * d for a, d in zip(start, along, strict=True)] for f in (first, last)]


def _meet(one, other, shared):
    """Whether two triangles have a point in common besides the shared corners and sides."""
    if not any(_normal(one)) or not any(_normal(other)):
        return False
    if len(shared) == 3:
        return True
    common = []
    for k in range(3):
        common += _part_inside(one[k], one[(k + 1) % 3], other)
        common += _part_inside(other[k], other[(k + 1) % 3], one)
    if not shared:
        return bool(common)
    side = _minus(shared[-1], shared[0])
    return any(any(_cross(side, _minus(p, shared[0]))) or
               (len(shared) == 1 and p != shared[0]) for p in common)  # fmt: skip


def _joined(exact, triangles):
    """For every point the set of those that are the same: joined by free edges on one another."""
    sides = [frozenset((t[k], t[(k + 1) % 3])) for t in triangles for k in range(3)]
    free = [tuple(side) for side in sides if sides.count(side) == 1 and len(side) == 2]
    group = {i: {i} for i in range(len(exact))}
    for one, other in itertools.combinations(free, 2):
        for ends in (other, other[::-1]):
            if all(exact[a] == exact[b] for a, b in zip(one, ends, strict=True)):
                for a, b in zip(one, ends, strict=True):
                    both = group[a] | group[b]
                    group.update(dict.fromkeys(both, both))
    return group


def _exact(x):
    """A fraction, or where that says the same a whole number, with which it is quicker."""
    return int(x) if x == int(x) else Fraction(float(x))


def _plain_pairs(points, triangles):
    exact = [[_exact(x) for x in point] for point in points]
    triangles = np.asarray(triangles).tolist()
    joined = _joined(exact, triangles)
    found = []
    for i, j in itertools.combinations(range(len(triangles)), 2):
        one, other = triangles[i], triangles[j]
        shared = [exact[a] for a in one if any(b in joined[a] for b in other)]
        if _meet([exact[a] for a in one], [exact[b] for b in other], shared):
            found.append([i, j])
    return found


# ------------------------------------------------------------------------- against the plain form


@st.composite
def _soups(draw):
    """Few points on a small lattice, so that touching, overlap and repeats are the rule."""
    count = draw(st.integers(4, 9))
    lattice = st.integers(0, draw(st.integers(1, 4)))
    points = draw(st.lists(st.tuples(lattice, lattice, lattice), min_size=count, max_size=count))
    corner = st.integers(0, count - 1)
    triangles = draw(st.lists(st.tuples(corner, corner, corner), min_size=2, max_size=10))
    return np.array(points, dtype=float), np.array(triangles)


@settings(max_examples=60, deadline=None)
@given(_soups(), st.sampled_from([(1.0, 0.0), (0.1, 100.3), (1e-20, 0.0), (1e25, 3e25)]))
def test_lattice_soups_agree_with_exact_rationals(soup, map_to):
    points, triangles = soup
    points = points * map_to[0] + map_to[1]
    assert intersecting_pairs(points, triangles).tolist() == _plain_pairs(points, triangles)


@pytest.mark.parametrize("seed", seeds(3, 6))
def test_soups_in_a_tilted_plane_agree_with_exact_rationals(seed):
    # Rounding leaves these coplanar but for the last digits: float64 alone would have to guess.
    rng = np.random.default_rng(seed)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    points = np.c_[rng.integers(0, 4, (10, 2)), np.zeros(10)] @ turn + 10 * rng.normal(size=3)
    triangles = rng.integers(0, 10, (14, 3))
    assert intersecting_pairs(points, triangles).tolist() == _plain_pairs(points, triangles)


@pytest.mark.parametrize("step", [1, 2, 3])
@pytest.mark.parametrize("height", [0.0, 0.05, 1.0])
def test_fans_that_go_round_several_times_agree_with_exact_rationals(step, height):
    # A fan of seven faces that goes round once is clear; the star {7/2} or {7/3} is not.
    angle = 2 * np.pi * step * np.arange(7) / 7
    points = np.vstack([[0, 0, height], np.c_[np.cos(angle), np.sin(angle), np.zeros(7)]])
    triangles = np.array([[0, 1 + k, 1 + (k + 1) % 7] for k in range(7)])
    expected = _plain_pairs(points, triangles)
    assert intersecting_pairs(points, triangles).tolist() == expected
    assert (len(expected) > 0) == (step > 1)


@pytest.mark.parametrize("seed", range(4))
def test_only_pairs_with_a_moved_triangle_are_looked_at(seed):
    rng = np.random.default_rng(seed)
    points, triangles = rng.normal(size=(30, 3)), rng.integers(0, 30, (40, 3))
    moved = rng.random(40) < 0.3
    everything = intersecting_pairs(points, triangles)
    expected = everything[moved[everything].any(axis=1)]
    assert len(expected) > 0
    assert np.array_equal(intersecting_pairs(points, triangles, moved), expected)
    assert np.array_equal(intersecting_pairs(points, triangles, np.flatnonzero(moved)), expected)


def test_certain_answers_are_never_contradicted_by_exact_arithmetic():
    rng = np.random.default_rng(8)
    first, second = rng.integers(0, 4, (2, 3, 3, 4000)) + rng.choice([0, 1e-15], (2, 3, 3, 4000))
    meets, is_open = certain_contact(first, second, 0)
    exact = exact_contact(first, second)
    assert np.array_equal(meets[~is_open], exact[~is_open])
    assert 0 < is_open.sum() < 4000


# ------------------------------------------------------------------------------- by construction


def _bipyramid(tip):
    """A closed surface of eight triangles whose topmost point is here."""
    ring = [[1, 0, -2], [0, 1, -2], [-1, 0, -2], [0, -1, -2]]
    points = np.array([*ring, [0, 0, 0], [0, 0, -4]], dtype=float) + tip
    sides = [[k, (k + 1) % 4, 4] for k in range(4)] + [[(k + 1) % 4, k, 5] for k in range(4)]
    return points, np.array(sides)


def by_meshlab(points, triangles):
    """Faces that MeshLab says to intersect, in float32."""
    pymeshlab = pytest.importorskip("pymeshlab")
    judge = pymeshlab.MeshSet()
    judge.add_mesh(pymeshlab.Mesh(points, triangles))
    judge.compute_selection_by_self_intersections_per_face()
    return np.flatnonzero(judge.current_mesh().face_selection_array())


@pytest.mark.parametrize(
    ("upper", "count"),
    [
        ([[0, 0, 0], [2, 0, 3], [0, 2, 3], [-2, -2, 3]], 7),
        ([[-3, 0, 0], [3, 0, 0], [0, 2, 3], [0, -2, 3]], 6),
        ([[-3, -3, 0], [3, -3, 0], [0, 3, 0], [0, 0, 3]], 5),
    ],
    ids=["vertex on vertex", "vertex on edge", "vertex on face"],
)
def test_walls_that_touch_at_one_point_intersect(upper, count):
    """The tip of one closed surface on another: it passed where it lay on a vertex."""
    lower, faces = _bipyramid([0, 0, 0])
    points = np.vstack([lower, np.array(upper, dtype=float)])
    more = np.array([[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]) + len(lower)
    triangles = np.vstack([faces, more])
    found = self_intersecting_triangles(points, triangles)
    assert len(found) == count
    assert intersecting_pairs(points, triangles).tolist() == _plain_pairs(points, triangles)
    # Its decision in float32 misses most of what only touches.
    assert set(by_meshlab(points, triangles)) <= set(found)
    checked = check_surface(Surface(points, triangles))
    assert not checked.passed
    assert f"has {count} triangles intersecting near (" in checked.sentence()


@pytest.mark.parametrize("seed", seeds(3, 8))
def test_random_touching_tetrahedra_agree_with_exact_rationals(seed):
    """Two closed surfaces with a common corner on a small lattice; MeshLab selects no more."""
    rng = np.random.default_rng(seed)
    faces = np.array([[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]])
    found = 0
    while found < 10:
        points = rng.integers(0, 4, (8, 3)).astype(float)
        volumes = [np.linalg.det(one[1:] - one[0]) for one in (points[:4], points[4:])]
        if min(np.abs(volumes)) < 0.5 or len(np.unique(points, axis=0)) == 8:
            continue
        found += 1
        triangles = np.vstack([faces, faces + 4])
        assert intersecting_pairs(points, triangles).tolist() == _plain_pairs(points, triangles)
        selected = by_meshlab(points, triangles)
        assert set(selected) <= set(self_intersecting_triangles(points, triangles).tolist())


# ----------------------------------------------------------------------- real vessels and MeshLab


def _vessel(data_dir, name, unit):
    reader_module = pytest.importorskip("vtkmodules.vtkIOXML")
    from vtkmodules.util.numpy_support import vtk_to_numpy

    reader = reader_module.vtkXMLPolyDataReader()
    reader.SetFileName(str(data_dir / name))
    reader.Update()
    surface = reader.GetOutput()
    triangles = vtk_to_numpy(surface.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    return unit * vtk_to_numpy(surface.GetPoints().GetData()).astype(float), triangles


VESSELS = [
    ("aorta_iliac_surface_cm.vtp", 10.0),
    ("pulmonary_surface_cm.vtp", 10.0),
    ("vmtk_aorta_surface_mm.vtp", 1.0),
]


@pytest.mark.parametrize(("name", "unit"), VESSELS)
@pytest.mark.parametrize("noise", [0.1, 0.3])
def test_crumpled_vessels_get_the_faces_that_meshlab_selects(data_dir, name, unit, noise):
    points, triangles = _vessel(data_dir, name, unit)
    edge = np.median(np.linalg.norm(points[triangles[:, 0]] - points[triangles[:, 1]], axis=1))
    points = points + noise * edge * np.random.default_rng(4).normal(size=points.shape)
    points = points.astype(np.float32).astype(float)
    expected = by_meshlab(points, triangles)
    assert np.array_equal(self_intersecting_triangles(points, triangles), expected)
