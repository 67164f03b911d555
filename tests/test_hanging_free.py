"""A stent that hangs free is warned of, by the free share of its circumference."""

import numpy as np
import pytest

from benchmarks.phantoms import stenosed_tube, straight_tube
from SDFStentLib.stent import AtCenter, Stent
from SDFStentLib.treatment import Treatment


def kinds(result):
    return [caution.kind for caution in result.warnings]


def treated(phantom, diameter, length, place):
    stent = Stent(diameter, placement=AtCenter(place), length=length)
    return Treatment(phantom.surface, [stent], phantom.centerline).result


@pytest.mark.parametrize("share", [0.5, 0.8, 0.9, 1.0, 1.1])
def test_in_a_tube_it_hangs_free_by_its_gap(share):
    phantom = straight_tube(radius=5.0)
    result = treated(phantom, share * 10.0, 12.0, phantom.centerline.points.mean(axis=0))
    apposition = result.stents[0].apposition
    hangs = (1 - share) * 5.0 > 0.3  # a strut's thickness
    assert ("hangs-free" in kinds(result)) == hangs
    assert apposition.hanging_length == pytest.approx(apposition.length if hangs else 0.0)
    if hangs:
        (told,) = [one for one in result.warnings if one.kind == "hangs-free"]
        assert f"over {apposition.length:.1f} of its {apposition.length:.1f} mm" in str(told)
        assert "no source says" in str(told)


@pytest.mark.parametrize("diameter", [5.2, 6.5, 7.4, 8.2, 9.0])
@pytest.mark.parametrize("length", [8.0, 14.0, 24.0])
def test_in_a_narrowing_it_hangs_free_beyond_where_the_wall_leaves_it(diameter, length):
    phantom = stenosed_tube(radius=5.0, throat_radius=2.5, stenosis_length=20.0)
    middle = phantom.centerline.points.mean(axis=0)
    result = treated(phantom, diameter, length, middle)
    apposition = result.stents[0].apposition
    # The wall's own radius by the formula of the phantom; where it is less the stent pushes it out.
    at = abs(apposition.arc_length - apposition.length / 2)
    wall = np.where(at < 10.0, 5.0 - 1.25 * (1 + np.cos(np.pi * np.minimum(at, 10.0) / 10.0)), 5.0)
    part = (wall > diameter / 2 + 0.3).mean()
    assert apposition.hanging_length / apposition.length == pytest.approx(part, abs=0.12)
    if abs(part - 1 / 3) > 0.12:
        assert ("hangs-free" in kinds(result)) == (part > 1 / 3)
