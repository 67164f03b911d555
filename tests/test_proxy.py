"""The preview on a proxy against the full preview, and its lumen against the full measurement."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from SDFStentLib import phantoms
from SDFStentLib.centerline import Centerline
from SDFStentLib.deformation import DeploymentSettings, Proxy, deploy
from SDFStentLib.geometry import Line, Surface, dot, face_normals
from SDFStentLib.lumen import diameter_profile, rough_radii
from SDFStentLib.stent import AlongAxis, AtCenter, Stent
from SDFStentLib.treatment import Preview, Treatment
from SDFStentLib.validation import DeploymentError, InputError

PREVIEW = DeploymentSettings.preview()

FARTHEST = 1.2
"""Distance of a vertex to where the full preview puts it, over the spacing of the proxy."""

FAR = 0.65
"""The same of 99 of 100 vertices that move."""


class Found:
    """A stent by proxy and in full."""

    def __init__(self, surface: Surface, axis: np.ndarray, radius: float, inside=None) -> None:
        self.chain = PREVIEW.chain(axis)
        self.seen = Proxy(surface, inside).deployed(self.chain, radius)
        full = deploy(surface, self.chain, radius, PREVIEW).points
        shown = self.seen.state.applied_to(surface.points)
        has_moved = (full != surface.points).any(axis=1)
        self.distance = np.linalg.norm(shown - full, axis=1)
        self.largest = self.distance.max()
        self.most = np.percentile(self.distance[has_moved], 99)
        normals = [face_normals(p, surface.triangles) for p in (surface.points, full, shown)]
        self.turned = int((dot(normals[1], normals[2]) < 0).sum())
        self.turned_in_full = int((dot(normals[0], normals[1]) < 0).sum())


@cache
def fine_tube() -> phantoms.Phantom:
    return phantoms.stenosed_tube(3.0, 1.8, 40, 0.3)


def half_way(phantom: phantoms.Phantom, length: float) -> np.ndarray:
    """A stent's axis in the middle of a phantom."""
    line = phantom.centerline
    middle = float(line.arc_length.max()) / 2
    return phantom.axis_at(np.linspace(middle - length / 2, middle + length / 2, 60))


@pytest.mark.parametrize(
    ("make", "numbers", "radius"),
    [
        (phantoms.straight_tube, {"radius": 3.0, "length": 40}, 4.0),
        (phantoms.bent_tube, {"radius": 3.0, "bend_radius": 15, "angle_deg": 90}, 4.0),
        (phantoms.helix_tube, {"radius": 3.0}, 4.0),
        (phantoms.stenosed_tube, {"radius": 3.0, "throat_radius": 1.8, "length": 40}, 3.6),
        (phantoms.branching_pulmonary_artery, {"edge_length": 0.5}, 6.0),
        (phantoms.tube_with_neighbor, {}, 3.6),
    ],
)
def test_the_preview_is_near_the_full_one_in_phantoms(make, numbers, radius):
    phantom = make(**{"edge_length": 0.3, **numbers})
    found = Found(phantom.surface, half_way(phantom, 14), radius, phantom.centerline.points)
    assert found.seen.spacing > 0  # a sample, not all vertices
    assert found.largest <= FARTHEST * found.seen.spacing
    assert found.most <= FAR * found.seen.spacing
    assert found.turned == 0


ANATOMIES = (
    "vmtk_aorta",
    *(pytest.param(name, marks=pytest.mark.bench) for name in ("aorta_iliac", "pulmonary")),
)


@pytest.mark.parametrize("name", ANATOMIES)
@pytest.mark.parametrize("ratios", [(1.05, 1.6)])
def test_the_preview_is_near_the_full_one_in_anatomies(sweep, data_dir, name, ratios):
    vessel = sweep.vessel(name, data_dir)
    for number in range(4):
        stent = sweep.random_stent(name, 12, number, ratios, data_dir)
        found = Found(vessel.surface, stent.axis, stent.radius, vessel.centerline.points)
        spacing = max(found.seen.spacing, 0.25)  # of a proxy of all vertices only steps are longer
        assert found.largest <= FARTHEST * spacing
        assert found.most <= FAR * spacing
        # The full preview is not untangled either: faces that it turns over may turn here as well.
        assert found.turned <= 0.001 * len(vessel.triangles) + found.turned_in_full


