"""Which wall is that of the stented lumen: by degrees, so that no hair's breadth decides."""

from __future__ import annotations

import numpy as np
from deployment_cases import anatomy_case
from hypothesis import given
from hypothesis import strategies as st

from SDFStentLib.deformation import DeploymentSettings, deploy
from SDFStentLib.deformation.wall_around import FOREIGN, own_share


def best_of_all_ways(count, sides, tissue, nearest):
    """By trying: the least tissue up to which vertices hang together with the nearest."""
    worst = np.full(count, np.inf)
    for limit in sorted(set(tissue[tissue < FOREIGN]), reverse=True):
        reached = {nearest}
        for _ in range(count):
            for a, b in sides:
                if tissue[a] <= limit and tissue[b] <= limit and {a, b} & reached:
                    reached |= {a, b}
        worst[list(reached)] = limit
    return 1 - np.minimum(worst / FOREIGN, 1)


@given(st.integers(0, 2**32 - 1))
def test_the_share_is_that_of_the_best_of_all_ways(seed):
    rng = np.random.default_rng(seed)
    count = 12
    sides = rng.integers(0, count, (16, 2))
    tissue = rng.choice([0, 0, 0.2 * FOREIGN, 0.7 * FOREIGN, 3 * FOREIGN], count)
    tissue[3] = 0
    expected = best_of_all_ways(count, sides, tissue, 3)
    np.testing.assert_allclose(own_share(sides, tissue, 3), expected)


def test_the_field_of_the_other_fold_draws_no_single_point_in_by_a_millimeter(data_dir):
    """A vertex whose normal hardly turns was the only bridge to others: they moved 0.96 mm."""
    case = anatomy_case(data_dir, "pulmonary", 7.1224, 29.836, radius=10.3, leaf=0)
    settings = DeploymentSettings(fold="distal")
    there, back = (
        deploy(case.surface, settings.chain(axis), case.radius, settings).points
        for axis in (case.axis, case.axis[::-1])
    )
    assert np.linalg.norm(there - back, axis=1).max() < 0.3
