"""From a segmentation to a surface with flat, named ends and its centerline."""

import gzip
import json
import struct
import tracemalloc
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import round_tubes
import SimpleITK
from scipy import ndimage
from segmentations import FORK, named, voxels, write

from benchmarks.voxels import errors, voxel_tube
from SDFStentLib.centerline import Centerline
from SDFStentLib.certificate import check_surface, self_intersecting_triangles
from SDFStentLib.cli import main
from SDFStentLib.files import read_lines, read_surface
from SDFStentLib.geometry import Surface, edges, signed_volume
from SDFStentLib.lumen import inscribed_spheres
from SDFStentLib.scan import (
    Labelmap,
    contoured,
    largest_piece,
    prepared_vessel,
    read_segmentation,
    wall_distance,
)
from SDFStentLib.scan.contour import unfolded
from SDFStentLib.scan.ends import flat_ends, round_ends_of
from SDFStentLib.scan.wall_distance import SHARE, WIDTHS
from SDFStentLib.segment import closed_segment
from SDFStentLib.validation import DeploymentError, InputError

SIDE = 0.9
"""Of the voxels of the fork, mm."""


def prepare(path, *more, out="made"):
    return main(["prepare", str(path), "-o", str(path.parent / out), *more])


def labelmap(mask, spacing=1.0, origin=(0, 0, 0), directions=None):
    sides = np.broadcast_to(spacing, 3)
    return Labelmap(mask, sides, origin, np.eye(3) if directions is None else directions)


@pytest.fixture(scope="module")
def fork():
    return voxels(FORK, SIDE)


@pytest.fixture(scope="module")
def vessel(fork):
    mask, low = fork
    return prepared_vessel(labelmap(mask, SIDE, low))


@pytest.mark.parametrize("spacing", [(0.5, 0.5, 0.5), (0.4, 0.4, 0.8)])
def test_diameters_are_those_of_the_tube_within_a_quarter_voxel(spacing):
    tube = voxel_tube(7.0, np.array(spacing), 0.1, 3)
    off = errors(contoured(wall_distance(tube.labelmap), tube.labelmap.spacing), tube)
    is_wide = 2 * tube.radii[np.arange(200, 1001, 40)] > 6 * tube.labelmap.voxel
    assert np.abs(off[is_wide]).mean() < 0.25


def plain_wall_distance(labelmap):
    """The same, by filters of the whole image."""
    spacing, voxel = labelmap.spacing, labelmap.voxel
    inside = ndimage.distance_transform_edt(labelmap.mask, sampling=spacing)
    distance = ndimage.distance_transform_edt(~labelmap.mask, sampling=spacing) - inside
    distance = distance.astype(np.float32)

    def filtered(width):
        once = ndimage.gaussian_filter(distance, width * voxel / spacing, mode="nearest")
        return 2 * once - ndimage.gaussian_filter(once, width * voxel / spacing, mode="nearest")

    depth, steps = -filtered(1.0) / voxel, np.array(WIDTHS) / SHARE
    radius, diagonal = np.full_like(depth, steps[0]), np.linalg.norm(spacing) / voxel
    for least, most in zip(steps, [*steps[1:], np.inf], strict=True):
        own = np.where((depth >= least) & (depth < most), np.minimum(depth, steps[-1]), 0)
        sides = 2 * np.rint((least + diagonal) * voxel / spacing).astype(int) + 1
        radius = np.maximum(radius, ndimage.maximum_filter(own, sides.tolist()))
    radius = ndimage.gaussian_filter(radius, 1.0)
    level = np.interp(np.log(SHARE * radius), np.log(WIDTHS), np.arange(len(WIDTHS)))
    shares = [np.clip(1 - np.abs(level - number), 0, 1) for number in range(len(WIDTHS))]
    found = sum(share * filtered(width) for share, width in zip(shares, WIDTHS, strict=True))
    seen = np.where(distance < 2 * spacing.max(), -depth * voxel, distance)
    off = (found - seen) / spacing.max()
    kept = np.interp(np.abs(off), (0.0, 0.5, 1.5), (0.0, 0.5, 0.0))
    return seen + spacing.max() * np.sign(off) * kept


