"""The fast ways of measuring agree with plain ones, on phantoms and on anatomies."""

import numpy as np
import pytest
from deployment_cases import ONE_ANATOMY, VESSELS, vessel_named
from plain_measuring import nearest_points, plain_sphere

from benchmarks.phantoms import stenosed_tube, vascular_tree
from SDFStentLib.deformation import DeploymentSettings, deploy
from SDFStentLib.files import read_centerline, read_surface
from SDFStentLib.geometry import (
    Balls,
    Line,
    Surface,
    SurfaceIndex,
    may_meet_box,
    nearest_distances,
)
from SDFStentLib.geometry.distance import closest_points_on_triangles
from SDFStentLib.lumen import (
    LocalSurface,
    StationSearch,
    Until,
    equivalent_diameters,
    in_caps,
    inscribed_spheres,
    measured_after,
    measured_at,
    moved_wall,
    near_wall,
    rays_from,
    section_loops,
)
from SDFStentLib.lumen.cross_section import _lumen_area
from SDFStentLib.lumen.spheres import inscribed, known_index
from SDFStentLib.lumen.wall_map import cuts_across
from SDFStentLib.plan import read_input_files
from SDFStentLib.stent import AtCenter, Stent
from SDFStentLib.treatment import Treatment, treated_lesions
from SDFStentLib.vessel import branch_lumen, find_lesions, found_narrowings
from SDFStentLib.vessel.branch_lumen import branch_lumens, tree_lumen
from SDFStentLib.vessel.found_narrowings import measured_runs
from SDFStentLib.vessel.runs import vessel_runs


def narrowed_tree():
    """The same object each time, for it takes seconds to make."""
    return vascular_tree(8, 1.0, {3: 0.5})


@pytest.fixture(scope="module", params=[*VESSELS, *ONE_ANATOMY])
def a_vessel(request):
    """Points and triangles of a vessel, before and after a stent of 25 mm, and its axis."""
    made = vessel_named(request)
    line = made.centerline
    way = line.path(line.points[line.roots[0]], line.points[np.sort(line.leaves)[0]])
    axis = Line(way.points).cut(10.0, 35.0).points
    radius = 1.2 * np.nanmedian(way.inscribed_radius)
    settings = DeploymentSettings(certify=False)
    after = deploy(made.surface, settings.chain(axis), radius, settings)
    return (made.points, after.points), made.triangles, axis


@pytest.fixture(scope="module", params=["branches", "tree", *ONE_ANATOMY])
def a_vessel_and_its_tree(request):
    made = narrowed_tree() if request.param == "tree" else vessel_named(request)
    return made.surface, made.centerline


@pytest.mark.parametrize("name", ["su0243", "tree_narrowed"])
def test_vessels_that_rough_spheres_pass_over_have_no_lesion(data_dir, monkeypatch, name):
    """One of 28 % at an ostium was passed over, and half of one across a branch."""
    surface = read_surface(data_dir / f"{name}_surface_mm.vtp").surface
    line = read_centerline(data_dir / f"{name}_centerline_mm.vtp")
    told = find_lesions(surface, line)
    # All may have one by rough spheres.
    monkeypatch.setattr(found_narrowings, "_asked", lambda runs: list(range(len(runs))))
    every = find_lesions(Surface(surface.points, surface.triangles), line)
    assert [one.point for one in told] == [one.point for one in every]
    assert [one.percent_diameter for one in told] == [one.percent_diameter for one in every]


@pytest.mark.parametrize("when", [0, 1], ids=["before", "after"])
def test_spheres_are_those_of_a_plain_climb(a_vessel, when):
    points, triangles, axis = a_vessel[0][when], *a_vessel[1:]
    places = Line(axis).resampled(4.0).points
    directions = Line(places).directions
    found = inscribed_spheres(points, triangles, places, directions)
    for place, direction, radius in zip(places, directions, found.radii, strict=True):
        expected = plain_sphere(points, triangles, place, direction)[1]
        assert radius == pytest.approx(expected, abs=1e-3)


