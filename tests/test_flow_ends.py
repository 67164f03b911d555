"""The ends of a vessel in its network: caps that lean, and outlets as wide as they are."""

import numpy as np
import pytest
from seeds import seeds

from benchmarks.phantoms import straight_tube
from SDFStentLib.centerline import Centerline
from SDFStentLib.files import read_centerline, read_surface
from SDFStentLib.flow import FlowModel, channels_of, known_flow
from SDFStentLib.geometry import Surface

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


def a_random_tube(random, kind):
    """Sides, half axes, lengths and more of a tube of so many flat sides."""
    r = random.uniform(1.5, 8.0)
    length = r * random.uniform(8, 25)
    oval = random.uniform(1.05, 1.45) if kind == "oval" else 1.0
    bend = r * random.uniform(5, 12) if kind == "bent" else np.inf
    return {
        "sides": int(random.choice([8, 12, 16, 24, 64])),
        "axes": (r, r * oval),
        "length": 0.5 * round(2 * min(length, 2.6 * bend)),
        "bend": bend,
        "taper": random.uniform(0.6, 1.3) if kind == "tapered" else 1.0,
        "spacing": r * random.uniform(0.3, 1.0),
        "azimuth": random.uniform(0, 2 * np.pi),
        "is_capped": random.random() < 0.5,
    }


def a_tube_of_sides(shape, degrees):
    """Its ends lean by so many degrees; where it is straight all sections stay as they are."""
    sides, length, bend = shape["sides"], shape["length"], shape["bend"]
    around = 2 * np.pi * np.arange(sides) / sides
    unit = np.column_stack([shape["axes"][0] * np.cos(around), shape["axes"][1] * np.sin(around)])
    count = max(int(length / shape["spacing"]), 6)
    rows = []
    for at in np.linspace(0, length, count + 1).tolist():
        across = unit * (1 + (shape["taper"] - 1) * at / length)
        aside = across @ [np.cos(shape["azimuth"]), np.sin(shape["azimuth"])]
        ends = np.clip(1 - np.array([length - at, at]) / (2.4 * shape["axes"][1]), 0, 1)
        along = at + np.tan(np.radians(degrees)) * aside * (ends[0] - ends[1])
        x, y = (unit * (1 + (shape["taper"] - 1) * along / length)[:, None]).T
        if np.isfinite(bend):
            turn = along / bend
            rows.append(
                np.column_stack([bend - (bend - x) * np.cos(turn), y, (bend - x) * np.sin(turn)])
            )
        else:
            rows.append(np.column_stack([x, y, along]))
    points, ring = np.concatenate(rows), np.arange(sides)
    beside = np.roll(ring, -1)
    triangles = []
    for low in sides * np.arange(count):
        a, b, c, d = ring + low, beside + low, ring + low + sides, beside + low + sides
        triangles += [np.column_stack([a, b, d]), np.column_stack([a, d, c])]
    if shape["is_capped"]:
        for low, order in ((0, [0, 2, 1]), (sides * count, [0, 1, 2])):
            middle = np.full(sides, len(points))
            points = np.vstack([points, points[ring + low].mean(axis=0)])
            triangles.append(np.column_stack([middle, ring + low, beside + low])[:, order])
    at = np.arange(0, length + 0.1, 0.5)
    line = np.column_stack([0 * at, 0 * at, at])
    if np.isfinite(bend):
        line = np.column_stack([bend - bend * np.cos(at / bend), 0 * at, bend * np.sin(at / bend)])
    tree = Centerline.from_lines(line, [np.arange(len(line))])
    channels = channels_of(Surface(points, np.concatenate(triangles)), tree)
    network = FlowModel(channels, known_flow(5.0)).answer().networks[0]
    return channels[0], float(network.resistance.sum()), float(network.stenosis.sum())


@pytest.mark.parametrize("seed", seeds(4, 100))
def test_tubes_of_few_or_many_sides_cost_the_same_whether_their_caps_lean_or_not(seed):
    random = np.random.default_rng([seed, 52])
    kind = ["round", "oval", "bent", "tapered"][seed % 4]
    shape = a_random_tube(random, kind)
    _, upright, loss = a_tube_of_sides(shape, 0.0)
    channel, leaning, lost = a_tube_of_sides(shape, random.uniform(0, 10))
    assert leaning == pytest.approx(upright, rel=3e-3)
    assert lost == pytest.approx(loss, rel=5e-3, abs=1e-9 * upright)
    if kind in ("round", "oval"):
        sides, (small, large) = shape["sides"], shape["axes"]
        around = 2 * np.pi * np.arange(sides) / sides
        x, y = small * np.cos(around), large * np.sin(around)
        chords = np.hypot(np.roll(x, -1) - x, np.roll(y, -1) - y)
        twice = x * np.roll(y, -1) - y * np.roll(x, -1)
        area, b = twice.sum() / 2, 1e-3 * float((twice / chords).min())
        a = 1e-6 * area / (np.pi * b)
        white = 4 * MU * 1e-3 * shape["length"] * (a**2 + b**2) / (np.pi * a**3 * b**3)
        assert lost == 0
        assert leaning == pytest.approx(white, rel=2e-3)
        assert channel.tips[1] == pytest.approx(2 * np.sqrt(area / np.pi), rel=2e-3)