@pytest.mark.parametrize("spacing", [(0.5, 0.5, 0.5), (0.3, 0.3, 0.6)])
def test_filters_of_parts_of_the_image_are_those_of_the_whole_near_the_wall(spacing):
    tube = voxel_tube(9.0, np.array(spacing), 0.1, 5).labelmap
    found, plain = wall_distance(tube), plain_wall_distance(tube)
    near = np.abs(plain) < 2 * tube.voxel
    assert found[near] == pytest.approx(plain[near], abs=1e-5)  # single precision
    assert (np.sign(found) == np.sign(plain)).all()


def test_a_label_that_fills_its_image_has_a_distance_as_by_the_transform_of_the_whole():
    full = labelmap(np.ones((6, 7, 8), dtype=bool))
    found = wall_distance(full)
    near = plain_wall_distance(full) > -4
    assert found[near] == pytest.approx(plain_wall_distance(full)[near], abs=1e-5)


@pytest.mark.parametrize("trunk", [4.9, 12.0])
@pytest.mark.parametrize("way", [(1, 0, 0), (1, 1, 0), (1, 1, 1), (-0.72, 0.68, 0.17)])
def test_a_branch_is_as_wide_where_it_leaves_a_wide_trunk(trunk, way):
    """Aslant to the axes it was filtered as wide as the trunk allows: 0.6 mm of 3.3 were left."""
    way, radius, spacing = np.array(way) / np.linalg.norm(way), 0.34 * trunk, 0.14 * trunk
    reach = trunk + 6 * radius
    sides = [np.arange(-reach - 2 * spacing, reach + 3 * spacing, spacing)] * 3
    places = np.stack(np.meshgrid(*sides, indexing="ij"), axis=-1)
    along = places @ way
    aside = np.linalg.norm(places - along[..., None] * way, axis=-1)
    mask = np.hypot(*places[..., :2].transpose(3, 0, 1, 2)) < trunk
    mask |= (aside < radius) & (along > 0) & (along < reach)
    found = wall_distance(labelmap(mask, spacing))
    first = np.cross(way, (0.3, 0.5, 1.0))
    first /= np.linalg.norm(first)
    turn = np.linspace(0, 2 * np.pi, 48, endpoint=False)
    across = np.cos(turn)[:, None] * first + np.sin(turn)[:, None] * np.cross(way, first)
    out = np.arange(0.0, 1.5 * radius, 0.05 * radius)
    for at in np.arange(trunk, trunk + 3 * radius, spacing / 2):
        rays = at * way + out[:, None, None] * across
        where = np.moveaxis((rays - sides[0][0]) / spacing, -1, 0)
        is_wall = ndimage.map_coordinates(found, where, order=1) > 0
        wide = np.where(is_wall.any(axis=0), out[is_wall.argmax(axis=0)], np.inf)
        assert np.median(wide) > radius - spacing / 2


def beside_a_trunk(lean):
    """A branch beside a trunk, at an angle of some degrees, narrowed to half where it begins."""
    way = np.array([np.sin(np.deg2rad(lean)), 0.0, np.cos(np.deg2rad(lean))])
    places = [(0, 0, 12) + along * way for along in (6.0, 9.0, 12.0, 15.0, 24.0)]
    radii = (3.0, 3.0, 1.5, 3.0, 3.0)
    pieces = [(*pair, *both) for pair, both in zip(pairwise(places), pairwise(radii), strict=True)]
    return [((0, 0, 0), (0, 0, 40), 4.5, 4.5), *pieces], np.array([places[2]]), way[None]


@pytest.mark.parametrize("lean", [30, 40, 50])
@pytest.mark.parametrize("spacing", [0.3, 0.4])
def test_a_throat_beside_another_vessel_is_as_wide_as_in_the_label(lean, spacing):
    """Filters as wide as the vessels around it evened it out: 3.7 mm of 3 mm."""
    pieces, place, way = beside_a_trunk(lean)
    mask, low = voxels(pieces, spacing)
    made = contoured(wall_distance(labelmap(mask, spacing)), np.full(3, spacing))
    true = round_tubes.contoured(pieces, 0.15)
    found, known = (
        2 * float(inscribed_spheres(one.points, one.triangles, at, way).radii[0])
        for one, at in ((made, place - low), (true, place))
    )
    assert found == pytest.approx(known, abs=spacing)  # half a step on both sides


