"""Other ways and other tissue gaps are tried where untangling fails, unless that is hopeless."""

from __future__ import annotations

import numpy as np
import pytest
from deployment_cases import phantom

from SDFStentLib.deformation import Deployment, DeploymentSettings, untangle
from SDFStentLib.deformation import deployment as engine
from SDFStentLib.deformation.deployment import RETRIES
from SDFStentLib.deformation.untangle import WAYS_TO_UNTANGLE
from SDFStentLib.field import CapsuleChain


@pytest.mark.parametrize(
    ("way", "stent"),
    [
        (0, ("vmtk_aorta", 101, 182, (1.05, 1.6))),
        (1, ("aorta_iliac", 7, 111, (1.05, 1.6))),
        (2, ("vmtk_aorta", 5, 41, (1.6, 2.6))),
    ],
)
def test_every_way_to_untangle_saves_a_stent_that_those_before_do_not(
    sweep, data_dir, attempts, monkeypatch, way, stent
):
    placed = sweep.random_stent(*stent, data_dir)
    monkeypatch.setattr(untangle, "WAYS_TO_UNTANGLE", WAYS_TO_UNTANGLE[:way])
    monkeypatch.setattr(engine, "RETRIES", RETRIES[: way // 2])
    _, short = sweep.deployed(placed, DeploymentSettings(), data_dir)
    assert not short.certificate.passed
    monkeypatch.setattr(untangle, "WAYS_TO_UNTANGLE", WAYS_TO_UNTANGLE[: way + 1])
    deployment, result = sweep.deployed(placed, DeploymentSettings(), data_dir)
    assert result.certificate.passed
    is_relieved = WAYS_TO_UNTANGLE[way][1]
    assert (result.relief is not None) == is_relieved
    if is_relieved:
        near = np.linalg.norm(result.points - result.relief.center, axis=1).min()
        assert near < 1
        assert 0 < result.relief.depth < 0.5
    # What untangling moves stays outside of the stent, whose level ripples by up to k / 4.
    changed = np.flatnonzero((short.points != result.points).any(axis=1))
    level = deployment.chain.field(result.points[changed]).distance
    assert level.min() > deployment.target_level - deployment.chain.smoothing_width / 4


def test_another_gap_saves_a_stent_that_untangling_does_not(sweep, data_dir, attempts):
    stent = sweep.random_stent("aorta_iliac", 5, 24, (1.6, 2.6), data_dir)
    _, result = sweep.deployed(stent, DeploymentSettings(), data_dir)
    assert result.certificate.passed
    assert 1 < len(attempts) <= 1 + len(RETRIES)


@pytest.mark.parametrize(("longest", "expected"), [(np.inf, 1 + len(RETRIES)), (0.0, 2)])
def test_only_the_first_other_gap_is_tried_when_a_long_fold_is_left(
    attempts, monkeypatch, longest, expected
):
    monkeypatch.setattr(engine, "HOPELESS_FOLD", longest)
    made = phantom("hairpin_tube", edge_length=1.5)
    length = made.vessels[0].axis.length
    axis = made.axis_at(np.linspace(10, length - 10, 200))
    run = Deployment(made.surface, CapsuleChain.along(axis), 5.0)
    assert not run.result.certificate.passed
    assert len(attempts) == expected
