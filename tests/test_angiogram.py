"""The simulated angiogram: lengths of rays within a lumen, and how dark they are."""

import time

import numpy as np
import pytest
from round_tubes import contoured

from SDFStentLib.files import read_surface
from SDFStentLib.geometry import Line, Surface
from SDFStentLib.validation import InputError
from SDFStentLib.view import ArmView, Beam, angiogram, beam_on, path_lengths

FRONT = ArmView(0, 0).axes("LPS")
NOWHERE = np.zeros(3)


def prism(corners=64, radius=4.0, length=20.0, closed=True):
    """A tube along z whose sections are regular polygons, LPS."""
    angles = 2 * np.pi * (np.arange(corners) + 0.5) / corners
    rim = radius * np.column_stack([np.cos(angles), np.sin(angles), 0 * angles])
    ends = [rim + np.array([0, 0, z]) for z in (-length / 2, length / 2)]
    points = np.vstack([*ends, [[0, 0, -length / 2], [0, 0, length / 2]]])
    one = np.arange(corners)
    after = (one + 1) % corners
    wall = [np.c_[one, after, one + corners], np.c_[after, after + corners, one + corners]]
    caps = [
        np.c_[after, one, np.full(corners, 2 * corners)],
        np.c_[one + corners, after + corners, np.full(corners, 2 * corners + 1)],
    ]
    return Surface(points, np.vstack(wall + caps if closed else wall))


def sphere(radius=5.0, rings=120):
    """A sphere of triangles, its poles on z."""
    polar, around = (
        np.linspace(0, np.pi, rings + 1)[1:-1],
        2 * np.pi * np.arange(2 * rings) / (2 * rings),
    )
    p, a = np.meshgrid(polar, around, indexing="ij")
    points = np.stack([np.sin(p) * np.cos(a), np.sin(p) * np.sin(a), np.cos(p)], axis=-1).reshape(
        -1, 3
    )
    n = 2 * rings
    one = np.arange((rings - 2) * n)
    after = one - one % n + (one + 1) % n
    faces = [np.c_[one, one + n, after], np.c_[after, one + n, after + n]]
    last, k = len(points) - n, np.arange(n)
    faces += [
        np.c_[np.full(n, len(points)), k, (k + 1) % n],
        np.c_[last + k, np.full(n, len(points) + 1), last + (k + 1) % n],
    ]
    return Surface(radius * np.vstack([points, [[0, 0, 1], [0, 0, -1]]]), np.vstack(faces))


def beside(beam):
    """How far the pixels are from the middle, to the right and up, mm."""
    rows, columns = beam.size
    right = (np.arange(columns) + 0.5 - columns / 2) * beam.pixel
    up = (rows / 2 - np.arange(rows) - 0.5) * beam.pixel
    return np.meshgrid(right, up)


def chord_of_polygon(x, corners, radius):
    """Of a regular polygon with an edge at angle 0, at x, along y: where its edges are."""
    half = np.full_like(x, np.inf)
    apothem = radius * np.cos(np.pi / corners)
    for k in range(corners):
        angle = 2 * np.pi * k / corners
        if np.sin(angle) > 1e-12:
            half = np.minimum(half, (apothem - x * np.cos(angle)) / np.sin(angle))
    return np.where(np.abs(x) < apothem, np.maximum(2 * half, 0), 0)


def test_a_tube_has_the_chords_of_its_section():
    beam = Beam(FRONT, NOWHERE, (60, 90), 0.11)
    found = path_lengths(prism(), beam)
    right, up = beside(beam)
    assert np.abs(up).max() < 10
    assert found == pytest.approx(chord_of_polygon(right, 64, 4.0), abs=1e-9)


def test_a_tube_seen_askew_is_longer_by_the_sine():
    view = ArmView(0, 30)
    beam = Beam(view.axes("LPS"), NOWHERE, (16, 90), 0.11)
    right, _ = beside(beam)
    expected = chord_of_polygon(right, 64, 4.0) / np.cos(np.pi / 6)
    assert path_lengths(prism(length=60.0), beam) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("source", [None, 60.0, 780.0])
def test_a_sphere_has_the_chords_of_a_sphere(source):
    beam = Beam(ArmView(33, -21).axes("LPS"), np.array([1.0, 2, 3]), (80, 80), 0.17, source)
    body = sphere()
    right, up = beside(beam)
    axes = beam.axes
    # A ray through the pixel at the isocenter's plane; its distance from the middle of the sphere.
    through = beam.isocenter + right[..., None] * axes[0] + up[..., None] * axes[1]
    way = np.broadcast_to(axes[2], through.shape)
    if source is not None:
        way = through - (beam.isocenter - source * axes[2])
        way = way / np.linalg.norm(way, axis=-1, keepdims=True)
    away = np.linalg.norm(np.cross(through, way), axis=-1)
    expected = 2 * np.sqrt(np.maximum(25 - away**2, 0))
    found = path_lengths(body, beam)
    # Facets are up to 2 % of the radius short near the rim, and 0.001 of it in the middle.
    assert np.abs(found - expected)[away < 4.5].max() < 0.012
    assert (found <= expected + 1e-9).all()
    assert found.sum() == pytest.approx(expected.sum(), rel=2e-3)