def test_a_thin_vessel_beside_a_wide_one_stays():
    """One of two voxels was filtered as wide as the trunk beside which it runs."""
    pieces = [((0, 0, 0), (0, 0, 40), 6, 6), ((0, 0, 10), (8.5, 0, 14), 0.6, 0.6)]
    pieces += [((8.5, 0, 14), (8.5, 0, 38), 0.6, 0.6)]
    mask, low = voxels(pieces, 0.5)
    found = wall_distance(labelmap(mask, 0.5))
    axis = np.column_stack([np.full(30, 8.5), np.zeros(30), np.linspace(15, 37, 30)])
    assert (ndimage.map_coordinates(found, ((axis - low) / 0.5).T, order=1) < 0).all()


def test_the_ends_are_flat_and_named_the_widest_is_the_inlet(vessel):
    assert [end.name for end in vessel.ends] == ["inlet", "outlet_1", "outlet_2"]
    inlet, *outlets = (end.diameter for end in vessel.ends)
    assert [inlet, *sorted(outlets)] == pytest.approx([8, 5.2, 6], abs=0.4)
    for end in vessel.ends:
        corners = vessel.surface.points[vessel.surface.triangles[vessel.faces.ids == end.number]]
        middle = corners.mean(axis=1)
        across = np.linalg.svd(middle - middle.mean(axis=0))[2][2]
        assert np.abs((corners - middle.mean(axis=0)) @ across).max() < 1e-6
    assert set(vessel.faces.names.values()) == {"inlet", "outlet_1", "outlet_2", "wall"}


def test_a_wide_trunk_is_cut_though_its_lines_part_at_once():
    """As in a patient's main artery, 17 mm wide, whose lines part 3 mm from its tip."""
    trunk = [(0, 0, 0), (0, 0, 1)]
    right = [(0.6, 0, 3), (0.6, 0, 10), (0.6, 0, 20), (3, 0, 32), (11, 0, 48)]
    left = [(-x, y, z) for x, y, z in right]
    points = np.array([*trunk, *right, *left], dtype=float)
    parent = np.array([-1, 0, 1, 2, 3, 4, 5, 1, 7, 8, 9, 10])
    tree = Centerline(points, np.where(points[:, 2] < 22, 3.9, 2.6), parent)
    ends = round_ends_of(tree, [])
    found = flat_ends(round_tubes.contoured(FORK, 0.6), tree, ends, None)
    assert None not in found.planes
    inlet, *outlets = (face for face in found.segment.faces if face.kind != "wall")
    assert inlet.name == "inlet"
    assert 2 * np.sqrt(inlet.area / np.pi) == pytest.approx(8.0, abs=0.2)
    assert all(face.area < inlet.area for face in outlets)


@pytest.mark.parametrize("left", [0.7, 1.5, 2.5])
def test_a_trunk_that_is_cut_off_short_is_the_inlet(left):
    """Shorter than three of its radii it was no end, which nothing told, and a branch the inlet."""
    mask, origin = voxels(FORK, 0.55)
    cut_at = 26 - 4 * left
    mask &= origin[2] + 0.55 * np.arange(mask.shape[2]) > cut_at
    found = prepared_vessel(Labelmap(mask, np.full(3, 0.55), origin, np.eye(3)))
    inlet, *outlets = found.ends
    assert len(outlets) == 2
    assert inlet.center == pytest.approx([0, 0, cut_at], abs=6.0)
    assert inlet.diameter > max(outlet.diameter for outlet in outlets)


@pytest.mark.parametrize(
    ("radius", "side", "left", "lean"), [(6.6, 0.54, 14, 9), (5.8, 0.52, 16, 2)]
)
def test_a_trunk_that_was_cut_flat_is_the_inlet_up_to_there(radius, side, left, lean):
    """Its line ended in the round rim: 1.3 radii of it were cut off."""
    pieces = [
        ((0, 0, -30), (0, 0, 0), radius, 0.9 * radius),
        ((0, 0, 0), (2 * radius, 0, 3.5 * radius), 0.75 * radius, 0.6 * radius),
        ((0, 0, 0), (-2 * radius, 0.3 * radius, 3 * radius), 0.65 * radius, 0.5 * radius),
    ]
    mask, low = voxels(pieces, side)
    across = np.array([np.sin(np.deg2rad(lean)), 0.0, np.cos(np.deg2rad(lean))])
    middle = np.array([0.0, 0.0, -left])
    beyond = (np.indices(mask.shape).T * side + low - middle) @ across
    found = prepared_vessel(labelmap(mask & (beyond.T > 0), side, low))
    inlet, *outlets = found.ends
    assert len(outlets) == 2
    assert (inlet.center - middle) @ across < radius


