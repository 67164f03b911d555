"""Which part of which ostium lies under a stent: against plain ray casting, and in closed form."""

from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from deployment_cases import anatomy
from ostium_truth import RayCaster, openings_at
from seeds import seeds
from vtkmodules.vtkFiltersCore import vtkImplicitPolyDataDistance

from benchmarks import phantoms
from benchmarks.phantoms.axis import planar_axis
from benchmarks.phantoms.field import TubeField, TubeUnion
from benchmarks.phantoms.junction import branching_tube
from SDFStentLib.centerline import Centerline
from SDFStentLib.deformation import DeploymentSettings
from SDFStentLib.files import read_centerline, read_surface
from SDFStentLib.geometry import Line, NamedFaces, Surface
from SDFStentLib.lumen import extended_axis
from SDFStentLib.stent import AlongAxis, AtCenter, BetweenPoints, Stent, stent_axis
from SDFStentLib.treatment import Treatment, branches_beside, lumen_into
from SDFStentLib.treatment.warnings import narrowed_neighbors
from SDFStentLib.vessel import NeighborLumen, Ostium, apposition, find_ostia
from SDFStentLib.vessel.apposition import GAP
from SDFStentLib.vessel.ostia import PARENT

AORTA = ("vmtk_aorta_surface_mm.vtp", "mm")
FORMS = {
    "branch-split": (*AORTA, "vmtk_aorta_centerline_branches_mm.vtp"),
    "overlapping": (*AORTA, "vmtk_aorta_centerline_mm.vtp"),
    "iliac, reduced-order": ("aorta_iliac_surface_cm.vtp", "cm", "aorta_iliac_centerline_cm.vtp"),
    "pulmonary, reduced-order": ("pulmonary_surface_cm.vtp", "cm", "pulmonary_centerline_cm.vtp"),
}


@cache
def vessel(folder, form):
    surface, units, line = FORMS[form]
    read = read_surface(folder / surface, units=units)
    return read.surface, read_centerline(folder / line, units=units)


@cache
def a_tee(angle_deg=90.0, radius=5.0, side_radius=2.5, edge_length=0.7):
    """A straight tube along z with a straight side branch at z = 30, toward x; hardly rounded."""
    main = planar_axis([(60.0, 0.0)])
    angle = np.deg2rad(angle_deg)
    heading = (np.sin(angle), 0.0, np.cos(angle))
    side = planar_axis([(22.0, 0.0)], start=(0, 0, 30.0), heading=heading, toward=(0, 1, 0))
    tubes = [TubeField(main, lambda s: np.full(np.shape(s), radius))]
    tubes.append(TubeField(side, lambda s: np.full(np.shape(s), side_radius)))
    return branching_tube(TubeUnion(tubes, blend_width=0.3, beyond=4 * edge_length), edge_length)


def edge_near(surface, center, within=12.0):
    corners = surface.points[surface.triangles]
    near = corners[np.linalg.norm(corners.mean(axis=1) - center, axis=1) < within]
    return float(np.linalg.norm(near - near[:, [1, 2, 0]], axis=2).mean())


def ostia_of(surface, axis, centerline=None, **options):
    way = extended_axis(surface, axis, centerline)
    return find_ostia(surface, way, centerline=centerline, **options)


@pytest.mark.parametrize(("angle_deg", "start"), [(90, 27), (60, 10), (45, 31)])
def test_the_ostium_of_a_straight_branch_is_where_the_two_cylinders_meet(angle_deg, start):
    """The rim of a thin tube on a cylinder: nearest and farthest corner lie in their plane."""
    patch = a_tee(angle_deg)
    angle, leaves = np.deg2rad(angle_deg), 1.15 * 5.0
    # Where lines beside the branch's axis are as far out as where the wall counts as left.
    low = 30 + leaves / np.tan(angle) - 2.5 / np.sin(angle) - start
    high = 30 + leaves / np.tan(angle) + 2.5 / np.sin(angle) - start
    line = np.array([[0.3, 0.2, start], [0.3, 0.2, start + 15]])
    faces = NamedFaces(patch.face_ids)
    (ostium,) = ostia_of(Surface(patch.points, patch.triangles), line, faces=faces)
    assert ostium.name.startswith("side branch of ")
    assert ostium.face_ids == (4,)
    # One edge length.
    assert abs(ostium.start - low) < 0.7
    assert abs(ostium.end - high) < 0.7
    outlet = [22 * np.sin(angle), 0, 30 + 22 * np.cos(angle)]
    np.testing.assert_allclose(ostium.outlets[0], outlet, atol=0.2)
    if high < -0.7 or low > 15.7:
        assert ostium.is_free
    elif low > 0.7 and high < 14.3:
        assert ostium.is_fully_covered


