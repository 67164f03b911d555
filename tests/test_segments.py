"""A segment between two places of a vessel, closed by flat caps in planes that meet only it."""

import re
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from deployment_cases import ANATOMIES, anatomy
from scipy.spatial import cKDTree
from test_own_lines import a_loop
from vtkmodules.vtkCommonDataModel import vtkPlane, vtkPlaneCollection
from vtkmodules.vtkFiltersCore import vtkConnectivityFilter, vtkMassProperties, vtkTriangleFilter
from vtkmodules.vtkFiltersGeneral import vtkClipClosedSurface

from benchmarks.phantoms import (
    arch_with_coarctation,
    branching_pulmonary_artery,
    hairpin_tube,
    stenosed_tube,
    straight_tube,
    tube_with_neighbor,
    vascular_tree,
)
from SDFStentLib import extract_centerline
from SDFStentLib.centerline import Centerline
from SDFStentLib.certificate import check_surface
from SDFStentLib.deformation import DeploymentSettings
from SDFStentLib.files import (
    polydata_from_arrays,
    read_centerline,
    read_surface,
    surface_from_polydata,
)
from SDFStentLib.geometry import Line, NamedFaces, Surface, signed_volume
from SDFStentLib.lumen import flat_caps
from SDFStentLib.segment import CutPlane, bounded
from SDFStentLib.stent import AtDistalEnd, Stent
from SDFStentLib.treatment import SegmentWishes, Treatment, Vessel, extract_segment
from SDFStentLib.validation import DeploymentError, InputError
from SDFStentLib.vessel import branch_names, vessel_parts


def vessel_of(phantom):
    return Vessel(phantom.surface, phantom.centerline, faces=NamedFaces(phantom.face_ids))


@cache
def vessel_at(folder, name):
    found = anatomy(folder, name)
    file, _, units = ANATOMIES[name]
    return Vessel(found.surface, found.centerline, faces=read_surface(folder / file, units).faces)


RIGHT, LEFT = 0, 1
"""The branches of `branching_pulmonary_artery`, by place as `way_to` counts them."""


def way_to(vessel, leaf=0):
    tree = vessel.centerline
    leaves = sorted(tree.leaves, key=lambda node: -tree.points[node][0])
    return tree.points[tree.ancestry(leaves[leaf])]


def segment_of(vessel, first, last, leaf=0, **wishes):
    """Between two parts of the way to a leaf."""
    way = way_to(vessel, leaf)
    ends = Line(way).at(np.array([first, last]) * Line(way).length)
    return extract_segment(vessel, *ends, SegmentWishes(**wishes))


def faces_of(segment):
    return {face.name: face for face in segment.faces}


def assert_closed_by_its_planes(found):
    """Sound, and every plane holds one flat cap that looks out of the segment."""
    segment = found.before
    check = check_surface(segment.surface)
    assert check.is_watertight
    assert check.passed
    assert segment.volume > 0
    for plane in found.planes:
        heights = np.abs((segment.surface.points - plane.origin) @ plane.normal)
        flat = [face for face in segment.faces if heights[corners_of(segment, face)].max() < 1e-9]
        # Both ends of a hairpin lie in one plane.
        cap = min(flat, key=lambda face: np.linalg.norm(face.center - plane.origin))
        np.testing.assert_allclose(cap.normal, -plane.normal, atol=1e-9)
        assert (cap.kind == "wall") is plane.is_closed


def corners_of(segment, face):
    return np.unique(segment.surface.triangles[segment.face_ids == face.number])


CASES = [
    (name, leaf, *part) for name in ANATOMIES for leaf, part in enumerate(((0.1, 0.9), (0.3, 0.95)))
]


@pytest.mark.parametrize("case", CASES, ids=lambda case: "-".join(map(str, case)))
def test_segments_of_anatomies_are_sound(data_dir, case):
    """With their branches kept in one leaf's way, closed in the other's."""
    name, leaf, first, last = case
    close = leaf == 1
    found = segment_of(vessel_at(data_dir, name), first, last, leaf, close_branches=close)
    assert_closed_by_its_planes(found)
    kinds = [face.kind for face in found.before.faces]
    assert kinds.count("inlet") == 1
    if close:
        assert kinds.count("outlet") == 1


@pytest.mark.parametrize("close", [False, True], ids=["branches kept", "branches closed"])
@pytest.mark.parametrize(
    "make", [stenosed_tube, hairpin_tube, tube_with_neighbor, branching_pulmonary_artery,
             arch_with_coarctation, lambda: vascular_tree(4, 1.0)],
)  # fmt: skip
def test_segments_of_phantoms_are_sound(make, close):
    found = segment_of(vessel_of(make()), 0.12, 0.88, close_branches=close)
    assert_closed_by_its_planes(found)


