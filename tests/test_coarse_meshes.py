"""Meshes too coarse for a stent: the lumen is reached, or said where it is not, and what to do."""

import re

import numpy as np
import pytest
from scipy.spatial import KDTree

from SDFStentLib.deformation import DeploymentSettings
from SDFStentLib.geometry import Line, Surface
from SDFStentLib.stent import AlongAxis, Stent
from SDFStentLib.treatment import Preview, Treatment
from SDFStentLib.validation import DeploymentError

WIDE = 3.5
"""mm."""


def prism(sides, rings, depth=0.0, turn=0.0, is_twisted=False):
    """A closed tube of 60 mm with few sides, narrowed in its middle by a share of its radius.

    Twisted, every other ring has its corners between those of the others, as scans have.
    """
    z = np.linspace(0, 60, rings)
    radius = WIDE * (1 - depth * np.exp(-(((z - 30) / 5) ** 2)))
    angle = turn + 2 * np.pi * np.arange(sides) / sides
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    points = np.zeros((rings, sides, 3))
    points[..., :2], points[..., 2] = radius[:, None, None] * circle, z[:, None]
    if is_twisted:
        cosine, sine = np.cos(np.pi / sides), np.sin(np.pi / sides)
        points[1::2, :, :2] = points[1::2, :, :2] @ [[cosine, sine], [-sine, cosine]]
    i, j = (one.ravel() for one in np.mgrid[: rings - 1, :sides])
    a, b = i * sides + j, i * sides + (j + 1) % sides
    k, after = np.arange(sides), (np.arange(sides) + 1) % sides
    first, last = rings * sides, (rings - 1) * sides
    triangles = np.concatenate(
        [
            np.stack([a, b, b + sides], 1),
            np.stack([a, b + sides, a + sides], 1),
            np.stack([after, k, np.full(sides, first)], 1),
            np.stack([last + k, last + after, np.full(sides, first + 1)], 1),
        ]
    )
    return np.vstack([points.reshape(-1, 3), [[0, 0, 0], [0, 0, 60]]]), triangles


def halved(points, triangles):
    """Every triangle in four, on the same wall."""
    sides = np.sort(np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)]))
    ends, number = np.unique(sides, axis=0, return_inverse=True)
    number = number.reshape(3, -1) + len(points)
    (a, b, c), (ab, bc, ca) = triangles.T, number
    four = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
    parts = np.concatenate([np.stack(one, 1) for one in four])
    return np.vstack([points, points[ends].mean(axis=1)]), parts


def stented(points, triangles, diameter, start=22.0, end=38.0, settings=None):
    axis = np.stack([0 * np.linspace(start, end, 40)] * 2 + [np.linspace(start, end, 40)], axis=1)
    stent = Stent(diameter, placement=AlongAxis(axis))
    return Treatment(Surface(points, triangles), [stent], None, settings).result


def narrowest(result):
    """Diameter by dense samples of every triangle of the wall, from the axis."""
    weights = np.array([(i, j, 40 - i - j) for i in range(41) for j in range(41 - i)]) / 40
    corners = result.before.points[result.before.triangles]
    is_wall = np.ptp(corners[:, :, 2], axis=1) > 1e-9
    corners = result.surface.points[result.surface.triangles[is_wall]]
    samples = np.einsum("sc,fcx->fsx", weights, corners).reshape(-1, 3)
    line = Line(result.stents[0].axis.points).resampled(0.5)
    return 2 * KDTree(samples).query(line.points)[0].min()


def of_kind(result, kind):
    return [caution for caution in result.warnings if caution.kind == kind]


