"""A deployment as a whole: states, cancelling, companions and the gap."""

from __future__ import annotations

import numpy as np
import pytest
from deployment_cases import anatomy_case, phantom_case

from SDFStentLib.deformation import Deployment, DeploymentSettings

DEFAULT = DeploymentSettings()
PUBLISHED = DeploymentSettings.published()
both = pytest.mark.parametrize("settings", [DEFAULT, PUBLISHED], ids=["default", "published"])


@pytest.fixture(scope="module")
def case():
    return phantom_case("branching_pulmonary_artery")


def deployment_of(case, settings=DEFAULT, **others):
    return Deployment(case.surface, settings.chain(case.axis), case.radius, settings, **others)


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
