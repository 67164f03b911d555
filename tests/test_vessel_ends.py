"""Ends of a vessel from its wall alone, against phantoms whose ends are known."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from trees import unbranched

from benchmarks import phantoms
from benchmarks.phantoms import arch_with_coarctation, branching_pulmonary_artery, straight_tube
from SDFStentLib.deformation import Deployment, DeploymentSettings, deploy
from SDFStentLib.field import CapsuleChain
from SDFStentLib.files import read_surface
from SDFStentLib.geometry import Surface, boundary_edges, signed_volume
from SDFStentLib.lumen import bulged_caps, diameter_profile, inscribed_spheres
from SDFStentLib.stent import AlongAxis, AtCenter, Stent
from SDFStentLib.treatment import Preview, Treatment
from SDFStentLib.validation import InputError
from SDFStentLib.vessel import ends_without_line, line_seeds, vessel_ends

PULMONARY = branching_pulmonary_artery()


def openings(phantom):
    """Center and radius of every end, the largest first, from how the phantom was made."""
    found = [(opening.center, opening.radius) for opening in phantom.openings]
    return sorted(found, key=lambda opening: -opening[1])


def without_caps(phantom):
    """The wall alone: SimVascular's face id 1 is the wall, the others are caps."""
    return Surface(phantom.points, phantom.triangles[phantom.face_ids == phantom.face_ids.min()])


@pytest.mark.parametrize("is_open", [False, True], ids=["capped", "open"])
@pytest.mark.parametrize(
    "phantom",
    [PULMONARY, straight_tube(), arch_with_coarctation()],
    ids=["pulmonary", "tube", "arch"],
)
def test_every_end_of_a_phantom_is_found_where_it_was_made(phantom, is_open):
    surface = without_caps(phantom) if is_open else phantom.surface
    ends = vessel_ends(surface)
    centers = np.array([center for center, _ in openings(phantom)])
    assert len(ends) == len(centers)
    for end in ends:
        away = np.linalg.norm(centers - end.center, axis=1)
        nearest = openings(phantom)[int(np.argmin(away))]
        assert away.min() < 0.05
        # A polygon of the edge length of the mesh lies inside of the circle.
        assert 0.95 * nearest[1] < end.radius <= 1.001 * nearest[1]
        assert bool(len(end.faces)) != is_open
    assert [end.radius for end in ends] == sorted((end.radius for end in ends), reverse=True)


@pytest.mark.parametrize("phantom", [PULMONARY, arch_with_coarctation()], ids=["pulmonary", "arch"])
def test_the_rims_of_a_closed_vessel_are_the_free_edges_of_its_wall(phantom):
    wall = without_caps(phantom).triangles
    rims = np.concatenate([end.rim for end in vessel_ends(phantom.surface)])
    assert {*map(tuple, rims.tolist())} == {*map(tuple, boundary_edges(wall).tolist())}


def test_the_closed_surface_has_the_volume_of_the_vessel_and_its_ends_as_points():
    seeds = line_seeds(without_caps(PULMONARY))
    assert seeds.surface.topology.is_watertight
    assert seeds.surface.topology.is_consistently_wound
    volume = signed_volume(seeds.surface.points, seeds.surface.triangles)
    assert volume == pytest.approx(signed_volume(PULMONARY.points, PULMONARY.triangles), rel=1e-9)
    largest = vessel_ends(PULMONARY.surface)[0]
    assert np.allclose(seeds.surface.points[seeds.inlet], largest.center)
    assert len(seeds.outlets) == 2


@pytest.mark.parametrize(
    ("file", "units", "radii"),
    [
        ("pulmonary_surface_cm", "cm", (9.3, 2.6, 2.4)),
        ("aorta_iliac_surface_cm", "cm", (12.1, 5.6, 5.0)),
    ],
)
def test_the_caps_of_an_anatomy_are_its_model_faces(data_dir, file, units, radii):
    """SimVascular gives every cap a face id; the wall has the largest."""
    from vtkmodules.util.numpy_support import vtk_to_numpy

    read = read_surface(data_dir / f"{file}.vtp", units)
    ids = vtk_to_numpy(read.polydata().GetCellData().GetArray("ModelFaceID"))
    ends = vessel_ends(read.surface)
    assert [end.radius for end in ends] == pytest.approx(radii, abs=0.06)
    for end in ends:
        (own,) = np.unique(ids[end.faces])
        assert np.array_equal(np.flatnonzero(ids == own), end.faces)