def by_vtk(surface, found):
    """The volume between two planes and the areas of its ends, by VTK alone."""
    outward = surface.triangles
    if signed_volume(surface.points, outward) < 0:
        outward = outward[:, ::-1]
    data = polydata_from_arrays(surface.points, outward)
    areas = []
    for plane in found.planes:
        data = clipped(data, plane)
    for plane in found.planes:
        ends = surface_from_polydata(data)
        heights = np.abs((ends.points - plane.origin) @ plane.normal)
        at_end = ends.triangles[(heights[ends.triangles] < 1e-6).all(axis=1)]
        first, second, third = ends.points[at_end].transpose(1, 0, 2)
        areas.append(0.5 * np.linalg.norm(np.cross(second - first, third - first), axis=1).sum())
    mass = vtkMassProperties()
    mass.SetInputData(data)
    return mass.GetVolume(), areas


def clipped(data, plane):
    """What is above a plane and hangs together with what is beside its origin."""
    half = vtkPlane()
    half.SetOrigin(*plane.origin)
    half.SetNormal(*plane.normal)
    planes = vtkPlaneCollection()
    planes.AddItem(half)
    clip = vtkClipClosedSurface()
    clip.SetInputData(data)
    clip.SetClippingPlanes(planes)
    part = vtkConnectivityFilter()
    part.SetInputConnection(clip.GetOutputPort())
    part.SetExtractionModeToClosestPointRegion()
    part.SetClosestPoint(*(plane.origin + 1e-3 * plane.normal))
    triangles = vtkTriangleFilter()
    triangles.SetInputConnection(part.GetOutputPort())
    triangles.PassVertsOff()
    triangles.PassLinesOff()
    triangles.Update()
    return triangles.GetOutput()


PARTS = [
    ("pulmonary", 0, 0.3, 0.6),
    ("pulmonary", 1, 0.3, 0.6),
    ("vmtk_aorta", 0, 0.1, 0.4),
    ("aorta_iliac", 1, 0.1, 0.4),
]


@pytest.mark.parametrize("part", PARTS, ids=lambda part: "-".join(map(str, part)))
def test_lumen_and_caps_of_an_anatomy_are_those_that_vtk_clips(data_dir, part):
    name, leaf, first, last = part
    vessel = vessel_at(data_dir, name)
    found = segment_of(vessel, first, last, leaf)
    volume, areas = by_vtk(vessel.surface, found)
    assert found.before.volume == pytest.approx(volume, rel=1e-4)
    # Points of the wall beside a plane move into it along a side: corners beside them are left out.
    caps = [faces_of(found.before)[name].area for name in ("inlet", "outlet")]
    assert caps == pytest.approx(areas, rel=1e-3)


@pytest.mark.parametrize("name", [pytest.param("pulmonary", marks=pytest.mark.bench), "vmtk_aorta"])
def test_tetgen_meshes_a_segment_without_repair(data_dir, name):
    judges = pytest.importorskip("test_outside_judges")
    for close in (False, True):
        segment = segment_of(vessel_at(data_dir, name), 0.12, 0.88, close_branches=close).before
        surface = segment.surface
        judges.assert_watertight(surface.points, surface.triangles)
        judges.assert_meshed_and_filled(surface.points, surface.triangles)
        if close:  # in one plane; MeshLab takes some neighbors there for crossing, TetGen is exact
            continue
        walls = {face.number for face in segment.faces if face.kind == "wall"}
        own = surface.triangles[np.isin(segment.face_ids, list(walls))]
        assert not len(judges.intersecting_faces(surface.points, own))


def test_a_segment_over_a_bifurcation_has_its_inlet_at_the_root():
    vessel = vessel_of(branching_pulmonary_artery())
    left, right = (
        Line(way_to(vessel, leaf)).at([0.8 * Line(way_to(vessel, leaf)).length])[0]
        for leaf in (0, 1)
    )
    kept = extract_segment(vessel, left, right).before
    faces = faces_of(kept)
    np.testing.assert_allclose(faces["inlet"].center, vessel.centerline.points[0], atol=0.1)
    assert [face.kind for face in kept.faces] == ["inlet", "outlet", "outlet", "wall"]
    # Both branches end where the user said; with the trunk closed the first is the inlet.
    closed = extract_segment(vessel, left, right, SegmentWishes(close_branches=True))
    faces = faces_of(closed.before)
    assert set(faces) == {"inlet", "outlet", "wall", "closed"}
    np.testing.assert_array_equal(closed.planes[0].origin, vessel.centerline.project(left).point)
    assert np.linalg.norm(faces["inlet"].center - left) < 0.2
    assert closed.before.volume < kept.volume


