"""A treatment that is told how the triangles hang together looks no further and gives the same."""

import numpy as np
import pytest

from SDFStentLib.geometry.topology import surface_topology
from SDFStentLib.phantoms.phantoms import branching_pulmonary_artery
from SDFStentLib.stent.placement import AtCenter
from SDFStentLib.stent.stent import Stent
from SDFStentLib.treatment import treatment as treatment_module
from SDFStentLib.treatment.treatment import Treatment


@pytest.fixture(scope="module")
def arguments():
    vessel = branching_pulmonary_artery()
    stents = [
        Stent(diameter, placement=AtCenter(vessel.throat.point), length=12.0)
        for diameter in (7.0, 8.0)
    ]
    return vessel.points, vessel.triangles, stents, vessel.centerline


def test_a_known_topology_is_used_and_changes_nothing(arguments, monkeypatch):
    expected = Treatment(*arguments).result
    topology = surface_topology(arguments[1])

    def refuse(_triangles):
        raise AssertionError("looked at again")

    monkeypatch.setattr(treatment_module, "surface_topology", refuse)
    result = Treatment(*arguments, topology=topology).result
    np.testing.assert_array_equal(result.points, expected.points)
    assert result.certificate.topology == expected.certificate.topology == topology
    assert result.certificate.sentence() == expected.certificate.sentence()
