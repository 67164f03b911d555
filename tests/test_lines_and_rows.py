"""Polylines, rows of vectors and loops: closed forms, identities and degenerate input."""

import os
import shutil

import numpy as np
import pytest
from child_processes import python
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from trees import unbranched

from benchmarks.phantoms import stenosed_tube
from SDFStentLib.__main__ import ONE_THREAD
from SDFStentLib.cli import main
from SDFStentLib.geometry import Line, SurfaceIndex, closest_on_segments, product, tightest_bend
from SDFStentLib.geometry.line import PAIRS_PER_BLOCK
from SDFStentLib.lumen import LocalSurface
from SDFStentLib.lumen.spheres import climb, inscribed
from SDFStentLib.samples import sample
from SDFStentLib.validation import InputError

CORNER = np.array([[0.0, 0, 0], [3, 0, 0], [3, 4, 0]])
# Coordinates up to 100 mm carry about 1e-14 relative rounding; sums of twenty stay far below.
ROUNDING = 1e-9

any_polyline = arrays(
    np.float64, st.tuples(st.integers(2, 20), st.just(3)), elements=st.floats(-100, 100, width=32)
).filter(lambda points: Line(points).length > 1e-3)


def an_arc(radius: float = 10.0, count: int = 200) -> np.ndarray:
    angles = np.linspace(0.0, np.pi / 2, count)
    return radius * np.column_stack([np.cos(angles), np.sin(angles), 0 * angles])


@settings(max_examples=30)
@given(any_polyline, st.floats(0.05, 50))
def test_resampling_keeps_the_ends_and_spaces_equally(points, spacing):
    total = Line(points).length
    if total / spacing > 2000:
        spacing = total / 2000
    result = Line(points).resampled(spacing).points
    assert len(result) == max(1, round(total / spacing)) + 1
    assert (result[0] == points[0]).all()
    assert (result[-1] == points[-1]).all()
    on_line = closest_on_segments(points[:-1], points[1:], result)
    assert on_line.distances.max() < ROUNDING


