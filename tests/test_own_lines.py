"""Centerlines of nothing but a surface, against the axes of phantoms and lines of other makers."""

import numpy as np
import pytest
from lesion_cases import bifurcation_case
from round_tubes import chain, circle, contoured, random_tree
from scipy.spatial import Delaunay, cKDTree
from trees import in_each_tree
from vtkmodules.vtkFiltersCore import vtkCleanPolyData, vtkQuadricDecimation, vtkTriangleFilter
from vtkmodules.vtkFiltersModeling import vtkLinearExtrusionFilter
from vtkmodules.vtkFiltersSources import vtkPlaneSource

from benchmarks.common import subdivided
from benchmarks.phantoms import (
    branching_pulmonary_artery,
    hairpin_tube,
    helix_tube,
    stenosed_tube,
    straight_tube,
    tube_with_neighbor,
)
from SDFStentLib import extract_centerline
from SDFStentLib.centerline import InnerBalls, WidestWays, inner_balls
from SDFStentLib.cli import main
from SDFStentLib.files import (
    polydata_from_arrays,
    read_centerline,
    read_surface,
    surface_from_polydata,
)
from SDFStentLib.geometry import (
    Line,
    Surface,
    SurfaceIndex,
    boundary_edges,
    distances_to_segments,
    median_edge,
    norm,
    vertex_normals,
)
from SDFStentLib.lumen import inscribed_spheres
from SDFStentLib.treatment import Vessel
from SDFStentLib.treatment.blunt_ends import blunt_ends
from SDFStentLib.validation import DeploymentError, InputError
from SDFStentLib.vessel import find_lesions, vessel_ends

ASIDE = np.array([20.0, 0.0, 0.0])


def apart(found, tree):
    """Distance of points from the axes of a centerline, over its radius there."""
    below = np.flatnonzero(tree.parent >= 0)
    starts, ends = tree.points[tree.parent[below]], tree.points[below]
    near = [distances_to_segments(point, starts, ends)[0].min() for point in found]
    return np.sqrt(near) / tree.inscribed_radius[cKDTree(tree.points).query(found)[1]]


@pytest.mark.parametrize(
    "phantom",
    [
        straight_tube(edge_length=0.4),
        helix_tube(edge_length=0.4),
        hairpin_tube(edge_length=0.4),
        stenosed_tube(3.0, 1.2, edge_length=0.4),
    ],
    ids=lambda phantom: phantom.name,
)
def test_lines_of_tubes_lie_on_their_axes(phantom):
    found = extract_centerline(phantom.surface)
    assert found.warnings == ()
    assert len(found.lines.lines) == 1
    away = apart(found.lines.points, phantom.centerline)
    assert np.median(away) < 0.002
    assert away.max() < 0.01


@in_each_tree
def test_every_end_of_a_tree_has_its_line(phantom):
    found = extract_centerline(phantom.surface)
    tree = found.centerline
    tips = tree.points[[*tree.roots, *tree.leaves]]
    assert len(tips) == len(phantom.openings)
    for opening in phantom.openings:
        assert norm(tips - opening.center).min() < 0.1 * opening.radius
    assert np.median(apart(found.lines.points, phantom.centerline)) < 0.03
    inside = SurfaceIndex(phantom.points, phantom.triangles).distances(tree.points).distance
    is_inner = ~np.isin(np.arange(len(tree.points)), [*tree.roots, *tree.leaves])
    # What is told of a point is the sphere beside it, and that is inside.
    assert (inside[is_inner] > 0.5 * tree.inscribed_radius[is_inner]).mean() > 0.9


@pytest.mark.parametrize("name", ["pulmonary", "aorta_iliac"])
def test_lines_of_an_anatomy_agree_with_those_that_came_with_it(data_dir, name):
    surface = read_surface(data_dir / f"{name}_surface_cm.vtp", "cm").surface
    known = read_centerline(data_dir / f"{name}_centerline_cm.vtp", "cm")
    found = extract_centerline(surface)
    assert len(found.lines.lines) == len(known.leaves)
    away = apart(found.lines.points, known)
    assert np.median(away) < 0.03
    assert np.quantile(away, 0.95) < 0.3


