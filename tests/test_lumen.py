"""From the last step to the prescribed lumen."""

from itertools import pairwise

import numpy as np
import pytest
from deployment_cases import arc, phantom, phantom_case, straight
from hypothesis import given, settings
from hypothesis import strategies as st
from oracle import PlainField, capsule_distance, smin
from oracle import field as plain_field

from SDFStentLib.deformation import BLENDS, FALLOFFS, Deployment, DeploymentSettings
from SDFStentLib.deformation.contact_search import FEW
from SDFStentLib.deformation.contact_set import PHASES, NewContacts
from SDFStentLib.deformation.lumen import OnStent
from SDFStentLib.deformation.wall_around import FOREIGN, own_share
from SDFStentLib.field import CapsuleChain, radius_correction
from SDFStentLib.geometry import Surface, smooth_minimum
from SDFStentLib.lumen import inscribed_spheres

DEFAULT = DeploymentSettings(certify=False)


def deployment_in(made, start, length, radius, settings=DEFAULT):
    axis = made.axis_at(np.linspace(start, start + length, 400))
    return Deployment(made.surface, settings.chain(axis), radius, settings)


def inscribed_diameters(deployment):
    """Maximum inscribed spheres at every millimeter of the stent, both ends included."""
    result = deployment.result
    spheres = inscribed_spheres(result.points, deployment.surface.triangles, deployment.chain.nodes)
    return 2 * spheres.radii


# The calibration -------------------------------------------------------------------------------


def test_the_papers_quarter_of_k_is_not_the_inflation():
    """k/4 holds where two capsules meet alone; many short ones inflate by up to all of k."""
    radius = 3.0
    correction = {
        length: radius_correction(CapsuleChain.along(straight(60), capsule_length=length), radius)
        for length in (0.1, 0.25, 1.0, 4.0)
    }
    assert correction[1.0] == pytest.approx(0.129, abs=0.003)
    assert list(correction.values()) == sorted(correction.values(), reverse=True)
    assert correction[4.0] < 0.1 < correction[1.0] < correction[0.1] < 0.4


@pytest.mark.parametrize("bend", [12.0, 30.0])
def test_the_correction_is_the_mean_inflation_on_the_real_axis(bend):
    radius = 4.0
    chain = CapsuleChain.along(arc(bend))
    nodes = chain.nodes
    middle, along = (nodes[:-1] + nodes[1:]) / 2, np.diff(nodes, axis=0)
    along /= np.linalg.norm(along, axis=1)[:, None]
    up = np.array([0.0, 1, 0])
    angles = np.linspace(0, 2 * np.pi, 96, endpoint=False)[:, None, None]
    samples = middle + radius * (np.cos(angles) * up + np.sin(angles) * np.cross(along, up))
    samples = samples.reshape(-1, 3)
    true = np.min([capsule_distance(samples, a, b)[0] for a, b in pairwise(nodes)], axis=0)
    expected = (true - plain_field(samples, nodes, 0.4).distance)[true > 0.999 * radius].mean()
    # 12 angles against 96; the inflation varies with the cosine of the angle.
    assert radius_correction(chain, radius) == pytest.approx(expected, abs=0.002)


# The finish ------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["straight_tube", "bent_tube", "helix_tube", "hairpin_tube"])
def test_the_finished_wall_lies_on_the_true_distance_from_the_axis(name):
    case = phantom_case(name)
    settings = DEFAULT.with_changes(facet_compensation=False, tissue_gap=0)
    deployment = Deployment(case.surface, settings.chain(case.axis), case.radius, settings)
    away = deployment.chain.axis_distance(deployment.result.points)
    # Three rounds along directions up to 20 degrees off; points just outside contact stay there.
    assert away.min() > case.radius - 1e-4
    beside = np.abs(away - case.radius)[away < case.radius + 0.01]
    assert len(beside) > 50
    assert (beside < 1e-4).mean() > 0.85


@pytest.mark.parametrize("tolerance", [0.002, 0.01, 0.05])
@pytest.mark.parametrize("rule", ["events", "published"])
def test_the_finish_takes_the_contact_tolerance_away(rule, tolerance):
    made = phantom("stenosed_tube", radius=2.0, throat_radius=1.2, edge_length=0.5)
    settings = DEFAULT.with_changes(
        rule=rule, contact_tolerance=tolerance, facet_compensation=False
    )
    deployment = deployment_in(made, 12, 16, 3.0, settings)
    body = (made.points[:, 2] > 13) & (made.points[:, 2] < 27)
    away = deployment.chain.axis_distance(deployment.result.points[body])
    # All of this wall touches a stent half as wide again.
    np.testing.assert_allclose(away, 3.0, atol=1e-4)


