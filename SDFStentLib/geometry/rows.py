"""Arithmetic on the rows of arrays (n, 3): one vector per row."""

from __future__ import annotations

import numpy as np

from ..validation import Floats


def dot(one: Floats, other: Floats) -> Floats:
    """Scalar products (n,) of the rows."""
    return np.einsum("ij,ij->i", one, other)


def norm(vectors: Floats) -> Floats:
    """Lengths (n,) of the rows."""
    return np.sqrt(dot(vectors, vectors))


def across(directions: Floats) -> Floats:
    """Two unit vectors (n, 2, 3) across every unit direction (n, 3), and across each other."""
    axis = np.eye(3)[np.abs(directions).argmin(axis=1)]
    first = np.cross(directions, axis)
    first /= np.linalg.norm(first, axis=1)[:, None]
    return np.stack([first, np.cross(directions, first)], axis=1)