@pytest.mark.parametrize("seed", [0, 4])
@pytest.mark.parametrize(("name", "unit"), [("vmtk_aorta", "mm"), ("pulmonary", "cm")])
def test_pockets_of_a_rough_wall_are_no_ends(data_dir, name, unit, seed):
    """Up to six more lines were drawn, and one of them was the inlet: a pocket is longer than it is
    wide, but not as wide as the vessel to whose middle its end was moved."""
    plain = read_surface(data_dir / f"{name}_surface_{unit}.vtp", unit).surface
    points, triangles = subdivided(plain.points, plain.triangles)
    aside = 0.06 * median_edge(points, triangles)
    aside *= np.random.default_rng(seed).normal(size=(len(points), 1))
    found = extract_centerline(
        Surface(points + aside * vertex_normals(points, triangles), triangles)
    )
    assert len(found.lines.lines) == 2


@pytest.mark.parametrize("seed", [0, 2])
def test_what_lies_within_a_rough_cap_is_no_end_of_its_own(data_dir, seed):
    """A line more led into the rim of the inlet, and another one to a piece of an outlet's cap."""
    plain = read_surface(data_dir / "pulmonary_surface_cm.vtp", "cm").surface
    points, triangles = subdivided(plain.points, plain.triangles)
    aside = 0.02 * median_edge(points, triangles)
    aside *= np.random.default_rng(seed).normal(size=(len(points), 1))
    points += aside * vertex_normals(points, triangles)
    assert len(extract_centerline(Surface(points, triangles)).lines.lines) == 2


def test_an_inlet_that_is_narrow_beside_the_lumen_is_told():
    """A trunk as short as it is wide, without a flat end, is no end: vessels led from an outlet to
    all others, in silence."""
    trunk, *branches = [(0, 0, -3), (0, 0, 0)], [(0, 0, 0), (30, 0, 30)], [(0, 0, 0), (-25, 0, 30)]
    pieces = [*chain(trunk, 9.0), *chain(branches[0], 3.5), *chain(branches[1], 3.0)]
    surface = contoured(pieces, 0.8)
    (told,) = extract_centerline(surface).warnings
    assert told.kind == "inlet-narrow"
    assert told.numbers["diameter_mm"] == pytest.approx(18.0, abs=1.0)
    assert told.numbers["inlet_mm"] < 7.5
    tip = surface.points[surface.points[:, 2].argmin()]
    named = extract_centerline(surface, inlet=tip)
    assert named.warnings == ()
    assert len(named.lines.lines) == 2


def away(one, other):
    return float(np.linalg.norm(np.subtract(one.point, other.point)))


def test_lines_of_a_patient_tell_the_lesions_that_lines_of_vmtk_tell(data_dir):
    surface = read_surface(data_dir / "su0243_surface_mm.vtp").surface
    known = read_centerline(data_dir / "su0243_centerline_mm.vtp")
    found = extract_centerline(surface)
    assert len(found.lines.lines) == len(known.leaves) == 92
    assert np.median(apart(found.lines.points, known)) < 0.1
    wanted = Vessel(surface, known).lesions[:4]
    told = find_lesions(surface, found.centerline)
    for lesion in wanted:
        same = min(told, key=lambda one: away(one, lesion))
        assert away(same, lesion) < 1.0
        assert abs(same.percent_diameter - lesion.percent_diameter) < 1.5


def test_a_throat_that_goes_on_in_one_branch_is_told_once_whichever_line_leads_there():
    """By its own line the sample had a second lesion, of 27 %, from the trunk into its right."""
    made = branching_pulmonary_artery()
    (lesion,) = find_lesions(made.surface, extract_centerline(made.surface).centerline)
    assert lesion.percent_diameter == pytest.approx(40, abs=3)
    assert np.linalg.norm(np.subtract(lesion.point, made.throat.point)) < 1.0


