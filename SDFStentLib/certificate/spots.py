"""Clusters of faulty faces on a surface, and the words for them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..geometry import component_labels
from ..units import place_text
from ..validation import Indices, Place, Points, Triangles, as_place


class FaultSpot(NamedTuple):
    """A spot of the surface where faces fail.

    Attributes
    ----------
    center : (x, y, z)
        Mean of the centroids of the faces, mm.
    triangles : tuple of int
        The faces, ascending.
    """

    center: Place
    triangles: tuple[int, ...]

    def __str__(self) -> str:
        return place_text(self.center, "mm")


def spots_of(
    points: Points, triangles: Triangles, faces: Indices, pairs: Indices
) -> list[FaultSpot]:
    """Spots at which faces fail, most faces first.

    Faces belong to one spot when they share a corner or stand together in one of `pairs`.

    Parameters
    ----------
    points, triangles : (n, 3) and (m, 3) arrays
    faces : (k,) array
        Failing faces.
    pairs : (p, 2) array
        Faces that fail together; pairs of other faces are ignored.
    """
    faces = np.unique(faces)
    if not len(faces):
        return []
    pairs = pairs[np.isin(pairs, faces).all(axis=1)]
    used, corners = np.unique(triangles[faces], return_inverse=True)
    label = component_labels(
        len(faces) + len(used),
        np.r_[np.repeat(np.arange(len(faces)), 3), np.searchsorted(faces, pairs[:, 0])],
        np.r_[len(faces) + corners.ravel(), np.searchsorted(faces, pairs[:, 1])],
    )[: len(faces)]
    centers = points[triangles[faces]].mean(axis=1)
    found = []
    for number in np.unique(label):
        center = as_place(centers[label == number].mean(axis=0))
        found.append(FaultSpot(center, tuple(faces[label == number].tolist())))
    return sorted(found, key=lambda spot: (-len(spot.triangles), spot.triangles))


def faults_in_words(spots: Sequence[FaultSpot], units: str, *counted: tuple[int, str]) -> str:
    """Counts of triangles, each with its fault, and the place; `spots` are those of `spots_of`."""
    faults = ", ".join(f"{count_in_words(count)} {words}" for count, words in counted if count)
    place = place_text(spots[0].center, units)
    if len(spots) == 1:
        return f"{faults} near {place}"
    return f"{faults} at {len(spots)} places, most of them near {place}"


def winding_in_words(flipped: int, is_inside_out: bool) -> str:
    """The fault in the winding of triangles, as the end of a sentence."""
    if flipped:
        verb = "is" if flipped == 1 else "are"
        return f", and {flipped} of its triangles {verb} wound against their neighbors"
    return ", and it is inside out: its triangles must be turned" if is_inside_out else ""


def count_in_words(count: int) -> str:
    """A number of triangles in words, such as "1 triangle" or "1,200 triangles"."""
    return f"{count:,} triangle" + ("" if count == 1 else "s")
