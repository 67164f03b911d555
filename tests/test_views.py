"""Working views: the angles of the C-arm, foreshortening, what covers what, the best views."""

import time

import numpy as np
import pytest
from trees import unbranched

from SDFStentLib.centerline import Centerline
from SDFStentLib.geometry import Line
from SDFStentLib.lumen import equivalent_diameters
from SDFStentLib.plan import read_input_files
from SDFStentLib.validation import InputError
from SDFStentLib.view import (
    ArmLimits,
    ArmView,
    Shown,
    arm_axes,
    arm_limits,
    arm_view,
    working_views,
)

LEFT, BACK, HEAD = np.eye(3)
"""Of the patient, in LPS."""

BENT = np.array([[0.0, 0, 0], [10, 0, 0], [10, 0, 10]])
"""10 mm to the left, then 10 mm toward the head, LPS."""


def shown(points, radius=2.0, others=(), frame="LPS"):
    """A vessel along points, and others (points, radius) that hang together with nothing."""
    lines = [
        Line(points).resampled(0.5).points,
        *(Line(one).resampled(0.5).points for one, _ in others),
    ]
    radii = [radius, *(one for _, one in others)]
    counts = [len(one) for one in lines]
    parent = np.concatenate(
        [
            np.arange(count) - 1 + first
            for count, first in zip(counts, np.cumsum([0, *counts[:-1]]), strict=True)
        ]
    )
    parent[np.cumsum([0, *counts[:-1]])] = -1
    tree = Centerline(np.concatenate(lines), np.repeat(radii, counts), parent)
    return Shown(tree, Line(lines[0]), np.full(counts[0], radius), frame)


# The convention: DICOM PS3.3 C.8.7.5.


@pytest.mark.parametrize(
    ("view", "toward", "right", "up"),
    [
        (ArmView(0, 0), -BACK, LEFT, HEAD),  # in front of the chest; the left side is on the right
        (ArmView(90, 0), LEFT, BACK, HEAD),  # LAO 90: the detector at the left side
        (ArmView(-90, 0), -LEFT, -BACK, HEAD),  # RAO 90: at the right side
        (ArmView(0, 90), HEAD, LEFT, BACK),  # CRA 90: at the head, looking at the feet
        (ArmView(0, -90), -HEAD, LEFT, -BACK),
    ],
)
def test_the_detector_is_where_dicom_has_it(view, toward, right, up):
    assert view.axes("LPS") == pytest.approx(np.stack([right, up, toward]), abs=1e-12)
    turned = view.axes("RAS") * (-1, -1, 1)
    assert turned == pytest.approx(view.axes("LPS"))


def test_axes_are_right_handed_and_tell_their_angles_again():
    rng = np.random.default_rng(5)
    first, second = rng.uniform(-180, 180, 50), rng.uniform(-89, 89, 50)
    for frame in ("LPS", "RAS"):
        axes = arm_axes(first, second, frame)
        assert np.cross(axes[:, 0], axes[:, 1]) == pytest.approx(axes[:, 2])
        for one, alpha, beta in zip(axes, first, second, strict=True):
            assert arm_view(3 * one[2], frame) == pytest.approx((alpha, beta))


@pytest.mark.parametrize(
    ("view", "words"),
    [
        (ArmView(12.4, 28), "LAO 12, CRA 28"),
        (ArmView(-30, -9.6), "RAO 30, CAU 10"),
        (ArmView(-0.2, 0), "LAO 0, CRA 0"),
    ],
)
def test_angles_are_said_as_in_the_laboratory(view, words):
    assert view.words == words


@pytest.mark.parametrize(
    ("primary", "secondary", "lost"),
    [
        # Of two legs of 10 mm, worked out by hand.
        (0, 0, 0.0),
        (90, 0, 0.5),  # that to the left is seen end-on
        (0, 90, 0.5),  # that to the head is
        (45, 0, (1 - np.sqrt(0.5)) / 2),
        (-45, 0, (1 - np.sqrt(0.5)) / 2),
        (0, 30, (1 - np.cos(np.pi / 6)) / 2),
        # toward = (sin 30 cos 20, -cos 30 cos 20, sin 20) = (0.46985, -0.81380, 0.34202)
        (30, 20, 1 - (0.88274 + 0.93969) / 2),
    ],
)
def test_foreshortening_of_a_bent_tube_is_as_worked_out_by_hand(primary, secondary, lost):
    for frame, sign in (("LPS", 1), ("RAS", (-1, -1, 1))):
        bent = shown(BENT * sign, frame=frame)
        assert bent.seen_from(ArmView(primary, secondary)).foreshortening == pytest.approx(
            lost, abs=1e-5
        )


