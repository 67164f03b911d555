"""The preview on a proxy against the full preview, and its lumen against the full measurement."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from benchmarks import phantoms
from SDFStentLib.centerline import Centerline
from SDFStentLib.deformation import DeploymentSettings, Proxy, deploy
from SDFStentLib.geometry import Line, Surface, dot, face_normals
from SDFStentLib.lumen import diameter_profile, rough_radii
from SDFStentLib.plan import read_input_files
from SDFStentLib.stent import AlongAxis, AtCenter, Stent
from SDFStentLib.treatment import Preview, TreatedStent, Treatment
from SDFStentLib.validation import DeploymentError, InputError
from SDFStentLib.vessel import find_lesions, lesions_after, lesions_within

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
def test_the_preview_is_near_the_full_one_in_anatomies(sweep, data_dir, name):
    vessel = sweep.vessel(name, data_dir)
    for number in range(4):
        stent = sweep.random_stent(name, 12, number, (1.05, 1.6), data_dir)
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


@pytest.mark.parametrize("name", ["su0243", "tree_narrowed"])
def test_what_a_preview_leaves_of_a_lesion_is_near_the_measured_one(data_dir, name):
    files = (data_dir / f"{name}_{kind}_mm.vtp" for kind in ("surface", "centerline"))
    vessel = read_input_files(*map(str, files)).vessel
    preview, settings = Preview(vessel.surface, vessel.centerline), DeploymentSettings()
    random = np.random.default_rng(3)
    large = [one for one in vessel.lesions if one.reference_diameter > 3]
    for _ in range(4):  # some shorter than the lesion, some beside its middle, some too narrow
        lesion = large[random.integers(len(large))]
        (place,) = lesion.line.at([random.uniform(0.1, 0.9) * lesion.line.length])
        diameter = lesion.reference_diameter * random.uniform(0.6, 1.3)
        stent = Stent(diameter, placement=AtCenter(place), length=random.uniform(6, 30))
        state = preview.of([stent])
        (axis,) = (one.axis.line for one in state.stents)
        (told,) = state.numbers(vessel.lesions)
        covered = lesions_within(vessel.lesions, axis)
        if not covered:
            assert told.lesion is None
            assert np.isnan(told.left)
            continue
        assert told.lesion.percent_diameter == max(one.percent_diameter for one in covered)
        in_vessels = {one.vessel for one in covered}
        there = [one for one in vessel.lesions if one.vessel in in_vessels]
        full = deploy(vessel.surface, settings.chain(axis), diameter / 2, settings).surface
        left = max(one.percent_diameter for one in lesions_after(there, full))
        assert told.left == pytest.approx(left, abs=5)


@pytest.mark.parametrize("name", ["su0243", "tree_narrowed"])
def test_a_preview_tells_how_many_branches_a_moved_stent_covers(data_dir, name):
    files = (data_dir / f"{name}_{kind}_mm.vtp" for kind in ("surface", "centerline"))
    vessel = read_input_files(*map(str, files)).vessel
    preview, random = Preview(vessel.surface, vessel.centerline), np.random.default_rng(3)
    lesion = max(vessel.lesions, key=lambda one: one.healthy.max())
    diameter, middle = 0.9 * lesion.reference_diameter, lesion.line.length / 2

    def planned(place: np.ndarray, length: float) -> list[Stent]:
        return [Stent(diameter, placement=AtCenter(place), length=length)]

    def treated(stents: list[Stent]) -> TreatedStent:
        treatment = Treatment(vessel.surface, stents, vessel.centerline)
        list(treatment)
        return treatment.result.stents[0]

    last = treated(planned(lesion.line.at([middle])[0], 20))
    covered = [sum(not one.is_free for one in last.branches)]
    for _ in range(3):
        middle = last.way.before + last.way.stent_length / 2 + random.uniform(-8, 8)
        stents = planned(last.way.line.at([middle])[0], random.uniform(14, 24))
        (told,) = preview.of(stents).numbers(measured=[last])
        covered.append(sum(not one.is_free for one in treated(stents).branches))
        assert told.covered[0] == covered[0]
        assert told.covered[1] == pytest.approx(covered[-1], abs=1)
    assert len({*covered}) > 1
    far = last.way.points[0 if last.way.before > last.way.after else -1]
    (told,) = preview.of(planned(far, 12)).numbers(measured=[last])
    assert told.covered is None  # so far away nobody has looked for branches


def test_a_proxy_too_coarse_for_a_lumen_tells_nothing_of_it():
    phantom = fine_tube()
    (lesion,) = find_lesions(phantom.surface, phantom.centerline)
    state = Preview(phantom.surface, phantom.centerline).of(
        [Stent(5.0, placement=AtCenter(lesion.point), length=12)]
    )
    one = state.stents[0]
    coarse = replace(one, state=one.state._replace(spacing=9.0))
    (told,) = replace(state, stents=(coarse,)).numbers([lesion])
    assert np.isnan([told.lumen, told.left]).all()


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


def test_a_previewed_lumen_is_that_of_the_stent():
    phantom = fine_tube()
    one = Preview(phantom.surface, phantom.centerline).of(two_stents(phantom.centerline)).stents[0]
    assert one.minimum_lumen() == pytest.approx(7.2, rel=0.03)
