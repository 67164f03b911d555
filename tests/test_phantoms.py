"""Synthetic vessels: surfaces that any mesher takes, and truths in closed form."""

from functools import cache

import numpy as np
import pytest

from benchmarks import phantoms
from benchmarks.phantoms import Phantom, vascular_tree
from benchmarks.phantoms.axis import planar_axis
from benchmarks.phantoms.field import TubeField, TubeUnion
from benchmarks.phantoms.junction import branching_tube
from benchmarks.phantoms.tree import NARROWER, ROOT_RADIUS
from SDFStentLib.certificate import check_surface, self_intersecting_triangles
from SDFStentLib.geometry import signed_volume
from SDFStentLib.validation import InputError
from SDFStentLib.vessel import find_lesions

EDGE_LENGTH = {
    "straight_tube": 0.8,
    "stenosed_tube": 0.8,
    "bent_tube": 0.8,
    "helix_tube": 0.8,
    "hairpin_tube": 0.8,
    "arch_with_coarctation": 1.0,
    "branching_pulmonary_artery": 0.9,
    "tube_with_neighbor": 0.8,
}
NAMES = list(EDGE_LENGTH)
HARDER = ("branching_pulmonary_artery", "tube_with_neighbor", "hairpin_tube")
SWEPT = [name for name in NAMES if name != "branching_pulmonary_artery"]


@cache
def phantom(name: str) -> Phantom:
    return getattr(phantoms, name)()