def test_no_sphere_is_looked_for_within_the_lumen_that_a_branch_leaves(monkeypatch):
    asked = []

    def search(points, triangles, centers, directions):
        asked.append(centers)
        return inscribed_spheres(points, triangles, centers, directions)

    monkeypatch.setattr("SDFStentLib.treatment.own_lines.inscribed_spheres", search)
    branch = chain([(0, 0, 15), (16, 0, 15)], 1.5)
    extract_centerline(contoured(chain([(0, 0, 0), (0, 0, 36)], 4) + branch, 0.5))
    (places,) = asked
    away = places[norm(places[:, :2]) > 0.5]
    assert norm(away[:, :2]).min() > 0.8 * 4.0
    assert len(away) > 20


def test_the_balls_are_those_of_a_plain_search():
    """Empty, through four points of the wall, inside; linked where they share three of them."""
    tube = stenosed_tube(3.0, 1.5, 20.0, 1.2)
    balls = inner_balls(tube.surface)
    nearest = cKDTree(tube.points).query(balls.centers, k=4)[0]
    np.testing.assert_allclose(nearest, balls.radii[:, None] * np.ones(4), rtol=0, atol=0.02)
    outside = Delaunay(tube.points).find_simplex(balls.centers) < 0
    assert not outside.any()
    near = norm(balls.centers[balls.links[:, 0]] - balls.centers[balls.links[:, 1]])
    reach = balls.radii[balls.links].sum(axis=1)
    assert (near < reach).all()  # two balls with points in common overlap


def test_no_tips_are_judged_where_none_reaches_beyond_the_known_ends(monkeypatch):
    """Half of the time that round ends took in a patient's tree, whose ends are all flat."""
    judged = []
    monkeypatch.setattr("SDFStentLib.centerline.tips.limbs_met", lambda *_: judged.append(1))
    assert len(extract_centerline(stenosed_tube(3.0, 1.5, 20.0, 1.2).surface).lines.lines) == 1
    assert judged == []


def test_vessels_side_by_side_are_not_mixed_up():
    made = tube_with_neighbor()
    first = made.vessels[0].axis
    ends = first.point(np.array([0.0, first.length]))
    found = extract_centerline(made.surface, ends[0], [ends[1]])
    assert len(found.lines.lines) == 1
    axis = first.point(np.linspace(0.0, first.length, 400))
    assert cKDTree(axis).query(found.lines.points)[0].max() < 0.1  # places are 0.1 mm apart


def test_a_part_that_hangs_free_is_left_out_and_an_end_of_it_that_is_named_refused():
    tube = straight_tube(radius=3.0, length=30.0)
    points = np.vstack([tube.points, tube.points + ASIDE])
    both = Surface(points, np.vstack([tube.triangles, tube.triangles + len(tube.points)]))
    found = extract_centerline(both)
    assert len(found.lines.lines) == 1
    (caution,) = found.warnings
    assert "hang free" in caution.sentence()
    near, far = tube.openings[0].center, tube.openings[1].center + ASIDE
    with pytest.raises(DeploymentError, match="does not lead to the end at"):
        extract_centerline(both, near, [far])


def test_a_part_with_round_ends_that_hangs_free_is_told_with_its_place():
    """Only parts with flat ends were: of two vessels in one model one had no line in silence."""
    one, other = chain([(0, 0, 0), (0, 0, 30)], 3), chain([(30, 0, 5), (30, 0, 25)], 2)
    found = extract_centerline(contoured(one + other, 0.6))
    assert len(found.lines.lines) == 1
    (caution,) = found.warnings
    assert (caution.kind, caution.numbers["count"]) == ("ends-apart", 1)
    assert abs(caution.place[0] - 30) < 1
    assert not extract_centerline(contoured(one, 0.6)).warnings


