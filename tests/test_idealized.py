"""Idealized tubes, a few of the bench: none refused, every narrowing told once and as it is."""

import sys

import numpy as np
import pytest
from child_processes import PROJECT
from seeds import seeds

sys.path.insert(0, str(PROJECT))

from benchmarks.idealized import NEAR, WAYS, DrawnTube, TubeNarrowing, _tube, judged, of_seed, table
from SDFStentLib.files import check_same_space
from SDFStentLib.vessel import find_lesions


@pytest.mark.parametrize("number", seeds(2 * len(WAYS), 60))
def test_the_narrowings_of_a_random_tube_are_told_once_and_as_they_are(number):
    row = judged(20261128, number)
    assert not row.is_wrong, row


def a_tube(way, bell, *, capped, sides=40, line_from=0.0):
    """A tube of 5 mm and 60 mm along z, bent like a wave in a plane or straight, at its middle."""
    z = np.linspace(0, 60, 241)
    axis = np.stack([way * np.sin(z / 12), 0 * z, z], axis=1)
    along = np.r_[0, np.cumsum(np.linalg.norm(np.diff(axis, axis=0), axis=1))]
    width, depth = bell
    radius = 2.5 * (1 - depth * np.exp(-(((z - 30) / width) ** 2)))
    points, triangles, is_cap = _tube(axis, radius, sides, capped)
    line = axis[round(4 * line_from) :]
    one = TubeNarrowing(float(np.interp(30, z, along)), width, depth)
    known = np.full(len(line), np.nan)
    return DrawnTube("", axis, along, points, triangles, is_cap, line, known, (one,))


@pytest.mark.parametrize("capped", [True, False], ids=["capped", "open"])
@pytest.mark.parametrize("width", [4.0, 7.5, 8.0, 8.5])
@pytest.mark.parametrize(("way", "depth"), [(0.0, 0.88), (3.0, 0.7), (3.0, 0.88)])
def test_no_cap_and_no_fan_hides_a_tight_narrowing(way, depth, width, capped):
    """Its line goes from cap to cap: the place on the cap answered for all, or every ray met a
    middle of a fan."""
    tube = a_tube(way, (width, depth), capped=capped)
    assert check_same_space(tube.surface, tube.line) == ()
    (lesion,) = find_lesions(tube.surface, tube.centerline)
    assert lesion.percent_diameter == pytest.approx(tube.degrees()[0], abs=NEAR)
    assert lesion.percent_diameter == pytest.approx(100 * depth, abs=NEAR)
    assert np.linalg.norm(np.subtract(lesion.point, tube.axis[120])) < 0.5


@pytest.mark.parametrize("depth", [0.4, 0.6, 0.85])
@pytest.mark.parametrize("width", [9.0, 10.0])
def test_a_gradual_narrowing_is_not_measured_against_its_own_flank(width, depth):
    """Where its slope was just too steep for healthy vessel, what lay within counted as healthy."""
    tube = a_tube(0.0, (width, depth), capped=True)
    (lesion,) = find_lesions(tube.surface, tube.centerline)
    assert lesion.percent_diameter == pytest.approx(100 * depth, abs=NEAR)


@pytest.mark.bench
def test_the_bench_counts_what_is_wrong():
    found = of_seed(1, 5)
    assert (found["tubes"], found["refused"], found["missed"], found["apart"]) == (5, 0, 0, 0)
    assert len(table(found).splitlines()) == 3
