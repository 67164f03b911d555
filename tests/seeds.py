"""How many random cases a test tries."""

from __future__ import annotations

import pytest


def seeds(few: int, count: int) -> list:
    """A few seeds for `make test`, and for `make bench` so many."""
    more = (pytest.param(seed, marks=pytest.mark.bench) for seed in range(few, count))
    return [*range(few), *more]
