"""The points of a sweep: what every parameter is, sample by sample."""

from __future__ import annotations

import itertools
import math
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..validation import InputError
from .axes import Axis, Value
from .value import MOST_SAMPLES, Sampling

Parameters = dict[str, Value]
"""Of one sample, by the name of the axis."""


def samples(axes: tuple[Axis, ...], sampling: Sampling) -> list[Parameters]:
    """The samples in order; the same axes, method, count and seed give the same ones.

    A random or Sobol sweep of more samples begins with those of fewer; a Latin hypercube does not.

    Raises
    ------
    InputError
        A grid of more than `MOST_SAMPLES`.
    """
    if sampling.method == "grid":
        return _grid(axes)
    shares = _shares(sampling, len(axes))
    columns = [axis.at(shares[:, at]) for at, axis in enumerate(axes)]
    names = [axis.name for axis in axes]
    return [dict(zip(names, row, strict=True)) for row in zip(*columns, strict=True)]


def _grid(axes: tuple[Axis, ...]) -> list[Parameters]:
    count = math.prod(len(axis.values) for axis in axes)
    if count > MOST_SAMPLES:
        raise InputError(f"axes: expected at most {MOST_SAMPLES} points of the grid, got {count}.")
    names = [axis.name for axis in axes]
    rows = itertools.product(*(axis.values for axis in axes))
    return [dict(zip(names, row, strict=True)) for row in rows]


def _shares(sampling: Sampling, width: int) -> NDArray[np.float64]:
    """(n, width) in [0, 1)."""
    generator = np.random.default_rng(sampling.seed)
    if sampling.method == "random":
        return generator.random((sampling.count, width))
    # Late: scipy.stats costs more to import than most sweeps to write down.
    from scipy.stats import qmc

    kind = qmc.Sobol if sampling.method == "sobol" else qmc.LatinHypercube
    with warnings.catch_warnings():
        # Sobol's points are best in powers of two; any number of them is still a good spread.
        warnings.filterwarnings("ignore", "The balance properties", UserWarning)
        found: NDArray[np.float64] = _engine(kind, width, generator).random(sampling.count)
    return found


def _engine(kind: Callable[..., Any], width: int, generator: np.random.Generator) -> Any:
    """The generator was called `seed` up to SciPy 1.14."""
    try:
        return kind(width, rng=generator)
    except TypeError:
        return kind(width, seed=generator)