def test_the_rounded_ends_of_an_anatomy_have_to_be_named(data_dir):
    surface = read_surface(data_dir / "vmtk_aorta_surface_mm.vtp").surface
    assert vessel_ends(surface) == []
    with pytest.raises(InputError, match="name the inlet and every outlet"):
        line_seeds(surface)
    top, bottom = surface.points[[10, 2000]]
    seeds = line_seeds(surface, top, [bottom])
    assert (seeds.inlet, seeds.outlets) == (10, (2000,))
    assert np.array_equal(seeds.surface.points, surface.points)


@pytest.mark.parametrize(
    ("places", "words"),
    [
        (([0.0, 0.0, 500.0],), "inlet: expected a place within 10 mm of the surface"),
        ((None, [[0.0, 0.0, 500.0]]), "outlet 1: expected a place within 10 mm of the surface"),
        ((None, [[0.0, 0.0, 40.0], [0.0, 0.1, 40.0]]), "each to be named once"),
        (([0.0, 0.0, float("nan")],), "inlet"),
    ],
)
def test_a_place_that_names_no_end_is_refused(places, words):
    with pytest.raises(InputError, match=words):
        line_seeds(straight_tube().surface, *places)


def test_a_vessel_with_one_flat_end_needs_an_outlet():
    tube = straight_tube()
    is_cap = np.isin(
        np.arange(len(tube.points)), tube.triangles[tube.face_ids == tube.face_ids.max()]
    )
    rounded = tube.points.copy()
    height = np.sqrt(np.maximum(0.0, 9.0 - rounded[:, 0] ** 2 - rounded[:, 1] ** 2))
    rounded[is_cap, 2] += height[is_cap]
    with pytest.raises(InputError, match="found one; name an outlet"):
        line_seeds(Surface(rounded, tube.triangles))


@pytest.mark.parametrize(("aside", "without"), [(0.0, 0), (0.8, 0), (2.5, 2)])
def test_a_line_that_goes_on_beyond_an_end_leads_there(aside, without):
    """As of a surface that was cut shorter than its centerline; one beside the vessel does not."""
    tube = straight_tube()
    start, stop = tube.centerline.points[[0, -1]]
    line = np.linspace(1.2 * start - 0.2 * stop, 1.2 * stop - 0.2 * start, 80)
    line[:, 0] += aside * openings(tube)[0][1]
    assert ends_without_line(vessel_ends(tube.surface), unbranched(line)) == without


# Diameters right up to a capped in- or outlet.

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


@pytest.mark.parametrize("lean", [0.0, 0.5, 10, 25, 35, 45, 55])
def test_a_cap_that_leans_makes_no_vessel_narrow(lean):
    """And cuts off no section: what is told of one is the area of the whole tube."""
    turn = Rotation.from_euler("xyz", [35, 49, 20], degrees=True).as_matrix()
    points, triangles = a_capped_duct(a_circle(), np.deg2rad(lean))
    profile = diameter_profile(Surface(points @ turn.T, triangles), A_LINE @ turn.T)
    width = 2 * RADIUS * np.cos(np.pi / 32)
    # The first and the last station lie as good as in the caps.
    np.testing.assert_allclose(profile.inscribed_diameter[1:-1], width, rtol=1e-3)
    whole = RADIUS * np.sqrt(128 * np.sin(np.pi / 16) / (2 * np.pi))
    is_known = np.isfinite(profile.equivalent_diameter)
    np.testing.assert_allclose(profile.equivalent_diameter[is_known], whole, rtol=1e-3)
    beyond = 2 + RADIUS * np.tan(np.deg2rad(lean))
    middle = np.abs(profile.arc_length - LENGTH / 2) < LENGTH / 2 - beyond
    assert is_known[middle].all()
    assert is_known.all() == (lean < 1)


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


# Caps that a stent bulges are found; flat spots of the wall are not caps.


@pytest.fixture(scope="module")
def a_tube():
    return phantoms.straight_tube(radius=3.0, length=40.0, edge_length=0.8)