def test_a_rounded_end_is_found_or_named_and_a_lumen_without_any_is_refused():
    tube = straight_tube(radius=3.0, length=30.0)
    squeezed = tube.points.copy()
    low, high = squeezed[:, 2].min(), squeezed[:, 2].max()
    for end, sign in ((low, 1.0), (high, -1.0)):
        depth = np.clip(1 - sign * (squeezed[:, 2] - end) / 3.0, 0, 1)
        squeezed[:, :2] *= np.sqrt(1 - np.minimum(depth, 0.995) ** 2)[:, None]
    round_one = Surface(squeezed, tube.triangles)
    tips = squeezed[squeezed[:, 2].argmin()], squeezed[squeezed[:, 2].argmax()]
    found = extract_centerline(round_one, tips[0], [tips[1]])
    inner = found.lines.points[np.abs(found.lines.points[:, 2] - (low + high) / 2) < 9.0]
    assert norm(inner[:, :2]).max() < 0.1
    assert extract_centerline(round_one, outlets=tips).warnings == found.warnings == ()
    by_itself = extract_centerline(round_one)
    assert norm(by_itself.centerline.points[:, :2]).max() < 0.15
    assert np.ptp(by_itself.centerline.points[:, 2]) > 0.75 * (high - low)
    with pytest.raises(InputError, match="longer than wide, found 0"):
        extract_centerline(round_one.with_points(squeezed * [1.0, 1.0, 0.15]))


STRAIGHT = [(0, 0, 0), (0, 0, 36)]


@pytest.mark.parametrize(
    ("pieces", "lines"),
    [
        (chain(STRAIGHT, 3) + chain([(0, 0, 15), (14, 0, 15)], 2), 2),
        (chain(STRAIGHT, 6) + chain([(0, 0, 15), (14, 0, 15)], 1.2), 2),
        (chain(STRAIGHT, 3) + chain([(0, 0, 15), (5, 0, 15)], 3), 1),  # a stub as wide as long
        (chain(STRAIGHT, 3) + chain([(5, 0, 18), (5.01, 0, 18)], 4), 1),  # an aneurysm's sac
        ([((0, 0, 0), (0, 0, 18), 3, 7), ((0, 0, 18), (0, 0, 36), 7, 3)], 1),
        ([((0, 0, 0), (0, 0, 18), 3, 0.9), ((0, 0, 18), (0, 0, 36), 0.9, 3)], 1),
        (chain(STRAIGHT, 3) + chain([(0, 0, 0), (14, 0, 0), (7, 0, 18), (14, 0, 36)], 3), 1),
    ],
    ids=["branch", "thin branch", "stub", "sac", "fusiform", "throat", "walls 1 mm apart"],
)
def test_round_ends_longer_than_wide_have_lines_and_bulges_have_none(pieces, lines):
    found = extract_centerline(contoured(pieces, 0.5))
    assert len(found.lines.lines) == lines
    assert found.warnings == ()


@pytest.mark.parametrize("seed", [105, 110, 118])
def test_every_round_end_of_a_random_tree_has_its_line_and_nothing_else(seed):
    pieces, ends = random_tree(seed)
    tree = extract_centerline(contoured(pieces, 0.55)).centerline
    found = tree.points[[*tree.roots, *tree.leaves]]
    assert len(found) == len(ends)
    for middle, radius in ends:
        assert norm(found - middle).min() < radius
    assert norm(found[:1] - ends[0][0])[0] < ends[0][1]  # the widest is the inlet


@pytest.mark.parametrize("seed", range(300, 340))
@pytest.mark.bench
def test_every_round_end_of_many_random_trees_has_its_line(seed):
    pieces, ends = random_tree(seed)
    tree = extract_centerline(contoured(pieces, 0.55)).centerline
    found = tree.points[[*tree.roots, *tree.leaves]]
    assert all(norm(found - middle).min() < radius for middle, radius in ends)


def a_loop(at):
    """Ring from which stems lead away on its right side and at another place (2,)."""
    stems = chain([(15, 0, 0), (35, 0, 0)], 3) + chain([(*at, 0), (2.5 * at[0], 2.5 * at[1], 0)], 3)
    return contoured(chain(circle(15), 2.5) + stems, 0.6)


@pytest.mark.parametrize("at", [(-15, 0), (0, 15)], ids=["even", "uneven"])
def test_limbs_meet_at_the_same_place_however_balls_and_links_are_numbered(at):
    balls = inner_balls(a_loop(at))
    inlet = norm(balls.centers - [33.0, 0, 0]).argmin()
    (wanted,) = balls.centers[WidestWays(balls, inlet).meetings]
    for seed in range(3):
        random = np.random.default_rng(seed)
        order = random.permutation(len(balls.radii))
        number = np.argsort(order)
        links = random.permutation(random.permuted(number[balls.links], axis=1))
        other = InnerBalls(balls.centers[order], balls.radii[order], links, balls.at_wall)
        (met,) = other.centers[WidestWays(other, number[inlet]).meetings]
        np.testing.assert_array_equal(met, wanted)


