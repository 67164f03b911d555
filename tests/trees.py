"""Centerlines that the tests make by hand."""

from dataclasses import replace

import numpy as np

from SDFStentLib.centerline import Centerline


def unbranched(points, inscribed_radius=None) -> Centerline:
    """The centerline along a curve; its first point is the root."""
    radius = np.full(len(points), np.nan) if inscribed_radius is None else inscribed_radius
    return Centerline(points, radius, np.arange(len(points)) - 1)


def with_radius(tree: Centerline, inscribed_radius) -> Centerline:
    """The same tree with other radii, one per point."""
    return replace(tree, inscribed_radius=inscribed_radius)