# What covers what.

UPRIGHT = np.array([[0.0, 0, -5], [0, 0, 5]])
LONG = np.array([[0.0, 0, -30], [0, 0, 30]])


@pytest.mark.parametrize("deep", [-12.0, 12.0])
@pytest.mark.parametrize(
    ("beside", "radius", "share"),
    [
        # Rays at x = -1.6, -0.8, 0, 0.8, 1.6 of a radius of 2; the other has its axis at x = 3:
        # 9 - (x - 3)^2 >= 4 - x^2 where x >= 2/3, on two of the five.
        (3.0, 3.0, 0.4),
        (0.0, 3.0, 1.0),
        (5.0, 3.0, 0.0),
        (0.0, 1.9, 0.4),  # thinner than the vessel: 1.9^2 - x^2 < 2^2 - x^2 everywhere
    ],
)
def test_a_vessel_before_or_behind_covers_what_it_darkens_more(beside, radius, share, deep):
    one = shown(UPRIGHT, others=[(LONG + np.array([beside, deep, 0]), radius)])
    share = 0.0 if radius < 2 else share
    assert one.seen_from(ArmView(0, 0)).covered == pytest.approx(share)
    assert one.seen_from(ArmView(180, 0)).covered == pytest.approx(share)
    assert one.seen_from(ArmView(90, 0)).covered == 0


def test_the_branches_that_cover_are_named_most_of_it_first():
    across = np.array([[-20.0, -12, 3], [20, -12, 3]])
    one = shown(UPRIGHT, others=[(across, 2.2), (LONG + 12 * BACK, 3.0)])
    assert one.seen_from(ArmView(0, 0)).over_it == (2, 1)
    assert one.seen_from(ArmView(90, 0)).over_it == ()


def test_a_vessel_is_not_covered_by_itself_and_a_hairpin_is():
    assert shown(LONG).seen_from(ArmView(30, 85)).covered == 0
    hairpin = np.array([[0.0, 0, -20], [0, 0, 20], [0, 14, 20], [0, 14, -20]])
    one = shown(hairpin)
    assert one.seen_from(ArmView(90, 0)).covered == 0
    assert one.seen_from(ArmView(0, 0)).covered > 0.8


def fork(angle=90.0):
    """A vessel of 40 mm toward the head, from whose middle a branch leaves to the left, LPS."""
    trunk = np.column_stack([np.zeros(81), np.zeros(81), np.linspace(-20, 20, 81)])
    way = np.array([np.sin(np.deg2rad(angle)), 0, np.cos(np.deg2rad(angle))])
    branch = trunk[40] + np.linspace(0.5, 30, 60)[:, None] * way
    parent = np.r_[np.arange(81) - 1, 40, np.arange(81, 140)]
    radius = np.r_[np.full(81, 3.0), np.full(60, 2.0)]
    return Centerline(np.vstack([trunk, branch]), radius, parent), Line(trunk[30:51])


def test_the_origin_of_a_branch_is_free_in_profile_and_covered_by_its_vessel_head_on():
    tree, line = fork()
    one = Shown(tree, line, np.full(len(line), 3.0), "LPS")
    assert one.seen_from(ArmView(0, 0)).ostia_covered == 0
    behind = unbranched(LONG + np.array([7.0, 15, 0]), np.full(2, 4.0))
    both = Centerline(
        np.vstack([tree.points, behind.points]),
        np.r_[tree.inscribed_radius, behind.inscribed_radius],
        np.r_[tree.parent, -1, len(tree.points)],
    )
    two = Shown(both, line, np.full(len(line), 3.0), "LPS")
    assert two.seen_from(ArmView(0, 0)).ostia_covered == 1
    assert two.seen_from(ArmView(0, 0)).covered == 0


# The best views.


