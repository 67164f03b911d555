"""Lesions beside a treatment stay what they are, and are not measured again."""

from __future__ import annotations

import numpy as np
import pytest

from SDFStentLib.deformation import DeploymentSettings
from SDFStentLib.measure import find_lesions
from SDFStentLib.phantoms.tree import vascular_tree
from SDFStentLib.stent import AtCenter, Stent
from SDFStentLib.treatment import Treatment, treated_lesions


@pytest.fixture(scope="module")
def tree_with_two_lesions():
    made = vascular_tree(6, 1.0, {0: 0.4, 5: 0.4})
    return made, find_lesions(made.surface, made.centerline)


def test_a_lesion_beside_the_stent_is_that_of_before(tree_with_two_lesions):
    made, found = tree_with_two_lesions
    assert len(found) == 2
    for treated in found:
        (other,) = (lesion for lesion in found if lesion is not treated)
        stent = Stent(treated.reference_diameter, placement=AtCenter(treated.point), length=12.0)
        result = Treatment(
            made.surface, [stent], made.centerline, DeploymentSettings(certify=False)
        ).result
        plain = treated_lesions(found, result.stents, result.surface)
        fast = treated_lesions(found, result.stents, result.surface, made.surface)
        number = found.index(other)
        assert fast[number].after is other
        for one, exact in zip(fast, plain, strict=True):
            for name in ("minimum_diameter", "percent_diameter", "minimum_area", "percent_area"):
                values = getattr(one.after, name), getattr(exact.after, name)
                assert values[0] == pytest.approx(values[1], abs=2e-3), name
            np.testing.assert_allclose(one.after.point, exact.after.point, atol=0.1)
            assert one.stents == exact.stents
        assert plain[found.index(treated)].after.percent_diameter < 10
        assert fast[found.index(treated)].after is not treated
