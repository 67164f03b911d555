"""A deployment as a whole: states, cancelling, companions, warnings and refusals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from deployment_cases import anatomy_case, phantom, phantom_case

from SDFStentLib.deformation import Deployment, DeploymentSettings
from SDFStentLib.geometry import Precision

DEFAULT = DeploymentSettings()
PUBLISHED = DeploymentSettings.published()
both = pytest.mark.parametrize("settings", [DEFAULT, PUBLISHED], ids=["default", "published"])


@pytest.fixture(scope="module")
def case():
    return phantom_case("branching_pulmonary_artery")


def deployment_of(case, settings=DEFAULT, **others):
    return Deployment(case.surface, settings.chain(case.axis), case.radius, settings, **others)


# States -----------------------------------------------------------------------------------------


@both
def test_the_stent_grows_from_state_to_state_up_to_the_prescribed_radius(case, settings):
    states = list(deployment_of(case, settings))
    radii = np.array([state.radius for state in states])
    fractions = np.array([state.fraction for state in states])
    assert (np.diff(radii) >= 0).all()
    assert radii[-1] == case.radius
    assert (np.diff(fractions) > 0).all()
    assert fractions[0] > 0
    assert (fractions[:-1] < 1).all()
    assert fractions[-1] == 1


@both
def test_cancelling_is_to_stop_iterating(case, settings):
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


# Companions -------------------------------------------------------------------------------------


def test_companions_inside_the_expanded_stent_stay_and_others_move_with_the_wall():
    made = phantom("straight_tube", edge_length=1.0)
    axis = made.axis_at(np.linspace(12, 28, 50))
    inside = made.axis_at(np.linspace(10, 30, 21)) + np.array([1.5, 0, 0])
    outside = made.axis_at(np.array([18.0, 20, 22])) + np.array([4.5, 0, 0])
    far = made.axis_at(np.array([20.0])) + np.array([60.0, 0, 0])
    companions = np.concatenate([inside, outside, far])
    run = Deployment(made.surface, DEFAULT.chain(axis), 3.8, DEFAULT, companions=companions)
    after = run.result.state.companions
    np.testing.assert_array_equal(after[:21], inside)
    np.testing.assert_array_equal(after[24], far[0])
    pushed = after[21:24] - outside
    assert (pushed[:, 0] > 0.2).all()
    np.testing.assert_allclose(pushed[:, 1:], 0, atol=0.05)


@pytest.mark.parametrize("name", ["pulmonary", "vmtk_aorta"])
def test_companions_do_not_change_what_the_wall_does_in_an_anatomy(data_dir, name):
    case = anatomy_case(data_dir, name, 20.0, 25.0)
    np.testing.assert_array_equal(
        deployment_of(case, companions=case.points + 0.3).result.points,
        deployment_of(case).result.points,
    )


# The certificate --------------------------------------------------------------------------------


def test_the_certificate_is_about_the_points_that_are_returned(case):
    from SDFStentLib.certificate import certify

    result = deployment_of(case, precision=Precision(np.float32, 0.1)).result
    again = certify(case.surface, result.points, precision=Precision(np.float32, 0.1))
    # What is about the stent is known to the deployment only.
    of_surface = replace(result.certificate, motion=(), lumen=())
    assert of_surface.as_dict() == again.as_dict()
    assert result.certificate.passed


# What is stented --------------------------------------------------------------------------------


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


def test_the_crimped_stent_never_starts_beyond_the_wall(case):
    """A start beyond the wall would jump; the default and a hundred times as much agree."""
    wide = deployment_of(case, PUBLISHED.with_changes(crimped_radius=40.0))
    narrow = deployment_of(case, PUBLISHED.with_changes(crimped_radius=0.4))
    nearest = wide.chain.field(case.points).distance.min()
    assert next(iter(wide)).radius < nearest + 0.3
    # Euler steps begin at other radii: their own error.
    apart = np.linalg.norm(wide.result.points - narrow.result.points, axis=1)
    assert apart.max() < 0.2


# Refusals ---------------------------------------------------------------------------------------