def oval_tube(wide):
    """A tube along z, 40 mm long, with half axes of 2 mm and `wide`."""
    made = phantom("straight_tube", radius=2.0, edge_length=0.4)
    return made.points * [wide / 2.0, 1.0, 1.0], made.triangles


def stented_oval(wide, settings=DEFAULT):
    """Deployed; how far outside of the stent the wall beside it was and is, mm."""
    deployment = Deployment(
        Surface(*oval_tube(wide)),
        settings.chain(straight(16) + np.array([0, 0, 12.0])),
        3.0,
        settings,
    )
    end = deployment.result.points
    beside = (end[:, 2] > 12) & (end[:, 2] < 28)
    native, after = (
        deployment.chain.axis_distance(points[beside]) - 3.0
        for points in (deployment.surface.points, end)
    )
    return deployment, native, after


def without_drag_bound(monkeypatch):
    monkeypatch.setattr(
        "SDFStentLib.deformation.attempt.drawn_in",
        lambda motion, positions, *_: OnStent(positions, np.empty(0, dtype=np.int64)),
    )


@pytest.mark.parametrize("gap", [0.4, 0.0])
def test_wall_that_the_stent_reaches_ends_on_it_however_it_was_dragged(gap, monkeypatch):
    settings = DEFAULT.with_changes(facet_compensation=False, tissue_gap=gap)
    _, native, after = stented_oval(2.9, settings)
    without_drag_bound(monkeypatch)
    _, _, undrawn = stented_oval(2.9, settings)
    assert native.max() < 0
    # The wide sides of the oval were run ahead of.
    assert undrawn.max() > 0.1
    assert -1e-4 < after.min() <= after.max() < 1e-4


# Wall dragged ahead of the stent ---------------------------------------------------------------


@pytest.mark.parametrize(
    ("throat", "slope", "diameter", "length"),
    [(0.9, 16, 3.0, 14), (0.9, 16, 4.5, 22), (1.5, 16, 4.0, 22), (0.9, 8, 4.5, 14)],
)
def test_a_lumen_that_a_stent_does_not_reach_is_not_widened(throat, slope, diameter, length):
    """The wall of the slopes went out by up to a tenth, dragged by what the throat's wall did."""
    made = phantom(
        "stenosed_tube", radius=3.0, throat_radius=throat, edge_length=0.6, stenosis_length=slope
    )
    done = deployment_in(made, 20 - length / 2, length, diameter / 2, DeploymentSettings())
    assert done.result.certificate.passed, done.result.certificate.sentence()
    heights = np.linspace(20 - length / 2, 20 + length / 2, 4 * length + 1)
    line = made.axis_at(heights)
    before, after = (
        2 * inscribed_spheres(points, made.triangles, line).radii
        for points in (made.points, done.result.points)
    )
    assert (after > 0.97 * diameter).all()
    is_unreached = before > 1.1 * diameter
    assert is_unreached.any()
    # The sphere beside a widened throat has more room on that side.
    assert (after[is_unreached] < 1.06 * before[is_unreached]).all()


# The lumen -------------------------------------------------------------------------------------


FINE = {
    "stenosed_tube": ({"radius": 2.0, "throat_radius": 1.2, "edge_length": 0.25}, 10, 20),
    "bent_tube": ({"radius": 2.0, "bend_radius": 12.0, "edge_length": 0.25}, 12, 16),
    "helix_tube": ({"edge_length": 0.3}, 10, 25),
}


@pytest.mark.parametrize("name", list(FINE))
def test_a_six_millimeter_stent_in_a_fine_mesh_opens_six_millimeters(name):
    sizes, start, length = FINE[name]
    diameters = inscribed_diameters(deployment_in(phantom(name, **sizes), start, length, 3.0))
    # The goals; measured 6.0002 to 6.0012 with SD 0.0013 to 0.0023 and 5.9925 at the worst end.
    assert 5.99 < diameters.mean() < 6.01
    assert diameters.std() <= 0.005
    assert 5.985 < diameters.min() <= diameters.max() < 6.01


@pytest.mark.parametrize("edge_length", [0.5, 0.8])
def test_compensation_gives_a_coarse_lumen_back_what_its_facets_take(edge_length):
    made = phantom("stenosed_tube", radius=2.0, throat_radius=1.2, edge_length=edge_length)
    finished = deployment_in(made, 10, 20, 3.0)
    bare = deployment_in(made, 10, 20, 3.0, DEFAULT.with_changes(facet_compensation=False))
    plain, compensated = inscribed_diameters(bare), inscribed_diameters(finished)
    # Chords of edges that the stent has stretched 1.5 times: the sagitta h^2 / (8 R), both sides.
    sagitta = (1.5 * edge_length) ** 2 / (8 * 3.0)
    assert 6.0 - plain.mean() > sagitta
    assert abs(compensated.mean() - 6.0) < 0.25 * (6.0 - plain.mean())
    assert compensated.max() < 6.0 * 1.005
    # No vertex was pushed inside the prescribed radius.
    away = finished.chain.axis_distance(finished.result.points)
    assert away.min() > 3.0 - 1e-4
    assert away[away < 3.3].max() < 3.0 + 0.3


