"""The sample vessels are what their phantoms are, to the bit."""

import numpy as np
import pytest

from benchmarks import phantoms
from SDFStentLib.cli.demo import STENT_ENDS
from SDFStentLib.files import read_centerline, read_surface
from SDFStentLib.samples import NAMES, sample


@pytest.mark.parametrize("name", NAMES)
def test_a_sample_is_its_phantom_to_the_bit(name):
    made = getattr(phantoms, name)()
    wall = read_surface(sample(name).surface)
    assert np.array_equal(wall.points, made.points)
    assert np.array_equal(wall.triangles, made.triangles)
    assert np.array_equal(wall.faces.ids, made.face_ids)
    assert wall.faces.names == made.faces.names
    assert wall.frame == "RAS"
    line = read_centerline(sample(name).centerline)
    for part in ("points", "parent", "inscribed_radius"):
        assert np.array_equal(getattr(line, part), getattr(made.centerline, part))


def test_the_stent_of_the_demo_lies_on_the_axis():
    made = phantoms.branching_pulmonary_artery()
    assert np.array_equal(made.axis_at((26.0, 37.0)), STENT_ENDS)