def test_balls_to_which_no_way_leads_are_no_limbs():
    centers = np.array([[0.0, 0, 0], [1.0, 0, 0], [50.0, 0, 0], [60.0, 0, 0]])
    links = np.array([[0, 1], [2, 3]])
    balls = InnerBalls(centers, np.ones(4), links, np.arange(4))
    assert WidestWays(balls, 0).meetings.shape == (0, 2)


@pytest.mark.parametrize("at", [(-15, 0), (0, 15)], ids=["even", "uneven"])
def test_both_limbs_of_a_loop_have_lines_and_it_is_said(at):
    found = extract_centerline(a_loop(at))
    assert len(found.centerline.loops) == 1
    (caution,) = found.warnings
    assert "Limbs that meet again: 1, one near (" in caution.sentence()
    # Nowhere on the ring is the next line farther than some steps along it.
    assert distances(circle(15, 90), found.lines.points).max() < 2.0
    ends = np.array([[35.0, 0, 0], [2.5 * at[0], 2.5 * at[1], 0]])
    assert distances(ends, found.lines.points).max() < 2.0


def distances(places, points):
    return cKDTree(points).query(places)[0]


def test_a_round_end_beside_flat_ones_is_found():
    tube = straight_tube(radius=3.0, length=30.0)
    low = tube.points[:, 2] < tube.points[:, 2].mean()
    depth = np.clip(1 - (tube.points[:, 2].max() - tube.points[:, 2]) / 3.0, 0, 0.995)
    points = tube.points.copy()
    points[:, :2] *= np.where(low, 1.0, np.sqrt(1 - depth**2))[:, None]
    tree = extract_centerline(Surface(points, tube.triangles)).centerline
    (root,) = tree.roots
    assert tree.points[root][2] < points[:, 2].min() + 0.1
    assert len(tree.leaves) == 1
    assert tree.points[tree.leaves[0]][2] > points[:, 2].max() - 4.6


def test_the_share_that_is_done_is_told_and_changes_nothing():
    shares = []
    surface = contoured(chain(STRAIGHT, 3), 0.6)
    found = extract_centerline(surface, show=shares.append)
    np.testing.assert_array_equal(found.lines.points, extract_centerline(surface).lines.points)
    assert len(shares) > 3
    assert shares == sorted(set(shares))
    assert 0 < shares[0] < shares[-1] < 1


def tube_with_a_hole():
    """Tube of 3 mm with a hole of 2 mm in its wall, and the middle of that."""
    tube = straight_tube(radius=3.0, length=30.0)
    middle = np.array([3.0, 0.0, tube.points[:, 2].mean()])
    corners = tube.points[tube.triangles]
    left = norm(corners.mean(axis=1) - middle) > 2.0
    return Surface(tube.points, tube.triangles[left]), middle


def test_a_hole_in_the_wall_lets_no_line_out():
    """The largest balls lay outside of it, kilometers wide, and a line of minutes led there."""
    surface, middle = tube_with_a_hole()
    found = extract_centerline(surface)
    assert len(found.lines.lines) == 1
    (caution,) = found.warnings
    assert caution.kind == "open-wall"
    assert np.linalg.norm(caution.place - middle) < 0.5
    assert caution.numbers["diameter_mm"] == pytest.approx(4.0, abs=0.5)
    assert norm(found.lines.points[:, :2]).max() < 1.0
    assert found.lines.inscribed_radius.max() < 3.5