def test_the_surface_is_closed_and_wound_outward(vessel):
    found = check_surface(vessel.surface)
    assert found.passed
    assert found.is_watertight
    assert vessel.warnings == ()
    assert signed_volume(vessel.surface.points, vessel.surface.triangles) > 0


def test_lines_lead_from_the_inlet_to_every_outlet(vessel):
    lines = vessel.lines
    assert len(lines.lines) == 2
    for line, end in zip(lines.lines, vessel.ends[1:], strict=True):
        for at, cap in ((0, vessel.ends[0]), (-1, end)):
            assert np.linalg.norm(lines.points[line[at]] - cap.center) < 1e-6
        assert vessel.surface.contains(lines.points[line[1:-1]]).all()
        assert lines.inscribed_radius[line[-1]] == pytest.approx(end.diameter / 2, rel=0.1)
        assert end.name.startswith("outlet")


def test_a_place_names_another_inlet(fork):
    mask, low = fork
    found = prepared_vessel(labelmap(mask, SIDE, low), np.array([11.0, 0, 48]))
    assert found.ends[0].diameter == pytest.approx(6, abs=0.5)
    assert np.linalg.norm(found.ends[0].center - (11, 0, 48)) < 5
    starts = {int(line[0]) for line in found.lines.lines}
    assert np.linalg.norm(found.lines.points[starts.pop()] - found.ends[0].center) < 1e-6
    assert not starts
    with pytest.raises(InputError, match=r"inlet: .* the nearest end is .* mm away"):
        prepared_vessel(labelmap(mask, SIDE, low), np.array([90.0, 0, 48]))


@pytest.mark.parametrize("turned", [1.0, -1.0])
def test_orientation_moves_the_vessel_and_keeps_it_outward(fork, vessel, turned):
    mask, low = fork
    axes = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
    axes *= turned * np.sign(np.linalg.det(axes))
    found = prepared_vessel(labelmap(mask, SIDE, axes @ low, axes))
    assert signed_volume(found.surface.points, found.surface.triangles) == pytest.approx(
        signed_volume(vessel.surface.points, vessel.surface.triangles)
    )
    moved = np.array([end.center for end in vessel.ends]) @ axes.T
    np.testing.assert_allclose([end.center for end in found.ends], moved, atol=1e-6)


def test_a_fault_has_its_place_in_the_patient(fork, monkeypatch):
    judged = []

    def judge(surface):
        judged.append(surface.points)
        return check_surface(surface)

    mask, low = fork
    axes = np.diag([-1.0, 1.0, -1.0])
    label = labelmap(mask, SIDE, axes @ low, axes)
    found = prepared_vessel(label)
    monkeypatch.setattr("SDFStentLib.scan.prepared.check_surface", judge)
    monkeypatch.setattr(
        "SDFStentLib.scan.prepared.flat_ends",
        lambda *given: flat_ends(*given)._replace(is_sound=False),
    )
    with pytest.raises(DeploymentError, match="expected a sound surface"):
        prepared_vessel(label)
    np.testing.assert_array_equal(judged[0], found.surface.points)


def test_a_plane_that_spoils_the_wall_makes_place_for_the_next_one(fork, monkeypatch):
    made = []

    def spoiled_at_first(opened):
        segment = closed_segment(opened)
        if not made:
            (cap,) = (face.number for face in segment.faces if face.said == "1")
            points = segment.surface.points.copy()
            first, second, third = segment.surface.triangles[segment.face_ids == cap][0]
            points[first] = (points[second] + points[third]) / 2
            segment = replace(segment, surface=Surface(points, segment.surface.triangles))
        made.append({plane.name: plane.origin for plane in opened.planes})
        return segment

    monkeypatch.setattr("SDFStentLib.scan.ends.closed_segment", spoiled_at_first)
    mask, low = fork
    found = prepared_vessel(labelmap(mask, SIDE, low))
    assert check_surface(found.surface).passed
    assert len(found.ends) == 3
    assert len(made) == 2
    moved = {name: np.linalg.norm(made[1][name] - made[0][name]) for name in made[0]}
    assert moved["0"] == moved["2"] == 0.0
    assert 0.1 < moved["1"] < 2.0