def test_closest_points_in_blocks_match_dense_sampling():
    rng = np.random.default_rng(7)
    points, queries = rng.normal(size=(30, 3)), rng.normal(size=(PAIRS_PER_BLOCK // 29 + 10, 3))
    found = Line(points).nearest(queries)
    np.testing.assert_allclose(
        np.linalg.norm(found.points - queries, axis=1), found.distances, atol=ROUNDING
    )
    np.testing.assert_allclose(Line(points).at(found.arc_lengths), found.points, atol=ROUNDING)
    samples = Line(points).resampled_to(3000).points
    some = np.r_[0:20, -20:0]
    brute = np.linalg.norm(samples[:, None] - queries[some], axis=2).min(axis=0)
    step = Line(points).length / 2999
    # A sample lies within half a step of the true foot.
    assert (found.distances[some] <= brute + ROUNDING).all()
    assert (brute <= found.distances[some] + step / 2 + ROUNDING).all()


def test_the_bend_radius_of_lines_corners_and_hairpins():
    assert tightest_bend(Line(CORNER[:2])).radius == np.inf
    assert tightest_bend(Line([[0, 0, 0], [1, 0, 0], [5, 0, 0]])).radius == np.inf
    assert tightest_bend(Line([[0, 0, 0], [1, 0, 0], [0.5, 0, 0]])).radius == 0
    corner = tightest_bend(Line([[0, 0, 0], [4, 0, 0], [4, 4, 0]]), window=2.0).radius
    # The corner is met to a sixteenth of the window, which is second order in the radius.
    assert corner == pytest.approx(2 / (2 * np.sin(np.pi / 4)), rel=1 / 16**2 * 2)
    assert tightest_bend(Line(an_arc()), window=1e-9).radius > 0


# Arithmetic on rows of vectors.


@pytest.mark.parametrize(
    "shape", [(0, 3, 4), (4, 3, 0), (1, 5, 70_000), (70_000, 3, 40), (9, 5, 9)]
)
def test_a_product_in_blocks_is_the_product(shape):
    rows, inner, columns = shape
    random = np.random.default_rng(0)
    left, right = random.normal(size=(rows, inner)), random.normal(size=(inner, columns))
    np.testing.assert_allclose(product(left, right), left @ right, atol=1e-12)
    vector = random.normal(size=inner)
    np.testing.assert_allclose(product(left, vector), left @ vector, atol=1e-12)


def test_the_command_line_computes_with_one_thread():
    script = f"""
import os, sys
from SDFStentLib.__main__ import main
assert "numpy" not in sys.modules
sys.argv = ["sdfstent", "--version"]
main()
print([os.environ[name] for name in {ONE_THREAD}])
"""
    clean = {name: value for name, value in os.environ.items() if name not in ONE_THREAD}
    assert str(["1", "1", "1"]) in python(script, env=clean).stdout


# Nothing waits for ever: every loop ends for a reason that stands beside it.


@pytest.fixture(scope="module")
def the_patient(tmp_path_factory):
    """A folder with the surface and the centerline of the demo."""
    folder = tmp_path_factory.mktemp("loops")
    for path, name in zip(
        sample("branching_pulmonary_artery"), ("surface", "centerline"), strict=True
    ):
        shutil.copy(path, folder / f"{name}.vtp")
    return folder


@pytest.mark.parametrize(
    "command",
    [
        "deploy -o out.vtp --center -26.510415359278095 0 36 --diameter 8.217 --length 19.11"
        " --straighten 0.5",
        "deploy -o out.vtp --center 17.320665289765397 -5.114567101086642 30.282713418689042"
        " --diameter 10.419 --length 25.31 --straighten 1",
        "measure --spacing 9",
    ],
)
def test_a_station_on_a_vertex_of_a_closed_end_is_measured(
    the_patient, command, monkeypatch, capsys
):
    monkeypatch.chdir(the_patient)
    name, *options = command.split()
    code = main([name, "surface.vtp", "--centerline", "centerline.vtp", *options])
    said = capsys.readouterr().err
    assert code in (0, 3), said
    assert all(line.startswith("warning: ") for line in said.splitlines()), said


@pytest.mark.parametrize("seed", range(5))
def test_a_local_surface_misses_nothing_of_the_whole_one(seed):
    random = np.random.default_rng(seed)
    tube = stenosed_tube(edge_length=1.5)
    points, triangles = tube.points, tube.triangles
    centers = points[random.integers(0, len(points), 2)]
    local, whole = LocalSurface(points, triangles, centers), SurfaceIndex(points, triangles)
    for scale in (0.0, 1e-12, 0.1, 3.0, 20.0, 1e3):
        queries = centers + scale * random.normal(size=(2, 3))
        # A part made anew, of which nothing has been asked yet.
        least = LocalSurface(points, triangles, centers).least(queries)
        assert (least <= whole.distances(queries).distance).all()
        assert (whole.distances(queries).distance <= least + whole.disc_radii.max() + 1e-9).all()
        radii = scale * random.random(2)
        found, expected = local.near(queries, radii), whole.near(queries, radii)
        for query in range(2):
            corners = [
                np.sort(index.corners[pairs.triangle[pairs.query == query]].reshape(-1, 9), axis=0)
                for index, pairs in ((local.index, found), (whole, expected))
            ]
            np.testing.assert_array_equal(*corners)
        exact = whole.distances(queries).distance
        np.testing.assert_allclose(local.distances(queries), exact, rtol=1e-14, atol=0)


@pytest.mark.parametrize(("length", "spacing"), [(1e6, 1e-20), (1.0, 1e-320), (20.001, 1e-3)])
def test_a_line_is_made_anew_with_a_bounded_number_of_segments(length, spacing):
    with pytest.raises(InputError, match="spacing: expected at least"):
        Line([[0, 0, 0], [length, 0, 0]]).resampled(spacing)
    with pytest.raises(InputError, match="spacing: expected at least"):
        unbranched([[0, 0, 0], [length, 0, 0]]).resampled(spacing)
    assert len(Line([[0, 0, 0], [20.0, 0, 0]]).resampled(1e-3)) == 20_001


def test_a_climb_that_does_not_settle_ends_with_the_exact_radius_of_where_it_is(monkeypatch):
    tube = stenosed_tube(edge_length=1.5)
    monkeypatch.setattr(climb, "ROUNDS", 1)
    axis = [[0.5, 0, 10], [0.5, 0, 20], [0.5, 0, 30]]
    spheres = inscribed.inscribed_spheres(tube.points, tube.triangles, axis)
    exact = SurfaceIndex(tube.points, tube.triangles).distances(spheres.centers).distance
    np.testing.assert_allclose(spheres.radii, exact, rtol=1e-12)
    settled = SurfaceIndex(tube.points, tube.triangles).distances(np.asarray(axis)).distance
    assert (spheres.radii >= settled).all()