def test_half_of_an_ostium_is_half_covered():
    patch = a_tee()
    (ostium,) = ostia_of(Surface(patch.points, patch.triangles), [[0, 0, 30.0], [0, 0, 45.0]])
    assert ostium.covered_share == pytest.approx(0.5, abs=0.03)
    # An ellipse on the unrolled wall: the branch's circle, wider round the vessel.
    assert ostium.area == pytest.approx(np.pi * 2.5**2, rel=0.15)
    assert not ostium.is_free
    assert not ostium.is_fully_covered
    assert ostium.sentence().startswith("Side branch of 4.7 mm at 0 mm: 5")
    assert " % covered; its ostium lies from -2." in ostium.sentence()


@pytest.mark.parametrize(
    ("first", "second", "share"),
    [
        ((18, 30), (30, 42), 1.0),
        ((18, 31), (29, 42), 1.0),
        ((18, 30), (21, 30), 0.5),
        # Of a circle 2.5 mm in radius, without the band from 1 mm before its middle to 1 beyond.
        ((18, 29), (31, 42), 1 - 2 / np.pi * (np.arcsin(0.4) + 0.4 * np.sqrt(1 - 0.4**2))),
    ],
)
def test_what_two_stents_cover_of_one_ostium_is_told_once_and_of_both(first, second, share):
    """Where two met, half of one branch was told of each, as of two branches."""
    patch = a_tee()
    stents = [Stent(10.4, placement=AlongAxis([[0, 0, a], [0, 0, b]])) for a, b in (first, second)]
    result = Treatment(Surface(patch.points, patch.triangles), stents).result
    (branch,) = branches_beside(result.stents)
    assert branch.stents == (1, 2)
    assert branch.ostium.covered_share == pytest.approx(share, abs=0.03)
    assert branch.ostium.is_fully_covered == (share == 1)


def test_where_a_placement_snaps_does_not_decide_about_a_branch(data_dir):
    """Once the left iliac was free, 8.5 mm away, and 0.1 mm farther covered, 6.2 mm inside."""
    found = []
    for form in ("branch-split", "overlapping"):
        surface, tree = vessel(data_dir, form)
        for y in (142.7, 142.8):
            ends = BetweenPoints((221.9, y, 23.61), (213, 115, 28))
            axis = stent_axis(Stent(10, placement=ends), tree)
            found.append(ostia_of(surface, axis.points, tree))
    assert all(len(ostia) == 1 and ostia[0].is_fully_covered for ostia in found)
    extents = np.array([[ostia[0].start, ostia[0].end] for ostia in found])
    assert np.ptp(extents, axis=0).max() < 0.5


def a_random_stent(folder, seed):
    """Vessel, tree or None, and the axis of a stent, mostly near a junction."""
    rng = np.random.default_rng(seed)
    names = [*FORMS, "phantom"]
    name = names[seed % len(names)]
    if name == "phantom":
        made = phantoms.branching_pulmonary_artery()
        surface, tree = made.surface, made.centerline
    else:
        surface, tree = vessel(folder, name)
    path = tree.path(tree.points[tree.roots[0]], tree.points[rng.choice(tree.leaves)])
    length = rng.uniform(6, 40)
    junction = tree.arc_length[rng.choice(tree.junctions)]
    start = rng.uniform(junction - length - 5, junction + 25)
    start = np.clip(start, 0, max(0, path.length - length - 1))
    axis = Line(path.points).cut(float(start), float(start + length)).points
    axis = axis[::-1] if rng.random() < 0.3 else axis
    return surface, (tree if rng.random() < 0.75 else None), axis


@pytest.mark.parametrize("seed", seeds(3, 10))
def test_random_stents_agree_with_plain_ray_casting(data_dir, seed):
    surface, tree, line = a_random_stent(data_dir, seed)
    axis = extended_axis(surface, line, tree)
    # Where the wall leaves gently the border is as uncertain as the middle of the vessel: it lies
    # between those for 2 % of the radius less and more, some 0.1 mm of wall.
    low, middle, high = (
        sorted(found)
        for found in openings_at(
            surface.points,
            surface.triangles,
            axis.points,
            axis.before,
            axis.stent_length,
            [1.13, 1.15, 1.17],
        )
    )
    found = find_ostia(surface, axis)
    assert len(found) == len(low) == len(middle) == len(high)
    for ostium, wide, truth, narrow in zip(found, low, middle, high, strict=True):
        edge = edge_near(surface, ostium.center)
        assert wide.start - edge < ostium.start < narrow.start + edge
        assert narrow.end - edge < ostium.end < wide.end + edge
        # What an edge at each end of the stent makes of the share.
        assert abs(ostium.covered_share - truth.share) < 2 * edge / (truth.end - truth.start)


