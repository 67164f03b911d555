"""How many ends a vessel has, on surfaces of which that is known as they were made."""

import numpy as np
import pytest
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkFiltersCore import vtkMarchingCubes, vtkQuadricDecimation

from benchmarks.phantoms import branching_pulmonary_artery
from benchmarks.sweep import vessel as anatomy
from SDFStentLib.files import polydata_from_arrays
from SDFStentLib.geometry import Surface
from SDFStentLib.lumen import caps_of, flat_caps
from SDFStentLib.lumen.spheres import LocalSurface, index_within
from SDFStentLib.vessel import vessel_ends

SEEDS = range(4)

PULMONARY = branching_pulmonary_artery()


def a_prism(random, closed=(True, True), refined=None):
    """A vessel of few sides along an arc or a line, of any proportions and subdivision.

    Its caps are fans; each side of every ring may be cut into several triangles in one plane.
    """
    sides, radius = int(random.integers(3, 12)), random.uniform(1, 12)
    length = radius * random.uniform(6, 25)
    rings, cuts = int(random.integers(2, 40)), refined or int(random.integers(1, 4))
    bend = random.choice([0.0, random.uniform(0.1, 1.5)])
    at, angle = np.linspace(0, 1, rings), 2 * np.pi * np.arange(sides) / sides
    corner = radius * np.column_stack([np.cos(angle), np.sin(angle)])
    share = np.arange(cuts)[:, None] / cuts
    outline = np.concatenate(
        [one + share * (two - one) for one, two in zip(corner, np.roll(corner, -1, 0), strict=True)]
    )
    places = []
    for turn in bend * at:
        if bend:
            reach = length / bend
            middle = np.array([reach * (1 - np.cos(turn)), 0, reach * np.sin(turn)])
        else:
            middle = np.array([0, 0, length * at[len(places)]])
        side = np.array([np.cos(turn), 0, -np.sin(turn)])
        places.append(middle + outline[:, :1] * side + outline[:, 1:] * [0, 1, 0])
    count = len(outline)
    ring = np.arange(count)
    faces = []
    for base in range(0, count * (rings - 1), count):
        a, b = base + ring, base + np.roll(ring, -1)
        faces += [np.column_stack([a, b, b + count]), np.column_stack([a, b + count, a + count])]
    points = np.concatenate([*places, [places[0].mean(0)], [places[-1].mean(0)]])
    last = count * (rings - 1)
    fans = [
        np.column_stack([np.roll(ring, -1), ring, np.full(count, len(points) - 2)]),
        np.column_stack([last + ring, last + np.roll(ring, -1), np.full(count, len(points) - 1)]),
    ]
    faces += [fan for fan, is_closed in zip(fans, closed, strict=True) if is_closed]
    turned = np.linalg.qr(random.normal(size=(3, 3)))[0]
    used, numbers = np.unique(np.concatenate(faces), return_inverse=True)
    return Surface((points @ turned.T)[used], numbers.reshape(-1, 3))


@pytest.mark.parametrize("seed", SEEDS)
def test_a_vessel_of_few_sides_has_two_ends_closed_or_open(seed):
    random = np.random.default_rng(seed)
    for _ in range(12):
        closed = tuple(random.random(2) < 0.6)
        surface = a_prism(random, closed)
        assert len(vessel_ends(surface)) == 2
        assert len(caps_of(surface)) == sum(closed)


@pytest.mark.parametrize("seed", SEEDS)
def test_ends_are_the_same_by_the_wall_near_them_and_by_an_index_of_all(seed):
    random = np.random.default_rng(seed)
    for surface in (a_prism(random), a_prism(random, refined=4), PULMONARY.surface):
        near, whole = (Surface(surface.points, surface.triangles) for _ in range(2))
        kept = LocalSurface.of(whole, whole.points).index
        index, numbers = index_within(whole, whole.points[:1], np.ones(1))
        assert index is kept
        assert len(numbers) == len(whole.triangles)
        found, expected = caps_of(near), caps_of(whole)
        assert len(found) == len(expected) > 0
        for one, other in zip(found, expected, strict=True):
            np.testing.assert_array_equal(one.faces, other.faces)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_hole_in_the_wall_is_no_end(seed):
    random = np.random.default_rng(seed)
    triangles = PULMONARY.triangles
    wall = np.flatnonzero(PULMONARY.face_ids == PULMONARY.face_ids.min())
    left = np.setdiff1d(np.arange(len(triangles)), random.choice(wall, 3, replace=False))
    assert len(vessel_ends(Surface(PULMONARY.points, triangles[left]))) == 3


def contoured(values, spacing, level=0.5):
    """Marching cubes (VTK) of voxels (nx, ny, nz): slivers and steps as a segmentation has them."""
    image = vtkImageData()
    image.SetDimensions(*values.shape)
    image.SetSpacing(spacing, spacing, spacing)
    image.GetPointData().SetScalars(numpy_to_vtk(values.ravel(order="F"), deep=True))
    contour = vtkMarchingCubes()
    contour.SetInputData(image)
    contour.SetValue(0, level)
    contour.Update()
    return as_arrays(contour.GetOutput())


def as_arrays(data):
    points = vtk_to_numpy(data.GetPoints().GetData()).astype(float)
    return Surface(points, vtk_to_numpy(data.GetPolys().GetConnectivityArray()).reshape(-1, 3))


@pytest.mark.parametrize("seed", SEEDS)
def test_the_steps_of_a_segmentation_are_no_ends(seed):
    """A label of two limbs, each round at its tip: a flat spot may close a tip, nothing else."""
    random = np.random.default_rng(seed)
    places = np.stack(np.meshgrid(*[np.arange(44.0)] * 3, indexing="ij"), axis=-1)
    label, spacing = np.zeros(places.shape[:3]), random.uniform(0.4, 2)
    start, tips = random.uniform(18, 26, 3), []
    for radius in random.uniform(3, 7, 2):
        stop = random.uniform(9, 35, 3)
        for place in start + np.linspace(0, 1, 60)[:, None] * (stop - start):
            label[((places - place) ** 2).sum(-1) < radius**2] = 1
        tips += [(start, radius), (stop, radius)]
    surface = contoured(label, spacing)
    assert len(flat_caps(surface.points, surface.triangles)) > 5
    for end in vessel_ends(surface):
        center = end.center / spacing
        assert min(np.linalg.norm(center - tip) / radius for tip, radius in tips) < 1.35


def decimated(surface, share):
    """A surface of which a share of the triangles is taken away, by quadrics."""
    lesser = vtkQuadricDecimation()
    lesser.SetInputData(polydata_from_arrays(surface.points, surface.triangles))
    lesser.SetTargetReduction(share)
    lesser.Update()
    return as_arrays(lesser.GetOutput())


@pytest.mark.parametrize("share", [0.5, 0.8, 0.9])
def test_a_vessel_with_few_faces_left_has_its_ends(share):
    """The caps have few faces, the wall has flat spots."""
    ends = vessel_ends(decimated(PULMONARY, share))
    assert len(ends) == 3
    for known in PULMONARY.openings:
        away = min(np.linalg.norm(end.center - known.center) for end in ends)
        assert away < 0.6 * known.radius


@pytest.mark.parametrize("share", [0.5, 0.8, 0.9, 0.95])
@pytest.mark.parametrize("name", ["aorta_iliac", "pulmonary"])
def test_a_patient_with_few_faces_left_has_its_ends(name, share):
    """Decimation tilts the faces of a cap against each other, by some degrees."""
    assert len(vessel_ends(decimated(anatomy(name).surface, share))) == 3
