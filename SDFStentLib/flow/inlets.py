"""Inlets of a vessel: from the names that the user knows to its ends."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..centerline import Centerline, distal_ends
from ..validation import InputError, Points
from ..vessel import BESIDE_TIP
from .channels import Channel
from .course import tips_of
from .known import Known

NEAR = 1.0
"""mm, from an end of the tree at which a line of the file may end, where no radius is known."""

LISTED = 6
"""Names of ends that a complaint lists."""


class Ends(NamedTuple):
    """Names and inlets of the branches of a centerline, for the ends to which they lead."""

    names: Sequence[str] = ()
    """Names in reports."""
    given: Sequence[str | None] = ()
    """Names by the user."""
    begun: frozenset[int] = frozenset()
    """Branches at whose ends lines of the file begin, as at the root; other inlets, that is."""


class Inlets(NamedTuple):
    """Inlets of a vessel, open and closed."""

    fractions: dict[int, float]
    """Shares of the flow by node, as of `course.nodes_of`, the first one first; 0 where it is
    closed."""
    names: tuple[str, ...]
    """Names of the inlets that are not closed,"""
    closed: tuple[str, ...]
    """and of those closed because nothing is known of them."""


FROM_ROOT = Inlets({0: 1.0}, ("inlet",), ())


def inlets_of(channels: Sequence[Channel], known: Known, ends: Ends) -> Inlets:
    """The inlets of a vessel: those with a known flow, or the root of the centerline.

    Then other ends at which lines begin are closed.

    Raises
    ------
    InputError
        A name of no end, or of several.
    """
    branch_at = {
        node: int(channels[max(node - 1, 0)].branch[-1 if node else 0])
        for node in tips_of(channels)
    }
    names = {node: _names(branch, ends) for node, branch in branch_at.items()}
    closed = [node for node, branch in branch_at.items() if node and branch in ends.begun]
    if not known.inlets:
        found = {0: 1.0, **dict.fromkeys(closed, 0.0)}
        return Inlets(found, (names[0][0],), tuple(names[node][0] for node in closed))
    told: dict[int, str] = {}
    for one in known.inlets:
        node = _named(one.name, names)
        if node in told:
            raise InputError(
                f"inlets: expected another end for each, got {told[node]!r} and {one.name!r} for "
                "the same one; leave one of them out."
            )
        told[node] = one.name
    found = dict(zip(told, known.fractions, strict=True))
    # Pressure is told at the first one; that is where blood comes in.
    order = sorted(found, key=lambda node: not found[node])
    closed = [node for node in closed if node not in found]
    return Inlets(
        {node: found[node] for node in order} | dict.fromkeys(closed, 0.0),
        tuple(told[node] for node in order if found[node]),
        tuple(names[node][0] for node in closed),
    )


def end_names(tree: Centerline, ends: Ends) -> tuple[tuple[str, ...], ...]:
    """Names by which ends of a tree are found as inlets, the root first; those without are left.

    As reports have it, as the user has, and by number and face.
    """
    outlets = {*distal_ends(tree.parent, tree.loops).tolist()}
    tips = [0, *(k for k, nodes in enumerate(tree.branches) if int(nodes[-1]) in outlets)]
    names = {node: _names(branch, ends) for node, branch in enumerate(tips)}
    own = (
        tuple(dict.fromkeys(name for name in some if _found(name, names) == [node]))
        for node, some in names.items()
    )
    return tuple(filter(None, own))


def begun_branches(tree: Centerline, lines: Points) -> frozenset[int]:
    """Branches at whose ends lines of the file begin, if some do at the root, and others end.

    Only where all lines (n, 2, 3), by their begins and ends, lead from several ends of the tree to
    several others; from outlets to inlets, too: inlets are the ends of the root's kind.
    """
    root, tips = int(tree.roots[0]), [int(tree.roots[0]), *tree.leaves.tolist()]
    away = np.linalg.norm(lines[:, :, None] - tree.points[tips], axis=-1)
    nearest = away.argmin(axis=2)
    reach = BESIDE_TIP * np.nan_to_num(tree.inscribed_radius[tips])[nearest]
    if not (away.min(axis=2) <= np.maximum(reach, NEAR)).all():
        return frozenset()
    begins, ends = ({tips[number] for number in column} for column in nearest.T.tolist())
    if begins & ends or min(len(begins), len(ends)) < 2:
        return frozenset()
    inlets = (begins if root in begins else ends) - {root}
    return frozenset(n for n, nodes in enumerate(tree.branches) if int(nodes[-1]) in inlets)


def _names(branch: int, ends: Ends) -> tuple[str, ...]:
    """Names of the end of a branch: as reports and the user have it, and by number and face."""
    number = f"branch {branch + 1}"
    own = ends.names[branch] if branch < len(ends.names) else number
    given = ends.given[branch] if branch < len(ends.given) else None
    return own, *([given] if given else []), number, own.removeprefix("branch to ")


def _named(name: str, names: dict[int, tuple[str, ...]]) -> int:
    """The node of an end by its name."""
    found = _found(name, names)
    if len(found) == 1:
        return found[0]
    told = ", ".join(own[0] for own in list(names.values())[:LISTED])
    raise InputError(
        f"inlets: expected the name of one end of the vessel, such as {told}, got {name!r}"
        f"{', which several have' if found else ''}; take another one, or name the ends",
        "names",
        end=".",
    )


def _found(name: str, names: dict[int, tuple[str, ...]]) -> list[int]:
    """The nodes of all ends of a name."""
    found = [
        node for node, own in names.items() if name.casefold() in (one.casefold() for one in own)
    ]
    # What the user calls the vessel at the root may go on in one of its branches.
    return found[:1] if found[:1] == [0] else found
