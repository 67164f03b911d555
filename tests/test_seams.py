"""Points that lie on each other without being shared, ghost cells, triangles a second time."""

import json

import numpy as np
import pytest
from mesh_files import octahedron, open_tube, read_vtk
from scipy.spatial import cKDTree
from tube_files import deploy, write_wall
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkFiltersCore import vtkPolyDataNormals

from benchmarks.phantoms import stenosed_tube
from SDFStentLib.cli import main
from SDFStentLib.deformation import DeploymentSettings, Proxy
from SDFStentLib.files import encode_vtp, polydata_from_arrays, read_surface, write_surface
from SDFStentLib.geometry import Surface, surface_topology
from SDFStentLib.validation import InputError
from SDFStentLib.vessel import find_lesions

TUBE = stenosed_tube(edge_length=1.0)
MIDDLES = TUBE.points[TUBE.triangles].mean(axis=1)


def apart(points, triangles, label):
    """The surface in parts with points of their own, and which point each of these was."""
    keys = np.stack([np.repeat(label, 3), triangles.ravel()])
    pairs, corner = np.unique(keys, axis=1, return_inverse=True)
    return points[pairs[1]], corner.reshape(-1, 3), pairs[1]


PARTS = {
    "wall and caps": TUBE.face_ids,
    "cut through the throat": (MIDDLES[:, 2] > 20).astype(int),
    "slabs": (MIDDLES[:, 2] // 4).astype(int),
    "every fourth": np.arange(len(MIDDLES)) % 4,
    "soup": np.arange(len(MIDDLES)),
}


def same_shape(one, other):
    return one._replace(unshared_points=0) == other._replace(unshared_points=0)


@pytest.mark.parametrize("parts", PARTS)
@pytest.mark.parametrize("suffix", [".vtp", ".vtk", ".ply", ".obj"])
def test_parts_whose_rims_lie_on_each_other_are_one_surface(tmp_path, parts, suffix):
    points, triangles, source = apart(TUBE.points.astype("f4"), TUBE.triangles, PARTS[parts])
    write_wall(tmp_path / "parts.vtp", points, triangles)
    apart_file = read_surface(tmp_path / "parts.vtp")
    write_surface(tmp_path / f"again{suffix}", apart_file, apart_file.points)
    read = read_surface(tmp_path / f"again{suffix}")
    whole = Surface(TUBE.points.astype("f4"), TUBE.triangles)
    assert same_shape(read.surface.topology, whole.topology)
    assert read.surface.topology.is_watertight
    # The file's points as they were, in number and order.
    np.testing.assert_allclose(read.points, points.astype(float), rtol=1e-6)
    assert len(read.points) == len(source)
    told = [caution for caution in read.warnings if caution.kind == "points-joined"]
    assert [caution.numbers["points"] for caution in told] == [len(source) - len(TUBE.points)]
    # Measured as what it is.
    expected = find_lesions(whole, TUBE.centerline)
    found = find_lesions(read.surface, TUBE.centerline)
    assert len(found) == len(expected) == 1
    assert found[0].percent_diameter == pytest.approx(expected[0].percent_diameter, abs=1e-4)


@pytest.mark.parametrize("parts", PARTS)
def test_a_stent_moves_copies_alike_and_everything_else_comes_back(a_folder, parts):
    """Against the same deployment of the surface whose points are shared."""
    scaled = (TUBE.points / 10).astype("f4")
    points, triangles, source = apart(scaled, TUBE.triangles, PARTS[parts])
    number = np.arange(len(points))
    data = polydata_from_arrays(
        points, triangles, {"number": number}, {"ModelFaceID": TUBE.face_ids}
    )
    (a_folder / "parts.vtp").write_bytes(encode_vtp(data))
    assert deploy("--arrays", surface="parts.vtp", out="after.vtp") == 0
    assert deploy("--arrays", out="whole.vtp") == 0
    after, whole = (read_vtk(a_folder / name) for name in ("after.vtp", "whole.vtp"))
    coordinates = vtk_to_numpy(after.GetPoints().GetData())
    np.testing.assert_allclose(
        coordinates, vtk_to_numpy(whole.GetPoints().GetData())[source], rtol=0, atol=2e-6
    )
    assert coordinates.dtype == np.float32
    pairs = cKDTree(points).query_pairs(0.0, output_type="ndarray")
    assert len(pairs) > 0
    assert (coordinates[pairs[:, 0]] == coordinates[pairs[:, 1]]).all()
    corners = vtk_to_numpy(after.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    np.testing.assert_array_equal(corners, triangles)
    arrays = {name: vtk_to_numpy(after.GetPointData().GetArray(name)) for name in ("number",)}
    np.testing.assert_array_equal(arrays["number"], number)
    for name in ("AreaStretch", "ModelFaceID"):
        one, other = (vtk_to_numpy(data.GetCellData().GetArray(name)) for data in (after, whole))
        np.testing.assert_allclose(one, other, rtol=1e-4)
    moved = vtk_to_numpy(after.GetPointData().GetArray("Displacement"))
    assert (moved[pairs[:, 0]] == moved[pairs[:, 1]]).all()
    assert np.abs(moved).max() > 0.5


def test_normals_that_are_split_at_edges_stay_split(a_folder):
    """What ParaView and VTK make by default: two normals at the rim of a cap, one place."""
    split = vtkPolyDataNormals()
    split.SetInputData(read_vtk(a_folder / "tube.vtp"))
    split.Update()
    (a_folder / "split.vtp").write_bytes(encode_vtp(split.GetOutput()))
    read = read_surface(a_folder / "split.vtp", "cm")
    assert read.surface.topology.is_watertight
    assert read.surface.unshared_points == len(read.points) - len(TUBE.points)
    assert deploy(surface="split.vtp") == 0
    after = read_vtk(a_folder / "out.vtp")
    normals = vtk_to_numpy(after.GetPointData().GetArray("Normals"))
    at_cap = read.surface.copies[np.abs(read.points[read.surface.copies, 2] - 40) < 1e-3]
    assert len(at_cap) > 8
    first = read.surface._mesh.originals[np.isin(read.surface.copies, at_cap)]
    assert np.abs((normals[at_cap] * normals[first]).sum(axis=1)).max() < 0.2


def test_a_file_of_two_pieces_is_one_surface(tmp_path):
    points, triangles, _ = apart(TUBE.points, TUBE.triangles, PARTS["cut through the throat"])
    pieces = ""
    for number in (0, 1):
        own = triangles[PARTS["cut through the throat"] == number]
        used, corners = np.unique(own, return_inverse=True)
        ends = " ".join(map(str, 3 * np.arange(1, len(own) + 1)))
        pieces += (
            f'<Piece NumberOfPoints="{len(used)}" NumberOfPolys="{len(own)}"><Points>'
            '<DataArray type="Float64" NumberOfComponents="3" format="ascii">'
            f"{' '.join(map(repr, points[used].ravel().tolist()))}</DataArray></Points><Polys>"
            '<DataArray type="Int64" Name="connectivity" format="ascii">'
            f"{' '.join(map(str, corners.ravel()))}</DataArray>"
            f'<DataArray type="Int64" Name="offsets" format="ascii">{ends}</DataArray>'
            "</Polys></Piece>"
        )
    (tmp_path / "pieces.vtp").write_text(
        '<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" '
        f'header_type="UInt64"><PolyData>{pieces}</PolyData></VTKFile>',
        encoding="utf-8",
    )
    assert read_surface(tmp_path / "pieces.vtp").surface.topology.is_watertight


def test_check_says_that_a_mesher_needs_the_seams_merged_and_how(a_folder, capsys):
    points, triangles, _ = apart(TUBE.points / 10, TUBE.triangles, PARTS["slabs"])
    write_wall(a_folder / "parts.vtp", points, triangles)
    assert main(["check", "parts.vtp", "--units", "cm"]) == 0
    said, warned = capsys.readouterr()
    count = len(points) - len(TUBE.points)
    assert f"watertight once {count} points that lie on others are merged" in said
    assert "Surface Toolbox, Clean" in said + warned
    assert main(["check", "parts.vtp", "--units", "cm", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    found = found.get("check", found)
    assert found["watertight"] is False
    assert found["unshared_points"] == count


# What a seam is -----------------------------------------------------------------------------------


def two_tubes(sides=24):
    """Open tubes side by side that touch along a line, their points there in the same places."""
    points, triangles = open_tube(5.0, 40.0, sides, 20)
    mirrored = points * [-1, 1, 1] + [10, 0, 0]
    mirrored[np.abs(mirrored[:, 0] - 5) < 1e-9, 0] = points[np.abs(points[:, 0] - 5) < 1e-9, 0]
    both = np.concatenate([points, mirrored])
    pairs = cKDTree(points).query_ball_point(mirrored, 1e-9)
    for row, found in enumerate(pairs):
        if found:
            both[len(points) + row] = points[found[0]]
    return both, np.concatenate([triangles, triangles[:, ::-1] + len(points)])


@pytest.mark.parametrize("is_soup", [False, True])
def test_walls_that_touch_are_not_glued(is_soup):
    points, triangles = two_tubes()
    touching = len(points) - len(np.unique(points, axis=0))
    assert touching == 21
    if is_soup:
        points, triangles = (
            points[triangles].reshape(-1, 3),
            np.arange(triangles.size).reshape(-1, 3),
        )
    found = Surface(points, triangles).topology
    assert found.component_count == 2
    assert found.is_manifold
    assert found.boundary_edge_count == 4 * 24
    assert found.unshared_points == (len(points) - len(two_tubes()[0]) if is_soup else 0)


def test_spheres_that_share_a_vertex_by_place_stay_two():
    points, triangles = octahedron()
    other = points * [-1, 1, 1] + [60, 0, 0]
    other[points[:, 0].argmax()] = points[points[:, 0].argmax()]
    both = np.concatenate([points, other])
    found = Surface(both, np.concatenate([triangles, triangles[:, ::-1] + len(points)])).topology
    assert (found.component_count, found.is_watertight, found.unshared_points) == (2, True, 0)


@pytest.mark.parametrize("seed", range(12))
def test_random_parts_of_random_surfaces_close_as_they_were(seed):
    """Cuts at random, windings at random, some triangles missing: no third at an edge."""
    random = np.random.default_rng(seed)
    points, triangles = octahedron(rounds=3) if seed % 2 else open_tube()
    points = points + random.normal(size=points.shape) * 0.05
    triangles = triangles[random.random(len(triangles)) > random.choice([0.0, 0.02, 0.1])]
    label = random.integers(0, random.integers(2, 400), len(triangles))
    parts, corners, source = apart(points.astype("f4"), triangles, label)
    turned = np.flatnonzero(random.random(label.max() + 1) < 0.5)
    corners = np.where(np.isin(label, turned)[:, None], corners[:, ::-1], corners)
    found, expected = Surface(parts, corners).topology, surface_topology(triangles)
    # Where only a corner was shared the parts stay apart there: an edge is what joins.
    assert found.component_count == expected.component_count
    assert found.boundary_edge_count == expected.boundary_edge_count
    assert found.is_edge_manifold
    assert found.is_closed == expected.is_closed
    assert len(source) == len(parts)


def test_a_surface_without_seams_is_taken_as_it_is():
    surface = Surface(TUBE.points, TUBE.triangles)
    assert surface.cells is None
    assert surface.whole is surface
    assert not len(surface.copies)
    np.testing.assert_array_equal(surface.triangles, TUBE.triangles)


def test_a_preview_moves_copies_alike():
    from SDFStentLib import CapsuleChain

    points, triangles, source = apart(TUBE.points, TUBE.triangles, PARTS["slabs"])
    chain = CapsuleChain.along(np.array([[0, 0, 12.0], [0, 0, 28.0]]))
    states = [
        Proxy(Surface(*made)).deployed(chain, 3.0, DeploymentSettings.preview()).state
        for made in ((points, triangles), (TUBE.points, TUBE.triangles))
    ]
    after = states[0].applied_to(points)
    np.testing.assert_allclose(after, states[1].applied_to(TUBE.points)[source], atol=1e-9)


# Ghost cells --------------------------------------------------------------------------------------


def with_ghosts(scale=1.0):
    """Two pieces that overlap by a layer of ghosts, as filters in parallel leave them."""
    height = MIDDLES[:, 2]
    pieces = (height < 22, height >= 18)  # 18 to 22 twice
    points, triangles, ghosts, cells = [], [], [], []
    for number, own in enumerate(pieces):
        used, corners = np.unique(TUBE.triangles[own], return_inverse=True)
        triangles.append(corners.reshape(-1, 3) + sum(map(len, points)))
        points.append(TUBE.points[used])
        ghosts.append(height[own] >= 20 if number == 0 else height[own] < 20)
        cells.append(np.flatnonzero(own))
    is_ghost = np.concatenate(ghosts)
    return (
        scale * np.concatenate(points),
        np.concatenate(triangles),
        is_ghost,
        np.concatenate(cells),
    )


@pytest.mark.parametrize(
    ("name", "mark", "kind"),
    [("vtkGhostType", 1, "u1"), ("vtkGhostLevels", 2, "u1"), ("vtkGhostType", 32, "i4")],
)
def test_ghost_cells_are_left_out_and_come_back(a_folder, name, mark, kind):
    points, triangles, is_ghost, cells = with_ghosts(0.1)
    marks = np.where(is_ghost, mark, 0).astype(kind)
    data = polydata_from_arrays(
        points, triangles, None, {name: marks, "ModelFaceID": TUBE.face_ids[cells]}
    )
    (a_folder / "ghosts.vtp").write_bytes(encode_vtp(data))
    read = read_surface(a_folder / "ghosts.vtp", "cm")
    assert same_shape(read.surface.topology, TUBE.surface.topology)
    assert [caution.kind for caution in read.warnings][-2:] == ["points-joined", "ghost-cells"]
    assert len(read.faces.ids) == (~is_ghost).sum()
    before = points.copy()
    assert deploy("--arrays", surface="ghosts.vtp") == 0
    # Not by VTK's reader, which turns levels into kinds.
    after = read_surface(a_folder / "out.vtp", "cm").polydata()
    got = after.GetCellData()
    np.testing.assert_array_equal(vtk_to_numpy(got.GetArray(name)), marks)
    np.testing.assert_array_equal(vtk_to_numpy(got.GetArray("ModelFaceID")), TUBE.face_ids[cells])
    assert np.isnan(vtk_to_numpy(got.GetArray("AreaStretch"))[is_ghost]).all()
    moved = vtk_to_numpy(after.GetPoints().GetData())
    # A ghost moves as the cell that it is a copy of.
    pairs = cKDTree(before).query_pairs(0.0, output_type="ndarray")
    assert (moved[pairs[:, 0]] == moved[pairs[:, 1]]).all()
    report = a_folder / "report.json"
    assert deploy("--report", str(report), surface="ghosts.vtp") == 0
    assert main(["measure", "ghosts.vtp", "--units", "cm", "--centerline", "line.vtp"]) == 0


def test_cells_with_a_hidden_point_are_left_out(tmp_path):
    marks = np.zeros(len(TUBE.points), dtype=np.uint8)
    marks[TUBE.triangles[7, 0]] = 2
    (tmp_path / "hidden.vtp").write_bytes(
        encode_vtp(polydata_from_arrays(TUBE.points, TUBE.triangles, {"vtkGhostType": marks}))
    )
    surface = read_surface(tmp_path / "hidden.vtp").surface
    around = (TUBE.triangles == TUBE.triangles[7, 0]).any(axis=1)
    np.testing.assert_array_equal(surface.cells, np.flatnonzero(~around))


def test_nothing_but_ghosts_is_refused(tmp_path):
    marks = np.ones(len(TUBE.triangles), dtype=np.uint8)
    write_wall(tmp_path / "ghosts.vtp", TUBE.points, TUBE.triangles, None, {"vtkGhostType": marks})
    with pytest.raises(InputError, match=f"got {len(marks)} ghost cells and nothing else"):
        read_surface(tmp_path / "ghosts.vtp")


# A second time ------------------------------------------------------------------------------------


def doubled(kind):
    points, triangles = TUBE.points, TUBE.triangles
    again = {
        "three triangles": triangles[100:103],
        "three turned": triangles[100:103, ::-1],
        "all of it": triangles,
    }
    if kind in again:
        return points, np.concatenate([triangles, again[kind]])
    second = triangles if kind == "a second surface" else triangles[:, ::-1]
    return np.concatenate([points, points]), np.concatenate([triangles, second + len(points)])


@pytest.mark.parametrize(
    "kind",
    ["three triangles", "three turned", "all of it", "a second surface", "a second one, turned"],
)
def test_what_is_there_twice_is_one_wall_and_a_mesher_is_told(a_folder, capsys, kind):
    points, triangles = doubled(kind)
    write_wall(a_folder / "twice.vtp", 0.1 * points, triangles)
    read = read_surface(a_folder / "twice.vtp", "cm")
    extra = len(triangles) - len(TUBE.triangles)
    assert same_shape(read.surface.topology, TUBE.surface.topology)
    assert len(read.surface.whole.triangles) == len(triangles)
    assert [str(extra) in str(one) for one in read.warnings if one.kind == "triangles-again"] == [
        True
    ]
    assert main(["check", "twice.vtp", "--units", "cm", "--json"]) == 3
    found = json.loads(capsys.readouterr().out)
    found = found.get("check", found)
    # Numbers of the file.
    assert set(range(len(TUBE.triangles), len(triangles))) <= set(
        found["self_intersecting_triangles"]
    )
    deploy(surface="twice.vtp")
    deploy(out="whole.vtp")
    after, whole = (read_surface(a_folder / f"{n}.vtp", "cm").points for n in ("out", "whole"))
    np.testing.assert_allclose(after[: len(whole)], whole, atol=2e-5)
    if len(after) > len(whole):
        np.testing.assert_array_equal(after[: len(whole)], after[len(whole) :])
