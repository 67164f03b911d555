"""Arithmetic on rows of vectors."""

from __future__ import annotations

import os

import numpy as np
import pytest
from child_processes import python

from SDFStentLib.__main__ import ONE_THREAD
from SDFStentLib.geometry import product


@pytest.mark.parametrize(
    "shape", [(0, 3, 4), (4, 3, 0), (1, 5, 70_000), (70_000, 3, 40), (9, 5, 9)]
)
def test_a_product_in_blocks_is_the_product(shape):
    rows, inner, columns = shape
    random = np.random.default_rng(0)
    left, right = random.normal(size=(rows, inner)), random.normal(size=(inner, columns))
    np.testing.assert_allclose(product(left, right), left @ right, atol=1e-12)
    vector = random.normal(size=inner)
    np.testing.assert_allclose(product(left, vector), left @ vector, atol=1e-12)


@pytest.mark.parametrize("wanted", [None])
def test_the_command_line_computes_with_one_thread_unless_told_otherwise(wanted):
    script = f"""
import os, sys
from SDFStentLib.__main__ import main
assert "numpy" not in sys.modules
sys.argv = ["sdfstent", "--version"]
main()
print([os.environ[name] for name in {ONE_THREAD}])
"""
    clean = {name: value for name, value in os.environ.items() if name not in ONE_THREAD}
    environment = clean if wanted is None else {**clean, ONE_THREAD[0]: wanted}
    said = python(script, env=environment).stdout
    assert str([wanted or "1", "1", "1"]) in said