def test_the_best_view_is_across_the_vessel_and_free():
    one = shown(BENT, others=[(LONG + np.array([10.0, -20, 0]), 3.0)])
    found = working_views(one, arm_limits())
    assert found.best.foreshortening < 0.1
    assert found.best.covered == 0
    assert found.second is not None
    cosine = found.best.view.axes("LPS")[2] @ found.second.view.axes("LPS")[2]
    assert abs(cosine) <= 0.5 + 1e-9
    assert found.worst.seen == pytest.approx(found.map.seen[found.map.is_reached].min())
    assert found.best.seen >= found.map.seen[found.map.is_reached].max() - 0.011


@pytest.mark.parametrize(("primary", "secondary"), [(30, 20), (-50, -15), (0, 40), (80, 0)])
def test_a_bend_and_a_fork_are_best_seen_across_their_plane(primary, secondary):
    """By hand: nothing of what lies in a plane is lost where one looks along its normal, and its
    branch lies beside it."""
    right, up, _ = ArmView(primary, secondary).axes("LPS")
    angle = np.linspace(0, np.pi / 2, 61)[:, None]
    arc = 15 * (np.sin(angle) * up + (1 - np.cos(angle)) * right)
    branch = arc[30] + np.linspace(0.5, 25, 50)[:, None] * (right - up) / np.sqrt(2)
    parent = np.r_[np.arange(61) - 1, 30, np.arange(61, 110)]
    tree = Centerline(np.vstack([arc, branch]), np.r_[np.full(61, 2.5), np.full(50, 1.5)], parent)
    one = Shown(tree, Line(arc[10:51]), np.full(41, 2.5), "LPS")
    across = one.seen_from(ArmView(primary, secondary))
    assert (across.foreshortening, across.covered) == (pytest.approx(0, abs=1e-9), 0)
    assert across.ostia_covered == 0
    found = working_views(one, arm_limits())
    # As good to one percent, of the best of a grid, which is at most 2.5 degrees from the normal by
    # either angle and so loses 1 - cos 3.6 degrees.
    assert found.best.foreshortening <= 0.01 + 0.002
    assert found.best.ostia_covered == 0
    assert found.worst.foreshortening > 0.3


def test_both_frames_give_the_same_views():
    one = working_views(shown(BENT), arm_limits())
    other = working_views(shown(BENT * (-1, -1, 1), frame="RAS"), arm_limits())
    assert one.best.view == other.best.view
    assert one.best[1:5] == pytest.approx(other.best[1:5])
    assert one.map.seen == pytest.approx(other.map.seen)


def test_the_arm_keeps_to_its_limits_and_to_those_of_a_table():
    one = shown(BENT[1:] + np.array([0, -3.0, 0]) * [[0], [1]])
    table = ((-40.0, 30.0, 20.0), (0.0, 30.0, 20.0), (40.0, 10.0, 0.0))
    for limits in (arm_limits(30, 20), arm_limits(60, 50, table)):
        found = working_views(one, limits)
        for seen in (found.best, found.second, found.worst):
            if seen is not None:
                assert limits.reach(*np.array(seen.view)[:, None])[0]
    within = ArmLimits(110, 50, table)
    first, second = np.array(
        [[-41, 0], [-40, 31], [-40, 30], [20, 21], [20, 20], [20, -10], [20, -11]]
    ).T
    assert within.reach(first, second).tolist() == [False, False, True, False, True, True, False]


def test_a_second_view_that_the_arm_does_not_reach_is_none():
    assert working_views(shown(UPRIGHT), arm_limits(20, 20)).second is None


@pytest.mark.parametrize(
    "wrong",
    [
        {"lao_rao": -1},
        {"cra_cau": 91},
        {"table": ((0.0, 10.0, 10.0), (0.0, 10.0, 10.0))},
        {"table": ((0.0, 100.0, 10.0),)},
    ],
)
def test_limits_that_no_arm_has_are_refused(wrong):
    with pytest.raises(InputError):
        arm_limits(**wrong)


def test_a_tree_without_radii_has_no_views():
    tree = unbranched(LONG)
    with pytest.raises(InputError, match="radii of inscribed spheres"):
        Shown(tree, Line(LONG), np.full(2, np.nan), "LPS")


# A patient.


