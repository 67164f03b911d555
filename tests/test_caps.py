"""Caps that a stent bulges are found; flat spots of the wall are not caps."""

from __future__ import annotations

import numpy as np
import pytest

from SDFStentLib import phantoms
from SDFStentLib.deformation import Deployment, deploy
from SDFStentLib.field import CapsuleChain
from SDFStentLib.lumen import bulged_caps, inscribed_spheres
from SDFStentLib.stent import AlongAxis, Stent
from SDFStentLib.treatment import Preview, Treatment
from SDFStentLib.validation import InputError


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