def test_spheres_of_a_whole_tree_are_those_of_plain_climbs(monkeypatch):
    monkeypatch.setattr(inscribed, "PAIRS", 1 << 14)  # They are searched in some parts.
    rng = np.random.default_rng(0)
    made = narrowed_tree()
    lines = [made.centerline.points[branch] for branch in made.centerline.branches]
    # At an end an axis point lies on the wall, where the plain way does not know where to go.
    lines = [Line(line).resampled(0.4).points[1:-1] for line in lines if Line(line).length > 0]
    places = np.concatenate(lines)
    directions = np.concatenate([Line(line).directions for line in lines])
    found = inscribed_spheres(made.points, made.triangles, places, directions).radii
    middles = made.points[made.triangles].mean(axis=1)
    for one in rng.choice(len(places), 8, replace=False):
        # The plain way begins with a part of what it is given: of a whole tree too little is left.
        near = made.triangles[np.linalg.norm(middles - places[one], axis=1) < 15.0]
        expected = plain_sphere(made.points, near, places[one], directions[one])[1]
        assert found[one] == pytest.approx(expected, abs=1e-3)


def test_spheres_in_most_of_a_surface_are_those_in_the_part_round_them():
    made = narrowed_tree()
    surface, branches = made.surface, made.centerline.branches
    lines = [Line(made.centerline.points[branch]) for branch in branches]
    lines = [line.resampled(2.0) for line in lines if line.length > 4.0]
    longest = max(lines, key=lambda line: np.ptp(line.points, axis=0).max())
    for some in (lines, [longest]):
        places, ways = (
            np.concatenate([getattr(line, name) for line in some])
            for name in ("points", "directions")
        )
        kept = LocalSurface.of(surface, places)
        part = LocalSurface(made.points, made.triangles, places)
        found, own = (StationSearch(one, places, ways, Until()) for one in (kept, part))
        for one, other in ((found.rough, own.rough), (found.exact(), own.exact())):
            np.testing.assert_array_equal(one.centers, other.centers)
            np.testing.assert_array_equal(one.radii, other.radii)
        is_most = len(part.index.centroids) > len(made.triangles) / 2
        assert (kept.index is known_index(surface)) == is_most
        assert is_most == (some is lines)


@pytest.mark.parametrize("when", [0, 1], ids=["before", "after"])
def test_sections_cut_together_have_the_areas_of_those_cut_one_by_one(a_vessel, when):
    points, triangles, axis = a_vessel[0][when], *a_vessel[1:]
    places = Line(axis).resampled(1.0).points
    directions = Line(places).directions
    found = equivalent_diameters(points, triangles, places, directions)
    areas = [_lumen_area(points, triangles, *at) for at in zip(places, directions, strict=True)]
    np.testing.assert_allclose(found, 2 * np.sqrt(np.array(areas) / np.pi), rtol=1e-9)
    assert np.isfinite(found).any()


def test_the_whole_surface_is_looked_at_once_however_many_sections(monkeypatch):
    """It was for every 16 of them: a fifth of the time of sections of a fine mesh."""
    tube, looked_at = stenosed_tube(3.0, 1.5, 40.0, 0.8), []

    def counted(points, triangles, *box):
        looked_at.append(len(triangles))
        return may_meet_box(points, triangles, *box)

    monkeypatch.setattr("SDFStentLib.lumen.section_areas.may_meet_box", counted)
    places = np.linspace([0, 0, 10.0], [0, 0, 30.0], 40)
    ways = np.tile([0, 0, 1.0], (40, 1))
    found = equivalent_diameters(tube.points, tube.triangles, places, ways)
    assert np.isfinite(found).all()
    assert looked_at.count(len(tube.triangles)) == 1
    assert equivalent_diameters(tube.points, tube.triangles, places[:0], ways[:0]).shape == (0,)


@pytest.mark.parametrize("when", [0, 1], ids=["before", "after"])
def test_stations_measured_together_are_those_measured_alone(a_vessel, when):
    surface = Surface(a_vessel[0][when], a_vessel[1])
    places = Line(a_vessel[2]).resampled(6.0).points
    directions = Line(places).directions
    together = measured_at(surface, places, directions)
    for number in range(len(places)):
        alone = measured_at(surface, places[[number]], directions[[number]])
        one = together.at([number])
        np.testing.assert_allclose(one.spheres.radii, alone.spheres.radii, atol=1e-3)
        np.testing.assert_allclose(one.equivalent, alone.equivalent, atol=1e-3)


