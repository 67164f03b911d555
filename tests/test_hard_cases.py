"""Vessels and stents as nobody would draw them: certified, or refused with the place named."""

import re

import numpy as np
import pytest
from deployment_cases import phantom
from mesh_files import open_tube
from scipy.spatial import KDTree

from benchmarks import phantoms
from SDFStentLib.deformation import DeploymentSettings
from SDFStentLib.field import CapsuleChain
from SDFStentLib.geometry import Surface
from SDFStentLib.lumen import inscribed_spheres
from SDFStentLib.stent import AlongAxis, AtCenter, Stent
from SDFStentLib.treatment import Treatment

SETTINGS = DeploymentSettings()


def along(axis, diameter):
    return Stent(diameter, placement=AlongAxis(axis))


def treated(points, triangles, *stents, centerline=None):
    """The finished treatment, after what holds for every one of them has been asserted."""
    result = Treatment(Surface(points, triangles), stents, centerline).result
    assert result.points.shape == points.shape
    assert np.isfinite(result.points).all()
    assert result.certificate.passed or " near (" in result.certificate.sentence()
    for sentence in [result.certificate.sentence(), *map(str, result.warnings)]:
        assert "nan" not in sentence.lower()
        assert sentence.endswith(".")

    beyond = np.ones(len(points), dtype=bool)
    for stent in result.stents:
        reach = stent.stent.radius + SETTINGS.influence_distance + SETTINGS.tissue_gap
        beyond &= CapsuleChain.along(stent.axis.points).axis_distance(points) > reach
    np.testing.assert_array_equal(result.points[beyond], points[beyond])
    untouched = np.setdiff1d(np.arange(len(points)), result.indices)
    assert result.points[untouched].tobytes() == points[untouched].tobytes()
    return result


def seam_width(before, after):
    """How far points that lay on each other lie apart, at most."""
    pairs = KDTree(before).query_pairs(1e-9, output_type="ndarray")
    return np.linalg.norm(after[pairs[:, 0]] - after[pairs[:, 1]], axis=1).max()


def a_stenosis():
    return phantom("stenosed_tube", edge_length=0.8)


def its_stent(tube, offset=(0.0, 0.0, 0.0)):
    return along(tube.axis_at(np.linspace(10, 30, 100)) + offset, 6.0)


# What the vessel meets ----------------------------------------------------------------------------


@pytest.mark.parametrize(("diameter", "swept_walls"), [(14.0, 1), (23.6, 2)])
def test_a_neighbor_swept_by_a_stent_is_crushed_without_a_crossing(diameter, swept_walls):
    made = phantom("tube_with_neighbor")
    axis = made.axis_at(np.linspace(10, 30, 100))
    radius = diameter / 2
    beside = (made.points[:, 0] > 4.0) & (np.abs(made.points[:, 2] - 20) < 6)
    near, far = made.points[beside, 0].min(), made.points[beside, 0].max()
    assert sum(wall < radius for wall in (near, far)) == swept_walls
    result = treated(made.points, made.triangles, along(axis, diameter))
    assert result.certificate.passed
    away = CapsuleChain.along(axis).axis_distance(result.points)
    # Tissue stays between the lumens.
    assert away[beside].min() > radius + 0.3
    # Facets of 0.8 mm, stretched up to fourfold as the circle is: the same share of it.
    assert result.stents[0].after.minimum == pytest.approx(diameter, rel=0.005)
    assert result.stents[0].after.maximum == pytest.approx(diameter, rel=0.005)


def test_a_stent_over_the_rim_of_an_open_vessel_widens_the_rim():
    points, triangles = open_tube(radius=3.0, length=30.0, around=24, along=40)
    result = treated(points, triangles, along([[0.0, 0, 20], [0, 0, 36]], 7.2))
    assert result.certificate.passed
    assert "open (48 boundary edges), as it was" in result.certificate.sentence()
    rim = points[:, 2] > 29.9
    # The lumen of a 24-sided ring has the prescribed radius, so its corners lie beyond it.
    away = np.linalg.norm(result.points[rim, :2], axis=1)
    assert away.min() > 3.6 - 1e-4
    assert away.max() < 3.6 / np.cos(np.pi / 24) + 0.01
    # Where the stent is outside, there is no lumen to measure, and that is said.
    assert any(caution.kind == "no-inscribed-diameter" for caution in result.warnings)


# What the axis does -------------------------------------------------------------------------------