def test_planes_that_bound_nothing_with_the_others_are_told():
    """For one plane of a patient's 89 that lay beyond another 48 were left out, the inlet's too."""
    vessel = vessel_of(branching_pulmonary_artery())
    parts, planes = vessel_parts(vessel.surface, vessel.centerline), []
    for leaf, share in ((0, 0.1), (LEFT, 0.8), (RIGHT, 0.8), (RIGHT, 0.9), (RIGHT, 0.905)):
        line = Line(way_to(vessel, leaf))
        at = share * line.length
        turned = 1 if leaf == 0 and share < 0.5 else -1
        (place,), ahead = line.at([at]), line.at([at + 0.5])[0] - line.at([at - 0.5])[0]
        planes.append(CutPlane("", place, turned * ahead / np.linalg.norm(ahead)))
    inlet, left, right, beyond, _ = planes
    assert bounded(parts, [inlet, left, right]).apart == []
    assert bounded(parts, [inlet, beyond, left, right]).apart == [1]
    assert sorted(bounded(parts, planes).apart) == [3, 4]
    assert bounded(parts, [inlet, replace(left, normal=-left.normal), right]).apart == [1]
    nowhere = replace(left, origin=left.origin + 100.0)
    assert bounded(parts, [inlet, nowhere, left, right]).apart == [1]


def test_a_branch_that_the_centerline_does_not_know_is_said_to_stay_open():
    made = branching_pulmonary_artery()
    way = way_to(vessel_of(made), LEFT)
    alone = Centerline.from_lines(way, [np.arange(len(way))])
    vessel = Vessel(made.surface, alone)
    (told,) = segment_of(vessel, 0.1, 0.9, close_branches=True).warnings
    end = way_to(vessel_of(made), RIGHT)[-1]
    assert (told.kind, told.numbers["name"]) == ("branch-without-line", "outlet_face_3")
    np.testing.assert_allclose(told.place, end, atol=0.2)
    assert not segment_of(vessel, 0.1, 0.9).warnings
    assert not segment_of(vessel_of(made), 0.1, 0.9, close_branches=True).warnings


def test_an_open_end_within_the_segment_is_closed_flat():
    phantom = branching_pulmonary_artery()
    wall = phantom.triangles[phantom.face_ids == 1]
    used = np.unique(wall, return_inverse=True)
    surface = Surface(phantom.points[used[0]], used[1].reshape(-1, 3))
    assert surface.topology.boundary_edge_count > 0
    found = segment_of(Vessel(surface, phantom.centerline), 0.1, 0.9)
    whole = segment_of(vessel_of(phantom), 0.1, 0.9)
    assert_closed_by_its_planes(found)
    assert found.before.volume == pytest.approx(whole.before.volume, rel=1e-9)


def test_where_limbs_of_a_loop_meet_is_no_dead_end():
    """The limb that ends at its last point was told to be cut flat."""
    surface = a_loop((-15, 0))
    tree = extract_centerline(surface).centerline
    assert len(tree.loops) == 1
    ends = np.array([[28.0, 0, 0], [-30.0, 0, 0]])
    assert not extract_segment(Vessel(surface, tree), *ends).warnings


def test_a_branch_with_a_round_end_is_named(data_dir):
    found = segment_of(vessel_at(data_dir, "vmtk_aorta"), 0.1, 0.9)
    assert [caution.kind for caution in found.warnings] == ["dead-end"]
    assert not segment_of(vessel_at(data_dir, "vmtk_aorta"), 0.1, 0.9, close_branches=True).warnings
    assert not segment_of(vessel_at(data_dir, "pulmonary"), 0.1, 0.9).warnings


def test_a_plane_beside_a_bifurcation_is_refused_and_the_place_that_is_said_is_not():
    vessel = vessel_of(branching_pulmonary_artery())
    way = way_to(vessel, LEFT)
    with pytest.raises(InputError, match="meets only this vessel") as error:
        extract_segment(vessel, *Line(way).at([0.4 * Line(way).length, 0.9 * Line(way).length]))
    place = str(error.value).split("to (")[1].split(") mm")[0].split(", ")
    found = extract_segment(
        vessel, [float(x) for x in place], Line(way).at([0.9 * Line(way).length])[0]
    )
    assert_closed_by_its_planes(found)
    # Beyond the bifurcation it is as wide as its branch.
    assert faces_of(found.before)["inlet"].area < 1.5 * faces_of(found.before)["outlet"].area


