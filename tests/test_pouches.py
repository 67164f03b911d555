"""What a covered opening is called that leads to no end of the model, of shapes in closed form."""

from functools import cache

import numpy as np
import pytest
from seeds import seeds

from benchmarks.phantoms.axis import planar_axis
from benchmarks.phantoms.field import TubeField, TubeUnion
from benchmarks.phantoms.junction import branching_tube
from SDFStentLib.centerline import Centerline
from SDFStentLib.geometry import Surface
from SDFStentLib.lumen import extended_axis
from SDFStentLib.report import stent_lines
from SDFStentLib.report.branches import branch_facts
from SDFStentLib.stent import AlongAxis, Stent
from SDFStentLib.treatment import Treatment, branches_beside
from SDFStentLib.vessel import find_ostia

RADIUS = 5.0
STENT = np.array([[0.3, 0.2, 24.0], [0.3, 0.2, 39.0]])
POUCH, SAC, VESSEL = "pouch (aneurysm or stump) of", "aneurysm with a neck of", "side branch of"


def aside(radius, start, end):
    """Radius and extent on the x axis of a tube or, hardly longer than 0, a ball."""
    axis = planar_axis(
        [(end - start, 0.0)], start=(start, 0, 30.0), heading=(1, 0, 0), toward=(0, 1, 0)
    )
    return TubeField(axis, lambda s: np.full(np.shape(s), radius))


@cache
def a_vessel(*sides, is_capped=False, edge_length=0.7):
    """A tube along z with tubes (radius, start, end) aside at z = 30; the last may end flat."""
    main = TubeField(planar_axis([(60.0, 0.0)]), lambda s: np.full(np.shape(s), RADIUS))
    tubes = [main, *(aside(*side) for side in sides)]
    ends = [0, len(sides)] if is_capped else [0]
    patch = branching_tube(TubeUnion(tubes, 0.3, 4 * edge_length, ends), edge_length)
    faces = patch.triangles[patch.face_ids != 3] if is_capped == "open" else patch.triangles
    return Surface(patch.points, faces)


def ball(radius, center):
    return radius, center, center + 0.1


def a_tree(*ways, until=60.0):
    """The line of the tube up to a height, and lines from it to places (x) beside z = 30."""
    trunk = np.linspace((0, 0, 0), (0, 0, until), 61)
    lines = [np.linspace((1, 0, 30), (x, 0, 30), 2 * int(x)) for x in ways]
    parents = np.arange(len(trunk)) - 1
    points = trunk
    for line in lines:
        own = len(points) + np.arange(len(line)) - 1
        own[0] = np.abs(trunk[:, 2] - 30).argmin()
        parents, points = np.r_[parents, own], np.vstack([points, line])
    return Centerline(points, np.full(len(points), np.nan), parents)


def called(surface, tree=None):
    way = extended_axis(surface, STENT, tree)
    return [one.name for one in find_ostia(surface, way, centerline=tree)]


@pytest.mark.parametrize(
    ("sides", "is_capped", "name"),
    [
        ((ball(4, 7.0),), False, POUCH),
        ((ball(6, 6.0),), False, POUCH),
        ((ball(5, 9.0),), False, SAC),
        (((1.5, 0, 9), ball(4, 9.5)), False, SAC),
        (((2.0, 0, 9), ball(5, 11.0)), False, SAC),
        (((2.5, 0, 10),), False, POUCH),
        (((2.0, 0, 9),), False, POUCH),
        (((2.5, 0, 22),), False, VESSEL),
        (((1.5, 0, 30),), False, VESSEL),
        (((2.5, 0, 12),), True, VESSEL),
        (((2.5, 0, 22),), True, VESSEL),
        (((2.5, 0, 12),), "open", VESSEL),
        (((2.5, 0, 22),), "open", VESSEL),
        # A vessel beyond a sac that it leaves.
        (((1.5, 0, 9), ball(4, 9.5), (1.5, 9.5, 30)), False, VESSEL),
    ],
)
def test_what_ends_closed_before_it_is_as_long_as_a_vessel_is_no_side_branch(
    sides, is_capped, name
):
    surface = a_vessel(*sides, is_capped=is_capped)
    (found,) = called(surface)
    assert found.startswith(name)
    assert found.endswith(" mm at 6 mm")
    inside_out = Surface(surface.points, surface.triangles[:, ::-1].copy())
    assert called(inside_out) == [found]


def test_a_line_that_leads_there_tells_a_vessel():
    """One of the vessel beside tells none; where all of its ends are flat, nothing is told."""
    stump = a_vessel((2.5, 0, 10))
    assert called(stump, a_tree(9.0))[0].startswith(VESSEL)
    assert called(stump, a_tree(until=45.0))[0].startswith(POUCH)
    assert called(stump, a_tree()) == []


@pytest.mark.parametrize("seed", seeds(4, 60))
def test_a_ball_is_an_aneurysm_where_it_is_one_and_a_half_times_as_wide_as_its_neck(seed):
    """Its neck is a circle in closed form: where the ball meets the tube round the neck."""
    rng = np.random.default_rng(seed)
    neck, share = rng.uniform(1.5, 2.5), rng.choice([rng.uniform(1.1, 1.35), rng.uniform(1.8, 2.2)])
    radius = share * neck
    # Deep enough to be told.
    leaves = max(RADIUS + rng.uniform(1.0, 2.0), 2.1 * RADIUS - 1.9 * radius)
    surface = a_vessel((neck, 0, leaves), ball(radius, leaves + 0.9 * radius))
    noisy = surface.points + rng.normal(0, 0.03, surface.points.shape)
    (found,) = called(Surface(noisy, surface.triangles))
    assert found.startswith(SAC if share > 1.5 else POUCH)
    assert float(found.split(" of ")[-1].split()[0]) == pytest.approx(2 * neck, rel=0.15)


def test_the_treatment_and_its_report_have_the_same_words():
    sac = a_vessel((2.0, 0, 9), ball(5, 11.0))
    result = Treatment(sac, [Stent(10.4, placement=AlongAxis(STENT))]).result
    (branch,) = branches_beside(result.stents)
    assert branch.ostium.name.startswith(SAC)
    assert branch.ostium.sentence().startswith("Aneurysm with a neck of ")
    assert "side branch" not in " ".join(map(str, result.warnings)).lower()
    assert branch_facts(1, branch.ostium, None).value("name") == branch.ostium.name
    assert branch.ostium.sentence() in stent_lines(result.stents[0], None)
