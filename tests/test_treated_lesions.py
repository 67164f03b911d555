"""Lesions beside a treatment stay what they are, and are not measured again."""

from __future__ import annotations

import numpy as np
import pytest

from SDFStentLib.deformation import DeploymentSettings
from SDFStentLib.lumen import inscribed_spheres
from SDFStentLib.phantoms import stenosed_tube, vascular_tree
from SDFStentLib.stent import AtCenter, Stent
from SDFStentLib.treatment import Residual, Treatment, residual_of, treated_lesions
from SDFStentLib.vessel import find_lesions


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


@pytest.mark.parametrize(("shift", "side"), [(-4.0, "distal"), (4.0, "proximal"), (0.0, "within")])
def test_what_is_left_is_the_narrowest_place_of_the_vessel_wherever_it_lies(shift, side):
    """By another way: spheres along the whole tube, against its 6 mm."""
    made = stenosed_tube(edge_length=0.5, length=60.0)
    lesions = find_lesions(made.surface, made.centerline)
    length = 12.0 if shift else 30.0
    stent = Stent(5.4, placement=AtCenter((0, 0, 30 + shift)), length=length)
    result = Treatment(
        made.surface, [stent], made.centerline, DeploymentSettings(certify=False)
    ).result
    left = residual_of(treated_lesions(lesions, result.stents, result.surface), result.stents)
    line = made.axis_at(np.linspace(5, 55, 501))
    widths = 2 * inscribed_spheres(result.surface.points, made.triangles, line).radii
    assert left.minimum == pytest.approx(widths.min(), abs=0.01)
    assert left.percent == pytest.approx(100 * (1 - widths.min() / 6), abs=1)
    assert left.side == side
    axis = result.stents[0].axis.points[:, 2]
    away = max(left.point[2] - axis.max(), axis.min() - left.point[2], 0)
    assert left.distance == pytest.approx(away, abs=0.2)


@pytest.mark.parametrize(
    ("side", "distance", "said"),
    [
        ("proximal", 0.03, "just before stent 1"),
        ("distal", 1.2, "1 mm beyond stent 1"),
        ("between", 0.4, "between stents, just beyond stent 1"),
        ("within", 0.0, "within stent 1"),
    ],
)
def test_where_the_narrowest_place_left_lies_is_told_without_a_distance_of_nothing(
    side, distance, said
):
    assert Residual(20.0, 4.0, 5.0, (0, 0, 0), 1, side, 1, distance).place() == said
