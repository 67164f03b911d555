"""The smooth minimum of the published method: a minimum whose gradient has no jump.

Source: SDFStent, arXiv 2605.22009, section 2.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..validation import Floats


class SmoothMinimum(NamedTuple):
    """Value of a smooth minimum and the share of the first argument in its gradient."""

    value: Floats
    share: Floats


def smooth_minimum(first: Floats, second: Floats, smoothing_width: float) -> SmoothMinimum:
    """Quadratic smooth minimum of two distances.

    Parameters
    ----------
    first, second : arrays of one shape
        Distances, mm.
    smoothing_width : float
        k of the paper, mm; 0 gives the hard minimum.

    Returns
    -------
    SmoothMinimum
        `value`, `min(a, b) - max(k - |a - b|, 0)^2 / (4 k)`, at most k/4 below the smaller
        argument, and `share` s in [0, 1]: the gradient is `s grad first + (1 - s) grad second`.
    """
    if smoothing_width == 0:
        share = (first <= second).astype(np.float64)
        return SmoothMinimum(np.minimum(first, second), share)
    share = np.clip(0.5 + (second - first) / (2 * smoothing_width), 0, 1)
    overlap = np.maximum(smoothing_width - np.abs(second - first), 0)
    return SmoothMinimum(np.minimum(first, second) - overlap**2 / (4 * smoothing_width), share)
