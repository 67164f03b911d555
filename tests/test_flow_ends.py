"""The ends of a vessel in its network: caps that lean, and outlets as wide as they are."""

import numpy as np
import pytest

from SDFStentLib.centerline import Centerline
from SDFStentLib.files import read_centerline, read_surface
from SDFStentLib.flow import FlowModel, channels_of, known_flow
from SDFStentLib.geometry import Surface
from SDFStentLib.phantoms import straight_tube

MU = 0.004


def a_leaning_tube(tilt, oval, *, is_reversed=False, radius=4.0, length=80.0):
    """An oval tube whose two caps lean by so many mm per mm of its long axis; and its network."""
    phantom = straight_tube(radius, length, 0.5)
    points = phantom.points * [oval, 1.0, 1.0]
    toward_end = np.abs(2 * points[:, 2] / length - 1) ** 4
    points[:, 2] += tilt * points[:, 0] * toward_end
    tree = phantom.centerline
    line = tree.points[::-1] if is_reversed else tree.points
    tree = Centerline(line, tree.inscribed_radius, np.arange(len(line)) - 1)
    channels = channels_of(Surface(points, phantom.triangles), tree)
    return channels, FlowModel(channels, known_flow(20.0)).answer().networks[0]


@pytest.mark.parametrize("is_reversed", [False, True])
@pytest.mark.parametrize(("tilt", "oval"), [(0.0, 1.4), (0.02, 1.4), (0.3, 1.2), (1.0, 1.3)])
def test_caps_that_lean_make_no_narrowing(tilt, oval, is_reversed):
    """It is White's ellipse: a section that a cap cuts was the least oblong one."""
    _, network = a_leaning_tube(tilt, oval, is_reversed=is_reversed)
    a, b = 0.004 * oval, 0.004
    white = 4 * MU * 0.08 * (a**2 + b**2) / (np.pi * a**3 * b**3)
    assert network.stenosis[0] == pytest.approx(0.0, abs=1e-9 * network.resistance[0])
    assert network.resistance[0] == pytest.approx(white, rel=8e-3)  # chords


@pytest.mark.parametrize("tilt", [0.0, 0.05, 0.5, 1.0])
def test_an_outlet_is_as_wide_as_its_vessel_whether_its_cap_leans_or_not(tilt):
    (channel,), _ = a_leaning_tube(tilt, 1.4)
    assert channel.tips[1] == pytest.approx(8 * 1.4**0.5, rel=0.01)


@pytest.mark.parametrize("spacing", [0.7, 2.0, 6.0])
@pytest.mark.parametrize("is_short", [False, True])
def test_the_flow_to_the_legs_does_not_hang_on_the_points_of_the_centerline(
    data_dir, spacing, is_short
):
    """Their ends have 97.2 and 78.7 mm2: 56 and 44 percent by the power 7/3 of the diameters."""
    surface = read_surface(data_dir / "aorta_iliac_surface_cm.vtp", "cm").surface
    tree = read_centerline(data_dir / "aorta_iliac_centerline_cm.vtp", "cm")
    tree = tree.resampled(spacing)
    if is_short:  # as lines of VMTK, which end a radius before an open end
        lines = [tree.ancestry(leaf) for leaf in tree.leaves]
        kept = [line[: len(line) - round(5 / spacing)] for line in lines]
        tree = Centerline.from_lines(tree.points, kept, tree.inscribed_radius)
    answer = FlowModel(channels_of(surface, tree), known_flow(20.0)).answer()
    shares = sorted(band.value for band in answer.before["mean"].sides)
    areas = np.array([78.74, 97.25]) ** (7 / 6)
    assert shares == pytest.approx(areas / areas.sum(), abs=0.01)
