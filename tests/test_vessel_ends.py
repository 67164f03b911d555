"""Ends of a vessel from its wall alone, against phantoms whose ends are known."""

import numpy as np
import pytest
from trees import unbranched

from SDFStentLib.files import read_surface
from SDFStentLib.geometry import Surface, signed_volume
from SDFStentLib.phantoms import arch_with_coarctation, branching_pulmonary_artery, straight_tube
from SDFStentLib.validation import InputError
from SDFStentLib.vessel import ends_without_line, line_seeds, vessel_ends

PULMONARY = branching_pulmonary_artery()


def openings(phantom):
    """Center and radius of every end, the largest first, from how the phantom was made."""
    found = [(opening.center, opening.radius) for opening in phantom.openings]
    return sorted(found, key=lambda opening: -opening[1])


def without_caps(phantom):
    """The wall alone: SimVascular's face id 1 is the wall, the others are caps."""
    return Surface(phantom.points, phantom.triangles[phantom.face_ids == phantom.face_ids.min()])


@pytest.mark.parametrize("is_open", [False, True], ids=["capped", "open"])
@pytest.mark.parametrize(
    "phantom",
    [PULMONARY, straight_tube(), arch_with_coarctation()],
    ids=["pulmonary", "tube", "arch"],
)
def test_every_end_of_a_phantom_is_found_where_it_was_made(phantom, is_open):
    surface = without_caps(phantom) if is_open else phantom.surface
    ends = vessel_ends(surface)
    centers = np.array([center for center, _ in openings(phantom)])
    assert len(ends) == len(centers)
    for end in ends:
        away = np.linalg.norm(centers - end.center, axis=1)
        nearest = openings(phantom)[int(np.argmin(away))]
        assert away.min() < 0.05
        # A polygon of the edge length of the mesh lies inside of the circle.
        assert 0.95 * nearest[1] < end.radius <= 1.001 * nearest[1]
        assert bool(len(end.faces)) != is_open
    assert [end.radius for end in ends] == sorted((end.radius for end in ends), reverse=True)


def test_the_closed_surface_has_the_volume_of_the_vessel_and_its_ends_as_points():
    seeds = line_seeds(without_caps(PULMONARY))
    assert seeds.surface.topology.is_watertight
    assert seeds.surface.topology.is_consistently_wound
    volume = signed_volume(seeds.surface.points, seeds.surface.triangles)
    assert volume == pytest.approx(signed_volume(PULMONARY.points, PULMONARY.triangles), rel=1e-9)
    largest = vessel_ends(PULMONARY.surface)[0]
    assert np.allclose(seeds.surface.points[seeds.inlet], largest.center)
    assert len(seeds.outlets) == 2


@pytest.mark.parametrize(
    ("file", "units", "radii"),
    [
        ("pulmonary_surface_cm", "cm", (9.3, 2.6, 2.4)),
        ("aorta_iliac_surface_cm", "cm", (12.1, 5.6, 5.0)),
    ],
)
def test_the_caps_of_an_anatomy_are_its_model_faces(data_dir, file, units, radii):
    """SimVascular gives every cap a face id; the wall has the largest."""
    from vtkmodules.util.numpy_support import vtk_to_numpy

    read = read_surface(data_dir / f"{file}.vtp", units)
    ids = vtk_to_numpy(read.polydata().GetCellData().GetArray("ModelFaceID"))
    ends = vessel_ends(read.surface)
    assert [end.radius for end in ends] == pytest.approx(radii, abs=0.06)
    for end in ends:
        (own,) = np.unique(ids[end.faces])
        assert np.array_equal(np.flatnonzero(ids == own), end.faces)


def test_the_rounded_ends_of_an_anatomy_have_to_be_named(data_dir):
    surface = read_surface(data_dir / "vmtk_aorta_surface_mm.vtp").surface
    assert vessel_ends(surface) == []
    with pytest.raises(InputError, match="name the inlet and every outlet"):
        line_seeds(surface)
    top, bottom = surface.points[[10, 2000]]
    seeds = line_seeds(surface, top, [bottom])
    assert (seeds.inlet, seeds.outlets) == (10, (2000,))
    assert np.array_equal(seeds.surface.points, surface.points)


@pytest.mark.parametrize(
    ("places", "words"),
    [
        (([0.0, 0.0, 500.0],), "inlet: expected a place within 10 mm of the surface"),
        ((None, [[0.0, 0.0, 500.0]]), "outlet 1: expected a place within 10 mm of the surface"),
        ((None, [[0.0, 0.0, 40.0], [0.0, 0.1, 40.0]]), "each to be named once"),
        (([0.0, 0.0, float("nan")],), "inlet"),
    ],
)
def test_a_place_that_names_no_end_is_refused(places, words):
    with pytest.raises(InputError, match=words):
        line_seeds(straight_tube().surface, *places)


def test_a_vessel_with_one_flat_end_needs_an_outlet():
    tube = straight_tube()
    is_cap = np.isin(
        np.arange(len(tube.points)), tube.triangles[tube.face_ids == tube.face_ids.max()]
    )
    rounded = tube.points.copy()
    height = np.sqrt(np.maximum(0.0, 9.0 - rounded[:, 0] ** 2 - rounded[:, 1] ** 2))
    rounded[is_cap, 2] += height[is_cap]
    with pytest.raises(InputError, match="found one; name an outlet"):
        line_seeds(Surface(rounded, tube.triangles))


@pytest.mark.parametrize(("aside", "without"), [(0.0, 0), (0.8, 0), (2.5, 2)])
def test_a_line_that_goes_on_beyond_an_end_leads_there(aside, without):
    """As of a surface that was cut shorter than its centerline; one beside the vessel does not."""
    tube = straight_tube()
    start, stop = tube.centerline.points[[0, -1]]
    line = np.linspace(1.2 * start - 0.2 * stop, 1.2 * stop - 0.2 * start, 80)
    line[:, 0] += aside * openings(tube)[0][1]
    assert ends_without_line(vessel_ends(tube.surface), unbranched(line)) == without
