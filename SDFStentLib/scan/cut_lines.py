"""The lines of a vessel up to the planes by which its ends are cut flat."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..centerline import Centerline, ExtractedLines
from ..geometry import norm
from ..segment import CutPlane
from ..validation import Points
from .ends import RoundEnd


def lines_between(
    tree: Centerline, ends: Sequence[RoundEnd], planes: Sequence[CutPlane | None], caps: Points
) -> ExtractedLines:
    """The lines of a tree from its inlet to every other end, up to the middles of flat ends.

    Parameters
    ----------
    tree : Centerline
    ends : sequence of RoundEnd
        Round ends of the whole tree.
    planes : sequence of CutPlane or None
        Plane of each; an end without one stays as it is.
    caps : (k, 3) array
        Middles of the flat ends, mm, the inlet first; lines come in their order.
    """
    points, radii = tree.points.copy(), tree.inscribed_radius.copy()
    is_gone = np.zeros(len(points), dtype=bool)
    for end, plane in zip(ends, planes, strict=True):
        if plane is not None:
            at = end.line.nearest(plane.origin[None])
            outer, inner = end.numbers[int(at.segments[0]) :][:2]
            points[outer] = caps[norm(caps - plane.origin).argmin()]
            radii[outer] += float(at.fractions[0]) * (radii[inner] - radii[outer])
            is_gone[end.numbers[: int(at.segments[0])]] = True
    kept = [line[~is_gone[line]] for line in _lines_of(tree)]
    cut = Centerline.from_lines(points, kept, radii, inlet=caps[0])
    lines = _lines_of(cut)
    first = [int(norm(caps - cut.points[line[-1]]).argmin()) for line in lines]
    order = np.argsort(first, kind="stable").tolist()
    return ExtractedLines(cut.points, tuple(lines[k] for k in order), cut.inscribed_radius)


def _lines_of(tree: Centerline) -> list[np.ndarray]:
    """The points of every line from the root on; where limbs meet both lead to the same point."""
    limbs = tree.loops.tolist()
    found = [tree.ancestry(leaf) for leaf in tree.leaves.tolist()]
    return [*found, *(np.append(tree.ancestry(other), limb) for limb, other in limbs)]