def test_the_way_before_a_stent_goes_on_to_the_root_and_not_straight_on_into_the_other_branch():
    """The vessel that a stented one comes from was told as a branch that the stent covers."""
    patch, fork = a_tee(side_radius=4.0), (0, 0, 30)
    ways = ((22, 0, 30), fork), (fork, (0, 0, 55)), (fork, (0, 0, 5))
    trunk, up, down = (np.linspace(*ends, 23) for ends in ways)
    points = np.concatenate([trunk, up[1:], down[1:]])
    parent = np.arange(len(points)) - 1
    parent[len(trunk) + len(up) - 1] = len(trunk) - 1
    tree = Centerline(points, np.full(len(points), np.nan), parent)
    surface, axis = Surface(patch.points, patch.triangles), np.linspace((0, 0, 31), (0, 0, 45), 15)
    extended = extended_axis(surface, axis, tree)
    np.testing.assert_allclose(extended.points[0], (19, 0, 30), atol=0.1)
    (other,) = find_ostia(surface, extended)
    assert other.name.endswith("before the stent")


def a_bent_path(patch):
    """The centerline up a tee's main vessel and round into its branch, and the one straight on."""
    up, on = np.linspace((0, 0, 0), (0, 0, 30), 31), np.linspace((0, 0, 31), (0, 0, 60), 30)
    side = np.linspace((1, 0, 30), (22, 0, 30), 22)
    points = np.concatenate([up, on, side])
    parent = np.arange(len(points)) - 1
    parent[len(up) + len(on)] = len(up) - 1
    return Surface(patch.points, patch.triangles), Centerline(points, np.full(83, np.nan), parent)


@pytest.mark.parametrize("start", [24.0, 27.0, 30.0])
def test_the_vessel_that_a_stented_one_comes_from_is_no_branch(start):
    """Round a bend rays look back along the vessel's own lumen: it was "fully covered"."""
    surface, tree = a_bent_path(a_tee(side_radius=3.5))
    way = tree.path(tree.project(np.array([0, 0, start])), np.array([15.0, 0, 30])).points
    (onward,) = ostia_of(surface, way, tree)
    np.testing.assert_allclose(onward.outlets, [(0, 0, 60)], atol=0.01)


@pytest.mark.parametrize("start", [1.0, 8.0])
def test_in_a_model_of_flat_ends_what_leads_to_none_is_no_branch(start):
    """The far wall of a wide trunk, seen from its branch, was told as one of 7.4 mm."""
    surface, tree = a_bent_path(a_tee(radius=9.0))
    way = np.linspace((start, 0, 30), (20, 0, 30), 20)
    (onward,) = ostia_of(surface, way, tree)
    np.testing.assert_allclose(onward.outlets, [(0, 0, 60)], atol=0.01)
    assert onward.name.startswith("branch of"), "the trunk is no side branch of its branch"
    # A centerline that ends elsewhere does not tell what vessels end in.
    tree = replace(tree, points=np.where(tree.points == 60, 45.0, tree.points))
    assert [len(one.outlets) for one in ostia_of(surface, way, tree)] == [0, 1]


@cache
def left_artery(folder):
    """The paper's patient: surface, centerline and the line from the root into the left artery."""
    surface = read_surface(folder / "su0243_surface_mm.vtp").surface
    tree = read_centerline(folder / "su0243_centerline_mm.vtp")
    leaf = tree.project((32.03, -68.35, -87.08)).index
    return surface, tree, Line(tree.points[tree.ancestry(leaf)])


def test_a_stent_that_begins_in_the_funnel_of_its_vessel_covers_nothing_of_that_above(data_dir):
    """On from there to the root is the vessel itself."""
    surface, tree, line = left_artery(data_dir)
    found = ostia_of(surface, line.cut(36.75, 66.75), tree)
    assert PARENT not in [ostium.name for ostium in found]