def test_a_sphere_does_not_depend_on_what_else_is_searched(data_dir):
    """In junctions a plane has two widest places: of 400 stations one was up to 0.2 mm wider."""
    names = [str(data_dir / f"su0243_{name}_mm.vtp") for name in ("surface", "centerline")]
    vessel = read_input_files(*names).vessel
    lines = [Line(vessel.centerline.points[branch]) for branch in vessel.centerline.branches]
    places = np.concatenate([line.points for line in lines])
    ways = np.concatenate([line.directions for line in lines])
    wall = LocalSurface.of(vessel.surface, places)
    whole = StationSearch(wall, places, ways, Until()).exact()
    some = np.sort(np.random.default_rng(1).choice(len(places), 400, replace=False))
    part = StationSearch(wall, places[some], ways[some], Until()).exact()
    np.testing.assert_array_equal(part.radii, whole.radii[some])
    np.testing.assert_array_equal(part.centers, whole.centers[some])


@pytest.mark.parametrize("when", [0, 1], ids=["before", "after"])
def test_a_climb_ends_where_the_sphere_is_large_enough(a_vessel, when):
    points, triangles, axis = a_vessel[0][when], *a_vessel[1:]
    places = Line(axis).resampled(4.0).points
    directions = Line(places).directions
    whole = inscribed_spheres(points, triangles, places, directions)
    enough = 0.9 * whole.radii
    enough[::3] = np.inf
    found = inscribed_spheres(points, triangles, places, directions, Until(enough=enough))
    np.testing.assert_allclose(found.radii[::3], whole.radii[::3], atol=1e-3)
    is_large = found.radii > enough
    np.testing.assert_allclose(found.radii[~is_large], whole.radii[~is_large], atol=1e-3)
    assert (found.radii <= whole.radii + 1e-3).all()
    exact = SurfaceIndex(points, triangles).distances(found.centers).distance
    np.testing.assert_allclose(found.radii, exact, rtol=1e-9)


def test_ends_of_vessels_are_the_same_where_their_spheres_are_searched_to_the_end(
    a_vessel_and_its_tree, monkeypatch
):
    surface, tree = a_vessel_and_its_tree
    fast = vessel_runs(branch_lumens(surface, tree))

    def whole(wall, stations, directions, until):
        assert np.isfinite(until.enough).any()
        return StationSearch(wall, stations, directions, until._replace(enough=np.inf))

    monkeypatch.setattr(branch_lumen, "StationSearch", whole)
    unmeasured = surface.with_points(surface.points)
    for one, exact in zip(fast, vessel_runs(branch_lumens(unmeasured, tree)), strict=True):
        np.testing.assert_allclose(one.diameter, exact.diameter, atol=1e-3)


def test_vessels_with_a_narrowing_are_measured_exactly_and_others_nearly_so(a_vessel_and_its_tree):
    surface, tree = a_vessel_and_its_tree
    told, asked = measured_runs(surface, tree)
    lumens = tree_lumen(surface, tree)
    exact = lumens.spheres.exact()
    for number, run in enumerate(told):
        at = lumens.stations_of(run)
        known = np.isfinite(run.diameter)
        share = run.diameter[known] / (2 * exact.radii[at][known])
        # Spheres that leave their vessel are told smaller.
        if number in asked:
            assert (share <= 1 + 1e-3).all()
            assert np.median(share) == pytest.approx(1, abs=1e-3)
        else:
            assert np.median(share) == pytest.approx(1, abs=0.03)
            assert (share <= 1.1).all()


def test_sections_do_not_depend_on_the_winding():
    tube = stenosed_tube()
    turned = tube.triangles.copy()
    turned[::3] = turned[::3, ::-1]
    places = np.array([[0, 0, 12.0], [0, 0, 20.0]])
    directions = np.array([[0, 0, 1.0], [0, 0.3, 1.0]])
    found, expected = (
        equivalent_diameters(tube.points, faces, places, directions)
        for faces in (turned, tube.triangles)
    )
    assert np.isfinite(expected).all()
    np.testing.assert_allclose(found, expected, rtol=1e-12)


def test_a_followed_section_is_that_of_a_new_cut():
    """The wall grows from the axis: the same edges are cut, at the same shares of them."""
    made = stenosed_tube(edge_length=0.7)
    centers = made.axis_at(np.linspace(6, 30, 20))
    ways = np.tile(made.axis_at(30.0) - made.axis_at(6.0), (20, 1)) / 24.0
    loops = section_loops(made.points, made.triangles, centers, ways)
    grown = made.points + 0.25 * (made.points - centers[0]) * (1 - np.abs(ways[0]))
    for points in (made.points, grown):
        expected = equivalent_diameters(points, made.triangles, centers, ways)
        found = 2 * np.sqrt(loops.areas(points, centers, ways) / np.pi)
        np.testing.assert_allclose(found, expected, rtol=1e-9)


