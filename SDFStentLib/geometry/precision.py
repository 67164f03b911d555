"""The numbers that a file will hold: their type, and the unit they are in."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, DTypeLike

from ..validation import InputError, Points, as_number, as_points


class Precision(NamedTuple):
    """How coordinates will be stored: the certificate is about the stored numbers."""

    dtype: DTypeLike = np.float64
    scale: float = 1.0
    """File units per mm."""


def stored_points(points: ArrayLike, dtype: DTypeLike, scale: float) -> Points:
    """The numbers that a file of this type and unit would hold, as float64 (n, 3).

    Not to be changed: where nothing has to be converted they are the given points themselves.
    `InputError` for points not of shape (n, 3), a `dtype` that is no floating type or too narrow,
    or a `scale` not above 0.
    """
    points = as_points(points)
    scale = as_number(scale, "scale", above=0)
    kind = np.dtype(dtype)
    if kind.kind != "f":
        raise InputError(f"dtype: expected a floating type such as float32, got {kind}.")
    with np.errstate(over="ignore"):
        stored = points if scale == 1 else points * scale
        stored = stored.astype(kind, copy=False).astype(np.float64, copy=False)
    if stored is not points and not np.all(np.isfinite(stored)):
        raise InputError(
            f"points: expected coordinates that fit into {kind}, got some too large for it after "
            f"scaling by {scale:g}; store them as float64."
        )
    return stored
