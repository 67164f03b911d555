"""A lumen and the outer side of its wall in one file: measured and treated is the lumen."""

import time

import numpy as np
import pytest
from mesh_files import read_vtk
from scipy.spatial import cKDTree
from tube_files import deploy, write_wall
from vtkmodules.util.numpy_support import vtk_to_numpy

from benchmarks import phantoms
from benchmarks.phantoms import branching_pulmonary_artery, stenosed_tube
from SDFStentLib.cli import main
from SDFStentLib.deformation import DeploymentSettings, Proxy
from SDFStentLib.field import CapsuleChain
from SDFStentLib.files import polydata_from_arrays, read_surface, surface_from_polydata
from SDFStentLib.files.composition import rings
from SDFStentLib.geometry import (
    Surface,
    boundary_edges,
    compacted,
    different_counts,
    vertex_normals,
)
from SDFStentLib.stent import AtCenter, Stent
from SDFStentLib.treatment import Treatment, Vessel


def lumen_of(made):
    """Its wall without caps."""
    kinds, counts = np.unique(made.face_ids, return_counts=True)
    return compacted(made.points, made.triangles[made.face_ids == kinds[counts.argmax()]])


def with_outer_side(
    points, triangles, thickness, *, is_solid=False, outer_first=False, turn="as is"
):
    """Also the surface at a distance outside of it; a solid has a ring at each end."""
    count = len(points)
    outer = points + thickness * vertex_normals(points, triangles)
    inner = triangles[:, ::-1] if is_solid else triangles
    a, b = boundary_edges(triangles).T
    rings = [np.stack([a, b, b + count], 1), np.stack([a, b + count, a + count], 1)]
    faces = np.concatenate([inner, triangles + count, *(rings if is_solid else [])])
    both = np.concatenate([points, outer])
    if outer_first:
        both, faces = np.roll(both, count, axis=0), ((faces + count) % (2 * count))[::-1]
    if turn == "inward":
        faces = faces[:, ::-1]
    if turn == "mixed":
        some = np.random.default_rng(0).random(len(faces)) < 0.3
        faces = np.where(some[:, None], faces[:, ::-1], faces)
    return both, faces


TUBE = stenosed_tube(edge_length=1.0)


@pytest.mark.parametrize("turn", ["as is", "inward", "mixed"])
@pytest.mark.parametrize("outer_first", [False, True])
@pytest.mark.parametrize("is_solid", [False, True])
@pytest.mark.parametrize("thickness", [0.3, 1.0, 2.0])
def test_the_lumen_of_a_wall_is_found(thickness, is_solid, outer_first, turn):
    points, triangles = lumen_of(TUBE)
    both, faces = with_outer_side(
        points, triangles, thickness, is_solid=is_solid, outer_first=outer_first, turn=turn
    )
    surface = surface_from_polydata(polydata_from_arrays(both, faces))
    first = len(points) if outer_first else 0
    found = {tuple(sorted(corners)) for corners in surface.triangles.tolist()}
    assert found == {tuple(sorted(corners)) for corners in (triangles + first).tolist()}
    assert len(surface.whole.triangles) == len(faces)
    alone = Vessel(Surface(points, triangles), TUBE.centerline).lesions
    lesions = Vessel(surface, TUBE.centerline).lesions
    assert [one.percent_diameter for one in lesions] == pytest.approx(
        [one.percent_diameter for one in alone]
    )


