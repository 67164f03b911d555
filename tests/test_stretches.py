"""Lines that run through one lumen are one vessel, however early the file parts them."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from lesion_cases import bifurcation_case

from SDFStentLib.centerline import BranchLumen, Centerline, joined_lumens
from SDFStentLib.geometry import Line
from SDFStentLib.vessel import find_lesions
from SDFStentLib.vessel.branch_lumen import branch_lumens
from SDFStentLib.vessel.runs import vessel_runs


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


@pytest.mark.parametrize("shares", [(0.15, -0.15), (0.3, 0.0)])
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


def test_vessels_are_those_of_lines_that_part_where_the_lumens_do(divided):
    early = parted(divided.centerline, (0.15, -0.15))
    known, found = (
        vessel_runs(branch_lumens(divided.surface, line)) for line in (divided.centerline, early)
    )
    assert [run.outlets for run in found] == [run.outlets for run in known]
    assert [run.parent for run in found] == [run.parent for run in known]
    calibers = [run.caliber for run in found]
    assert calibers == pytest.approx([run.caliber for run in known], rel=0.02)


def a_lumen(branch, nodes, start, points, longer=1.0):
    """A branch of 6 mm with a station every mm, along which lengths are `longer` times as long."""
    line = Line(points)
    along = longer * line.arc_lengths
    diameter = np.full(len(points), 6.0)
    return BranchLumen(branch, nodes, start, line, along, diameter, line.points)


def test_two_lines_through_a_branch_are_one_though_they_came_by_a_longer_way():
    way = np.arange(31.0)[:, None]
    trunk, aside = way[:21] * [0, 0, 1], np.array([0, np.sqrt(0.5), np.sqrt(0.5)])
    fork = trunk[-1]
    lumens = [
        a_lumen(0, (0, 1), 0.0, trunk),
        a_lumen(1, (1, 2), 20.0, fork + np.arange(61.0)[:, None] * [0, 0, 1]),
        # Wanders from side to side, in the same lumen.
        a_lumen(2, (0, 3), 0.0, trunk, longer=1.1),
        a_lumen(3, (3, 4), 22.0, fork + way * aside),
        a_lumen(4, (3, 5), 22.0, fork + way[:21] * aside + [0.5, 0, 0]),
    ]
    stretches = joined_lumens(lumens).stretches
    assert [one.above for one in stretches] == [-1, 0, 0]
    assert sorted(one.along[-1] for one in stretches[1:]) == pytest.approx([50.0, 80.0], abs=1.0)


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
