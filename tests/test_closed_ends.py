"""Diameters right up to a capped in- or outlet."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from trees import unbranched

from SDFStentLib.deformation import DeploymentSettings
from SDFStentLib.files import read_surface
from SDFStentLib.geometry import Surface
from SDFStentLib.lumen import diameter_profile
from SDFStentLib.stent import AtCenter, Stent
from SDFStentLib.treatment import Treatment

RADIUS, LENGTH = 4.0, 30.0


def a_capped_duct(outline, tilt=0.0, bulge=0.0):
    """Tube of any convex outline (k, 2) along z with caps that lean by `tilt` and may bulge."""
    outline = np.asarray(outline, dtype=float)
    count, heights = len(outline), np.linspace(0, LENGTH, 31)
    rings = []
    for height in heights:
        lean = np.tan(tilt) * outline[:, 0] * abs(1 - 2 * height / LENGTH)
        rings.append(np.column_stack([outline, np.full(count, height) + lean]))
    ring, after = np.arange(count), (np.arange(count) + 1) % count
    faces = []
    for base in range(0, count * (len(heights) - 1), count):
        faces.append(np.column_stack([base + ring, base + after, base + count + after]))
        faces.append(np.column_stack([base + ring, base + count + after, base + count + ring]))
    points = np.concatenate(rings)
    middles = [[0, 0, bulge], [0, 0, LENGTH - bulge]]
    first, last = len(points), len(points) - count
    faces.append(np.column_stack([after, ring, np.full(count, first)]))
    faces.append(np.column_stack([last + ring, last + after, np.full(count, first + 1)]))
    return np.concatenate([points, middles]), np.concatenate(faces)


def a_circle(count=32):
    angle = np.linspace(0, 2 * np.pi, count, endpoint=False)
    return RADIUS * np.column_stack([np.cos(angle), np.sin(angle)])


A_SQUARE = [
    [s, t] for s, t in ((-3, -3), (0, -3), (3, -3), (3, 0), (3, 3), (0, 3), (-3, 3), (-3, 0))
]
A_LINE = [[0.1, 0, 0], [0.1, 0, LENGTH]]


@pytest.mark.parametrize("turned", [0, 20, 35, 50, 80])
@pytest.mark.parametrize("lean", [0, 2, 5, 10, 15, 25])
def test_an_axis_that_ends_askew_on_a_cap_makes_no_vessel_narrow(turned, lean):
    turn = Rotation.from_euler("xyz", [turned, 1.4 * turned, 20], degrees=True).as_matrix()
    points, triangles = a_capped_duct(a_circle())
    aside = 8 * np.tan(np.deg2rad(lean))
    axis = np.array([[0.1, 0, 15], [0.1, 0, 22], [0.1 + aside, 0, LENGTH]]) @ turn.T
    profile = diameter_profile(Surface(points @ turn.T, triangles), axis, 2.0)
    inscribed = profile.inscribed_diameter
    # The last plane may lead out of the end: it holds no sphere, or one up to half the long axis
    # of the ellipse in which it cuts the tube.
    width = 2 * RADIUS * np.cos(np.pi / 32)
    np.testing.assert_allclose(inscribed[:-2], width, rtol=1e-4)
    known = inscribed[-2:][np.isfinite(inscribed[-2:])]
    longest = width / np.cos(np.deg2rad(lean))
    assert ((known > 0.9999 * width) & (known < 1.0001 * longest)).all(), inscribed
    assert len(profile.gaps) or np.isfinite(inscribed).all()


def test_the_flat_sides_of_a_square_duct_are_wall():
    profile = diameter_profile(Surface(*a_capped_duct(A_SQUARE)), A_LINE)
    np.testing.assert_allclose(profile.inscribed_diameter, 6, rtol=1e-6)


def test_a_patients_rounded_outlets_are_as_wide_as_the_vessel_before_them(data_dir):
    """Against the circle that fits into the section, which knows nothing of spheres."""
    from SDFStentLib.files import read_centerline
    from SDFStentLib.geometry import plane_section

    vessel = read_surface(data_dir / "vmtk_aorta_surface_mm.vtp")
    tree = read_centerline(data_dir / "vmtk_aorta_centerline_mm.vtp")
    for leaf in tree.leaves:
        path = tree.path(tree.points[tree.roots[0]], tree.points[leaf])
        profile = diameter_profile(vessel.surface, path.points)
        inscribed = profile.inscribed_diameter
        assert np.isfinite(inscribed).all()
        assert inscribed[-8:-1].min() > 0.95 * np.median(inscribed[-16:-8])
        # The last section lies in the rounding itself and is smaller; the sphere fills it.
        assert inscribed[-1] > 0.9 * profile.equivalent_diameter[-1]
        direction = path.points[-1] - path.points[-8]
        for center, diameter in zip(profile.centers[-4:-1], inscribed[-4:-1], strict=True):
            loops = plane_section(
                vessel.surface.points, vessel.surface.triangles, center, direction
            )
            corners = min((np.linalg.norm(loop.points - center, axis=1) for loop in loops), key=min)
            assert diameter / 2 < 1.02 * corners.min()


def test_a_ridge_beside_the_way_is_no_end():
    """Near the end of a line, a sphere that touches a flow divider obliquely keeps its diameter."""
    points, triangles = a_capped_duct(a_circle())
    # A small pyramid in the way, 35 degrees beside the axis as seen from the line's last point.
    tip = np.array([2.0, 0.0, 15.0])
    foot = tip + np.array([[1.0, -0.6, 2.0], [1.0, 0.6, 2.0], [2.0, 0.0, 2.5]])
    ridge = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]) + len(points)
    points, triangles = np.vstack([points, tip, foot]), np.concatenate([triangles, ridge])
    profile = diameter_profile(Surface(points, triangles), [[0, 0, 2.0], [0, 0, 12.2]])
    assert np.isfinite(profile.inscribed_diameter).all()
    assert profile.inscribed_diameter[-1] < 7.5


def test_the_vessel_between_a_stent_and_a_cap_is_as_wide_as_its_wall():
    """And not as the way to the cap is long, nor as the cap is bulged."""
    surface, height = Surface(*a_capped_duct(a_circle())), np.linspace(0, LENGTH, 61)
    tree = unbranched(np.column_stack([0 * height, 0 * height, height]), np.full(61, RADIUS))
    stent = Stent(9.5, placement=AtCenter([0, 0, 9.0]), length=10.0)
    treated = Treatment(surface, [stent], tree, DeploymentSettings(certify=False)).result.stents[0]
    lumen = 2 * RADIUS * np.cos(np.pi / 32)
    for neighbor in treated.neighbors:
        assert not neighbor.by_area
        assert neighbor.before == pytest.approx(lumen, rel=1e-6)
        assert neighbor.after >= neighbor.before - 1e-6
