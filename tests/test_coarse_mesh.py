"""A mesh too coarse for its stent is named, one that is fine enough is not."""

from __future__ import annotations

import re

import numpy as np
import pytest
from scipy.spatial import KDTree

from SDFStentLib import phantoms
from SDFStentLib.stent import AlongAxis, Stent
from SDFStentLib.treatment import Treatment


def treated(made, axis, radius):
    stent = Stent(2 * radius, placement=AlongAxis(axis))
    return Treatment(made.surface, [stent]).result


def coarse_of(result):
    return [caution for caution in result.warnings if caution.kind == "coarse-mesh"]


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
    result = treated(made, made.axis_at(np.linspace(15, 29, 50)), radius)
    told = coarse_of(result)
    assert bool(told) == is_told
    assert (narrowest_share(result, radius) < 0.97) == is_told
    if is_told:
        text = str(told[0])
        sides = result.surface.points[result.surface.triangles]
        sides = np.linalg.norm(sides - np.roll(sides, 1, axis=1), axis=2)
        stated = float(re.search(r"longer than ([\d.]+) mm", text)[1])
        assert 0.6 * radius < stated < sides.max()
        assert f"radius is {radius:g} mm" in text
        assert "at most 1.1 mm" in text