# Parts of the motion: patch, contacts, smooth minimum and profiles.

# Who is nearest among the points in contact, as they come, and in the mean of a step.


def cloud(count, seed=0, spread=5.0):
    return np.random.default_rng(seed).normal(size=(count, 3)) * spread + [300, -200, 100]


def new_contacts(points, times, growth=0.8):
    return NewContacts(points, np.asarray(times, dtype=float), growth)


def nearest_distance(asking, points, bound=6.5):
    return np.minimum(np.linalg.norm(asking[:, None] - points, axis=2).min(axis=1), bound)


@pytest.mark.parametrize(("count", "parts"), [(1, np.inf), (FEW, np.inf), (120, PHASES)])
def test_the_mean_is_that_of_the_contacts_one_by_one(count, parts):
    """Against the plain sum over all contact times, one contact after the other."""
    rng = np.random.default_rng(4)
    held, hits, asking = cloud(150), cloud(count, 2), cloud(400, 3)
    times = rng.uniform(0, 0.8, len(hits))
    before = nearest_distance(asking, held)
    near = nearest_distance(asking, hits) < before
    asking, before = asking[near], before[near]
    excess = new_contacts(hits, times).excess(asking, np.arange(len(asking)), before)

    current, total, last = before, np.zeros(len(asking)), 0.0
    for number in np.argsort(times):
        total += current * (times[number] - last)
        last = times[number]
        current = np.minimum(current, np.linalg.norm(asking - hits[number], axis=1))
    total += current * (0.8 - last)
    # Of many contacts only the nearest in each part of the step counts: the others' drop comes at
    # most one part late. Few are exact.
    late = excess - (total / 0.8 - current)
    assert late.min() > -1e-9
    assert (late <= (before - current) / parts + 1e-9).all()


# The smooth minimum and the profiles, against their closed forms.


DISTANCE = st.floats(-20, 20, allow_nan=False)
WIDTH = st.floats(0.01, 3)
ROUNDING = 1e-12  # mm: a few operations on numbers below 20


def pair(first, second):
    return np.array([first], dtype=float), np.array([second], dtype=float)


@settings(max_examples=100, deadline=None, derandomize=True)
@given(DISTANCE, DISTANCE, st.one_of(st.just(0.0), WIDTH))
def test_the_smooth_minimum_is_the_papers_kernel_form_with_its_chain_rule(first, second, k):
    a, b = pair(first, second)
    along_first, along_second = np.array([[1.0, 0, 0]]), np.array([[0.0, 1, 0]])
    plain = smin(PlainField(a, along_first), PlainField(b, along_second), k)
    value, share = smooth_minimum(a, b, k)
    assert value[0] == pytest.approx(plain.distance[0], abs=ROUNDING)
    gradient = share[0] * along_first[0] + (1 - share[0]) * along_second[0]
    np.testing.assert_allclose(gradient, plain.gradient[0], atol=1e-10)


@pytest.mark.parametrize("name", [*FALLOFFS, *BLENDS])
def test_every_profile_falls_monotonically_from_one_to_zero(name):
    profile = {**FALLOFFS, **BLENDS}[name]
    values = profile(np.linspace(0, 1, 1001))
    # One rounding of a sum of terms near 1.
    assert values[0] == pytest.approx(1, abs=1e-15)
    assert values[-1] == pytest.approx(0, abs=1e-15)
    assert (np.diff(values) < 1e-15).all()


# Which wall is that of the stented lumen: by degrees, so that no hair's breadth decides.


def best_of_all_ways(count, sides, tissue, nearest):
    """By trying: the least tissue up to which vertices hang together with the nearest."""
    worst = np.full(count, np.inf)
    for limit in sorted(set(tissue[tissue < FOREIGN]), reverse=True):
        reached = {nearest}
        for _ in range(count):
            for a, b in sides:
                if tissue[a] <= limit and tissue[b] <= limit and {a, b} & reached:
                    reached |= {a, b}
        worst[list(reached)] = limit
    return 1 - np.minimum(worst / FOREIGN, 1)


@given(st.integers(0, 2**32 - 1))
def test_the_share_is_that_of_the_best_of_all_ways(seed):
    rng = np.random.default_rng(seed)
    count = 12
    sides = rng.integers(0, count, (16, 2))
    tissue = rng.choice([0, 0, 0.2 * FOREIGN, 0.7 * FOREIGN, 3 * FOREIGN], count)
    tissue[3] = 0
    expected = best_of_all_ways(count, sides, tissue, 3)
    np.testing.assert_allclose(own_share(sides, tissue, 3), expected)
