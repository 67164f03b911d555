"""Lines that run through one lumen are one vessel, however early the file parts them."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from lesion_cases import bifurcation_case

from SDFStentLib.centerline import Centerline, joined_lumens
from SDFStentLib.vessel import find_lesions
from SDFStentLib.vessel.branch_lumen import branch_lumens


@pytest.fixture(scope="module")
def divided():
    """A trunk that divides, without a lesion."""
    return bifurcation_case(22, None, fineness=0.4)


def parted(
    centerline: Centerline, shares: tuple[float, float], *, has_radius: bool = False
) -> Centerline:
    """A line to each outlet, moved aside by so much of the radius from a little after the inlet."""
    ways = [centerline.ancestry(int(leaf)) for leaf in centerline.leaves]
    if ways[0][0] != centerline.roots[0]:
        ways = [way[::-1] for way in ways]
    pieces = []
    for way, share in zip(ways, shares, strict=True):
        aside = share * centerline.inscribed_radius[way]
        aside *= np.clip(centerline.arc_length[way] / 10.0, 0, 1)
        pieces.append(centerline.points[way] + aside[:, None] * np.array([0.0, 1.0, 0.0]))
    ends = np.cumsum([0, *map(len, pieces)])
    lines = [np.arange(first, last) for first, last in pairwise(ends)]
    radius = np.concatenate([centerline.inscribed_radius[way] for way in ways])
    return Centerline.from_lines(np.concatenate(pieces), lines, radius if has_radius else None)


@pytest.mark.parametrize("shares", [(0.15, -0.15)])
def test_lines_that_part_far_above_the_division_part_where_the_lumens_do(divided, shares):
    known = joined_lumens(branch_lumens(divided.surface, divided.centerline)).stretches
    early = parted(divided.centerline, shares)
    lumens = branch_lumens(divided.surface, early)
    trunk, *branches = joined_lumens(lumens).stretches
    assert len(known) == 3
    assert [one.above for one in branches] == [0, 0]
    # The file's lines part before half of the trunk is over.
    assert min(lumen.start for lumen in lumens if lumen.start > 0) < 0.5 * known[0].along[-1]
    radius = np.nanmedian(known[0].diameter) / 2
    assert trunk.along[-1] == pytest.approx(known[0].along[-1], abs=1.5 * radius)
    for one in branches:
        assert one.along[0] == trunk.along[-1]
        assert (np.diff(one.along) > 0).all()


def test_what_is_told_does_not_depend_on_where_lines_part():
    case = bifurcation_case(22, "ostium", fineness=0.4)
    (known,) = find_lesions(case.surface, case.centerline)
    (found,) = find_lesions(case.surface, parted(case.centerline, (0.15, -0.15)))
    assert found.percent_diameter == pytest.approx(known.percent_diameter, abs=1.0)
    assert np.linalg.norm(np.subtract(found.point, known.point)) < 0.1 * known.length


def test_a_tree_that_parts_at_once_behind_its_root_is_measured(divided):
    tree = divided.centerline
    (root,) = tree.roots
    way = tree.points[root + 1] - tree.points[root]
    beside = tree.points[root] + 5 * way / np.linalg.norm(way) + [0, 1, 0]
    # Too short to be a branch, yet where it ends is no root.
    points = np.vstack([tree.points[root] - 5e-10 * way / np.linalg.norm(way), tree.points, beside])
    parent = np.r_[-1, np.where(tree.parent < 0, 0, tree.parent + 1), root + 1]
    parting = Centerline(points, np.full(len(points), np.nan), parent)
    starts = [lumen.start for lumen in branch_lumens(divided.surface, parting)]
    assert 0 < min(starts) < 1e-9