def test_rays_that_look_down_into_a_branch_from_a_funnel_above_make_its_ostium_no_larger(data_dir):
    """Covered between 44.8 and 51 mm; two rays of 1,400 made it three times as large."""
    surface, tree, line = left_artery(data_dir)
    found = ostia_of(surface, line.cut(43.5, 56.5), tree)
    (branch,) = (one for one in found if np.linalg.norm(one.center - (9.09, -83.42, -53.58)) < 1.5)
    assert branch.is_fully_covered
    assert branch.area == pytest.approx(11.5, abs=2)


def test_an_ostium_ends_where_it_ends_though_the_end_of_the_tube_looks_into_the_branch(data_dir):
    """The branch of 3.3 mm below the stent was told with one 16 mm beyond it, 60 % covered."""
    surface, tree, _ = left_artery(data_dir)
    line = Line(tree.points[tree.ancestry(5818)])
    found = ostia_of(surface, line.cut(44.4, 54.8), tree)
    (covered,) = (one for one in found if not one.is_free)
    assert covered.is_fully_covered
    assert covered.end - covered.start < 6


def test_a_stent_from_one_branch_into_the_other_covers_the_vessel_from_which_both_come():
    made = phantoms.branching_pulmonary_artery()
    tree = made.centerline
    across = Line(tree.path(*tree.points[tree.leaves[:2]]).points)
    middle = across.length / 2
    names = [one.name for one in ostia_of(made.surface, across.cut(middle - 8, middle + 8), tree)]
    assert PARENT in names


# Where a stent hangs free, how neighbors fare, and diameters beyond its ends.


def test_a_stent_that_touches_no_wall_covers_no_branch():
    made = phantoms.branching_pulmonary_artery()
    tree = made.centerline
    way = tree.path(tree.points[tree.roots[0]], tree.points[tree.leaves[0]])
    place = Line(way.points).at([24.0])[0]
    settings = DeploymentSettings(certify=False)
    found = {}
    for diameter in (0.6, 12.0):
        stent = Stent(diameter, length=14, placement=AtCenter(place))
        (treated,) = Treatment(made.surface, [stent], tree, settings).result.stents
        found[diameter] = treated.apposition.is_loose, [one.is_free for one in treated.branches]
    assert found == {0.6: (True, [True]), 12.0: (False, [False])}


def free_by_vtk(surface, axis, radius):
    """Share of places on a stent that are farther than the gap from any wall, along its axis."""
    distance = vtkImplicitPolyDataDistance()
    distance.SetInput(RayCaster(surface.points, surface.triangles).polydata)
    at = np.r_[0, np.cumsum(np.linalg.norm(np.diff(axis, axis=0), axis=1))]
    along, half = np.linspace(0, at[-1], 41), radius / 2
    middle, ahead, behind = (
        np.column_stack([np.interp(np.clip(along + by, 0, at[-1]), at, one) for one in axis.T])
        for by in (0, half, -half)
    )
    first = np.cross(ahead - behind, [0.3, 0.5, 0.8])
    second = np.cross(ahead - behind, first)
    first, second = (v / np.linalg.norm(v, axis=1)[:, None] for v in (first, second))
    angles = np.linspace(0, 2 * np.pi, 48, endpoint=False)[:, None, None]
    places = middle + radius * (np.cos(angles) * first + np.sin(angles) * second)
    away = [abs(distance.EvaluateFunction(place)) > GAP for place in places.reshape(-1, 3)]
    return along, np.reshape(away, (48, 41)).mean(axis=0)