@pytest.mark.parametrize("seed", range(20))
def test_a_section_holds_a_place_where_an_independent_test_says_so(seed):
    """Prisms over random stars, whose walls fold so that rays cross them often."""
    from matplotlib.path import Path

    random = np.random.default_rng(seed)
    angle = np.sort(random.uniform(0, 2 * np.pi, 40))
    outline = random.uniform(1, 6, 40)[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    first, after = np.arange(40), np.roll(np.arange(40), -1)
    rings = [np.column_stack([outline, np.full(40, height)]) for height in (0.0, 5.0)]
    triangles = [np.stack([first, after, after + 40]), np.stack([first, after + 40, first + 40])]
    surface = np.concatenate(rings), np.concatenate(triangles, axis=1).T
    places = np.column_stack([random.uniform(-5, 5, (200, 2)), np.full(200, 2.3)])
    ways = np.tile([0.0, 0.0, 1.0], (200, 1))
    inside = Path(outline).contains_points(places[:, :2])
    x, y = outline.T
    area = abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2
    expected = np.where(inside, 2 * np.sqrt(area / np.pi), np.nan)
    assert inside.any()
    assert not inside.all()
    np.testing.assert_allclose(equivalent_diameters(*surface, places, ways), expected)
    plain = [_lumen_area(*surface, *both) for both in zip(places, ways, strict=True)]
    np.testing.assert_allclose(plain, np.where(inside, area, np.nan))


def test_nearest_points_of_triangles_are_those_of_a_plain_way():
    random = np.random.default_rng(0)
    corners = random.normal(size=(500, 3, 3)) * 10.0 ** random.uniform(-3, 2, (500, 1, 1))
    corners[:100, 2] = corners[:100, 0] + 0.5 * (corners[:100, 1] - corners[:100, 0])
    query = random.normal(size=3)
    found = closest_points_on_triangles(np.tile(query, (500, 1)), corners)
    expected = nearest_points(query, corners)
    distance, best = (np.linalg.norm(query - points, axis=1) for points in (found, expected))
    np.testing.assert_allclose(distance, best, rtol=1e-9)


def test_what_is_near_is_what_a_plain_search_over_all_pairs_finds():
    tube = stenosed_tube(edge_length=1.5)
    random = np.random.default_rng(1)
    queries = random.uniform(tube.points.min(axis=0) - 5, tube.points.max(axis=0) + 5, (300, 3))
    queries[250:] = queries[250]
    radii = random.uniform(0, 12, 300)
    index = SurfaceIndex(tube.points, tube.triangles)
    found = index.near(queries, radii)
    corners = tube.points[tube.triangles]
    every = np.array([np.linalg.norm(q - nearest_points(q, corners), axis=1) for q in queries])
    pairs = np.zeros(every.shape, dtype=bool)
    pairs[found.query, found.triangle] = True
    assert pairs[every <= radii[:, None]].all()
    assert np.count_nonzero(pairs) < 1.5 * np.count_nonzero(every <= radii[:, None])
    assert (found.bound <= every[found.query, found.triangle] * (1 + 1e-9)).all()
    assert (np.diff(found.query) >= 0).all()
    np.testing.assert_allclose(index.distances(queries).distance, every.min(axis=1), rtol=1e-9)


def test_balls_that_only_just_touch_what_is_looked_for_are_found():
    """Far from the origin, where rounding is coarse; balls of all sizes, many at one spot."""
    random = np.random.default_rng(2)
    middles = 1e5 + random.normal(size=(500, 3))
    middles[400:] = middles[400]
    radii = 4.0 ** random.integers(-9, 1, 500)
    radii[::50] = 0.0
    balls = Balls(middles, radii)
    places = np.repeat(middles[::5], 2, axis=0) + np.array([0.0, 0, 3])
    place, ball = balls.near(places, np.repeat(3.0 - radii[::5], 2))
    own = set(zip(place.tolist(), ball.tolist(), strict=True))
    assert all((n, 5 * (n // 2)) in own for n in range(len(places)))
    assert (np.diff(place) >= 0).all()
    gap = np.linalg.norm(places[place] - middles[ball], axis=1) - radii[ball]
    assert (gap <= np.repeat(3.0 - radii[::5], 2)[place] + 3 * radii[ball] + 1e-6).all()
    expected = [np.linalg.norm(middles - one, axis=1).min() for one in places]
    np.testing.assert_allclose(balls.nearest(places), expected, rtol=1e-9)
    place, middle = balls.near_middles(places, np.full(len(places), 3.0))
    own = set(zip(place.tolist(), middle.tolist(), strict=True))
    assert all((n, 5 * (n // 2)) in own for n in range(len(places)))
    assert (np.diff(place) >= 0).all()
    assert (np.linalg.norm(places[place] - middles[middle], axis=1) <= 3.0 + 1e-6).all()


def test_the_nearest_of_many_points_is_that_of_a_plain_search():
    random = np.random.default_rng(3)
    points = random.normal(size=(40_000, 3))
    places = np.vstack([random.normal(size=(50, 3)), points[:3]])
    expected = [np.linalg.norm(points - place, axis=1).min() for place in places]
    np.testing.assert_allclose(nearest_distances(places, points), expected, rtol=1e-12)


def test_the_wall_seen_from_a_shifted_place_is_that_of_rays_from_there(a_vessel):
    surface, axis = Surface(a_vessel[0][0], a_vessel[1]), a_vessel[2]
    near = near_wall(surface, axis, 40.0)
    cuts = cuts_across(near, Line(axis), spacing=2.0, window=4.0)
    shift = np.random.default_rng(4).normal(size=(len(cuts.centers), 2)) * 0.3
    seen = cuts.seen(shift)
    aside = np.einsum("ij,ijk->ik", shift, cuts.along[:, 1:])
    plain = rays_from(near, cuts.arc_length, cuts.centers + aside, cuts.along)
    np.testing.assert_allclose(seen.centers, plain.centers, atol=1e-12)
    # A ray that only just meets an edge may do so by rounding.
    is_same = np.isclose(seen.distance, plain.distance, rtol=1e-6)
    assert is_same.mean() > 0.999
    assert (seen.triangle == plain.triangle)[is_same].mean() > 0.99
    assert np.isfinite(seen.distance).any()


# After a treatment only what the moved wall comes near is measured again; nothing is missed.


@pytest.fixture(scope="module", params=["stenosis", "branches", *ONE_ANATOMY])
def treated(request):
    """A vessel, its centerline, and what came of a short stent in the middle of its longest way."""
    made = vessel_named(request)
    line = made.centerline
    leaf = line.leaves[np.argmax(line.arc_length[line.leaves])]
    way = line.path(line.points[line.roots[0]], line.points[leaf])
    middle = len(way.points) // 2
    diameter = 2.4 * float(np.nanmedian(way.inscribed_radius[middle - 5 : middle + 5]))
    stent = Stent(diameter, placement=AtCenter(way.points[middle]), length=1.5 * diameter)
    settings = DeploymentSettings(certify=False)
    return made, way, Treatment(made.surface, [stent], line, settings).result


def stations_along(way):
    """All 4 mm, but at the ends of the vessel."""
    places = Line(way.points).cut(5.0, float(way.length) - 5.0).resampled(4.0).points
    return places, Line(places).directions


def test_what_is_not_measured_again_is_what_a_whole_search_finds(treated):
    made, way, result = treated
    places, directions = stations_along(way)
    before = measured_at(made.surface, places, directions)
    moved = moved_wall(made.surface, result.surface)
    found = measured_after(before, moved, result.surface, in_caps(made.surface))
    plain = measured_at(result.surface, places, directions)
    np.testing.assert_allclose(found.spheres.radii, plain.spheres.radii, atol=1e-3)
    np.testing.assert_allclose(found.equivalent, plain.equivalent, atol=1e-3)
    assert not np.allclose(found.spheres.radii, before.spheres.radii, atol=1e-2)


def test_lesions_after_are_those_of_a_whole_search(treated):
    made, _, result = treated
    lesions = find_lesions(made.surface, made.centerline)
    fast = treated_lesions(lesions, result.stents, result.surface, made.surface)
    plain = treated_lesions(lesions, result.stents, result.surface)
    for one, exact in zip(fast, plain, strict=True):
        assert one.after.minimum_diameter == pytest.approx(exact.after.minimum_diameter, abs=1e-3)
        assert one.after.percent_diameter == pytest.approx(exact.after.percent_diameter, abs=0.02)
        np.testing.assert_allclose(one.after.minimum_area, exact.after.minimum_area, rtol=1e-3)
        assert (one.stents, one.is_left_beyond) == (exact.stents, exact.is_left_beyond)