@pytest.fixture(scope="module")
def patient(data_dir):
    """The first lesion of the paper's patient, in its tree, and the wall."""
    names = (data_dir / f"su0243_{kind}_mm.vtp" for kind in ("surface", "centerline"))
    vessel = read_input_files(*names, "mm").vessel
    lesion = vessel.lesions[0]
    one = Shown(vessel.centerline, lesion.line, lesion.diameters / 2, "LPS")
    return one, vessel.surface.points, vessel.surface.triangles


@pytest.mark.bench
def test_a_grid_of_629_views_takes_less_than_a_second(patient):
    one, _, _ = patient
    sides = np.arange(-90, 91, 5.0), np.arange(-40, 41, 5.0)
    one.mapped(*(side[:1] for side in sides), arm_limits())
    begun = time.process_time()
    found = one.mapped(*sides, arm_limits())
    assert found.seen.size == 629
    assert time.process_time() - begun < 1


def boxed(flat, places):
    """Those of triangles (m, 3, 3) in a picture that any ray through places (k, 3) can meet, and
    the corners of their boxes."""
    low, high = flat[..., :2].min(axis=1), flat[..., :2].max(axis=1)
    first, last = places[:, :2].min(axis=0), places[:, :2].max(axis=0)
    near = ((low <= last) & (high >= first)).all(axis=1)
    return flat[near], low[near], high[near]


def depths(wall, place):
    """Where a ray through a place of the picture meets triangles."""
    flat, low, high = wall
    near = np.flatnonzero(((low <= place[:2]) & (high >= place[:2])).all(axis=1))
    a, b, c = (flat[near, corner] for corner in range(3))
    x, y = place[:2]
    u, v, w = (
        (p[:, 0] - x) * (q[:, 1] - y) - (p[:, 1] - y) * (q[:, 0] - x)
        for p, q in ((b, c), (c, a), (a, b))
    )
    hit = ((u > 0) & (v > 0) & (w > 0)) | ((u < 0) & (v < 0) & (w < 0))
    total = u * a[:, 2] + v * b[:, 2] + w * c[:, 2]
    return np.sort(total[hit] / (u + v + w)[hit]) - place[2]


def lumen_on(wall, place):
    """How much lumen is on a ray through a closed wall, mm."""
    found = depths(wall, place)
    assert len(found) % 2 == 0  # a closed wall is left as often as entered
    return float((found[1::2] - found[::2]).sum())


def own_radii(points, triangles, middles, ways, radii):
    """Of circles with the area of the vessel's sections; where others are in them, as elsewhere."""
    share = equivalent_diameters(points, triangles, middles, ways) / 2 / radii
    share[~(share < 1.5)] = np.nan
    return np.where(np.isfinite(share), share, np.nanmedian(share)) * radii


def test_rays_cast_at_the_wall_find_the_same_overlap_as_spheres_of_the_tree(patient):
    """In 20 views anywhere within the limits: the same order, and 0.06 more in the mean, as several
    lumens on a ray add up there."""
    one, points, triangles = patient
    rng, shares = np.random.default_rng(3), []
    at = (np.arange(25) + 0.5) * one.line.length / 25
    middles, radii = one.line.at(at), np.interp(at, one.line.arc_lengths, one.radii)
    half = one.line.length / 50
    ways = one.line.at(at + half) - one.line.at(at - half)
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    widths = own_radii(points, triangles, middles, ways, radii)
    for _ in range(20):
        view = ArmView(rng.uniform(-110, 110), rng.uniform(-50, 50))
        axes = view.axes("LPS")
        places, own = [], []
        for middle, way, radius, width in zip(middles, ways, radii, widths, strict=True):
            side = np.cross(axes[2], way)
            sine = np.linalg.norm(side)
            for offset in radius * np.array([-0.8, -0.4, 0.0, 0.4, 0.8]):
                own.append(2 * np.sqrt(width**2 - offset**2) / sine)
                places.append(axes @ (middle + offset * side / sine))
        wall = boxed((points @ axes.T)[triangles], np.array(places))
        found = np.array([lumen_on(wall, place) for place in places])
        shares.append((one.seen_from(view).covered, (found >= 2 * np.array(own)).mean()))
    ours, cast = np.array(shares).T
    assert np.abs(ours - cast).mean() < 0.08
    assert np.corrcoef(ours, cast)[0, 1] > 0.97
