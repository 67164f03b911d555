"""Places that only a vessel knows, at a lesion or on a branch, as points of its centerline."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..centerline import Centerline
from ..geometry import Line
from ..stent import (
    DEFAULT_FORESHORTENING,
    AtCenter,
    AtDistalEnd,
    AtLesion,
    OfVessel,
    OnBranch,
    Stent,
)
from ..validation import InputError, Points, as_number
from ..vessel import Lesion
from .placing import placement_at

NEAR = 1.0
"""Distal ends so far apart are not at the same place of a branch, mm."""


class Landmarks(NamedTuple):
    """Centerline, lesions and branches of one vessel, by which places are found."""

    centerline: Centerline
    lesions: Sequence[Lesion]
    branch_names: Sequence[str]

    def lesion(self, number: int) -> Lesion:
        """The lesion with a number from 1; `InputError` for one that is not there."""
        count = len(self.lesions)
        if not count:
            raise InputError("lesion: expected a vessel with one, got none; give another place.")
        if number > count:
            there = f"a number from 1 to {count}" if count > 1 else "1"
            raise InputError(
                f"lesion: expected {there}, for so many there are, got {number}; see "
                "`sdfstent measure`."
            )
        return self.lesions[number - 1]

    def branch(self, wanted: int | str) -> int:
        """Index of a branch, by number from 1 or by name; `InputError` for none of them."""
        names, count = list(self.branch_names), len(self.centerline.branches)
        if wanted in names:
            return names.index(str(wanted))
        if isinstance(wanted, int) and wanted <= count:
            return wanted - 1
        raise InputError(
            f"branch: expected 1 to {count} or one of {', '.join(names)}, got {wanted!r}."
        )

    def along(self, placement: OnBranch) -> float:
        """Distance of a place along its branch, mm; errors as of `branch`."""
        if placement.distance is not None:
            return placement.distance
        assert placement.fraction is not None
        start, end = self._ends(self.branch(placement.branch))
        return placement.fraction * (end - start)

    def _ends(self, branch: int) -> tuple[float, float]:
        """Arc lengths at which a branch begins and ends."""
        start, end = self.centerline.arc_length[self.centerline.branches[branch][[0, -1]]]
        return float(start), float(end)

    def nearest(self, kind: type[OfVessel], point: Points | None) -> AtLesion | OnBranch:
        """Place of a kind, `AtLesion` or `OnBranch`, nearest to a point (3,), or a usual one
        without.

        `InputError` where there is no lesion.
        """
        find = self._nearest_lesion if kind is AtLesion else self._nearest_on_branch
        return find(point)

    def stent_over(self, lesion: Lesion) -> Stent:
        """A stent as wide as the healthy vessel at a lesion, and once expanded as long as that.

        Its diameter to a tenth of a mm, its length in whole mm, at a point.
        """
        length = float(np.ceil(lesion.length / (1 - DEFAULT_FORESHORTENING)))
        place = placement_at(lesion, self.centerline, length)
        return Stent(round(lesion.reference_diameter, 1), placement=place, length=length)

    def _nearest_lesion(self, point: Points | None) -> AtLesion:
        """The place at the lesion nearest to a point (3,), or the first; `InputError` for none."""
        self.lesion(1)
        if point is None:
            return AtLesion(1)
        away = [float(one.line.nearest(point[None]).distances[0]) for one in self.lesions]
        return AtLesion(1 + int(np.argmin(away)))

    def _nearest_on_branch(self, point: Points | None) -> OnBranch:
        """Place of a point (3,) on its branch, to a tenth of a mm; without one halfway on the
        first."""
        if point is None:
            return OnBranch(1, fraction=0.5)
        place, tree = self.centerline.project(point), self.centerline
        branch = next(k for k, nodes in enumerate(tree.branches) if place.index in nodes[1:])
        start, end = self._ends(branch)
        return OnBranch(branch + 1, round(min(max(place.arc_length - start, 0.0), end - start), 1))


class StentMiddle(NamedTuple):
    """The middle of a stent on the centerline."""

    way: Line
    """The way from the root to the end of the branch."""
    at: float
    """Arc length of the middle on the way, mm."""
    start: float
    """The start of the branch, along the way, mm."""
    lesion: Lesion | None

    @property
    def point(self) -> Points:
        """(3,) mm."""
        return self.way.at(np.array([self.at]))[0]

    def placement(self, deployed_length: float, tree: Centerline) -> AtCenter | AtDistalEnd:
        """The placement by its middle, or by its distal end where the branch needs that."""
        distal = self.at + deployed_length / 2
        if distal <= self.start or distal > self.way.arc_lengths[-1]:
            return AtCenter(self.point)
        end = self.way.at(np.array([distal]))[0]
        leads = tree.path_around(self.point, deployed_length).points[-1]
        if self.at < self.start or np.linalg.norm(leads - end) > NEAR:
            return AtDistalEnd(end)
        return AtCenter(self.point)


def spot_of(placement: OfVessel, among: Landmarks) -> StentMiddle:
    """Middle of a stent in the vessel.

    Raises
    ------
    InputError
        No such lesion or branch, or a place beyond its vessel.
    """
    if isinstance(placement, AtLesion):
        return _at_lesion(placement, among)
    return _on_branch(placement, among)


def placement_in(stent: Stent, among: Landmarks) -> AtCenter | AtDistalEnd:
    """The point by which a stent of some length is placed; errors as of `spot_of`."""
    placement, length = stent.placement, stent.length
    assert isinstance(placement, OfVessel)
    assert length is not None  # Stent refuses these placements without one
    if isinstance(placement, AtLesion) and placement.offset is None:
        lesion = among.lesion(placement.number)
        return placement_at(lesion, among.centerline, length, stent.foreshortening)
    deployed = length * (1 - stent.foreshortening)
    return spot_of(placement, among).placement(deployed, among.centerline)


def _at_lesion(placement: AtLesion, among: Landmarks) -> StentMiddle:
    lesion, tree = among.lesion(placement.number), among.centerline
    points = tree.branches[lesion.branch]
    way = Line(tree.points[tree.ancestry(int(points[-1]))])
    middle = (lesion.start + lesion.end) / 2
    low, high = -middle, way.arc_lengths[-1] - middle
    offset = placement.offset or 0.0
    at = middle + as_number(offset, "offset", unit="mm", minimum=low, maximum=float(high))
    return StentMiddle(way, at, float(tree.arc_length[points[0]]), lesion)


def _on_branch(placement: OnBranch, among: Landmarks) -> StentMiddle:
    tree = among.centerline
    points = tree.branches[among.branch(placement.branch)]
    start, end = tree.arc_length[points[[0, -1]]]
    if placement.fraction is not None:
        along = placement.fraction * (end - start)
    else:
        most = float(end - start)
        along = as_number(placement.distance, "distance", unit="mm", minimum=0, maximum=most)
    way = Line(tree.points[tree.ancestry(int(points[-1]))])
    return StentMiddle(way, float(start + along), float(start), None)
