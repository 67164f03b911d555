"""The verdict on a result that follows from that on an earlier one is the verdict from scratch."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from deployment_cases import phantom

from SDFStentLib.certificate import Comparison, certify, check_surface
from SDFStentLib.certificate.face_quality import Slivers
from SDFStentLib.deformation import DeploymentSettings
from SDFStentLib.geometry import Precision, Surface


def assert_same(one, other):
    """Field by field, arrays with their types."""
    for name, expected in other.items():
        if isinstance(expected, Slivers):
            assert one[name].as_dict() == expected.as_dict()
        elif isinstance(expected, np.ndarray):
            np.testing.assert_array_equal(one[name], expected, err_msg=name)
            assert one[name].dtype == expected.dtype, name
        else:
            assert one[name] == expected, name


FOLDING = [
    pytest.param("vmtk_aorta", 38, marks=pytest.mark.bench),
    ("vmtk_aorta", 2),
    ("vmtk_aorta", 11),
    ("pulmonary", 22),
]
"""Numbers of random stents, seed 1, that need untangling; no. 38 cannot be untangled."""


@pytest.mark.parametrize(("name", "number"), FOLDING)
def test_after_untangling_the_certificate_is_that_of_the_whole(
    data_dir, sweep, monkeypatch, name, number
):
    verdicts = []
    plain = Comparison.verdict

    def recorded(self, after, earlier=None):
        verdicts.append((self, after, plain(self, after, earlier)))
        return verdicts[-1][2]

    monkeypatch.setattr(Comparison, "verdict", recorded)
    stent = sweep.random_stent(name, 1, number, (1.6, 2.6), data_dir)
    deployment, result = sweep.deployed(stent, DeploymentSettings(), data_dir)
    monkeypatch.undo()
    assert len(verdicts) > 1
    assert not verdicts[0][2].passed
    for comparison, after, verdict in verdicts:
        assert_same(verdict._asdict(), plain(comparison, after)._asdict())

    precision = sweep.vessel(name, data_dir).precision
    whole = certify(
        Surface(deployment.surface.points, deployment.wound_triangles),
        result.points,
        precision=precision,
    )
    # What is promised of a stent is not judged by comparing two surfaces: see `test_spikes.py`.
    assert result.certificate.motion
    assert result.certificate.lumen
    assert_same(vars(replace(result.certificate, motion=(), lumen=())), vars(whole))


def bumps(points, rng, count, size):
    """The surface with a few patches thrown about."""
    after = points.copy()
    for centre in points[rng.integers(len(points), size=count)]:
        near = np.linalg.norm(points - centre, axis=1) < 2.0
        after[near] += rng.normal(size=(near.sum(), 3)) * size
    return after


@pytest.mark.parametrize("seed", range(2))
def test_whatever_was_judged_before_the_verdict_is_the_same(seed):
    made = phantom("bent_tube", edge_length=1.0)
    rng = np.random.default_rng(seed)
    # An input with faults of its own, some of which come and go.
    before = bumps(made.points, rng, 3, 1.0)
    results = [bumps(before, rng, 2, 0.7), bumps(before, rng, 4, 0.3), before]
    results += [bumps(results[0], rng, 1, 0.7), results[1]]
    collapsed = results[3].copy()
    collapsed[made.triangles[40:44]] = collapsed[made.triangles[40, 0]]
    results += [collapsed, before + 1.0, results[0]]
    assert not check_surface(Surface(before, made.triangles)).passed
    comparison = Comparison(before, made.triangles, Precision(np.float32, 1.0))
    earlier, faults = None, 0
    for after in results:
        may_move = rng.uniform(size=len(before)) < 0.8 if seed % 2 else None
        earlier = comparison.verdict(after, earlier, may_move)
        assert_same(earlier._asdict(), comparison.verdict(after, None, may_move)._asdict())
        faults += len(earlier.failing) > 0
    assert faults > 3
