"""What must hold for every deployment, whatever the numbers."""

from functools import cache
from itertools import product
from typing import NamedTuple

import numpy as np
import pytest
from deployment_cases import anatomy_case, phantom, phantom_case
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from SDFStentLib.deformation import Deployment, DeploymentSettings, deploy
from SDFStentLib.geometry import Line

DEFAULT = DeploymentSettings()
PUBLISHED = DeploymentSettings.published()
SETTINGS = {"default": DEFAULT, "preview": DeploymentSettings.preview(), "published": PUBLISHED}
both = pytest.mark.parametrize("name", ["default", "published"])


STENTS = {"aorta_iliac": (200.0, 36.0), "pulmonary": (12.0, 25.0), "vmtk_aorta": (20.0, 25.0)}


@pytest.fixture(scope="module")
def case():
    return phantom_case("branching_pulmonary_artery")


def deployed(case, settings, **changes):
    case = case._replace(**changes)
    return deploy(case.surface, settings.chain(case.axis), case.radius, settings).points


@cache
def plain(vessel, name, folder=None):
    """A case, and where its deployment puts the wall."""
    if vessel in STENTS:
        made = anatomy_case(folder, vessel, *STENTS[vessel])
    else:
        made = phantom_case(vessel, edge_length=0.6)._replace(radius=3.75)
    return made, deployed(made, SETTINGS[name])


class Frame(NamedTuple):
    """The same vessel and stent elsewhere, and by how many mm the wall may differ."""

    matrix: np.ndarray
    shift: np.ndarray
    way: int  # of the axis
    apart: float


STILL = np.zeros(3)
TURN = Rotation.from_rotvec(np.radians(143) * np.array([0.48, -0.6, 0.64])).as_matrix()
FAR = np.array([-190.0, 120, 60])
FRAMES = {
    "reversed": Frame(np.eye(3), STILL, -1, 0),
    # One plan in RAS and LPS is the same treatment.
    "mirrored": Frame(np.diag([-1.0, -1, 1]), STILL, 1, 0),
    # Of 80 stents at most 0.00002; 0.06 where the points' order followed that of the nodes.
    "turned and reversed": Frame(TURN, STILL, -1, 0.001),
    # Rounding of coordinates up to 300 mm; contact is a threshold of the default too.
    "far away": Frame(TURN.T, FAR, 1, 1e-4),
    "far away, as published": Frame(TURN.T, FAR, 1, 1e-9),
}
PHANTOMS = ("bent_tube", "helix_tube", "branching_pulmonary_artery", "hairpin_tube")


@pytest.mark.parametrize(
    ("frame", "vessel", "name"),
    [
        *product(["turned and reversed"], STENTS, ["default"]),
        ("reversed", "pulmonary", "preview"),
        ("reversed", PHANTOMS[3], "default"),
        ("mirrored", PHANTOMS[2], "published"),
        ("mirrored", "pulmonary", "default"),
        ("far away", PHANTOMS[2], "default"),
        ("far away, as published", PHANTOMS[2], "published"),
    ],
)
def test_where_a_vessel_lies_and_where_its_stent_begins_does_not_matter(
    request, frame, vessel, name
):
    folder = request.getfixturevalue("data_dir") if vessel in STENTS else None
    (case, wanted), (matrix, shift, way, apart) = plain(vessel, name, folder), FRAMES[frame]
    points, axis = case.points @ matrix.T + shift, case.axis[::way] @ matrix.T + shift
    found = deployed(case, SETTINGS[name], points=points, axis=axis)
    np.testing.assert_allclose((found - shift) @ matrix, wanted, rtol=0, atol=apart)


@pytest.mark.parametrize("scale", [0.5, 3.0])
def test_scaling_all_lengths_commutes_with_the_published_deployment(case, scale):
    lengths = ("influence_distance", "smoothing_width", "capsule_length", "contact_tolerance",
               "crimped_radius")  # fmt: skip
    scaled = PUBLISHED.with_changes(
        step=0.1 * scale, **{name: scale * getattr(PUBLISHED, name) for name in lengths}
    )
    result = deployed(
        case, scaled, points=scale * case.points, axis=scale * case.axis, radius=scale * case.radius
    )
    np.testing.assert_allclose(result, scale * deployed(case, PUBLISHED), rtol=0, atol=1e-8)


@both
def test_nothing_moves_beyond_the_influence_distance_bit_by_bit(case, name):
    deployment = Deployment(
        case.surface, SETTINGS[name].chain(case.axis), case.radius, SETTINGS[name]
    )
    level = deployment.chain.field(case.points).distance
    reach = deployment.target_level + deployment.settings.influence_distance
    beyond = level > reach + deployment.settings.tissue_gap
    assert 100 < beyond.sum() < len(beyond) - 100
    for state in deployment:
        assert not beyond[state.indices].any()
    np.testing.assert_array_equal(deployment.result.points[beyond], case.points[beyond])