def bulged_by(tube, start, end):
    axis = tube.axis_at(np.linspace(start, end, 20))
    state = deploy(tube.surface, CapsuleChain.along(axis), 3.6).state
    after = state.applied_to(tube.points)
    return bulged_caps(tube.surface, tube.surface.with_points(after), state.indices)


def test_a_stent_that_ends_in_the_outlet_bulges_its_cap(a_tube):
    (cap,) = bulged_by(a_tube, 25.0, 39.0)
    outlet = next(opening for opening in a_tube.openings if not opening.name.endswith("inlet"))
    assert np.linalg.norm(np.subtract(cap.center, outlet.center)) < 0.5
    assert cap.height > 0.5
    assert "out of its plane" in str(cap.caution())


def thin_stent(tube, end, radius=2.0):
    """Narrower than the tube by 1 mm all around; it touches nothing but the cap."""
    axis = tube.axis_at(np.linspace(25.0, end, 50))
    deployment = Deployment(tube.surface, CapsuleChain.along(axis), radius)
    return deployment, deployment.result


@pytest.mark.parametrize("end", [38.5, 39.5, 40.0])
def test_a_stent_that_touches_nothing_but_a_cap_leaves_the_wall_as_it_was(a_tube, end):
    """The outlet of 6 mm became 7.4 mm wide, and the stent was not certified for that."""
    _, result = thin_stent(a_tube, end)
    in_wall = np.hypot(*a_tube.points[:, :2].T) > 2.9
    is_cap = a_tube.points[:, 2] > 39.9
    assert (np.abs(result.points - a_tube.points) > 0.1)[is_cap].any()
    assert result.points[in_wall].tobytes() == a_tube.points[in_wall].tobytes()
    assert result.certificate.passed, result.certificate.sentence()


@pytest.mark.parametrize(
    ("start", "end", "radius", "widens"),
    [((-0.35, -0.02, 32.71), (1.18, -0.23, 39.18), 1.55, False),
     ((-0.09, 0.05, 33.52), (-1.42, 0.76, 39.08), 2.16, True)],
)  # fmt: skip
def test_the_lumen_at_a_cap_that_a_leaning_stent_bulged_is_that_between_the_walls(
    a_tube, start, end, radius, widens
):
    """It was unknown, or that of a sphere which the bulged cap held back."""
    stent = Stent(2 * radius, placement=AlongAxis([start, end]))
    result = Treatment(a_tube.surface, [stent]).result
    assert [warning.kind for warning in result.warnings].count("cap-bulged") == 1
    (treated,) = result.stents
    last, direction = treated.axis.points[-1:], np.subtract(end, start)[None]
    walls = a_tube.triangles[(np.abs(a_tube.points[a_tube.triangles][:, :, 2] - 40) > 1e-6).any(1)]
    expected = 2 * inscribed_spheres(result.points, walls, last, direction).radii[0]
    before, after = treated.before.inscribed_diameter[-1], treated.after.inscribed_diameter[-1]
    assert after == pytest.approx(expected, abs=1e-4)
    assert (after > before + 0.1) == widens


def test_a_width_is_checked_at_one_end_where_that_will_do(a_tube, monkeypatch):
    """A search tree of all points of the wall was made to ask it of every place of the axis."""

    def refusing(*_):
        raise AssertionError("a search tree was made")

    monkeypatch.setattr("SDFStentLib.treatment.warnings.nearest_distances", refusing)
    axis = np.array([[0, 0, 10.0], [0, 0, 39.9]])
    assert len(Treatment(a_tube.surface, [Stent(5.0, placement=AlongAxis(axis))]).stents) == 1


def test_a_thin_stent_at_a_cap_is_as_wide_as_the_walls_are_apart(a_tube):
    """Without known radii the nearest wall tells the lumen, and a cap is none."""
    axis = np.array([[0, 0, 39.5], [0, 0, 39.9]])
    thin = Stent(5.0, placement=AlongAxis(axis))
    assert Treatment(a_tube.surface, [thin]).stents == (thin,)
    Preview(a_tube.surface).of([thin])
    wide = Stent(26.0, placement=AlongAxis(axis))
    for refusing in (lambda: Treatment(a_tube.surface, [wide]),
                     lambda: Preview(a_tube.surface).of([wide])):  # fmt: skip
        with pytest.raises(
            InputError, match=r"4 times the lumen of 6\.01 mm where it lies, got 26 mm"
        ):
            refusing()
