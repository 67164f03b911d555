"""The number of random cases that a test tries."""

import pytest


def seeds(few: int, count: int) -> list:
    """A few seeds for `make test`, and `count` for `make bench`."""
    more = (pytest.param(seed, marks=pytest.mark.bench) for seed in range(few, count))
    return [*range(few), *more]
