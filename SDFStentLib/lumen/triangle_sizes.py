"""How large triangles are, and how thin."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..validation import Floats, Points, Triangles


class TriangleSizes(NamedTuple):
    """Of triangles (m,): their sides (m, 3), mm, and their smallest angles (m,), degrees."""

    edge_length: Floats
    smallest_angle: Floats


def triangle_sizes(points: Points, triangles: Triangles) -> TriangleSizes:
    """Sides and smallest angle of every triangle; the angle at a repeated corner is 0.

    Parameters
    ----------
    points, triangles : (n, 3) and (m, 3) arrays
        mm.
    """
    corners = points[triangles]
    sides = np.roll(corners, -1, axis=1) - corners
    lengths = np.linalg.norm(sides, axis=2)
    along = -np.einsum("fsx,fsx->fs", sides, np.roll(sides, 1, axis=1))
    product = lengths * np.roll(lengths, 1, axis=1)
    cosine = np.divide(along, product, out=np.ones_like(along), where=product > 0)
    angles = np.degrees(np.arccos(np.clip(cosine, -1, 1)))
    return TriangleSizes(lengths, angles.min(axis=1))
