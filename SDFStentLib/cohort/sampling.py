"""The points of a sweep: what every parameter is, sample by sample."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..validation import InputError
from .axes import Axis, Value
from .value import MOST_SAMPLES, Sampling

Parameters = dict[str, Value]
"""Of one sample, by the name of the axis."""

_BLOCK = 4096
"""Samples made at once."""


class Samples:
    """The samples in order; the same axes, method, count and seed give the same ones.

    A random or Sobol sweep of more samples begins with those of fewer; a Latin hypercube does not.
    They are made when they are asked for: millions of them would take gigabytes.

    Raises
    ------
    InputError
        A grid of more than `MOST_SAMPLES`.
    """

    def __init__(self, axes: tuple[Axis, ...], sampling: Sampling) -> None:
        self._axes = axes
        self._shares: NDArray[np.float64] | None = None
        if sampling.method == "grid":
            self._count = math.prod(len(axis.values) for axis in axes)
            if self._count > MOST_SAMPLES:
                raise InputError(
                    f"axes: expected at most {MOST_SAMPLES} points of the grid, got {self._count}."
                )
        else:
            self._shares, self._count = _shares(sampling, len(axes)), sampling.count

    def __len__(self) -> int:
        return self._count

    def __getitem__(self, at: int) -> Parameters:
        return self._at(np.atleast_1d(range(self._count)[at]))[0]

    def __iter__(self) -> Iterator[Parameters]:
        for start in range(0, self._count, _BLOCK):
            yield from self._at(np.arange(start, min(start + _BLOCK, self._count)))

    def _at(self, places: NDArray[np.int64]) -> list[Parameters]:
        if self._shares is None:
            # The last axis is the quickest.
            digits = np.unravel_index(places, [len(axis.values) for axis in self._axes])
            columns = [
                [axis.values[digit] for digit in column.tolist()]
                for axis, column in zip(self._axes, digits, strict=True)
            ]
        else:
            columns = [axis.at(self._shares[places, at]) for at, axis in enumerate(self._axes)]
        names = [axis.name for axis in self._axes]
        return [dict(zip(names, row, strict=True)) for row in zip(*columns, strict=True)]


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