def test_no_section_of_a_bifurcation_that_is_let_through_is_as_wide_as_two_vessels(data_dir):
    """Against the widest section of each branch, away from where they part."""
    vessel = vessel_at(data_dir, "vmtk_aorta")
    way = way_to(vessel, 1)
    allowed = {}
    for at in np.arange(30.0, 60.0, 1.5):
        try:
            found = extract_segment(vessel, *Line(way).at([at, 68.0]))
        except InputError:
            continue
        allowed[at] = faces_of(found.before)["inlet"].area
    # About 185 mm2 before and 65 after; where it divides sections have up to 213 mm2.
    assert all(area < 80 or (area < 190 and at < 38) for at, area in allowed.items())
    assert min(at for at, area in allowed.items() if area < 80) < 51
    assert len(allowed) > 10


BAD = {
    "far from an end": (
        ([0, 0, 8], [0, 0, 400]),
        "expected a place in the vessel, got one 360.0 mm",
    ),
    "the same place": (([0, 0, 8], [0, 0, 8]), "expected two places apart"),
    "off the vessel": (([40, 0, 8], [0, 0, 30]), "expected a place in the vessel, got one 40.0 mm"),
    "too near": (([0, 0, 20], [0, 0, 20.2]), "the second meets the other one within the vessel"),
    "not finite": (([np.nan, 0, 8], [0, 0, 30]), "finite"),
}


@pytest.mark.parametrize("name", BAD)
def test_places_that_cannot_be_are_a_sentence(name):
    ends, words = BAD[name]
    with pytest.raises(InputError, match=words):
        extract_segment(vessel_of(straight_tube()), *ends)


def test_a_vessel_without_a_centerline_and_places_in_two_vessels_are_a_sentence():
    with pytest.raises(InputError, match="expected a vessel with a centerline"):
        extract_segment(Vessel(straight_tube().surface), [0, 0, 8], [0, 0, 30])
    vessel = vessel_of(tube_with_neighbor())
    first, second = vessel.centerline.points[vessel.centerline.roots] + [0, 0, 8.0]
    with pytest.raises(InputError, match="one vessel tree"):
        extract_segment(vessel, first, second)


def test_a_hole_in_the_wall_where_a_plane_is_is_a_sentence():
    tube = straight_tube()
    middle = tube.points[tube.triangles].mean(axis=1)
    hole = (np.abs(middle[:, 2] - 10) < 1.5) & (middle[:, 0] > 2)
    vessel = Vessel(Surface(tube.points, tube.triangles[~hole]), tube.centerline)
    with pytest.raises(InputError, match="open end"):
        extract_segment(vessel, [0, 0, 10], [0, 0, 30])


@pytest.mark.parametrize("is_capped", [True, False])
def test_a_hole_in_the_wall_is_no_outlet_and_is_said_to_be_there(is_capped):
    """Closed as wall; ends where the centerline ends are outlets, open or not."""
    tube = straight_tube(edge_length=0.8)
    middle = tube.points[tube.triangles].mean(axis=1)
    hole = (np.abs(middle[:, 2] - 20) < 1.0) & (np.abs(middle[:, 1]) < 1.0) & (middle[:, 0] > 2)
    gone = hole if is_capped else hole | (middle[:, 2] > 39.99)
    vessel = Vessel(Surface(tube.points, tube.triangles[~gone]), tube.centerline)
    closed = extract_segment(Vessel(tube.surface, tube.centerline), [0, 0, 10], [0, 0, 30]).before
    found = extract_segment(vessel, [0, 0, 10], [0, 0, 30], SegmentWishes(units="cm"))
    faces = {face.name: face for face in found.before.faces}
    assert set(faces) == {"inlet", "outlet", "wall", "hole"}
    assert faces["hole"].kind == "wall"
    assert found.before.walls == {faces["wall"].number, faces["hole"].number}
    assert found.before.volume == pytest.approx(closed.volume, rel=0.01)
    (said,) = found.warnings
    assert re.search(
        r"^The wall is open at \(2\.\d+, .*\) mm \(in the file 0\.2\d+, .* cm\), [12]\.\d mm wide, "
        r"where no centerline ends: closed as wall, face hole;",
        said.sentence(units="cm"),
    )


