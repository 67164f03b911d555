"""Other tissue gaps are tried where untangling fails, unless that is hopeless."""

from __future__ import annotations

import importlib.util

import numpy as np
import pytest
from deployment_cases import phantom
from mesh_files import PROJECT

from SDFStentLib import deployment as engine
from SDFStentLib.deployment import RETRIES, Deployment
from SDFStentLib.settings import DeploymentSettings


@pytest.fixture
def attempts(monkeypatch):
    """Every attempt that a deployment makes."""
    made = []
    plain = engine.Attempt

    def recorded(*arguments):
        made.append(plain(*arguments))
        return made[-1]

    monkeypatch.setattr(engine, "Attempt", recorded)
    return made


def test_another_gap_saves_a_stent_that_untangling_does_not(data_dir, attempts):
    spec = importlib.util.spec_from_file_location("sweep", PROJECT / "benchmarks" / "sweep.py")
    sweep = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(sweep)
    stent = sweep.random_stent("aorta_iliac", 5, 24, (1.6, 2.6), data_dir)
    _, result = sweep.deployed(stent, DeploymentSettings(), data_dir)
    assert result.certificate.passed
    assert 1 < len(attempts) <= 1 + len(RETRIES)


@pytest.mark.parametrize(("longest", "expected"), [(np.inf, 1 + len(RETRIES)), (0.0, 1)])
def test_no_other_gap_is_tried_when_a_long_fold_is_left(attempts, monkeypatch, longest, expected):
    monkeypatch.setattr(engine, "HOPELESS_FOLD", longest)
    made = phantom("hairpin_tube", edge_length=1.5)
    length = made.vessels[0].axis.length
    axis = made.axis_at(np.linspace(10, length - 10, 200))
    run = Deployment(made.points, made.triangles, axis, 5.0)
    assert not run.result.certificate.passed
    assert len(attempts) == expected