@pytest.mark.parametrize("seed", range(600, 612))
def test_a_prism_is_opened_or_its_place_is_told_with_the_edges_to_refine_to(seed):
    random = np.random.default_rng(seed)
    sides, rings = int(random.integers(3, 13)), int(random.choice([9, 20, 61]))
    depth = float(random.choice([0.0, 0.5, 0.85]))
    diameter = 2 * WIDE * random.uniform(0.9, 1.4)
    points, triangles = prism(sides, rings, depth, random.uniform(0, 6), bool(seed % 2))
    result = stented(points, triangles, diameter)
    share = narrowest(result) / diameter
    assert not of_kind(result, "without-effect") or share > 0.97
    if result.certificate.passed:
        assert share > 0.969  # 3 %, and what the samples leave
        assert not of_kind(result, "too-coarse")
        return
    (told,) = of_kind(result, "too-coarse")
    numbers = told.numbers
    assert numbers["edge_mm"] > 0.6 * numbers["prescribed_mm"] / 2
    assert numbers["fine_mm"] <= numbers["start_mm"] / 3
    sides_now = np.linalg.norm(
        np.diff(result.surface.points[result.surface.triangles][:, [0, 1, 2, 0]], axis=1), axis=2
    )
    assert np.abs(sides_now - numbers["edge_mm"]).min() < 1e-9


def test_a_tight_throat_is_told_where_it_is_and_refined_as_told_it_is_opened():
    points, triangles = prism(5, 61, depth=0.87, turn=0.3, is_twisted=True)
    result = stented(points, triangles, 7.0)
    (told,) = of_kind(result, "too-coarse")
    assert abs(told.place[2] - 30) <= 8
    assert narrowest(result) < 0.97 * 7.0
    text = told.sentence()
    assert re.match(r"The mesh is too coarse for the stent near \(.*\) mm: triangles with", text)
    while np.linalg.norm(points[triangles[:, 0]] - points[triangles[:, 1]], axis=1).max() > 0.6:
        points, triangles = halved(points, triangles)
    again = stented(points, triangles, 7.0)
    assert narrowest(again) > 0.97 * 7.0
    assert not of_kind(again, "too-coarse")


@pytest.mark.parametrize("sides", [3, 7, 32])
def test_two_rings_of_a_cylinder_are_a_wall_between_points_that_are_too_far_apart(sides):
    points, triangles = prism(sides, 2)
    axis = np.array([[0, 0, 22.0], [0, 0, 38.0]])
    stents = [Stent(8.0, placement=AlongAxis(axis))]
    surface = Surface(points, triangles)
    away = WIDE * np.cos(np.pi / sides)
    for tried in (lambda: Treatment(surface, stents).result, lambda: Preview(surface).of(stents)):
        with pytest.raises(DeploymentError, match=r"the wall is [\d.]+ mm away near") as raised:
            tried()
        text = str(raised.value)
        assert float(re.search(r"wall is ([\d.]+) mm", text)[1]) == pytest.approx(away, abs=0.06)
        assert float(re.search(r"sides of (\d+)", text)[1]) >= 60
        assert text.endswith("to edges of at most 1 mm.")


def test_away_from_all_of_the_wall_unit_and_frame_are_asked_for():
    points, triangles = prism(12, 2)
    axis = AlongAxis(np.array([[80, 0, 22.0], [80, 0, 38.0]]))
    with pytest.raises(DeploymentError, match="same unit and frame"):
        _ = Treatment(Surface(points, triangles), [Stent(8.0, placement=axis)]).result


def test_a_stent_between_points_is_not_called_narrower_than_the_lumen():
    points, triangles = prism(16, 2)
    result = stented(points, triangles, 8.0, 8.5, 51.5)
    assert not of_kind(result, "without-effect")
    (told,) = of_kind(result, "too-coarse")
    assert "e+" not in told.sentence()
    assert told.numbers["fine_mm"] == pytest.approx(1.0)


def test_a_lumen_that_few_sides_reach_is_no_reason_to_warn_and_unjudged_it_is():
    points, triangles = prism(7, 61)
    result = stented(points, triangles, 8.0)
    assert result.certificate.passed
    assert narrowest(result) > 0.985 * 8.0
    assert not of_kind(result, "too-coarse")
    assert not of_kind(result, "coarse-mesh")
    unjudged = stented(points, triangles, 8.0, settings=DeploymentSettings(certify=False))
    assert of_kind(unjudged, "coarse-mesh")
