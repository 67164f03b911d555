"""The smooth minimum and the profiles, against their closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracle import PlainField, fall_off, smin

from SDFStentLib.deformation import BLENDS, FALLOFFS
from SDFStentLib.geometry import smooth_minimum

DISTANCE = st.floats(-20, 20, allow_nan=False)
WIDTH = st.floats(0.01, 3)
ROUNDING = 1e-12  # mm: a few operations on numbers below 20


def pair(first, second):
    return np.array([first], dtype=float), np.array([second], dtype=float)


@settings(max_examples=100, deadline=None, derandomize=True)
@given(DISTANCE, DISTANCE, st.one_of(st.just(0.0), WIDTH))
def test_the_smooth_minimum_is_the_papers_kernel_form_with_its_chain_rule(first, second, k):
    a, b = pair(first, second)
    along_first, along_second = np.array([[1.0, 0, 0]]), np.array([[0.0, 1, 0]])
    plain = smin(PlainField(a, along_first), PlainField(b, along_second), k)
    value, share = smooth_minimum(a, b, k)
    assert value[0] == pytest.approx(plain.distance[0], abs=ROUNDING)
    gradient = share[0] * along_first[0] + (1 - share[0]) * along_second[0]
    np.testing.assert_allclose(gradient, plain.gradient[0], atol=1e-10)


def test_without_width_it_is_the_hard_minimum_and_the_first_of_equals_wins():
    value, share = smooth_minimum(np.array([1.0, 2, 5]), np.array([2.0, 2, 3]), 0)
    assert value.tolist() == [1, 2, 3]
    assert share.tolist() == [1, 1, 0]


@pytest.mark.parametrize("name", [*FALLOFFS, *BLENDS])
def test_every_profile_falls_monotonically_from_one_to_zero(name):
    profile = {**FALLOFFS, **BLENDS}[name]
    values = profile(np.linspace(0, 1, 1001))
    # One rounding of a sum of terms near 1.
    assert values[0] == pytest.approx(1, abs=1e-15)
    assert values[-1] == pytest.approx(0, abs=1e-15)
    assert (np.diff(values) < 1e-15).all()


def test_the_default_fall_off_is_the_papers():
    distance = np.linspace(-2, 9, 200)
    weight = FALLOFFS["compact"](np.clip(distance / 6.5, 0, 1))
    np.testing.assert_allclose(weight, fall_off(distance, 6.5), atol=1e-15)
