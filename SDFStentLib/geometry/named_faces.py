"""The parts that a model's surface is divided into, by number and, where known, by name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from ..validation import Indices, InputError, one_line, read_only

_SAID = 3
"""So many parts are named one by one; of more the rest is counted."""


@dataclass(frozen=True, eq=False)
class NamedFaces:
    """To which part of the model every triangle belongs, as SimVascular marks its caps and walls.

    Parameters
    ----------
    ids : array_like of int, shape (m,)
        Of the triangles.
    names : mapping of int to str
        Of the parts that have one.

    Raises
    ------
    InputError
        Ids that are no row of integers.
    """

    ids: Indices
    names: Mapping[int, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        ids = np.asarray(self.ids)
        if ids.ndim != 1 or not np.issubdtype(ids.dtype, np.integer):
            raise InputError(
                f"face ids: expected one whole number for every triangle, got {ids.dtype} of shape "
                f"{ids.shape}."
            )
        object.__setattr__(self, "ids", read_only(ids.astype(np.int64)))
        names = {number: one_line(name) for number, name in self.names.items()}
        object.__setattr__(self, "names", names)

    def most(self, triangles: ArrayLike) -> int:
        """The part to which most of some triangles (k,) belong."""
        kinds, counts = np.unique(self.ids[np.asarray(triangles)], return_counts=True)
        return int(kinds[np.argmax(counts)])

    def branch_name(self, ids: Sequence[int]) -> str:
        """What a branch is called that leads to some parts."""
        if len(ids) == 1 and ids[0] in self.names:
            return self.said(ids)
        return f"branch to {self.said(ids)}"

    def said(self, ids: Sequence[int]) -> str:
        """Some parts in words, such as "face 3" or "right pulmonary artery"."""
        words = [self.names.get(number, f"face {number}") for number in ids]
        if len(words) > _SAID:
            words = [*words[:_SAID], f"{len(words) - _SAID} more"]
        return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)


def checked_faces(faces: NamedFaces | None, triangle_count: int) -> NamedFaces | None:
    """The same; `InputError` where they are of another surface."""
    if faces is not None and len(faces.ids) != triangle_count:
        raise InputError(
            f"face ids: expected one for each of {triangle_count} triangles, got {len(faces.ids)}; "
            "take them from the same file as the surface."
        )
    return faces