@pytest.mark.parametrize("seed", [2, 3])
@pytest.mark.parametrize("name", ["branching", "pulmonary"])
def test_holes_beside_the_planes_are_closed_as_wall_and_told(data_dir, name, seed):
    """Open or capped ends, one to three holes: sound, as large as without them, and told."""
    made = branching_pulmonary_artery(edge_length=0.8)
    vessel = vessel_of(made) if name == "branching" else vessel_at(data_dir, name)
    points, triangles = vessel.surface.points, vessel.surface.triangles
    leaf = int(seed > 1)
    way, middles = way_to(vessel, leaf), points[triangles].mean(axis=1)
    along = (Line(way).arc_lengths / Line(way).length)[cKDTree(way).query(middles)[1]]
    within = np.flatnonzero((along > 0.4) & (along < 0.7))
    gone = np.zeros(len(triangles), dtype=bool)
    for middle in middles[np.random.default_rng(seed).choice(within, 1 + seed % 3)]:
        gone |= np.linalg.norm(middles - middle, axis=1) < 1.0
    if seed % 2:
        for cap in flat_caps(points, triangles):
            gone[cap.faces] = True
    places = {"first": 0.3, "last": 0.8, "leaf": leaf}
    whole = segment_of(Vessel(vessel.surface, vessel.centerline), **places)
    found = segment_of(Vessel(Surface(points, triangles[~gone]), vessel.centerline), **places)
    assert_closed_by_its_planes(found)
    assert found.before.volume == pytest.approx(whole.before.volume, rel=0.005)
    holes = [face for face in found.before.faces if face.name.startswith("hole")]
    assert 1 <= len(holes) == len([one for one in found.warnings if one.kind == "hole"])
    assert len(found.before.faces) - len(holes) == len(whole.before.faces)


def test_refused_places_are_told_in_the_files_unit_and_along_their_branch(data_dir):
    """What is told can be typed again, and is what it says."""
    vessel = vessel_at(data_dir, "pulmonary")
    way = way_to(vessel)
    ends = Line(way).at(np.array([0.02, 0.5]) * Line(way).length)
    with pytest.raises(InputError, match=r"an end of the vessel; move it 2\.0 mm into") as refused:
        extract_segment(vessel, *ends, SegmentWishes(units="cm"))
    place = r"\((.*?)\) mm \(in the file (.*?) cm\), (.*?) mm along (.*?)"
    first, second = re.findall(place + r"[,.](?: |$)", str(refused.value))
    for told, expected in ((first, ends[0]), (second, None)):
        point = np.array(told[0].split(", "), float)
        np.testing.assert_allclose(10 * np.array(told[1].split(", "), float), point, atol=0.03)
        names = branch_names(vessel.surface, vessel.centerline, vessel.faces)
        at = vessel.centerline.point_at(names.index(told[3]), float(told[2]))
        assert np.linalg.norm(at - point) < 0.1
        if expected is not None:
            np.testing.assert_allclose(point, expected, atol=0.02)
    again = 10 * np.array(second[1].split(", "), float)
    assert extract_segment(vessel, again, ends[1]).before.volume > 0


def test_a_wall_that_crosses_itself_is_a_sentence():
    tube = straight_tube()
    points = tube.points.copy()
    inner = (np.abs(points[:, 2] - 20) < 0.6) & (points[:, 0] > 0)
    points[inner, 0] -= 7
    vessel = Vessel(tube.surface.with_points(points), tube.centerline)
    with pytest.raises(DeploymentError, match="expected one that is watertight and sound"):
        extract_segment(vessel, [0, 0, 10], [0, 0, 30])


def test_a_plane_that_meets_another_vessel_after_treatment_only_is_refused(data_dir):
    """A stent in the left artery opens its ostium: the plane cut off the trunk with it, 5.3 cm2."""
    file = read_surface(data_dir / "su0243_surface_mm.vtp")
    tree = read_centerline(data_dir / "su0243_centerline_mm.vtp")
    vessel = Vessel(file.surface, tree, faces=file.faces)
    stent = Stent(6.0, length=34, placement=AtDistalEnd((12.436, -70.277, -63.72)))
    settings = DeploymentSettings(certify=False)
    treated = Treatment(file.surface, [stent], tree, settings).result.surface
    after = Vessel(treated, tree, faces=file.faces)
    ends = [2.72, -88.7, -50.39], [12.436, -70.277, -63.72]
    with pytest.raises(InputError, match="into another vessel after treatment; move it 0"):
        extract_segment(vessel, *ends, after=after)
