"""Two vessels that are one lumen where their walls touch: said, and where; what grew so is not."""

from itertools import pairwise

import numpy as np
import pytest
from round_tubes import chain, contoured
from segmentations import voxels
from test_scan import labelmap
from trees import in_each_tree

from SDFStentLib import extract_centerline
from SDFStentLib.files import read_surface
from SDFStentLib.scan import prepared_vessel

UPRIGHT = chain([(0, 0, -24), (0, 0, 24)], 4)


def crossing(seed):
    """Two straight tubes at a random angle whose walls overlap, and the place where they do."""
    rng = np.random.default_rng(seed)
    wide, narrow = 4.0, 4.0 * rng.uniform(0.4, 1.0)
    overlap, angle = narrow * rng.uniform(0.03, 0.25), np.deg2rad(rng.uniform(25, 90))
    way = 8 * narrow * np.array([np.sin(angle), 0.0, np.cos(angle)])
    middle = np.array([0.0, wide + narrow - overlap, 0.0])
    other = chain([middle - way, middle + way], narrow)
    return [*UPRIGHT, *other], (0.0, wide - overlap / 2, 0.0), narrow


def touching(found):
    return [one for one in found.warnings if one.kind == "vessels-touch"]


@pytest.mark.parametrize("seed", range(6))
def test_vessels_that_are_one_where_they_touch_are_told_and_where(seed):
    """Lines led from one into both arms of the other, in silence."""
    pieces, place, radius = crossing(seed)
    found = extract_centerline(contoured(pieces, radius / 4))
    assert len(found.lines.lines) == 3
    (told,) = touching(found)
    assert np.linalg.norm(np.subtract(told.place, place)) < 2 * radius
    assert told.numbers["opening_mm"] < 1.8 * radius
    assert "part them there" in told.sentence()


@pytest.mark.parametrize("seed", range(100, 140))
@pytest.mark.bench
def test_many_vessels_that_touch_are_told(seed):
    pieces, place, radius = crossing(seed)
    (told,) = touching(extract_centerline(contoured(pieces, radius / 4)))
    assert np.linalg.norm(np.subtract(told.place, place)) < 2 * radius


def narrowed(radii, way):
    """Pieces of a tube along a way (3,) from the origin, of radii by the distance."""
    places = [(np.multiply(at, way), radius) for at, radius in radii]
    return [(*map(tuple, (one, other)), a, b) for (one, a), (other, b) in pairwise(places)]


OSTIUM = narrowed([(0, 1.2), (5, 1.2), (8, 2.6), (10, 2.6)], (0, 1, 0))
GROWN = {
    "branches opposite each other": chain([(0, -20, 0), (0, 20, 0)], 3),
    "branches nearly opposite": [
        *chain([(0, 0, 0), (0, 18, 6)], 3),
        *chain([(0, 0, 3), (0, -18, 9)], 3),
    ],
    "three branches": [
        piece
        for way in ((0, 20, 8), (17, -10, 8), (-17, -10, 8))
        for piece in chain([(0, 0, 0), way], 2.5)
    ],
    "a narrow ostium": narrowed([(0, 1.2), (8, 1.2), (11, 3), (30, 3)], (0, 1, 0)),
    "a narrow ostium before a fork": [
        *OSTIUM,
        *chain([(0, 10, 0), (11, 21, 0)], 2.2),
        *chain([(0, 10, 0), (-11, 21, 0)], 2.2),
    ],
}  # fmt: skip


@pytest.mark.parametrize("kind", GROWN)
def test_branches_are_no_vessels_that_touch(kind):
    assert touching(extract_centerline(contoured([*UPRIGHT, *GROWN[kind]], 0.6))) == []


def test_a_tube_of_its_own_between_two_vessels_is_no_opening():
    """As a duct or shunt, which is longer than wide."""
    other = chain([(-24, 14, 0), (24, 14, 0)], 4)
    between = chain([(0, 0, 0), (0, 14, 0)], 1.5)
    assert touching(extract_centerline(contoured([*UPRIGHT, *other, *between], 0.6))) == []


@in_each_tree
def test_vessels_of_phantoms_do_not_touch(phantom):
    assert touching(extract_centerline(phantom.surface)) == []


@pytest.mark.parametrize(
    ("name", "unit"),
    [("pulmonary", "cm"), ("aorta_iliac", "cm"), ("vmtk_aorta", "mm"), ("su0243", "mm")],
)
def test_vessels_of_anatomies_do_not_touch(data_dir, name, unit):
    surface = read_surface(data_dir / f"{name}_surface_{unit}.vtp", unit).surface
    assert touching(extract_centerline(surface)) == []


@pytest.mark.parametrize(("apart", "kind"), [(7.0, "thin-bridge"), (6.8, "vessels-touch")])
def test_vessels_that_touch_in_a_label_are_told_once(apart, kind):
    across = ((-30, apart, 0), (30, apart, 0), 3, 3)
    mask, low = voxels([((0, 0, -30), (0, 0, 30), 4, 4), across], 0.9)
    (told,) = prepared_vessel(labelmap(mask, 0.9, low)).warnings
    assert told.kind == kind
    assert np.linalg.norm(np.subtract(told.place, (0, 4, 0))) < 3