@pytest.mark.parametrize("is_solid", [False, True])
def test_a_stent_in_a_wall_is_the_one_in_its_lumen_and_the_wall_stays_a_wall(a_folder, is_solid):
    """Files through the shell, the wall's thickness by nearest points, against the lumen alone."""
    points, triangles = lumen_of(TUBE)
    both, faces = with_outer_side(points, triangles, 1.0, is_solid=is_solid)
    number = np.arange(len(faces))
    for name, made in (("wall", (both, faces)), ("lumen", (points, triangles))):
        rows = number[: len(made[1])]
        write_wall(a_folder / f"{name}.vtp", made[0] / 10, made[1], None, {"number": rows})
    assert main(["check", "wall.vtp", "--units", "cm"]) == 0
    assert deploy("--arrays", surface="wall.vtp") == 0
    assert deploy(surface="lumen.vtp", out="alone.vtp") == 0
    after, alone = (read_vtk(a_folder / f"{name}.vtp") for name in ("out", "alone"))
    moved = 10 * vtk_to_numpy(after.GetPoints().GetData())
    expected = 10 * vtk_to_numpy(alone.GetPoints().GetData())
    np.testing.assert_allclose(moved[: len(points)], expected, atol=1e-9)
    np.testing.assert_array_equal(vtk_to_numpy(after.GetCellData().GetArray("number")), number)
    # Thickness by a dense sample of the lumen, before and after.
    before, later = (thickness_of(one, triangles) for one in (both, moved))
    assert np.median(later / before) == pytest.approx(1, abs=0.02)
    assert (later / before).min() > 0.6
    assert (later / before).max() < 1.1
    # What lies away from the stent has not moved.
    away = np.abs(both[:, 2] - 20) > 18
    np.testing.assert_allclose(moved[away], both[away], atol=1e-6)


def thickness_of(both, triangles):
    """Distance of every point of the outer side from the lumen, mm, by samples of 0.1 mm."""
    count = len(both) // 2
    weights = np.array([(i, j, 8 - i - j) for i in range(9) for j in range(9 - i)]) / 8
    samples = np.einsum("sc,fcx->fsx", weights, both[:count][triangles]).reshape(-1, 3)
    return cKDTree(samples).query(both[count:])[0]


def treated(points, triangles, tree, stent, settings=None):
    surface = surface_from_polydata(polydata_from_arrays(points, triangles))
    return Treatment(surface, [stent], tree, settings or DeploymentSettings()).result


