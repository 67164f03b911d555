"""The synthetic tree: sound, divided as it says, with the lesions that it was given only."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from SDFStentLib.certificate import check_surface
from SDFStentLib.geometry import signed_volume
from SDFStentLib.phantoms import vascular_tree
from SDFStentLib.phantoms.tree import NARROWER, ROOT_RADIUS
from SDFStentLib.vessel import find_lesions

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
