"""Integrals along stations and over a cycle."""

from __future__ import annotations

import numpy as np

from ..validation import Floats


def integral_to(values: Floats, x: Floats) -> Floats:
    """The integral (n,) of values (n,) from the first place to each of rising x, by trapezoids."""
    return np.concatenate([[0.0], np.cumsum((values[1:] + values[:-1]) / 2 * np.diff(x))])