def test_without_smoothing_the_contact_lies_at_the_hard_minimum(case):
    """k = 0: no inflation, nothing to calibrate, and the wall on the true distance at once."""
    for calibration in ("axis", "paper", "none"):
        settings = PUBLISHED.with_changes(smoothing_width=0, calibration=calibration)
        deployment = Deployment(case.surface, settings.chain(case.axis), case.radius, settings)
        assert deployment.target_level == case.radius
    points = deployment.result.points
    away = deployment.chain.axis_distance(points)
    level = deployment.chain.field(points).distance
    np.testing.assert_allclose(level, away, rtol=0, atol=1e-12)
    last_step = deployment.states[-2].radius - deployment.states[-3].radius
    assert away.min() > case.radius - last_step - 1e-9


@both
def test_a_deployment_is_deterministic_to_the_last_bit(case, name):
    first = deployed(case, SETTINGS[name])
    deployed(phantom_case("bent_tube"), SETTINGS[name])
    np.testing.assert_array_equal(deployed(case, SETTINGS[name]), first)


@both
def test_the_order_of_points_and_triangles_does_not_matter(case, name):
    rng = np.random.default_rng(5)
    order = rng.permutation(len(case.points))
    number = np.argsort(order)
    triangles = number[case.triangles][rng.permutation(len(case.triangles))]
    shuffled = deployed(case, SETTINGS[name], points=case.points[order], triangles=triangles)
    # Only sums over a vertex's faces and products of other shapes round differently.
    np.testing.assert_allclose(shuffled[number], deployed(case, SETTINGS[name]), atol=1e-7)


@pytest.mark.parametrize(
    ("vessel", "winding"),
    [
        ("branching_pulmonary_artery", "flipped"),
        ("tube_with_neighbor", "mixed"),
        ("tube_with_neighbor", "one vessel flipped"),
    ],
)
def test_the_winding_of_the_input_does_not_matter(vessel, winding):
    case = phantom_case(vessel)
    # A large stent of short influence touches the neighbor, whose side then matters.
    settings = DEFAULT.with_changes(influence_distance=1.0)
    turned = np.ones(len(case.triangles), dtype=bool)
    if winding == "mixed":
        turned = np.random.default_rng(11).random(len(turned)) < 0.3
    if winding == "one vessel flipped":
        turned = case.points[case.triangles[:, 0], 0] > 4
    wound = np.where(turned[:, None], case.triangles[:, [0, 2, 1]], case.triangles)
    # Normals are sums of other roundings.
    np.testing.assert_allclose(
        deployed(case, settings, triangles=wound, radius=5.5),
        deployed(case, settings, radius=5.5),
        rtol=0,
        atol=1e-9,
    )


@settings(max_examples=6, deadline=None, derandomize=True)
@given(
    radius=st.floats(2.0, 6.0),
    start=st.floats(3, 15),
    length=st.floats(4, 20),
    falloff=st.sampled_from(["compact", "wendland", "cosine"]),
    blend=st.sampled_from(["linear", "quadratic", "exponential"]),
)
def test_no_wall_is_left_inside_a_finished_stent(radius, start, length, falloff, blend):
    made = phantom_case("bent_tube")
    line = phantom("bent_tube", edge_length=1.0).axis_at(np.linspace(0, 40, 400))
    axis = Line(line).cut(start, start + length).points
    settings = DEFAULT.with_changes(falloff=falloff, blend=blend, untangle=False, certify=False)
    deployment = Deployment(made.surface, settings.chain(axis), radius, settings)
    away = deployment.chain.axis_distance(deployment.result.points)
    # Three rounds along the smooth field's direction, which is up to 20 degrees off the true one.
    assert away.min() > radius - 1e-3


# A deployment as a whole: states, canceling, companions and the gap.


def deployment_of(case, settings=DEFAULT, **others):
    return Deployment(case.surface, settings.chain(case.axis), case.radius, settings, **others)


@pytest.mark.parametrize("settings", [DEFAULT, PUBLISHED], ids=["default", "published"])
def test_canceling_is_to_stop_iterating(case, settings):
    deployment = deployment_of(case, settings)
    running = iter(deployment)
    for _ in range(2):
        state = next(running)
    running.close()
    assert len(deployment.states) == 2
    assert state is deployment.states[-1]
    assert state.fraction < 1
    # Nothing is left over: the result is that of a deployment that was never stopped.
    np.testing.assert_array_equal(
        deployment.result.points, deployment_of(case, settings).result.points
    )


def test_companions_do_not_change_what_the_wall_does_in_an_anatomy(data_dir):
    case = anatomy_case(data_dir, "pulmonary", 20.0, 25.0)
    np.testing.assert_array_equal(
        deployment_of(case, companions=case.points + 0.3).result.points,
        deployment_of(case).result.points,
    )


def test_the_tissue_gap_can_be_left_out():
    case = phantom_case("tube_with_neighbor")._replace(radius=5.5)
    facing = (np.abs(case.points[:, 0] - 5) < 0.1) & (np.abs(case.points[:, 2] - 20) < 8)
    distances = []
    for gap in (0.0, 0.4, 1.0):
        settings = DEFAULT.with_changes(
            tissue_gap=gap, influence_distance=1.0, facet_compensation=False, untangle=False
        )
        run = deployment_of(case, settings)
        distances.append(run.chain.axis_distance(run.result.points[facing]).min())
    assert distances[0] == pytest.approx(5.5, abs=0.02)
    assert distances[1] == pytest.approx(5.9, abs=0.05)
    assert distances[2] == pytest.approx(6.5, abs=0.05)
