"""A stenosis as a view shows it."""

import numpy as np
import pytest
from trees import unbranched

from SDFStentLib.geometry import Line, Surface
from SDFStentLib.vessel import find_lesions, lesion_after
from SDFStentLib.view import ArmView, seen_stenosis, seen_widths

ALONG = np.linspace(0, 60, 241)
AROUND = 2 * np.pi * np.arange(72) / 72


def oval_tube(wide, thin, along=ALONG):
    """A tube along z whose sections are ellipses of half the widths that are given along it."""
    rings = np.stack(
        [
            wide[:, None] * np.cos(AROUND),
            thin[:, None] * np.sin(AROUND),
            np.repeat(along[:, None], len(AROUND), axis=1),
        ],
        axis=-1,
    )
    count = len(AROUND)
    one = np.arange((len(along) - 1) * count)
    after = one - one % count + (one + 1) % count
    faces = [np.c_[one, after, one + count], np.c_[after, after + count, one + count]]
    return Surface(rings.reshape(-1, 3), np.vstack(faces))


def dip(depth, along=ALONG):
    """3 mm, and less by a smooth dip in the middle."""
    return 3 - depth * np.exp(-(((along - 30) / 4) ** 2))


@pytest.fixture(scope="module")
def slit():
    """A lesion 4.8 mm wide from left to right and 2.4 mm from front to back, in 6 mm."""
    along = ALONG
    surface = oval_tube(dip(0.6), dip(1.8))
    tree = unbranched(np.c_[0 * along, 0 * along, along], dip(1.8))
    (lesion,) = find_lesions(surface, tree)
    return lesion, tree


@pytest.mark.parametrize(
    ("view", "percent", "width"),
    [
        (ArmView(0, 0), 20.0, 4.8),  # its broad side
        (ArmView(90, 0), 60.0, 2.4),  # its narrow side
        # Of an ellipse, 2 sqrt(2.4^2 cos^2 + 1.2^2 sin^2).
        (ArmView(45, 0), 100 * (1 - np.sqrt((2.4**2 + 1.2**2) / 2) / 3), 3.7947),
        (ArmView(0, 40), 20.0, 4.8),  # an upright vessel is as wide from above
    ],
)
def test_a_slit_is_as_narrow_as_its_side_that_the_view_shows(slit, view, percent, width):
    lesion, tree = slit
    assert lesion.percent_diameter == pytest.approx(60, abs=0.5)
    seen = seen_stenosis(lesion, lesion, tree, view.axes("LPS")[2])
    # Of places that are as narrow to a percent, that in the widest vessel is told.
    assert seen.width == pytest.approx(width, rel=0.011)
    # Healthy vessel is measured where the dip begins, as by `measure`: 5.93 to 6 mm.
    assert 5.91 < seen.reference < 6.0
    assert seen.percent == pytest.approx(100 * (1 - seen.width / seen.reference))
    assert seen.percent == pytest.approx(percent, abs=2.0)


def test_after_treatment_it_is_measured_against_the_same(slit):
    lesion, tree = slit
    after = lesion_after(lesion, oval_tube(dip(0.0), dip(0.3)))
    for view, width in ((ArmView(0, 0), 6.0), (ArmView(90, 0), 5.4)):
        toward = view.axes("LPS")[2]
        seen = seen_stenosis(lesion, after, tree, toward)
        assert seen.width == pytest.approx(width, rel=0.011)
        assert seen.reference == pytest.approx(
            seen_stenosis(lesion, lesion, tree, toward).reference
        )


def test_a_round_tube_is_as_wide_from_everywhere_and_has_no_width_along_itself():
    surface, line = oval_tube(dip(0.0), dip(0.0)), Line([[0, 0, 20], [0, 0, 40]])
    at, expected = np.linspace(0, 20, 5), np.full(5, 6.0)
    rng = np.random.default_rng(1)
    for toward in rng.normal(size=(5, 3)):
        widths = seen_widths(surface, line, at, expected, toward / np.linalg.norm(toward))
        assert widths == pytest.approx(np.full(5, 6.0), abs=0.01)
    assert np.isnan(seen_widths(surface, line, at, expected, np.array([0.0, 0, 1]))).all()


def test_a_section_far_wider_than_its_sphere_is_of_other_vessels_too():
    surface, line = oval_tube(3 * dip(0.0), dip(0.0)), Line([[0, 0, 20], [0, 0, 40]])
    widths = seen_widths(surface, line, np.array([10.0]), np.array([6.0]), np.array([0.0, 1, 0]))
    assert np.isnan(widths).all()
