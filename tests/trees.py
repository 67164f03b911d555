"""Centerlines that the tests make by hand, and phantoms with branches."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.phantoms import (
    arch_with_coarctation,
    branching_pulmonary_artery,
    cavopulmonary_connection,
    vascular_tree,
)
from SDFStentLib.centerline import Centerline

in_each_tree = pytest.mark.parametrize(
    "phantom",
    [
        arch_with_coarctation(),
        branching_pulmonary_artery(),
        cavopulmonary_connection(),
        vascular_tree(16),
    ],
    ids=lambda phantom: phantom.name,
)
"""Runs a test with each phantom that has branches."""


def unbranched(points, inscribed_radius=None) -> Centerline:
    """The centerline along a curve; its first point is the root."""
    radius = np.full(len(points), np.nan) if inscribed_radius is None else inscribed_radius
    return Centerline(points, radius, np.arange(len(points)) - 1)


def with_radius(tree: Centerline, inscribed_radius) -> Centerline:
    """The same tree with other radii, one per point."""
    return replace(tree, inscribed_radius=inscribed_radius)
