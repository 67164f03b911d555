"""Names of the branches of a centerline, after the ends of the model that they lead to."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..centerline import Centerline
from ..geometry import NamedFaces, Surface
from ..validation import Indices
from .tree_around import outlets_of
from .vessel_ends import BESIDE_TIP, vessel_ends


def branch_names(
    surface: Surface,
    centerline: Centerline,
    faces: NamedFaces | None = None,
    given: Sequence[str | None] = (),
) -> tuple[str, ...]:
    """A name for every branch, as `find_ostia` calls those that lead to known faces.

    Parameters
    ----------
    surface : Surface
    centerline : Centerline
        Centerline of the same vessel.
    faces : NamedFaces, optional
        Faces of the surface.
    given : sequence of str or None
        Names by the user, by branch, as of `given_names`; they come first.

    Returns
    -------
    tuple of str
        Such as "left pulmonary artery", or "branch to face 3" where an end has no name; that at
        the root is called after its own end. "branch 2 of 2.3 mm from 14 mm on (28 outlets)" where
        faces do not tell, or where it leads to several ends of which one at least has no name:
        branches are counted from 1 at the root. The number is behind a name that two have, too.
    """
    names = []
    by_size = _by_size(centerline)
    for number, ids in enumerate(_leading_to(surface, centerline, faces)):
        if given and (own := given[number]) is not None:
            names.append(own)
        elif faces is None or not ids or (len(ids) > 1 and not ids <= faces.names.keys()):
            names.append(f"branch {number + 1} {by_size[number]}")
        else:
            names.append(faces.branch_name(sorted(ids)))
    # Where some ends have no face, two branches may lead to the same.
    return tuple(
        f"{name} (branch {number})" if names.count(name) > 1 else name
        for number, name in enumerate(names, start=1)
    )


def size_words(caliber: float, start: float, outlets: int) -> str:
    """Words for a vessel that no face names: caliber and begin, mm, and the ends it leads to."""
    wide = f"of {caliber:.1f} mm " if caliber > 0 else ""
    return f"{wide}from {start:.0f} mm on ({outlets} outlet{'s' if outlets > 1 else ''})"


def _by_size(tree: Centerline) -> list[str]:
    """`size_words` of every branch, by the radii that came with the centerline."""
    outlets = outlets_of(tree)
    return [
        size_words(
            2 * float(np.median(tree.inscribed_radius[branch])),
            float(tree.arc_length[branch[0]]),
            int(outlets[branch[-1]]),
        )
        for branch in tree.branches
    ]


def named_branches(
    surface: Surface,
    centerline: Centerline,
    faces: NamedFaces | None = None,
    given: Sequence[str | None] = (),
) -> tuple[str | None, ...]:
    """The name of every branch that the user or the faces of the model give it, None without one.

    Arguments as of `branch_names`. A branch to several ends has one where all of them have.
    """
    given = given or (None,) * len(centerline.branches)
    if faces is None or not faces.names:
        return tuple(given)
    return tuple(
        own or (faces.branch_name(sorted(ids)) if ids and ids <= faces.names.keys() else None)
        for own, ids in zip(given, _leading_to(surface, centerline, faces), strict=True)
    )


def _leading_to(
    surface: Surface, centerline: Centerline, faces: NamedFaces | None
) -> list[set[int]]:
    """The faces at the ends to which each branch leads; at the root that of its own end."""
    face_at = {} if faces is None else faces_at_ends(surface, centerline, faces)
    leads_to = _faces_beyond(centerline, face_at)
    found = []
    for branch in centerline.branches:
        start = int(branch[0])
        ids = leads_to[int(branch[-1])]
        if centerline.parent[start] < 0:
            # A vessel without branches needs no name.
            ids = {face_at[start]} if start in face_at and len(centerline.branches) > 1 else set()
        found.append(ids)
    return found


def faces_at_ends(surface: Surface, centerline: Centerline, faces: NamedFaces) -> dict[int, int]:
    """Face of the model at each end of a centerline that lies in a cap."""
    ends = [end for end in vessel_ends(surface) if len(end.faces)]
    found = {}
    for tip in (*centerline.roots.tolist(), *centerline.leaves.tolist()):
        away = [np.linalg.norm(centerline.points[tip] - end.center) / end.radius for end in ends]
        if ends and min(away) <= BESIDE_TIP:
            found[tip] = faces.most(ends[int(np.argmin(away))].faces)
    return found


def _faces_beyond(centerline: Centerline, face_at: dict[int, int]) -> dict[int, set[int]]:
    """The faces at the leaves beyond each centerline point, for the ends of branches."""
    beyond: dict[int, set[int]] = {int(branch[-1]): set() for branch in centerline.branches}
    for leaf in centerline.leaves:
        way: Indices = centerline.ancestry(leaf)
        if int(leaf) in face_at:
            for node in way.tolist():
                if node in beyond:
                    beyond[node].add(face_at[int(leaf)])
    return beyond