def test_the_sum_over_all_rays_is_the_volume():
    tree = contoured([((0, 0, -12), (0, 0, 0), 3, 3), ((0, 0, 0), (8, 2, 9), 2, 2)], 0.4)
    corners = tree.points[tree.triangles]
    volume = abs(
        np.einsum("mi,mi->m", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6
    )
    beam = Beam(ArmView(20, 10).axes("RAS"), np.zeros(3), (800, 800), 0.05)
    assert path_lengths(tree, beam).sum() * 0.0025 == pytest.approx(volume, rel=3e-4)


def test_no_ray_slips_through_where_points_lie_on_the_rays():
    """Corners and edges exactly on the middles of pixels, and walls exactly along the rays."""
    x, y, z = np.array(np.meshgrid([-4.0, 4], [-4.0, 4], [-4.0, 4], indexing="ij")).reshape(3, -1)
    box = np.array(
        [
            [0, 1, 3],
            [0, 3, 2],
            [4, 6, 7],
            [4, 7, 5],
            [0, 4, 5],
            [0, 5, 1],
            [2, 3, 7],
            [2, 7, 6],
            [0, 2, 6],
            [0, 6, 4],
            [1, 5, 7],
            [1, 7, 3],
        ]
    )
    found = path_lengths(Surface(np.c_[x, y, z], box), Beam(FRONT, NOWHERE, (21, 21), 1.0))
    assert np.unique(found.round(12)).tolist() == [0.0, 8.0]
    assert (found == 8).sum() in (64, 72, 81)


def test_winding_and_open_ends_change_nothing():
    body, beam = prism(), Beam(ArmView(10, 20).axes("LPS"), NOWHERE, (50, 60), 0.4)
    usual = path_lengths(body, beam)
    mixed = body.triangles.copy()
    mixed[::2] = mixed[::2, ::-1]
    assert path_lengths(Surface(body.points, mixed), beam) == pytest.approx(usual, abs=1e-9)
    assert path_lengths(prism(closed=False), beam) == pytest.approx(usual, abs=1e-9)


def test_parts_add_up_each_by_itself():
    one, beam = prism(), Beam(ArmView(90, 0).axes("LPS"), NOWHERE, (40, 40), 0.5)
    other = one.points + np.array([12.0, 0, 0])
    faces = np.vstack([one.triangles, one.triangles[:, ::-1] + len(one.points)])
    both = Surface(np.vstack([one.points, other]), faces)
    assert path_lengths(both, beam) == pytest.approx(2 * path_lengths(one, beam), abs=1e-9)


@pytest.mark.parametrize("source", [None, 200.0])
def test_what_is_beyond_the_reach_is_left_out(source):
    beam = Beam(FRONT, NOWHERE, (61, 61), 0.2, source, 3.0)
    found = path_lengths(sphere(50.0), beam)
    right, up = beside(beam)
    squared = right**2 + up**2
    if source is not None:
        squared = squared * source**2 / (squared + source**2)
    assert found == pytest.approx(2 * np.sqrt(np.maximum(9 - squared, 0)), abs=1e-9)


def test_a_source_amidst_the_vessels_is_refused():
    with pytest.raises(InputError, match="source"):
        path_lengths(sphere(), Beam(FRONT, NOWHERE, (8, 8), 1.0, 4.0))


def test_gray_follows_beer_and_lambert_and_a_subtraction_is_linear():
    line = Line([[0, 0, -5], [0, 0, 5]])
    beam = beam_on(line, 4.0, ArmView(0, 0), "LPS")
    made = angiogram(prism(), ArmView(0, 0), beam)
    middle = made.lengths[256, 256]
    assert middle == pytest.approx(8, abs=0.02)
    assert made.gray(0.1)[256, 256] == round(255 * np.exp(-0.1 * middle))
    assert made.gray(0.1, darkest=16.0)[256, 256] == round(255 * (1 - middle / 16))
    assert made.gray()[256, 0] == 255
    assert made.pixels(np.zeros((1, 3)))[0] == pytest.approx([256, 256])
    # Half the picture is as far as 1.3 times the length, or six radii.
    assert beam.pixel * 256 == pytest.approx(24)


def test_a_patients_picture_is_quick_and_as_deep_as_rays_cast_one_by_one(data_dir):
    surface = read_surface(data_dir / "su0243_surface_mm.vtp", "mm").surface
    axes = ArmView(67, -26).axes("LPS")
    beam = Beam(axes, np.array([9.3, -77.5, -55.5]), (512, 512), 0.16)
    path_lengths(surface, beam)
    begun = time.process_time()
    found = path_lengths(surface, beam)
    assert time.process_time() - begun < 0.5
    assert not np.isnan(found).any()
    flat = ((surface.points - beam.isocenter) @ axes.T)[surface.triangles]
    rng = np.random.default_rng(2)
    right, up = beside(beam)
    for row, column in rng.integers(100, 412, (40, 2)):
        assert found[row, column] == pytest.approx(
            length_within(flat, right[row, column], up[row, column]), abs=1e-8
        )


def length_within(flat, x, y):
    """Of one ray, by looking at every triangle."""
    low, high = flat[..., :2].min(axis=1), flat[..., :2].max(axis=1)
    near = (low <= (x, y)).all(axis=1) & (high >= (x, y)).all(axis=1)
    a, b, c = (flat[near, corner] for corner in range(3))
    u, v, w = (
        (p[:, 0] - x) * (q[:, 1] - y) - (p[:, 1] - y) * (q[:, 0] - x)
        for p, q in ((b, c), (c, a), (a, b))
    )
    hit = ((u > 0) & (v > 0) & (w > 0)) | ((u < 0) & (v < 0) & (w < 0))
    depths = np.sort((u * a[:, 2] + v * b[:, 2] + w * c[:, 2])[hit] / (u + v + w)[hit])
    return float((depths[1::2] - depths[::2]).sum())