def test_an_end_that_a_handle_leads_round_is_cut_beyond_it():
    """A closed ring beside the end, as of a stump that touches again: nothing was cut off there."""
    ring = [
        ((3, 0, 2), (11, 0, 2), 2, 2),
        ((11, 0, 2), (11, 0, 9), 2, 2),
        ((11, 0, 9), (3, 0, 9), 2, 2),
    ]
    mask, low = voxels([((0, 0, 0), (0, 0, 44), 6, 6), *ring], 1.0)
    found = prepared_vessel(labelmap(mask, 1.0, low))
    low_end = min(found.ends, key=lambda end: end.center[2])
    assert 8.0 < low_end.center[2] < 12.0
    assert low_end.diameter == pytest.approx(12.0, abs=1.0)


@pytest.mark.parametrize("depth", [1, 2, 3])
def test_a_hollow_in_the_last_slice_of_the_image_is_no_tunnel_beside_its_end(depth):
    """Prolonged beyond the image, it led round the plane of that end, or lines ended beside it."""
    mask, low = voxels([((0, 0, 0), (0, 0, 40), 7, 7)], 1.0)
    x, y, z = np.round(-low).astype(int)
    mask = mask[:, :, z + 8 :].copy()
    mask[x - 2 : x + 3, y + 2 : y + 4, :depth] = False
    mask[x - 2 : x + 3, y + 2 :, depth - 1 : depth + 1] = False  # it comes out at the side
    found = prepared_vessel(labelmap(mask))
    first, last = sorted(found.ends, key=lambda end: end.center[2])
    assert first.center[2] < 1.0
    assert first.diameter == pytest.approx(12.7, abs=0.7)
    assert last.diameter == pytest.approx(13.7, abs=0.3)


def test_where_the_image_ends_the_vessel_is_cut_along_its_border(fork):
    mask, low = fork
    first = int(np.ceil((10 - low[2]) / SIDE))
    begin = low + np.array([0, 0, first * SIDE])
    found = prepared_vessel(labelmap(mask[:, :, first:], SIDE, begin))
    (end,) = [end for end in found.ends if end.is_at_border]
    assert end.name == "inlet"
    assert end.center[2] == pytest.approx(begin[2] - SIDE / 2)
    assert "at inlet" in " ".join(one.sentence() for one in found.warnings)


def test_bits_that_hang_free_are_left_out_and_hollows_filled(fork):
    mask = fork[0].copy()
    mask[1:3, 1:3, 1:3] = True
    middle = tuple(np.argwhere(fork[0]).mean(axis=0).round().astype(int))
    inner = np.argwhere(fork[0])
    inner = tuple(inner[np.abs(inner - [middle[0], middle[1], 20]).sum(axis=1).argmin()])
    mask[inner] = False
    found = largest_piece(labelmap(mask))
    assert (found.left_out, found.left_volume, found.filled) == (1, 8, 1)
    said = " ".join(one.sentence() for one in prepared_vessel(labelmap(mask)).warnings)
    assert "1 loose parts of the label, 8 mm3, were left out." in said


def test_the_image_beside_a_label_takes_next_to_no_memory():
    mask = np.zeros((200, 200, 200), dtype=bool)
    mask[150:170, 20:30, 90:100] = True
    tracemalloc.start()
    found = largest_piece(labelmap(mask, origin=(-20, 0, 5)))
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < mask.size / 10
    assert found.labelmap.mask.all()
    assert found.labelmap.mask.shape == (20, 10, 10)
    assert found.labelmap.origin.tolist() == [130, 20, 95]
    assert found.is_cut == ((False, False),) * 3