@pytest.mark.parametrize("flaps", [[(-3.0, 0.2), (0.5, 0.2)], [(-3.0, 0.3), (-1, 0.3), (1, 0.3)]])
def test_an_opening_that_is_partly_closed_is_an_end(flaps):
    """Where the image cuts a vessel a surface of its voxels may have pieces of a cap, here sectors
    from the rim almost to the middle: that opening passed for a hole as narrow as between them."""
    tube = straight_tube(radius=3.0, length=30.0)
    heights = tube.points[:, 2]
    wall = tube.triangles[np.ptp(heights[tube.triangles], axis=1) > 0]
    rim = boundary_edges(wall)
    rim = rim[heights[rim[:, 0]] == heights.max()]
    turn = np.arctan2(*tube.points[rim[:, 0], :2].T)
    points, triangles = [tube.points], [wall]
    for number, (first, share) in enumerate(flaps, start=len(tube.points)):
        part = rim[(turn >= first) & (turn < first + 2 * np.pi * share)]
        middle = first + np.pi * share
        points.append(np.array([[np.sin(middle) / 2, np.cos(middle) / 2, heights.max()]]))
        triangles.append(np.column_stack([part[:, ::-1], np.full(len(part), number)]))
    found = extract_centerline(Surface(np.vstack(points), np.vstack(triangles)))
    assert not found.warnings
    assert len(found.lines.lines) == 1
    assert np.ptp(found.lines.points[:, 2]) == pytest.approx(np.ptp(heights))


def test_a_hole_in_the_wall_that_is_named_is_an_end():
    """A valve that leads into a wider chamber passes for a hole; its middle is far from wall."""
    surface, middle = tube_with_a_hole()
    low = np.array([0.0, 0.0, surface.points[:, 2].min()])
    found = extract_centerline(surface, low, [middle])
    assert not found.warnings
    lines = found.lines
    assert np.linalg.norm(lines.points[lines.lines[0][-1]] - middle) < 0.5
    tree = extract_centerline(surface, inlet=middle).centerline
    assert np.linalg.norm(tree.points[tree.roots[0]] - middle) < 0.5
    assert len(tree.leaves) == 2


def test_the_widest_end_is_the_inlet_though_a_narrow_one_is_open():
    """A tree with round ends began at a spot of 0.13 mm that passed for a flat one."""
    pieces = [((0, 0, 0), (0, 0, 36), 4.5, 3.5), *chain([(0, 0, 15), (20, 0, 15)], 2)]
    surface = contoured(pieces, 0.6)
    is_left = surface.points[surface.triangles][..., 0].max(axis=1) < 20.0
    cut = Surface(surface.points, surface.triangles[is_left])
    (end,) = vessel_ends(cut)
    assert (end.center[0], end.radius) == pytest.approx((19.7, 2.0), abs=0.3)
    found = extract_centerline(cut).centerline
    np.testing.assert_allclose(found.points[found.roots], [[0, 0, 0]], atol=1.0)
    assert len(found.leaves) == 2
    named = extract_centerline(cut, inlet=[20.0, 0.0, 15.0]).centerline
    np.testing.assert_allclose(named.points[named.roots], [end.center], atol=0.1)


@pytest.mark.parametrize("spacing", [0.6, 0.8, 1.0])
def test_terraces_of_voxels_are_no_ends(spacing):
    """In the surface of a mask as it is every second terrace of vessels aslant passed for a flat
    end: there were up to 220, each with a line."""
    pieces = chain([(0, 0, 0), (20, 0, 36)], 4.5) + chain([(10, 0, 18), (-8, 3, 36)], 3.0)
    surface = contoured(pieces, spacing, is_mask=True)
    assert vessel_ends(surface) == []
    found = extract_centerline(surface).centerline
    assert len(found.leaves) == 2
    tips = cKDTree([(0, 0, 0), (20, 0, 36), (-8, 3, 36)])
    assert tips.query(found.points[[*found.roots, *found.leaves]])[0].max() < 3.0


def roughened(surface, kind, random):
    """The points of a closed surface with noise, or smoothed all over as if there were no rims."""
    if kind == "noise":
        return surface.points + random.normal(0, 0.03, surface.points.shape)
    points, triangles = surface.points.copy(), surface.triangles
    sides = np.concatenate([triangles[:, :2], triangles[:, 1:], triangles[:, ::2]])
    count = np.bincount(sides.ravel(), minlength=len(points))[:, None]
    for _ in range(20):
        total = np.zeros_like(points)
        for one, other in (sides.T, sides.T[::-1]):
            np.add.at(total, one, points[other])
        points += 0.1 * (total / count - points)
    return points


