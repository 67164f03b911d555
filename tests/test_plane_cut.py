"""Cutting a surface by one plane, and filling what was cut."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from SDFStentLib.geometry import Surface, cut_along, face_areas, flat_fill, section_around
from SDFStentLib.geometry.flat_fill import _ears
from SDFStentLib.phantoms import bent_tube, straight_tube


def circle(count, radius=3.0):
    angles = np.linspace(0, 2 * np.pi, count, endpoint=False)
    return radius * np.column_stack([np.cos(angles), np.sin(angles)])


def star(count, deep=0.3):
    polygon = circle(count)
    polygon[::2] *= deep
    return polygon


POLYGONS = {
    "triangle": circle(3),
    "circle": circle(60),
    "star": star(30),
    "narrow waist": circle(80) * [1, 0.02]
    + np.outer(np.cos(np.linspace(0, 4 * np.pi, 80)), [0, 0]),
    "square with points on its sides": np.array(
        [[x, 0] for x in range(5)]
        + [[5, y] for y in range(5)]
        + [[5 - x, 5] for x in range(5)]
        + [[0, 5 - y] for y in range(5)],
        float,
    ),
    "long beside short sides": np.vstack([circle(60)[:20], circle(60)[30:31], circle(60)[45:46]]),
    "hook": np.array([[0, 0], [4, 0], [4, 4], [3.9, 4], [3.9, 0.1], [0, 0.1]], float),
}


def area_of(polygon):
    (x, y), (end_x, end_y) = polygon.T, np.roll(polygon, -1, axis=0).T
    return float((x * end_y - y * end_x).sum() / 2)


def assert_filled(polygon, inner, triangles):
    points = np.vstack([polygon, inner])
    first, second, third = points[triangles].transpose(1, 0, 2)
    (ax, ay), (bx, by) = (second - first).T, (third - first).T
    areas = (ax * by - ay * bx) / 2
    assert areas.min() > 0
    assert areas.sum() == pytest.approx(area_of(polygon), rel=1e-12)
    sides = [
        (int(a), int(b)) for row in triangles for a, b in zip(row, np.roll(row, -1), strict=True)
    ]
    border = {side for side in sides if side[::-1] not in sides}
    assert len(set(sides)) == len(sides)
    assert border == {(n, (n + 1) % len(polygon)) for n in range(len(polygon))}
    # Euler: what is bounded by one curve, without a hole.
    assert len(triangles) == len(polygon) + 2 * len(inner) - 2


@pytest.mark.parametrize("name", POLYGONS)
def test_ears_fill_any_polygon(name):
    polygon = POLYGONS[name]
    assert_filled(polygon, np.zeros((0, 2)), _ears(polygon))


@settings(max_examples=30, deadline=None)
@given(st.lists(st.floats(0.2, 1.0), min_size=5, max_size=60))
def test_any_polygon_seen_from_its_middle_is_filled(radii):
    polygon = circle(len(radii)) * np.array(radii)[:, None]
    fill = flat_fill(polygon)
    assert_filled(polygon, fill.inner, fill.triangles)


def test_a_polygon_that_turns_clockwise_is_not_filled():
    assert flat_fill(circle(20)[::-1]) is None


PLANES = {
    "across": ([0, 0, 20.0], [0, 0, 1.0]),
    "between": ([0, 0, 20.123], [0, 0, -1.0]),
    "oblique": ([0, 0, 20.0], [0.5, 0.2, 1.0]),
    "very oblique": ([0, 0, 20.0], [2.0, 0.0, 1.0]),
}


def cut(surface, origin, normal):
    origin, normal = np.asarray(origin, float), np.asarray(normal, float)
    normal = normal / np.linalg.norm(normal)
    section = section_around(surface.points, surface.triangles, origin, normal)
    return section, cut_along(surface.points, surface.triangles, section, origin, normal), normal


@pytest.mark.parametrize("name", PLANES)
def test_the_area_of_a_section_is_that_of_the_ellipse(name):
    origin, normal = PLANES[name]
    section, _, unit = cut(straight_tube(radius=3.0).surface, origin, normal)
    ellipse = np.pi * 9 / abs(unit[2])
    assert section.area == pytest.approx(ellipse, rel=0.01)


@settings(max_examples=30, deadline=None)
@given(st.floats(3, 27), st.floats(-0.6, 0.6), st.floats(-0.6, 0.6))
def test_no_plane_across_a_bend_leaves_slivers_or_folds(place, first, second):
    tube = TUBE
    at = int(np.argmin(np.abs(tube.centerline.arc_length - place)))
    origin, ahead = tube.centerline.points[at], tube.centerline.points[at + 1]
    normal = (ahead - origin) / np.linalg.norm(ahead - origin) + [first, second, 0]
    _, found, _ = cut(tube.surface, origin, normal)
    assert len(found.rim)
    whole = Surface(found.points, found.triangles)
    assert whole.topology.is_watertight
    assert face_areas(found.points, found.triangles).min() > 1e-5


TUBE = bent_tube()
