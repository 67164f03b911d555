"""A surface is checked once and its topology looked at once, whatever a command does with it."""

import sys

import numpy as np
import pytest

from SDFStentLib import AtCenter, Stent, Surface, Treatment, validation
from SDFStentLib.cli import main
from SDFStentLib.files import (
    add_arrays,
    encode_vtp,
    polydata_from_arrays,
    polydata_from_lines,
    read_surface,
)
from SDFStentLib.geometry import topology
from SDFStentLib.phantoms import stenosed_tube


@pytest.fixture(scope="module")
def vessel():
    return stenosed_tube(edge_length=1.0)


@pytest.fixture
def looks(monkeypatch):
    """Shapes of the arrays that are checked and of the triangles whose topology is looked at."""
    seen = {"as_points": [], "as_triangles": [], "surface_topology": []}
    for name in seen:
        plain = getattr(validation, name, None) or getattr(topology, name)

        def counted(values, *others, _plain=plain, _name=name, **named):
            seen[_name].append(np.shape(values))
            return _plain(values, *others, **named)

        for module in list(sys.modules.values()):
            if getattr(module, "__name__", "").startswith("SDFStentLib"):
                for key, value in list(vars(module).items()):
                    if value is plain:
                        monkeypatch.setattr(module, key, counted)
    return seen


@pytest.fixture
def files(vessel, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    tree = vessel.centerline
    surface = polydata_from_arrays(vessel.points, vessel.triangles)
    line = polydata_from_lines(tree.points, [np.arange(len(tree.points))])
    add_arrays(line, {"MaximumInscribedSphereRadius": tree.inscribed_radius}, {})
    (tmp_path / "tube.vtp").write_bytes(encode_vtp(surface))
    (tmp_path / "line.vtp").write_bytes(encode_vtp(line))
    return tmp_path


def test_a_deploy_command_checks_its_surface_once(files, vessel, looks):
    place = ["--centerline", "line.vtp", "--center", "0", "0", "20", "--length", "20"]
    outputs = ["-o", "out.vtp", "--report", "r.html", "--arrays", "--steps", "steps", "--quiet"]
    assert main(["deploy", "tube.vtp", "--diameter", "6", *place, *outputs]) == 0
    assert looks["surface_topology"] == [vessel.triangles.shape]
    assert looks["as_triangles"] == [vessel.triangles.shape]
    # The input's points, and those of the result.
    assert looks["as_points"].count(vessel.points.shape) == 2
    moved = (read_surface("out.vtp").points != vessel.points).any(axis=1)
    assert 100 < np.count_nonzero(moved) < len(moved)  # so that none was taken for all


def test_many_treatments_of_a_surface_look_at_it_once(vessel, looks):
    surface = Surface(vessel.points, vessel.triangles)
    for diameter in (5.0, 6.0):
        stent = Stent(diameter, placement=AtCenter(vessel.throat.point), length=12.0)
        result = Treatment(surface, [stent, stent], vessel.centerline).result
        assert result.certificate.topology is surface.topology
    assert looks["surface_topology"] == [vessel.triangles.shape]
    assert looks["as_triangles"] == [vessel.triangles.shape]