def test_vessels_that_touch_are_told_and_where():
    """Two tubes across each other, 4 and 3 mm in radius, whose walls touch."""
    across = ((-30, 7, 30), (30, 7, 30), 3, 3)
    mask, low = voxels([((0, 0, 0), (0, 0, 60), 4, 4), across], SIDE)
    made = prepared_vessel(labelmap(mask, SIDE, low))
    (found,) = [one for one in made.warnings if one.kind == "thin-bridge"]
    assert np.linalg.norm(np.array(found.place) - (0, 4, 30)) < 2 * SIDE
    assert "part vessels that touch" in found.sentence()


def test_branches_that_overlap_are_told_as_a_loop_and_where():
    """Two branches that come together again by more than two voxels: a real loop, or they touch."""
    pieces = [((0, 0, 0), (0, 0, 25), 4, 4)]
    for x in (-1, 1):
        ways = [(0, 0, 25), (13 * x, 0, 45), (2 * x, 0, 65), (13 * x, 0, 88)]
        pieces += [(one, other, 3, 3) for one, other in pairwise(ways)]
    mask, low = voxels(pieces, SIDE)
    made = prepared_vessel(labelmap(mask, SIDE, low))
    (found,) = [one for one in made.warnings if one.kind in ("limbs-meet", "thin-bridge")]
    assert np.linalg.norm(np.array(found.place) - (0, 0, 65)) < 6
    assert found.sentence().startswith("Limbs that meet again: 1, one near (")
    assert found.sentence().endswith("part vessels that touch.")


def test_vessels_beyond_a_place_too_thin_for_the_voxels_are_told():
    """The surface parted there, and what lay beyond was gone in silence."""
    radii = [(0, 1.5), (9, 1.5), (15, 0.35), (21, 1.5), (30, 1.5)]
    pieces = [
        ((one, 0, 20), (other, 0, 20), wide, narrow)
        for (one, wide), (other, narrow) in pairwise(radii)
    ]
    mask, low = voxels([*FORK, *pieces], 0.5)
    assert ndimage.label(mask, np.ones((3, 3, 3)))[1] == 1
    made = prepared_vessel(labelmap(mask, 0.5, low))
    (found,) = [one for one in made.warnings if one.kind == "thin-parts"]
    assert found.place == pytest.approx((15, 0, 20), abs=1.0)
    assert "were left out: widen the label there" in found.sentence()


def test_segments_are_chosen_by_name_number_and_layer(tmp_path, fork):
    mask = fork[0]
    other = np.zeros_like(mask)
    other[:8, :8, :8] = True
    stack = np.stack([2 * mask, other], axis=-1).astype(np.uint8)
    texts = named(artery=(2, 0), heart=(1, 1), none=(7, 0))
    path = write(tmp_path / "two.seg.nrrd", stack, texts=texts)
    for word in ("artery", "2", 2):
        np.testing.assert_array_equal(read_segmentation(path, word).labelmap.mask, mask)
    assert read_segmentation(path, "heart").labelmap.mask.sum() == 512
    with pytest.raises(InputError, match=r"one label, got 2: 2 \(artery\), 1 \(heart\)"):
        read_segmentation(path)
    with pytest.raises(InputError, match=r"voxels of none, this segment is empty"):
        read_segmentation(path, "none")
    with pytest.raises(InputError, match=r"a label that is there, got 9"):
        read_segmentation(path, 9)


@pytest.mark.parametrize("suffix", [".nii.gz", ".nii", ".mha", ".nrrd"])
def test_spacing_place_and_direction_are_those_of_the_header(tmp_path, fork, suffix):
    axes = np.diag([-1.0, -1.0, 1.0])
    path = tmp_path / f"a{suffix}"
    write(path, fork[0], (5, 6, 7), (0.5, 0.6, 0.7), axes)
    found = read_segmentation(path).labelmap
    np.testing.assert_allclose(found.spacing, [0.5, 0.6, 0.7], atol=1e-6)
    np.testing.assert_allclose(found.origin, [5, 6, 7], atol=1e-5)
    np.testing.assert_allclose(found.directions, axes, atol=1e-6)