def nearest_on_axis(
    vessel: phantoms.TrueVessel, points: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Arc length of the nearest axis point and the distance to it, on a fine sampling."""
    from scipy.spatial import KDTree

    samples = vessel.axis.sampled(0.002)
    distance, index = KDTree(vessel.axis.point(samples)).query(points)
    return samples[index], distance


def wall_points(made: Phantom, face_id: int = 1) -> np.ndarray:
    return made.points[np.unique(made.triangles[made.face_ids == face_id])]


@pytest.mark.parametrize("name", NAMES)
def test_meshlab_finds_no_self_intersection(name: str) -> None:
    pymeshlab = pytest.importorskip("pymeshlab")
    made = phantom(name)
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(made.points, made.triangles.astype(np.int32)))
    meshes.compute_selection_by_self_intersections_per_face()
    flagged = meshes.current_mesh().face_selection_array()
    # In a flat cap that lies in no coordinate plane, its test of two triangles has nothing but
    # rounding errors to go by. A cap through the wall would flag the wall, too, and a cap that
    # overlaps itself would have too large an area (tested below).
    trusted = made.face_ids == 1 if name == "helix_tube" else np.ones(len(flagged), dtype=bool)
    assert not flagged[trusted].any()
    assert len(self_intersecting_triangles(made.points, made.triangles)) == 0
    measures = meshes.get_topological_measures()
    assert measures["is_mesh_two_manifold"]
    assert measures["boundary_edges"] == 0


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=() if name in HARDER else pytest.mark.bench) for name in NAMES],
)
def test_tetgen_meshes_a_phantom_and_keeps_its_surface(name: str) -> None:
    tetgen = pytest.importorskip("tetgen")
    made = phantom(name)
    mesher = tetgen.TetGen(made.points, made.triangles.astype(np.int32))
    nodes, elements = mesher.tetrahedralize(switches="pq1.4Y")[:2]
    # Y forbids points on the surface: the given points come first, unchanged.
    np.testing.assert_array_equal(nodes[: len(made.points)], made.points)
    edges = nodes[elements[:, 1:]] - nodes[elements[:, :1]]
    volume = np.abs(np.linalg.det(edges)).sum() / 6
    # The tetrahedra fill the surface: sums of 1e4 terms, rounding only.
    assert volume == pytest.approx(signed_volume(made.points, made.triangles), rel=1e-9)


@pytest.mark.parametrize("name", SWEPT)
def test_wall_points_lie_at_the_closed_form_radius_from_the_axis(name: str) -> None:
    made = phantom(name)
    for number, vessel in enumerate(made.vessels):
        at, distance = nearest_on_axis(vessel, wall_points(made, 3 * number + 1))
        # The samples are 0.002 mm apart: (0.001)^2 / 2 r and 0.001 of the radius' slope (< 0.8).
        np.testing.assert_allclose(distance, made.vessels[number].radius(at), atol=1e-3)


@pytest.mark.parametrize("name", NAMES)
def test_the_centerline_lies_on_the_exact_axes(name: str) -> None:
    made = phantom(name)
    distance = np.min(
        [nearest_on_axis(vessel, made.centerline.points)[1] for vessel in made.vessels], axis=0
    )
    assert distance.max() <= 1e-3  # half the spacing of the samples
    child = np.flatnonzero(made.centerline.parent >= 0)
    steps = made.centerline.points[child] - made.centerline.points[made.centerline.parent[child]]
    assert np.linalg.norm(steps, axis=1).max() < 0.5 + 1e-9


def test_a_vessel_too_thin_for_the_edges_is_refused() -> None:
    axes = [
        planar_axis([(30.0, 0.0)]),
        planar_axis([(12.0, 0.0)], start=(0, 0, 15), heading=(1, 0, 0), toward=(0, 1, 0)),
    ]
    thin = [TubeField(axis, lambda at: np.full(np.shape(at), 0.35)) for axis in axes]
    with pytest.raises(InputError, match="edge_length: 1 mm is too long for the narrowest places"):
        branching_tube(TubeUnion(thin, blend_width=0.2, beyond=4.0), 1.0)


# The synthetic tree: sound, divided as it says, with the lesions that it was given only.

LESIONS = {0: 0.5, 1: 0.3, 4: 0.6, 8: 0.4, 14: 0.5}


@cache
def tree(diseased=False):
    return vascular_tree(8, 0.8, LESIONS) if diseased else vascular_tree(8, 1.0)


def test_a_tree_of_eight_outlets_is_sound_and_has_its_openings():
    made = tree()
    assert len(made.vessels) == 15
    check = check_surface(made.surface)
    assert check.passed
    assert check.is_watertight
    assert [opening.name == "inlet" for opening in made.openings] == [True] + 8 * [False]
    for opening in made.openings:
        cap = made.points[made.triangles[made.face_ids == opening.face_id]]
        np.testing.assert_allclose((cap - opening.center) @ opening.outward, 0, atol=1e-9)
        away = np.linalg.norm(cap - opening.center, axis=2)
        assert away.max() == pytest.approx(opening.radius, abs=1e-9)
    assert made.openings[-1].radius == pytest.approx(ROOT_RADIUS * NARROWER**3)
    # Less than the straight tubes alone, which overlap at every division.
    tubes = sum(np.pi * v.radius(np.zeros(1))[0] ** 2 * v.axis.length for v in made.vessels)
    assert 0.85 * tubes < signed_volume(made.points, made.triangles) < tubes


def test_meshlab_finds_no_self_intersection_in_its_wall():
    pymeshlab = pytest.importorskip("pymeshlab")
    made = tree()
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(made.points, made.triangles.astype(np.int32)))
    meshes.compute_selection_by_self_intersections_per_face()
    # Its test has only rounding to go by in flat caps that lie in no coordinate plane.
    assert not meshes.current_mesh().face_selection_array()[made.face_ids == 1].any()


def test_all_lesions_of_a_tree_are_found_and_none_is_invented():
    assert find_lesions(tree().surface, tree().centerline) == ()
    made = tree(diseased=True)
    found = list(find_lesions(made.surface, made.centerline))
    assert len(found) == len(LESIONS)
    for number, depth in LESIONS.items():
        axis = made.vessels[number].axis
        away = [np.linalg.norm(one.point - axis.point(axis.length / 2)[0]) for one in found]
        lesion = found[int(np.argmin(away))]
        assert min(away) < 0.5
        # Facets of 0.8 mm cut into a throat of 2.5 mm.
        assert lesion.percent_diameter == pytest.approx(100 * depth, abs=3)