def test_a_hairpin_stent_wider_than_its_legs_are_apart_is_not_certified_and_says_where():
    made = phantom("hairpin_tube", edge_length=1.5)
    length = made.vessels[0].axis.length
    axis = made.axis_at(np.linspace(10, length - 10, 200))
    result = treated(made.points, made.triangles, along(axis, 10.0))
    assert not result.certificate.passed
    assert "Surface not certified for meshing: it has" in result.certificate.sentence()
    # Named by a place of the vessel, where the legs press on each other.
    center = result.certificate.places[0].center
    assert CapsuleChain.along(axis).axis_distance([center])[0] < 5.0 + 1.0
    assert f"{result.certificate.places[0]}" in result.certificate.sentence()


def test_a_target_smaller_than_the_lumen_moves_nothing_bit_by_bit_and_says_so():
    made = phantom("straight_tube", edge_length=0.8)
    stent = Stent(5.0, placement=AtCenter([0.0, 0, 20]), length=20.0)
    result = treated(made.points, made.triangles, stent, centerline=made.centerline)
    assert result.points.tobytes() == made.points.tobytes()
    assert result.centerline.points.tobytes() == made.centerline.points.tobytes()
    assert len(result.indices) == 0
    assert result.certificate.passed
    moves_nothing, hangs = sorted(map(str, result.warnings))
    assert moves_nothing == (
        "Nothing moves: the stent of 5 mm is not wider than the lumen where it lies "
        "(5.9 to 6.0 mm)."
    )
    assert hangs.startswith("The stent hangs free over 18.0 of its 18.0 mm")


def test_a_stent_in_a_wider_one_names_the_lumen_that_this_one_left():
    """It named the native lumen, which both stents are wider than."""
    made = phantom("stenosed_tube", edge_length=0.8)
    stents = [Stent(d, placement=AtCenter([0.0, 0, 20]), length=12.0) for d in (6.0, 4.5)]
    result = Treatment(made.surface, stents, made.centerline).result
    (said,) = (one for one in result.warnings if one.kind == "without-effect")
    found = re.search(r"lies as the earlier stents left it \((\S+) to (\S+) mm\)", str(said))
    after = result.stents[0].after
    assert float(found.group(1)) == pytest.approx(after.minimum, abs=0.1)
    assert float(found.group(1)) > 5.5


def test_a_later_stent_that_pushes_tissue_into_an_earlier_one_is_told_of():
    made = phantom("tube_with_neighbor")
    own = made.axis_at(np.linspace(10, 30, 60))
    axes = ((6.5, own), (9.0, np.add(own, [8.0, 0, 0])))
    stents = [Stent(diameter, placement=AlongAxis(axis)) for diameter, axis in axes]
    result = Treatment(made.surface, stents).result
    (told,) = (one for one in result.warnings if one.kind == "narrowed")
    assert told.stent == 1
    before = result.stents[0].result.surface
    for name, surface in (("minimum_mm", result.surface), ("earlier_minimum_mm", before)):
        radii = inscribed_spheres(surface.points, surface.triangles, own).radii
        assert told.numbers[name] == pytest.approx(2 * radii.min(), abs=0.05)
    assert told.numbers["minimum_mm"] < 0.9 * told.numbers["earlier_minimum_mm"]


def test_an_axis_beside_the_vessel_moves_nothing_and_says_why():
    made = phantom("straight_tube", edge_length=0.8)
    # 12 mm from the vessel's axis the wall is in reach, but 5.5 mm from the stent.
    result = treated(made.points, made.triangles, along([[12.0, 0, 5], [12, 0, 30]], 7.0))
    assert result.points.tobytes() == made.points.tobytes()
    assert str(result.warnings[0]) == (
        "Nothing moves: the stent of 7 mm touches no wall, and its axis lies outside the lumen; "
        "check that surface and axis are in the same unit and frame."
    )
    assert "a stent outside of the lumen near (12.0, 0.0," in result.certificate.sentence()


# What the mesh is like ----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("edge_length", "radius", "tolerance"),
    # The coarse tube is one of nine sides: its facets, after stretching, miss by 4 % of a sagitta.
    [(0.2, 2.5, 0.005), (6.0, 8.0, 0.4)],
)
def test_edges_of_a_fifth_of_a_millimeter_or_of_six_are_stented_to_size(
    edge_length, radius, tolerance
):
    made = phantom("straight_tube", radius=radius, length=6 * radius, edge_length=edge_length)
    axis = made.axis_at([2 * radius, 4 * radius])
    result = treated(made.points, made.triangles, along(axis, 2.4 * radius))
    assert result.certificate.passed
    after = np.array(result.stents[0].after.inscribed_diameter)
    assert np.abs(after - 2.4 * radius).max() < tolerance