@pytest.mark.parametrize("seed", range(6))
def test_walls_of_trees_stay_free_of_faults(seed):
    """Thin to thick, at the crotch and in branches; the lumen to the bit that of itself."""
    random = np.random.default_rng(seed)
    made = branching_pulmonary_artery(edge_length=random.uniform(0.9, 1.2))
    points, triangles = lumen_of(made)
    both, faces = with_outer_side(
        points, triangles, random.uniform(0.3, 1.0), is_solid=bool(seed % 2)
    )
    tree = made.centerline
    at = random.integers(len(tree.points) // 4, 3 * len(tree.points) // 4)
    width = 2 * tree.inscribed_radius[at] * random.uniform(1.1, 1.4)
    stent = Stent(width, length=random.uniform(10, 18), placement=AtCenter(tree.points[at]))
    result, alone = (
        treated(*surface, tree, stent) for surface in ((both, faces), (points, triangles))
    )
    np.testing.assert_allclose(result.points[: len(points)], alone.points, atol=1e-9)
    assert result.certificate.passed == alone.certificate.passed
    assert result.certificate.is_watertight == bool(seed % 2)
    assert result.stents[0].after.minimum == pytest.approx(alone.stents[0].after.minimum)


def test_two_stents_and_a_preview_take_the_outer_side_along():
    points, triangles = lumen_of(TUBE)
    both, faces = with_outer_side(points, triangles, 1.0)
    surface = surface_from_polydata(polydata_from_arrays(both, faces))
    stents = [
        Stent(5.0, length=12.0, placement=AtCenter([0, 0, 16.0])),
        Stent(6.0, length=12.0, placement=AtCenter([0, 0, 24.0])),
    ]
    result = Treatment(surface, stents, TUBE.centerline).result
    assert result.certificate.passed
    assert thickness_of(result.points, triangles).min() > 0.6
    chain = CapsuleChain.along(np.array([[0, 0, 12.0], [0, 0, 28.0]]))
    state = Proxy(surface).deployed(chain, 3.0).state
    seen = state.applied_to(both)
    assert np.abs(seen[len(points) :] - both[len(points) :]).max() > 0.5
    assert thickness_of(seen, triangles).min() > 0.6


@pytest.mark.parametrize("name", ["tube_with_neighbor", "hairpin_tube"])
def test_other_vessels_are_no_outer_sides(name):
    made = getattr(phantoms, name)(edge_length=1.0)
    surface = surface_from_polydata(polydata_from_arrays(made.points, made.triangles))
    assert len(surface.triangles) == len(made.triangles)
    assert not len(surface.followers)


def test_a_wire_in_the_lumen_makes_no_wall_of_it():
    points, triangles = lumen_of(TUBE)
    wire = points * [0.1, 0.1, 1]
    surface = surface_from_polydata(
        polydata_from_arrays(
            np.concatenate([points, wire]), np.concatenate([triangles, triangles + len(points)])
        )
    )
    assert len(surface.triangles) == 2 * len(triangles)


def test_a_solid_with_round_ends_is_refused_for_what_it_is(a_folder, capsys):
    """Its line lies in a hole; where no flat rings tell its two sides, the lumen is asked for."""
    points, triangles = lumen_of(TUBE)
    both, faces = with_outer_side(points, triangles, 1.0, is_solid=True)
    rim = len(both)
    a, b = boundary_edges(triangles).T
    count, top = len(points), points[:, 2].max()
    # A row of points in the middle of every ring, drawn out by half of the thickness.
    middle = np.full(count, -1)
    used = np.unique(np.r_[a, b])
    middle[used] = rim + np.arange(len(used))
    drawn = (both[used] + both[used + count]) / 2
    drawn[:, 2] += np.where(drawn[:, 2] > top / 2, 0.5, -0.5)
    faces = faces[: 2 * len(triangles)]
    for low, high in ((np.arange(count), middle), (middle, np.arange(count) + count)):
        faces = np.concatenate(
            [faces, np.stack([low[a], low[b], high[b]], 1), np.stack([low[a], high[b], high[a]], 1)]
        )
    write_wall(a_folder / "round.vtp", np.concatenate([both, drawn]) / 10, faces)
    assert read_surface(a_folder / "round.vtp", "cm").surface.topology.is_watertight
    assert main(["measure", "round.vtp", "--units", "cm", "--centerline", "line.vtp"]) == 2
    assert "give the surface of the lumen alone" in capsys.readouterr().err


def test_the_corners_of_flat_parts_are_counted_in_no_time():
    """Of a large closed surface with a handle, as a label of an image has; it has no rings."""
    rows, columns = 600, 400
    turn, bend = np.meshgrid(
        2 * np.pi * np.arange(rows) / rows, 2 * np.pi * np.arange(columns) / columns, indexing="ij"
    )
    away = 10 + 3 * np.cos(bend)
    points = np.stack([away * np.cos(turn), away * np.sin(turn), 3 * np.sin(bend)], axis=2)
    i, j = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
    a, b = i * columns + j, i * columns + (j + 1) % columns
    c, d = (i + 1) % rows * columns + j, (i + 1) % rows * columns + (j + 1) % columns
    triangles = np.concatenate([np.stack([a, c, b], 2), np.stack([b, c, d], 2)]).reshape(-1, 3)
    surface = Surface(points.reshape(-1, 3), triangles)
    surface.topology  # noqa: B018 made once
    begun = time.process_time()
    assert not rings(surface).any()
    assert time.process_time() - begun < 1.5


def test_different_numbers_are_counted_as_one_by_one():
    draw = np.random.default_rng(0)
    label, number = draw.integers(0, 7, 500), draw.integers(0, 40, 500)
    found = different_counts(label, number, 9)
    plain = [len(set(number[label == one].tolist())) for one in range(9)]
    assert found.tolist() == plain