# The minimum lumen


@pytest.mark.parametrize("name", ANATOMIES)
def test_the_minimum_lumen_of_a_preview_is_near_the_measured_one(sweep, data_dir, name):
    vessel = sweep.vessel(name, data_dir)
    proxy = Proxy(vessel.surface, vessel.centerline.points)
    for number, ratios in enumerate([(0.7, 0.9), (0.9, 1.05), (1.05, 1.3), (1.3, 1.6)]):
        stent = sweep.random_stent(name, 21, number, ratios, data_dir)
        chain = PREVIEW.chain(stent.axis)
        seen = proxy.deployed(chain, stent.radius)
        stations = Line(stent.axis).resampled(1.0).points
        rough = 2 * rough_radii(seen.points, stations, seen.normals).min()
        full = deploy(vessel.surface, chain, stent.radius).surface
        assert rough == pytest.approx(diameter_profile(full, stent.axis).minimum, rel=0.03)


def test_one_center_or_no_wall_is_refused():
    with pytest.raises(InputError, match="at least 2 points, got 1"):
        rough_radii([[1, 0, 0]], [[0, 0, 0]], [[1, 0, 0]])
    with pytest.raises(InputError, match="points of the wall"):
        rough_radii(np.empty((0, 3)), [[0, 0, 0], [1, 0, 0]], np.empty((0, 3)))


# A plan's preview


def two_stents(line: Centerline) -> list[Stent]:
    places = [line.points[share * len(line.points) // 3] for share in (1, 2)]
    return [Stent(7.2, placement=AtCenter(place), length=12) for place in places]


def test_a_stent_s_error_names_it():
    phantom = fine_tube()
    far = Stent(6, placement=AlongAxis([[90, 0, 0], [99, 0, 0]]), name="far")
    with pytest.raises(DeploymentError, match=r"^Stent 2 \(far\): "):
        Preview(phantom.surface, phantom.centerline).of([*two_stents(phantom.centerline)[:1], far])


@pytest.mark.parametrize("beyond", [-0.9, 0.3, 0.7, 1.0, 9.0])
def test_a_preview_refuses_a_place_that_the_treatment_refuses_and_no_other(beyond):
    phantom = fine_tube()
    tree = phantom.centerline
    middle = len(tree.points) // 2
    across = np.cross(tree.points[middle + 1] - tree.points[middle], (0.3, 0.5, 0.8))
    place = tree.points[middle] + (1.8 + beyond) * across / np.linalg.norm(across)
    stents = [Stent(7.2, placement=AtCenter(place), length=12)]
    said = []
    for tried in (
        lambda: Treatment(phantom.surface, stents, tree),
        lambda: Preview(phantom.surface, tree).of(stents),
    ):
        try:
            tried()
        except InputError as error:
            said.append(str(error))
    assert len(said) == (2 if beyond > 0.5 else 0)  # mm; nearer is on the wall
    assert len(set(said)) <= 1
    if said and beyond < 2:  # farther out another place of the throat's wall is nearer
        assert f"and {beyond:.1f} mm outside of the wall" in said[0]


def test_a_plan_without_stents_is_refused():
    with pytest.raises(InputError, match="at least one stent"):
        Preview(fine_tube().surface).of([])


def test_a_previewed_lumen_is_that_of_the_stent():
    phantom = fine_tube()
    one = Preview(phantom.surface, phantom.centerline).of(two_stents(phantom.centerline)).stents[0]
    assert one.minimum_lumen() == pytest.approx(7.2, rel=0.03)