@pytest.mark.parametrize("name", ["off the middle", "stenosis", "pulmonary", "vmtk_aorta"])
def test_contact_is_that_of_distances_to_the_surface_by_vtk(data_dir, name):
    if name in ("pulmonary", "vmtk_aorta"):
        vessel = anatomy(data_dir, name)
        tree = vessel.centerline
        path = tree.path(tree.points[tree.roots[0]], tree.points[np.sort(tree.leaves)[0]])
        center = tree.project(path.points[3 * len(path.points) // 10])
        width = 2.1 * float(center.inscribed_radius)
        stent = Stent(width, placement=AtCenter(center.point), length=20.0)
    else:
        is_narrowed, tree = name == "stenosis", None
        vessel = phantoms.stenosed_tube() if is_narrowed else phantoms.straight_tube()
        beside = np.array([0.0 if is_narrowed else 0.6, 0, 0])
        axis = vessel.axis_at(np.linspace(8, 32, 40)) + beside
        stent = Stent(5.0, placement=AlongAxis(axis))
    settings = DeploymentSettings(certify=False)
    result = Treatment(vessel.surface, [stent], tree, settings).result
    (done,) = result.stents
    along, expected = free_by_vtk(result.surface, done.axis.points, stent.radius)
    found = done.apposition
    share = np.interp(along, found.arc_length, found.free_share)
    assert 0.1 < expected.mean() < 0.7
    assert share.mean() == pytest.approx(expected.mean(), abs=0.02)
    assert np.abs(share - expected).mean() < 0.03
    assert found.free_length == pytest.approx((expected > 0.1).mean() * along[-1], abs=1.0)


def test_a_short_thin_stent_from_which_all_wall_is_far_hangs_free():
    tube = phantoms.straight_tube(radius=9.0, length=60, edge_length=1.5)
    (stretch,) = apposition(tube.surface, [[0, 0, 29.0], [0, 0, 31.0]], 2.0).stretches
    assert (stretch.start, stretch.end, stretch.share) == pytest.approx((0, 2, 1.0))
    assert stretch.largest_gap == pytest.approx(7.0, abs=0.1)


@pytest.mark.parametrize(
    ("is_known", "name"),
    [(True, "branch of 15.3 mm at 19 mm"), (False, "side branch of 14.6 mm at 19 mm")],
)
def test_a_covered_branch_that_is_pinched_is_told(data_dir, is_known, name):
    """With the tree and the faces of a vessel, and without both."""
    file = read_surface(data_dir / "pulmonary_surface_cm.vtp", units="cm")
    tree = read_centerline(data_dir / "pulmonary_centerline_cm.vtp", units="cm")
    stent = Stent(20, length=25, placement=AtCenter((27.16, -54.26, 67.09)))
    if not is_known:
        stent = Stent(20, placement=AlongAxis(stent_axis(stent, tree).points))
    result = Treatment(
        file.surface,
        [stent],
        tree if is_known else None,
        DeploymentSettings(certify=False),
        faces=file.faces if is_known else None,
    ).result
    (treated,) = result.stents
    *ends, branch = treated.neighbors
    assert {end.name for end in ends} <= {
        "the vessel proximal of the stent",
        "the vessel distal of the stent",
    }
    assert branch.name == treated.branches[0].name == name
    assert branch.before == pytest.approx(9.03, abs=0.05)
    assert branch.after == pytest.approx(7.37, abs=0.05)
    assert branch.is_narrowed
    assert "narrowed from 9.0" in str(branch.caution())
    assert not any(end.is_narrowed for end in ends)
    told = [str(caution) for caution in result.warnings if caution.kind == "neighbor-narrowed"]
    assert len(told) == 1
    assert f"The lumen of {name} is narrowed from 9.0" in told[0]


def lumen_along(path, name="side branch 1"):
    return NeighborLumen(name, Line(path), 5.0, 4.0, 3.0, by_area=False)


def test_of_two_branches_with_one_name_both_are_told_and_of_one_branch_the_worst():
    def treated(number, *lumens, again=None):
        ostia = [Ostium(one.name, one.path.points[0], 2.0, 4.0, 12.0, 1.0) for one in lumens]
        axis = SimpleNamespace(deployed_length=10.0)
        return SimpleNamespace(
            number=number, row=number, branches=ostia, neighbors=lumens, again=again, axis=axis
        )

    first = lumen_along([[0, 0, 0], [20, 0, 0]])
    worse = replace(lumen_along([[0, 1, 0], [20, 1, 0]]), after=2.0)
    other = lumen_along([[0, 9, 0], [20, 9, 0]])
    wide = replace(lumen_along([[0, 9, 0], [20, 9, 0]]), after=4.0)
    end = lumen_along([[0, 0, 0], [0, 0, 20]], "the vessel distal of the stent")
    stents = [treated(1, first, other), treated(2, worse, wide), treated(3, end)]
    # Stent 4 is dilated again as stent 5: the vessel beyond is one, too.
    stents += [treated(4, end, again=5), treated(5, replace(end, after=2.5))]
    for stent in stents[2:]:
        stent.branches = []
    told = list(narrowed_neighbors(stents, lambda number: f"Stent {number}: "))
    labels = ["Stents 1 and 2: ", "Stent 1: ", "Stent 3: ", "Stents 4 and 5: "]
    assert [one.label for one in told] == labels
    assert [one.numbers["after_mm"] for one in told] == [2.0, 3.0, 3.0, 2.5]
    assert [one.stent for one in told] == [None, 1, 3, None]
    assert [lumen_into(one, stents[0]) for one in stents[0].branches] == [first, other]
    assert str(told[0]).endswith("5 mm beyond its origin.")
    assert str(told[2]).endswith("5 mm beyond the end of the stent.")
