"""No stent makes a spike or narrows its lumen; what would is bounded, and not certified.

Judged here by VTK's distances and by the coordinates themselves, never by the certificate.
"""

import importlib.util
from functools import cache
from typing import NamedTuple

import numpy as np
import pytest
from child_processes import PROJECT
from deployment_cases import phantom

from SDFStentLib.cautions import Caution
from SDFStentLib.certificate import Certificate, MotionCheck
from SDFStentLib.deformation import Deployment, DeploymentSettings
from SDFStentLib.deformation.lumen import largest_push
from SDFStentLib.deformation.stent_checks import motion_check
from SDFStentLib.field import CapsuleChain
from SDFStentLib.geometry import Line
from SDFStentLib.stent import (
    AlongAxis,
    AtCenter,
    AtDistalEnd,
    AtProximalEnd,
    Stent,
    StentAxis,
    stent_axis,
    straight_way,
)
from SDFStentLib.treatment import AxisChange, Treatment, axis_in_vessel
from SDFStentLib.treatment.straightening import permitted

_spec = importlib.util.spec_from_file_location("judges", PROJECT / "benchmarks" / "judges.py")
judges = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(judges)
wall_distances = judges.wall_distances


class Outcome(NamedTuple):
    radius: float
    axis: StentAxis
    before: np.ndarray
    after: np.ndarray
    triangles: np.ndarray
    certificate: Certificate
    warnings: tuple[Caution, ...]

    @property
    def stations(self):
        return CapsuleChain.along(self.axis.points).nodes

    @property
    def largest_motion(self):
        return float(np.linalg.norm(self.after - self.before, axis=1).max())


@cache
def demo():
    return phantom("branching_pulmonary_artery")


def treated(vessel, center, diameter, length, straightening=0.0):
    stent = Stent(diameter, placement=AtCenter(np.array(center)), length=length)
    result = Treatment(
        vessel.surface, [stent], vessel.centerline, straightening_fraction=straightening
    ).result
    return Outcome(
        diameter / 2,
        result.stents[0].axis,
        vessel.points,
        result.points,
        vessel.triangles,
        result.certificate,
        result.warnings,
    )


ACROSS_THE_DIVIDER = ((-5.0, 0.0, 30.0), 7.5, 20.0)
INTO_THE_NARROW_BRANCH = ((-1.962, 0.0, 26.172), 5.95, 25.1)


@pytest.mark.parametrize(
    ("place", "straightening"), [(ACROSS_THE_DIVIDER, 0.5), (INTO_THE_NARROW_BRANCH, 1.0)]
)
def test_a_straightened_stent_across_a_divider_makes_no_spike_and_no_narrowing(
    place, straightening
):
    """Four vertices moved 28 mm; the lumen fell from 4.9 to 1.7 mm; both were certified."""
    found = treated(demo(), *place, straightening)
    assert found.largest_motion < found.radius
    width = wall_distances(found.after, found.triangles, found.stations)
    assert width.min() > 0.99 * found.radius
    assert found.certificate.passed


# What a chord can need -------------------------------------------------------------------------


def test_ends_pushed_as_far_as_allowed_bring_the_middle_of_a_chord_to_the_radius():
    radius, half_angle = 3.0, np.deg2rad([1.0, 10.0, 30.0, 45.0])
    length = 2 * radius * np.sin(half_angle)
    exact = radius / np.cos(half_angle) - radius
    middle = (radius + exact) * np.cos(half_angle)
    np.testing.assert_allclose(middle, radius)
    push = largest_push(length, radius)
    assert (push >= exact * (1 - 1e-12)).all()
    assert (push <= 1.5 * exact * (1 + 1e-12)).all()


# Straightening ---------------------------------------------------------------------------------


def test_straightening_stops_before_the_wall_and_says_how_far_it_went():
    found = treated(demo(), *ACROSS_THE_DIVIDER, 1.0)
    (said,) = [caution for caution in found.warnings if caution.kind == "straightened-less"]
    assert said.numbers["prescribed_fraction"] == 1
    used = said.numbers["fraction"]
    assert f"is straightened by {used:.2f} instead of 1:" in str(said)
    assert 0.3 < used < 0.9
    native = stent_axis(
        Stent(7.5, placement=AtCenter(np.array([-5.0, 0, 30])), length=20.0), demo().centerline
    )
    kept = wall_distances(demo().points, demo().triangles, found.stations)
    had = wall_distances(demo().points, demo().triangles, CapsuleChain.along(native.points).nodes)
    assert kept.min() > 0.4 * min(had.min(), found.radius)


def straight_in(made, first, last, placement=AlongAxis):
    """The axis along a part of a bent tube made straight, and as it was."""
    way = made.centerline.points[made.centerline.ancestry(made.centerline.leaves[0])]
    native = way[round(first * (len(way) - 1)) : round(last * (len(way) - 1)) + 1]
    if placement is AlongAxis:
        stent = Stent(7.2, placement=AlongAxis(native))
    else:
        end = native[-1] if placement is AtDistalEnd else native[0]
        sizes = {"length": Line(native).length, "foreshortening_fraction": 0}
        stent = Stent(7.2, placement=placement(end), **sizes)
    return axis_in_vessel(stent, made.centerline, made.surface, AxisChange(1.0)), native


