"""Pressure drops, against the formulas integrated by hand and the one case with a solver."""

import numpy as np
import pytest
from scipy.integrate import quad

from SDFStentLib.measure import Blood, DiameterProfile, pressure_band, vessel_block
from SDFStentLib.validation import InputError

MMHG = 133.322


def profile(diameter, length, equivalent=None, count=401):
    """Of a diameter that is a function of the position, mm."""
    x = np.linspace(0.0, length, count)
    inscribed = np.vectorize(diameter, otypes=[float])(x)
    wide = inscribed if equivalent is None else np.vectorize(equivalent, otypes=[float])(x)
    return DiameterProfile(x, np.zeros((count, 3)), inscribed, wide)


def throat(healthy, narrow, length):
    """A smooth narrowing in the middle of a vessel."""
    return lambda x: healthy - (healthy - narrow) * np.sin(np.pi * x / length) ** 2


def by_quadrature(diameter, length, flow, blood):
    """Poiseuille and Young-Tsai, mmHg, by adaptive quadrature in SI units."""
    area = lambda x: np.pi / 4 * (1e-3 * diameter(1e3 * x)) ** 2  # noqa: E731
    q = 1e-6 * flow
    along = 8 * np.pi * blood.viscosity * q * quad(lambda x: area(x) ** -2, 0, 1e-3 * length)[0]
    healthy, narrow = area(0.0), area(0.5e-3 * length)
    behind = 1.52 * blood.density / (2 * healthy**2) * (healthy / narrow - 1) ** 2 * q**2
    return (along + behind) / MMHG


@pytest.mark.parametrize("flow", [4.15, 8.3, 200.0])
@pytest.mark.parametrize(("healthy", "narrow"), [(16.0, 8.0), (6.0, 2.6), (7.0, 6.9)])
def test_the_closed_form_is_that_of_an_adaptive_quadrature(healthy, narrow, flow):
    blood = Blood(1050.0, 0.0035)
    diameter = throat(healthy, narrow, 30.0)
    line = profile(diameter, 30.0)
    block = vessel_block(line.arc_length, line.inscribed_diameter, blood)
    q = 1e-6 * flow
    drop = (block.resistance + block.stenosis * q) * q / MMHG
    assert drop == pytest.approx(by_quadrature(diameter, 30.0, flow, blood), rel=1e-3)


def test_the_loss_behind_a_coarctation_is_that_of_the_published_example():
    """16 to 8 mm at 200 mL/s: 53.8 mmHg behind the throat, 63.3 by 4 v^2 (domain facts, 3.6)."""
    line = profile(throat(16.0, 8.0, 15.0), 15.0)
    block = vessel_block(line.arc_length, line.inscribed_diameter)
    assert block.stenosis * (200e-6) ** 2 / MMHG == pytest.approx(53.8, abs=0.1)
    band = pressure_band(line, 200.0)
    assert band.high == pytest.approx(1.66 * 63.3, rel=2e-3)
    assert band.low < 55.3 < band.high


def test_a_tube_has_the_resistance_of_poiseuille_and_the_inertance_of_its_blood():
    block = vessel_block(np.linspace(0, 26.0, 27), np.full(27, 6.0))
    radius, length = 3e-3, 26e-3
    assert block.resistance == pytest.approx(8 * 0.004 * length / (np.pi * radius**4), rel=1e-12)
    assert block.inertance == pytest.approx(1060 * length / (np.pi * radius**2), rel=1e-12)
    assert block.stenosis == 0.0


@pytest.mark.parametrize(
    ("forms", "solver", "is_narrowed"),
    [
        ((12.5, 7.5, 9.4), 13.1, True),
        ((3.8, 2.3, 2.4), 3.5, True),
        ((0.30, 0.25, 0.44), 1.02, False),
        ((0.14, 0.12, 0.11), 0.30, False),
    ],
)
def test_the_band_holds_what_the_solver_gave(forms, solver, is_narrowed):
    """The left pulmonary artery that was compared with a solver (domain facts, 3.7)."""
    from SDFStentLib.measure.pressure import band_of

    low, high = band_of(forms, is_narrowed=is_narrowed)
    assert low < solver < high


def test_widening_lowers_the_band_and_a_stented_tube_has_the_wider_one():
    before = pressure_band(profile(throat(7.0, 3.0, 26.0), 26.0), 8.0)
    after = pressure_band(profile(lambda x: 7.0, 26.0), 8.0)
    assert after.high < before.low
    assert after.high / after.low > before.high / before.low


def test_equivalent_diameters_give_the_low_end_where_the_lumen_is_not_round():
    narrow, wide = throat(8.0, 3.0, 20.0), throat(8.0, 4.5, 20.0)
    band = pressure_band(profile(narrow, 20.0, wide), 10.0)
    assert band.low <= by_quadrature(wide, 20.0, 10.0, Blood()) * 1.001
    assert band.high >= by_quadrature(narrow, 20.0, 10.0, Blood())


@pytest.mark.parametrize("flow", [0.0, -3.0, float("nan"), float("inf"), "fast"])
def test_a_flow_that_is_none_is_refused(flow):
    with pytest.raises(InputError, match="flow"):
        pressure_band(profile(lambda x: 6.0, 20.0), flow)


def test_a_stretch_with_unknown_diameters_is_refused():
    line = profile(lambda x: float("nan") if x > 15 else 6.0, 20.0)
    with pytest.raises(InputError, match="some are not known"):
        pressure_band(line, 5.0)
