"""Taking apart what folds."""

import numpy as np
import pytest
from deployment_cases import anatomy_case, phantom

from SDFStentLib.certificate import Comparison, self_intersecting_triangles
from SDFStentLib.deformation import Deployment, DeploymentSettings, untangle
from SDFStentLib.deformation import deployment as engine
from SDFStentLib.deformation.deployment import RETRIES
from SDFStentLib.deformation.motion import Motion
from SDFStentLib.deformation.untangle import WAYS_TO_UNTANGLE, Tangle, untangled
from SDFStentLib.field import CapsuleChain
from SDFStentLib.geometry import Precision

DEFAULT = DeploymentSettings()
PLAIN = DEFAULT.with_changes(tissue_gap=0, untangle=False)


def folds(deployment):
    return len(deployment.result.certificate.new_self_intersecting)


@pytest.fixture(scope="module")
def folding_case(data_dir):
    """At the iliac bifurcation the wall of the stented lumen and the carina are swept together."""
    return anatomy_case(data_dir, "aorta_iliac", 200, 36, radius=12.0)


def deployment_of(case, settings):
    return Deployment(case.surface, settings.chain(case.axis), case.radius, settings)


def test_the_published_settings_fold_where_the_default_does_not(folding_case):
    published = deployment_of(folding_case, DeploymentSettings.published())
    assert folds(published) > 0
    assert not published.result.certificate.passed
    default = deployment_of(folding_case, DEFAULT)
    assert folds(default) == 0
    assert default.result.certificate.passed


def test_untangling_repairs_a_fold_without_the_tissue_gap(folding_case):
    without = deployment_of(folding_case, PLAIN)
    assert folds(without) > 0
    repaired = deployment_of(folding_case, PLAIN.with_changes(untangle=True))
    assert folds(repaired) == 0
    assert repaired.result.untangling_rounds > 0
    moved = np.linalg.norm(repaired.result.points - without.result.points, axis=1)
    # Local: a few vertices round the fold.
    assert 0 < (moved > 0).sum() < 100
    # No vertex enters the stent.
    level = repaired.chain.field(repaired.result.points).distance
    before = without.chain.field(without.result.points).distance
    assert (level - np.minimum(before, repaired.target_level)).min() > -0.01


# On a sheet whose fold is known -----------------------------------------------------------------


def a_sheet(count=15, spacing=0.5, height=3.0):
    """A flat grid `height` mm beside an axis along x, and its triangles."""
    x, y = np.meshgrid(np.arange(count) * spacing, np.arange(count) * spacing, indexing="ij")
    points = np.column_stack([x.ravel(), (y - y.mean()).ravel(), np.full(count**2, height)])
    corner = np.arange(count**2).reshape(count, count)
    a, b = corner[:-1, :-1].ravel(), corner[1:, :-1].ravel()
    c, d = corner[1:, 1:].ravel(), corner[:-1, 1:].ravel()
    return points, np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])


def a_folded_sheet():
    """The sheet with a few vertices pulled through the faces of others."""
    points, triangles = a_sheet()
    rng = np.random.default_rng(3)
    bent = points + [0, 0, 0.02] * rng.uniform(0, 1, (len(points), 1))
    middle = len(points) // 2 + np.array([0, 1, 15, 16])
    bent[middle] += rng.normal(size=(4, 3)) * 0.6 + [0, 0, 0.6]
    return points, bent, triangles


def motion_of(bent, axis):
    chain = CapsuleChain.along(axis)
    motion = Motion(chain, bent, np.ones(len(bent), dtype=bool))
    # The engine numbers patch vertices in motion order; here every vertex is one.
    return motion, motion.indices


def in_order(values, order, triangles):
    number = np.empty_like(order)
    number[order] = np.arange(len(order))
    return values[order], number[triangles]


AXIS = np.array([[-1.0, 0, 0], [8.0, 0, 0]])


def untangled_sheet(flat, bent, triangles):
    """What untangling makes of the sheet: motion, faults in its order, outcome."""
    motion, order = motion_of(bent, AXIS)
    motion.freeze()
    before, numbered = in_order(flat, order, triangles)
    faults = Comparison(before, numbered, Precision())
    bad = faults.new_faults(motion.positions, np.arange(len(triangles)))
    level = float(motion.level.min())
    return motion, faults, level, untangled(motion, level, faults, Tangle(motion.positions, bad))


def test_a_pulled_vertex_is_put_back_and_none_enters_the_stent():
    flat, bent, triangles = a_folded_sheet()
    assert len(self_intersecting_triangles(bent, triangles))
    motion, faults, level, outcome = untangled_sheet(flat, bent, triangles)
    assert outcome.rounds > 0
    assert len(outcome.faulty) == 0
    assert len(self_intersecting_triangles(outcome.positions, faults.triangles)) == 0
    after = motion.chain.field(outcome.positions).distance
    # One Newton step along the field: its curvature leaves a few micrometers.
    assert after.min() > level - 5e-3


def new_faults(before, after, triangles, precision=None):
    everything = np.arange(len(triangles))
    return Comparison(before, triangles, precision or Precision()).new_faults(after, everything)


def test_a_face_that_its_neighbors_turn_over_is_a_fault_though_it_stays():
    flat, triangles = a_sheet()
    face = len(triangles) // 4 + 7
    corners = triangles[face]
    # All but the face is mirrored and lifted: what lay beside it now lies over it.
    after = flat.copy()
    others = np.setdiff1d(np.arange(len(flat)), corners)
    after[others, 0] = 2 * flat[corners, 0].mean() - flat[others, 0]
    after[others, 2] += 0.4
    assert face not in self_intersecting_triangles(after, triangles, [face])
    beside = np.setdiff1d(np.arange(len(triangles)), face)
    assert face in Comparison(flat, triangles, Precision()).new_faults(after, beside)


# Other ways and other tissue gaps are tried where untangling fails, unless that is hopeless.


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