def test_the_command_writes_a_folder_that_other_commands_read(tmp_path, fork, capsys):
    mask, low = fork
    path = write(tmp_path / "artery.seg.nrrd", mask, low, SIDE, texts=named(artery=(1, 0)))
    assert prepare(path, "--label", "artery") == 0
    said = capsys.readouterr().out
    assert "Voxels of 0.9 mm: diameters +-0.18 mm on the average" in said
    surface = read_surface(tmp_path / "made" / "surface.vtp")
    assert surface.frame == "LPS"
    assert surface.faces.names[int(surface.faces.ids.max())].startswith("outlet")
    assert len(read_lines(tmp_path / "made" / "centerline.vtp").lines) == 2
    document = json.loads((tmp_path / "made" / "prepared.json").read_text(encoding="utf-8"))
    assert document["voxel_spacing_mm"] == [0.9] * 3
    assert document["inputs"]["label"] == {"value": 1, "name": "artery"}
    assert len(document["ends"]) == 3
    page = (tmp_path / "made" / "prepared.html").read_text(encoding="utf-8")
    assert "outlet_2" in page
    measured = ["measure", str(tmp_path / "made" / "surface.vtp"), "--centerline"]
    assert main([*measured, str(tmp_path / "made" / "centerline.vtp")]) == 0
    assert prepare(path) == 0  # its own folder is replaced


def test_bad_inputs_are_a_sentence_each_and_nothing_is_written(tmp_path, fork, capsys):
    mask = fork[0]
    rng = np.random.default_rng(1)
    ct = rng.integers(-1000, 400, mask.shape).astype(np.int16)
    four = tmp_path / "four.nii.gz"
    SimpleITK.WriteImage(
        SimpleITK.GetImageFromArray(np.ones((2, 3, 4, 5), np.uint8), isVector=False), str(four)
    )
    flat = bytearray(gzip.decompress(write(tmp_path / "flat.nii.gz", mask).read_bytes()))
    flat[80:84] = struct.pack("<f", 0.0)
    (tmp_path / "flat.nii").write_bytes(flat)
    flat_mha = write(tmp_path / "flat.mha", mask).read_bytes()
    flat_mha = flat_mha.replace(b"ElementSpacing = 1", b"ElementSpacing = 0")
    (tmp_path / "flat.mha").write_bytes(flat_mha)
    (tmp_path / "text.nrrd").write_text("no image", encoding="ascii")
    block = np.zeros((9, 9, 9), bool)
    block[3:6, 3:6, 3:6] = True
    for path, words in (
        (write(tmp_path / "empty.nrrd", np.zeros((5, 5, 5), np.uint8)), "all of them are empty"),
        (write(tmp_path / "ct.nrrd", ct), "got negative numbers as of an image"),
        (write(tmp_path / "mr.nrrd", np.abs(ct)), "got neighbors that differ as of an image"),
        (write(tmp_path / "soft.nrrd", mask * 0.5), "got fractions as of an image"),
        (four, "of three dimensions, got an image of 5 x 4 x 3 x 2"),
        (tmp_path / "flat.nii", "got a spacing of 0 x 1 x 1"),
        (tmp_path / "flat.mha", "got a spacing of 0 x 1 x 1"),
        (tmp_path / "text.nrrd", "it cannot be read"),
        (tmp_path / "none.nrrd", "there is no such file"),
        (tmp_path / "vessel.stl", "expected a segmentation, .nrrd"),
        (write(tmp_path / "block.nrrd", block), "expected two ends or more"),
    ):
        assert prepare(path) == 2, path.name
        said = capsys.readouterr().err
        assert words in said, (path.name, said)
        assert "expected" in said
        assert len(said.splitlines()) == 1, said
        assert not (tmp_path / "made").exists()


def test_walls_that_go_through_each_other_are_parted_and_nothing_else_moves():
    """As in a cleft that is narrower than a point's way along its wall."""
    axis = np.arange(20) - 9.3
    distance = np.sqrt(sum(np.square(np.meshgrid(axis, axis, axis)))) - 6.0
    surface = contoured(distance, np.ones(3))
    points, triangles = np.array(surface.points), surface.triangles
    links = edges(triangles).vertices
    pushed = int(points[:, 2].argmax())
    folded = points.copy()
    folded[pushed, 2] -= 13.0  # out of the other side
    assert len(self_intersecting_triangles(folded, triangles))
    found = unfolded(folded, points, triangles, links)
    assert not len(self_intersecting_triangles(found, triangles))
    assert (found != folded).any(axis=1).sum() == 1
    np.testing.assert_array_equal(unfolded(points, points, triangles, links), points)
