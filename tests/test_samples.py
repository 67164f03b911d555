"""The sample vessels are what their phantoms are."""

import numpy as np
import pytest

from benchmarks import phantoms
from SDFStentLib.cli.demo import STENT_ENDS
from SDFStentLib.files import read_centerline, read_surface
from SDFStentLib.geometry import SurfaceIndex
from SDFStentLib.samples import NAMES, sample

ROUNDING = 1e-12
"""Some units in the last place of 100 mm, mm."""


@pytest.mark.parametrize("name", NAMES)
def test_a_sample_is_its_phantom(name):
    """But for last digits of sines, which processors round differently, and what these decide."""
    made = getattr(phantoms, name)()
    wall = read_surface(sample(name).surface)
    # Of two diagonals of one length either may be taken, and numbers follow from that.
    assert wall.triangles.shape == made.triangles.shape
    for one, other in ((wall, made), (made, wall)):
        away = SurfaceIndex(one.points, one.triangles).distances(other.points).distance
        assert away.max() < ROUNDING
    assert np.array_equal(wall.faces.ids, made.face_ids)
    assert wall.faces.names == made.faces.names
    assert wall.frame == "RAS"
    line = read_centerline(sample(name).centerline)
    assert np.array_equal(line.parent, made.centerline.parent)
    for part in ("points", "inscribed_radius"):
        away = getattr(line, part) - getattr(made.centerline, part)
        assert np.abs(away).max() < ROUNDING


def test_the_stent_of_the_demo_lies_on_the_axis():
    made = phantoms.branching_pulmonary_artery()
    assert np.array_equal(made.axis_at((26.0, 37.0)), STENT_ENDS)