@pytest.mark.parametrize("kind", ["noise", "smoothed"])
@pytest.mark.parametrize("seed", [2001, 2005])
def test_caps_that_are_no_longer_flat_are_ends_in_the_middle_of_the_vessel(seed, kind):
    """Lines ended in the rim, as wide as they are there, and the inlet was an outlet: of a trunk of
    9.7 mm with branches of 6.7 and 7.7 one of these."""
    case = bifurcation_case(seed, None, fineness=0.4)
    points = roughened(case.surface, kind, np.random.default_rng(seed))
    found = extract_centerline(Surface(points, case.surface.triangles)).centerline
    known = case.centerline
    for ends, mine in ((known.roots, found.roots), (known.leaves, found.leaves)):
        assert len(ends) == len(mine)
        tree = cKDTree(found.points[mine])
        for end in ends:
            away = tree.query(known.points[end])[0]
            # A radius before the cap, and not aside.
            assert away < 1.05 * known.inscribed_radius[end]
    axis = cKDTree(Line(known.points[known.ancestry(int(known.leaves[0]))]).resampled(0.1).points)
    root = int(found.roots[0])
    assert axis.query(found.points[root])[0] < 0.2 * found.inscribed_radius[root]


@pytest.mark.parametrize("share", [0.8, 0.9])
def test_walls_with_sides_longer_than_the_lumen_is_wide_have_their_ends(share):
    """Decimated straight tubes: balls between points far apart bulged out of the wall, the lumen
    fell to pieces, and the inlet was a branch or a place in the wall of the trunk."""
    pieces = chain([(0, 0, 0), (0, 0, 40)], 4)
    tips = [(20, 0, 70), (-20, 0, 70)]
    for tip, radius in zip(tips, (3, 2.5), strict=True):
        pieces += chain([(0, 0, 40), tip], radius)
    whole = contoured(pieces, 1.0)
    coarse = vtkQuadricDecimation()
    coarse.SetInputData(polydata_from_arrays(whole.points, whole.triangles))
    coarse.SetTargetReduction(share)
    coarse.Update()
    tree = extract_centerline(surface_from_polydata(coarse.GetOutput())).centerline
    found = tree.points[[*tree.roots, *tree.leaves]]
    assert len(found) == 3
    assert norm(found[:1] - [0, 0, 0])[0] < 4
    for tip in tips:
        assert norm(found - tip).min() < 3


def test_the_command_needs_no_other_package(tmp_path, capsys, monkeypatch):
    from tube_files import write_tube

    monkeypatch.chdir(tmp_path)
    write_tube(tmp_path)
    words = ["centerline", "tube.vtp", "--units", "cm", "-o", "own.vtp"]
    assert main(words) == 0
    assert "1 line to own.vtp" in capsys.readouterr().out
    made = read_centerline("own.vtp", "cm")
    known = read_centerline("line.vtp", "cm")
    assert apart(made.points, known).max() < 0.05


@pytest.mark.parametrize("gap", [0.05, 0.1])
def test_flat_walls_that_touch_are_told_apart(gap):
    """`centerline` ended in an error: all faces near a point were those of the other wall."""
    plane, raised, faces = vtkPlaneSource(), vtkLinearExtrusionFilter(), vtkTriangleFilter()
    plane.SetPoint1(8, 0, 0)
    plane.SetPoint2(0, 8, 0)
    plane.SetResolution(11, 11)
    raised.SetVector(0, 0, 0.5)
    raised.SetExtrusionTypeToVectorExtrusion()
    for one, other in ((plane, raised), (raised, faces)):
        other.SetInputConnection(one.GetOutputPort())
    merged = vtkCleanPolyData()
    merged.SetInputConnection(faces.GetOutputPort())
    merged.Update()
    sheet = surface_from_polydata(merged.GetOutput())
    points = np.vstack([sheet.points, sheet.points + np.array([0, 0, 0.5 + gap])])
    both = Surface(points, np.vstack([sheet.triangles, sheet.triangles + len(sheet.points)]))
    assert blunt_ends(both, inner_balls(both).at_wall) == []
