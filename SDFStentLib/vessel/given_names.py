"""Names that the user gives the vessels of a tree: from places and faces to its branches."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..centerline import Centerline
from ..geometry import NamedFaces, Surface
from ..lumen import VesselInside
from ..validation import Floats, InputError, Place, as_place, in_short, place_words
from .branch_lumen import tree_lumen
from .branch_names import faces_at_ends
from .runs import VesselRun, is_main, vessel_runs
from .tree_around import limbs_of


class VesselName(NamedTuple):
    """Name of a vessel by the user, with the face or place that identifies it."""

    name: str
    at: int | Place
    """The face of the model at its end, or a place in it, mm."""

    def turned(self) -> VesselName:
        """Name in the other patient frame, RAS or LPS: x and y negated."""
        if isinstance(self.at, int):
            return self
        x, y, z = self.at
        return self._replace(at=(-x, -y, z))


def given_names(
    surface: Surface,
    centerline: Centerline,
    names: Sequence[VesselName],
    faces: NamedFaces | None = None,
) -> tuple[str | None, ...]:
    """The user's name of the vessel of every branch of a centerline; None without a name.

    Empty without any names.

    A name holds for the vessel as far as it goes on through side branches, up to the next place on
    it that has another name. It reaches back to the ostium, in the vessel at the root to where the
    last main branch left.

    Parameters
    ----------
    surface : Surface
        Surface before any stent; open or closed.
    centerline : Centerline
    names : sequence of VesselName
    faces : NamedFaces, optional
        Faces of the surface.

    Raises
    ------
    InputError
        A place in no vessel, a face at no end of the centerline, or two names for one vessel.
    """
    if not names:
        return ()
    runs = vessel_runs(tree_lumen(surface, centerline).rough, limbs_of(centerline))
    marked: dict[int, str] = {}
    for one in names:
        label = f"names: {one.name!r}"
        if isinstance(one.at, int):
            branch = _branch_to(one.at, label, surface, centerline, faces)
        else:
            branch = _branch_at(np.array(one.at), label, surface, runs)
        if branch in marked:
            raise InputError(
                f"{label}: expected one name for every vessel, got a second one for that of "
                f"{marked[branch]!r}; leave one of them out."
            )
        marked[branch] = one.name
    return _spread(marked, runs, centerline)


def _spread(
    marked: dict[int, str], runs: Sequence[VesselRun], centerline: Centerline
) -> tuple[str | None, ...]:
    """The name that holds for each branch, of the branches that are marked."""
    found: list[str | None] = [None] * len(centerline.branches)
    chains = _chains(runs)
    left_at = {
        int(centerline.branches[chain[0]][0])
        for run, chain in zip(runs, chains, strict=True)
        if chain and run.parent >= 0 and is_main(run, runs)
    }
    for run, chain in zip(runs, chains, strict=True):
        ends = [int(centerline.branches[branch][-1]) for branch in chain]
        own = [at for at, branch in enumerate(chain) if branch in marked]
        first = 0
        if own and run.parent < 0:
            first = max(
                (at + 1 for at, end in enumerate(ends[: own[0]]) if end in left_at), default=0
            )
        for at in range(first, len(chain) if own else 0):
            above = [place for place in own if place <= at] or own[:1]
            found[chain[at]] = marked[chain[above[-1]]]
    return tuple(found)


def _chains(runs: Sequence[VesselRun]) -> list[list[int]]:
    """The branches of every vessel, from its begin on; it begins at a station of its parent."""
    counts: dict[int, tuple[int, int]] = {}
    for number, run in enumerate(runs):
        for branch, count in zip(*np.unique(run.branch, return_counts=True), strict=True):
            counts[int(branch)] = max(counts.get(int(branch), (0, 0)), (int(count), -number))
    return [
        [k for k in dict.fromkeys(run.branch.tolist()) if counts[k][1] == -number]
        for number, run in enumerate(runs)
    ]


def _branch_at(place: Floats, label: str, surface: Surface, runs: Sequence[VesselRun]) -> int:
    """Branch in whose own lumen a place (3,) lies, whichever line is nearest there."""
    known = [np.isfinite(run.diameter) for run in runs]
    points = np.concatenate(
        [run.points[is_known] for run, is_known in zip(runs, known, strict=True)]
    )
    radius = np.concatenate(
        [run.diameter[is_known] for run, is_known in zip(runs, known, strict=True)]
    )
    branch = np.concatenate(
        [run.branch[is_known] for run, is_known in zip(runs, known, strict=True)]
    )
    inside = np.linalg.norm(points - place, axis=1) / (radius / 2)
    nearest = int(inside.argmin())
    if inside[nearest] > 1 and (beyond := VesselInside(surface).beyond(place)):
        raise InputError(
            f"{label}: expected a place in a vessel, got {place_words(place)}",
            place=as_place(place),
            end=f", which is {beyond:.1f} mm outside of the wall; move it into the vessel that is "
            "meant.",
        )
    return int(branch[nearest])


def _branch_to(
    face: int, label: str, surface: Surface, tree: Centerline, faces: NamedFaces | None
) -> int:
    """The branch that ends at a face of the model."""
    if faces is None:
        raise InputError(
            f"{label}: expected a place in the vessel, as the surface has no face ids, got face "
            f"{face}; give its x, y and z."
        )
    ends = faces_at_ends(surface, tree, faces)
    nodes = [node for node, number in ends.items() if number == face]
    for branch, points in enumerate(tree.branches):
        if {int(points[0]), int(points[-1])} & set(nodes):
            return branch
    there = sorted(set(ends.values()))
    raise InputError(
        f"{label}: expected a face at an end of the centerline, {in_short(there)}, got {face}; "
        "give one of these, or a place in the vessel."
    )