@pytest.mark.parametrize("placement", [AtProximalEnd, AtDistalEnd])
def test_the_end_by_which_a_stent_is_placed_stays(placement):
    found, native = straight_in(phantom("bent_tube"), 0.3, 0.6, placement)
    stays = 0 if placement is AtProximalEnd else -1
    np.testing.assert_allclose(found.points[stays], native[stays], atol=1e-6)
    moved = np.linalg.norm(found.points[-1 - stays] - native[-1 - stays])
    assert moved > 0.1
    assert found.deployed_length == pytest.approx(Line(native).length, abs=1e-6)


def test_an_axis_does_not_pass_through_a_thin_wall_into_the_next_lumen():
    """Beyond the wall of a hairpin's leg is its other leg, where the axis would be free again."""
    made = phantom("hairpin_tube")
    axis = made.axis_at(np.linspace(5, 45, 120))
    way = straight_way(Line(axis))
    found = permitted(way, 3.0, made.surface, 1.0)
    assert found.fraction < 0.5
    assert np.isfinite(found.place).all()
    # It goes as far as it may: half of what it had from the wall is left where that is tightest.
    had, has = (
        wall_distances(made.points, made.triangles, way.at(done).points)
        for done in (0.0, found.fraction)
    )
    assert (has - np.minimum(had, 3.0) / 2).min() == pytest.approx(0.0, abs=0.02)


# The certificate -------------------------------------------------------------------------------


def through_the_wall(**changes):
    """A stent whose axis leaves the lumen and comes back, as straightened ones did."""
    made = demo()
    stent = Stent(5.95, placement=AtCenter(np.array([-1.962, 0.0, 26.172])), length=25.1)
    axis = straight_way(stent_axis(stent, made.centerline).line).at(1.0)
    settings = DeploymentSettings().with_changes(**changes)
    return Deployment(made.surface, settings.chain(axis.points), 5.95 / 2, settings)


def test_a_lumen_narrower_than_prescribed_is_not_certified_and_says_where():
    deployment = through_the_wall()
    certificate = deployment.result.certificate
    assert not certificate.passed
    [check] = certificate.lumen
    assert check.is_narrow
    stations = deployment.chain.nodes
    width = wall_distances(deployment.result.points, deployment.surface.triangles, stations)
    assert check.narrowest / 2 >= width.min() - 1e-6
    at = int(np.linalg.norm(stations - check.narrowest_at, axis=1).argmin())
    assert width[at] < 0.97 * deployment.radius
    said = certificate.sentence()
    assert said.startswith("Surface not certified for meshing: it has")
    assert f"a lumen of {check.narrowest:.2f} mm instead of 5.95 mm near (" in said
    assert certificate.as_dict()["lumen"][0]["passed"] is False


def test_a_point_moved_too_far_is_not_certified_and_says_where():
    made = phantom("straight_tube", edge_length=1.0)
    axis = made.axis_at(np.linspace(10, 20, 50))
    deployment = Deployment(made.surface, CapsuleChain.along(axis), 3.6)
    state = deployment.result.state
    before, after = made.points[state.indices], state.coordinates.copy()
    assert motion_check(before, after, deployment.chain, 3.6, 0.4).passed
    spike = int(deployment.chain.axis_distance(before).argmin())
    outward = after[spike] - before[spike]
    after[spike] += 4 * outward / np.linalg.norm(outward)
    check = motion_check(before, after, deployment.chain, 3.6, 0.4)
    assert not check.passed
    np.testing.assert_allclose(check.point, before[spike])
    assert check.distance == pytest.approx(np.linalg.norm(after[spike] - before[spike]))
    assert f"a point that moved {check.distance:.1f} mm" in check.fault()
    slightly = MotionCheck(3.729, 3.690, (1.0, 2.0, 3.0))
    assert slightly.fault() == (
        "a point that moved 3.7 mm, 0.039 mm farther than the method moves it, from "
        "(1.0, 2.0, 3.0) mm"
    )


def test_the_published_rule_promises_no_lumen_and_nothing_is_said_about_it():
    certificate = through_the_wall(finish=False, facet_compensation=False).result.certificate
    assert certificate.lumen == ()
    assert "lumen" not in certificate.sentence()


def test_a_stent_outside_of_the_vessel_is_not_certified():
    made = phantom("straight_tube", edge_length=1.0)
    axis = made.axis_at(np.linspace(10, 20, 50)) + np.array([6.0, 0, 0])
    certificate = Deployment(made.surface, CapsuleChain.along(axis), 2.0).result.certificate
    assert not certificate.passed
    assert "outside of the lumen" in certificate.sentence()


def test_every_stent_of_a_plan_is_judged_on_the_surface_that_all_of_them_leave():
    made = phantom("straight_tube", edge_length=1.0)

    def along(start, end):
        return AlongAxis(made.axis_at(np.linspace(start, end, 80)))

    stents = [Stent(7.2, placement=along(8, 20)), Stent(8.4, placement=along(16, 28))]
    certificate = Treatment(made.surface, stents).result.certificate
    assert certificate.passed, certificate.sentence()
    assert [check.prescribed for check in certificate.lumen] == [7.2, 8.4]
    assert len(certificate.motion) == 2
