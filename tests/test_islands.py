"""Closed parts that float in the lumen: they narrow it, and no stent minds them."""

import time

import numpy as np
import pytest
from mesh_files import octahedron, open_tube, read_vtk
from tube_files import deploy, write_wall
from vtkmodules.util.numpy_support import vtk_to_numpy

from benchmarks.phantoms import stenosed_tube
from SDFStentLib.centerline import Centerline
from SDFStentLib.files import polydata_from_arrays, surface_from_polydata
from SDFStentLib.files.composition import composition_warnings
from SDFStentLib.geometry import Line
from SDFStentLib.treatment import Vessel

TUBE = stenosed_tube(edge_length=1.0)


def with_islands(points, triangles, *balls):
    """The surface with balls (x, y, z, radius) in it, every second one wound inward."""
    parts, faces = [points], [triangles]
    for number, (*center, radius) in enumerate(balls):
        ball, own = octahedron(radius, rounds=3)
        faces.append((own[:, ::-1] if number % 2 else own) + sum(map(len, parts)))
        parts.append(ball + center)
    return np.concatenate(parts), np.concatenate(faces)


def surface_of(points, triangles):
    return surface_from_polydata(polydata_from_arrays(points, triangles))


@pytest.mark.parametrize("seed", range(5))
def test_a_section_is_the_lumen_without_what_floats_in_it(seed):
    """Against areas and radii of circles, with one island and with two in a plane."""
    random = np.random.default_rng(seed)
    radius, sides = random.uniform(3, 10), 96
    points, triangles = open_tube(radius, 60.0, sides, 120)
    sizes = radius * random.uniform(0.12, 0.3, 2)
    turn = random.uniform(0, 2 * np.pi) + np.array([0, 2.5])
    far = 0.35 * radius + 1.02 * sizes
    balls = list(zip(far * np.cos(turn), far * np.sin(turn), (30.0, 30.0), sizes, strict=True))[
        : 1 + seed % 2
    ]
    surface = surface_of(*with_islands(points, triangles, *balls))
    assert len(surface.triangles) == len(triangles)
    line = Line(np.stack([np.zeros(61), np.zeros(61), np.linspace(0, 60, 61)], axis=1))
    found = Vessel(surface).diameters(line, 1.0)
    heights = found.arc_length
    taken = sum(np.maximum(size**2 - (heights - z) ** 2, 0) for _, _, z, size in balls)
    polygon = sides / 2 * np.sin(2 * np.pi / sides) / np.pi
    expected = 2 * np.sqrt(polygon * radius**2 - taken)
    inner = slice(2, -2)
    np.testing.assert_allclose(found.equivalent_diameter[inner], expected[inner], rtol=6e-3)
    # In the plane at their middles no larger circle than beside them all.
    flat = np.linspace(-radius, radius, 201)
    x, y = np.meshgrid(flat, flat)
    room = radius - np.hypot(x, y)
    for bx, by, _, size in balls:
        room = np.minimum(room, np.hypot(x - bx, y - by) - size)
    assert found.inscribed_diameter[30] == pytest.approx(2 * room.max(), rel=0.03)


def test_one_on_the_line_invents_no_lesion_and_is_told():
    points, triangles = with_islands(TUBE.points, TUBE.triangles, (0.1, 0.0, 8.0, 1.0))
    surface = surface_of(points, triangles)
    alone = Vessel(TUBE.surface, TUBE.centerline).lesions
    lesions = Vessel(surface, TUBE.centerline).lesions
    assert [one.percent_diameter for one in lesions] == [one.percent_diameter for one in alone]
    (told,) = composition_warnings(surface, "file")
    assert (told.kind, told.numbers["islands"]) == ("islands", 1)
    assert told.place == pytest.approx((0.1, 0.0, 8.0), abs=1e-6)
    assert told.numbers["extent_mm"] == pytest.approx(2.0)


@pytest.mark.parametrize("place", [(0.0, 0.0), (1.2, 0.4), (0.3, -0.9)])
def test_a_stent_opens_the_wall_as_if_none_were_there(a_folder, place):
    points, triangles = with_islands(TUBE.points, TUBE.triangles, (*place, 18.0, 0.5))
    write_wall(a_folder / "island.vtp", points / 10, triangles)
    write_wall(a_folder / "tube.vtp", TUBE.points / 10, TUBE.triangles)
    assert deploy("--arrays", surface="island.vtp") == 0
    assert deploy(out="alone.vtp") == 0
    after, alone = (
        vtk_to_numpy(read_vtk(a_folder / f"{name}.vtp").GetPoints().GetData())
        for name in ("out", "alone")
    )
    np.testing.assert_allclose(after[: len(alone)], alone, atol=1e-12)
    np.testing.assert_array_equal(after[len(alone) :], points[len(alone) :] / 10)


def test_vessels_and_what_crosses_the_wall_are_no_islands():
    other = TUBE.points + np.array([30.0, 0.0, 0.0])
    apart = surface_of(
        np.concatenate([TUBE.points, other]),
        np.concatenate([TUBE.triangles, TUBE.triangles + len(other)]),
    )
    assert len(apart.triangles) == 2 * len(TUBE.triangles)
    crossing = with_islands(TUBE.points, TUBE.triangles, (3.0, 0.0, 8.0, 1.0))
    assert not len(surface_of(*crossing).islands)


def test_thousands_of_loose_pieces_are_read_in_no_time():
    random = np.random.default_rng(0)
    corners = random.uniform(0, 60, (20_000, 1, 3)) + random.normal(size=(20_000, 3, 3))
    start = time.perf_counter()
    surface = surface_of(corners.reshape(-1, 3), np.arange(60_000).reshape(-1, 3))
    assert len(surface.triangles) == 20_000
    assert time.perf_counter() - start < 20


def test_the_surface_that_is_measured_ends_with_its_islands():
    surface = surface_of(*with_islands(TUBE.points, TUBE.triangles, (1.5, 0.0, 8.0, 0.5)))
    tree = Centerline.from_lines(TUBE.centerline.points, [np.arange(len(TUBE.centerline.points))])
    measured = Vessel(surface, tree).with_islands
    assert measured.wall is surface
    np.testing.assert_array_equal(measured.triangles[: len(surface.triangles)], surface.triangles)


def test_an_island_beside_which_the_lumen_is_half_as_wide_takes_its_share_at_every_station():
    """4 mm beside the axis of a tube of 10: no opening into another lumen, nothing cut off."""
    points, triangles = open_tube(5.0, 60.0, 48, 150)
    surface = surface_of(*with_islands(points, triangles, (2.5, 0.01, 30.02, 2.0)))
    along = np.array([[0.003, 0.004, 25.0], [0.003, 0.004, 35.0]])
    found = Vessel(surface).diameters(Line(along), 1.0)
    z = 25 + found.arc_length
    taken = np.maximum(4 - (z - 30.02) ** 2, 0)
    polygon = 24 * np.sin(np.pi / 24) / np.pi
    np.testing.assert_allclose(
        found.equivalent_diameter, 2 * np.sqrt(25 * polygon - taken), rtol=3e-3
    )
    assert found.inscribed_diameter[5] == pytest.approx(5.5, abs=0.02)