def test_triangles_without_area_in_a_watertight_wall_pass_or_are_named():
    """Every 37th face is cut at the middle of one side, and a flat face closes the gap."""
    tube = a_stenosis()
    points, cut = tube.points, tube.triangles[::37]
    middles = points[cut[:, :2]].mean(axis=1)
    a, b, c = cut.T
    new = len(points) + np.arange(len(cut))
    kept = np.delete(tube.triangles, np.arange(0, len(tube.triangles), 37), axis=0)
    triangles = np.concatenate(
        [kept, np.stack([a, new, c], 1), np.stack([new, b, c], 1), np.stack([a, b, new], 1)]
    )
    result = treated(np.concatenate([points, middles]), triangles, its_stent(tube))
    assert result.certificate.is_watertight
    certificate = result.certificate
    assert not certificate.passed
    places = (certificate.places or certificate.fitness.places)[:1]
    assert str(places[0]) in certificate.sentence()
    # The cut faces are as good as the whole ones.
    assert result.stents[0].after.minimum > 6.0 * 0.985


@pytest.mark.parametrize("parts", ["caps", "halves", "every triangle"])
def test_points_stored_twice_in_the_wall_stay_together(parts):
    """Programs that compute normals split a surface along its sharp edges, as those of caps."""
    tube = a_stenosis()
    halves = tube.points[tube.triangles].mean(axis=1)[:, 0] > 0
    labels = {"caps": tube.face_ids, "halves": halves, "every triangle": np.arange(len(halves))}
    points, triangles, source = split(tube, labels[parts])
    result = treated(points, triangles, its_stent(tube))
    assert result.certificate.passed or parts != "caps"
    # Torn open it would be useless, whatever the certificate of an open surface says.
    assert seam_width(points, result.points) == 0.0
    whole = treated(tube.points, tube.triangles, its_stent(tube))
    # The same but for the order of sums.
    np.testing.assert_allclose(result.points, whole.points[source], rtol=0, atol=1e-9)


def split(tube, label):
    """The surface with points of its own for every part, and which point each was."""
    points, triangles, source, count = [], [], [], 0
    for name in np.unique(label):
        used, corners = np.unique(tube.triangles[label == name], return_inverse=True)
        points.append(tube.points[used])
        triangles.append(corners.reshape(-1, 3) + count)
        source.append(used)
        count += len(used)
    return np.concatenate(points), np.concatenate(triangles), np.concatenate(source)


# A mesh too coarse for its stent is named, one that is fine enough is not.


def treated_along(made, axis, radius):
    stent = Stent(2 * radius, placement=AlongAxis(axis))
    return Treatment(made.surface, [stent]).result


def coarse_of(result):
    return [caution for caution in result.warnings if caution.kind in ("too-coarse", "narrower")]


def narrowest_share(result, radius):
    """Of the prescribed radius: each facet's distance from nodes of the axis, by dense samples."""
    weights = np.array([(i, j, 20 - i - j) for i in range(21) for j in range(21 - i)]) / 20
    corners = result.surface.points[result.surface.triangles]
    samples = np.einsum("sc,fcx->fsx", weights, corners).reshape(-1, 3)
    return KDTree(samples).query(result.stents[0].axis.points)[0].min() / radius


@pytest.mark.parametrize(("edge", "is_told"), [(0.4, False), (0.85, True)])
def test_edges_long_against_the_radius_are_told_where_the_lumen_misses_by_more_than_3_percent(
    edge, is_told
):
    radius = 4.0 * 1.15
    made = phantoms.bent_tube(4.0, 16.0, edge_length=edge * radius, leg_length=12.0)
    result = treated_along(made, made.axis_at(np.linspace(15, 29, 50)), radius)
    told = coarse_of(result)
    assert bool(told) == is_told
    assert (narrowest_share(result, radius) < 0.97) == is_told
    if is_told:
        text = str(told[0])
        found = float(re.search(r"([\d.]+) instead of", text)[1])
        assert found == pytest.approx(2 * radius * narrowest_share(result, radius), rel=0.03)
        assert f"instead of {2 * radius:.2f} mm" in text
