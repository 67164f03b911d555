"""Pouches: openings of a vessel that end closed before they are as long as a vessel."""

from __future__ import annotations

import numpy as np

from ..centerline import Centerline
from ..geometry import Surface, boundary_edges, dot, norm, search_tree, vertex_normals
from ..validation import Floats, Indices, Points
from .spheres import SOME
from .tolerances import ROUNDING
from .wall_map import corner_tree

AS_LONG = 2.0
"""Length over width from which on an outgrowth of a vessel is itself a vessel, by definition."""


def pouch_width(
    surface: Surface,
    beyond: Indices,
    middle: Floats,
    neck: float,
    outward: Floats,
    tree: Centerline | None = None,
) -> float | None:
    """The width of the pouch to which an opening without an end of the model leads, mm; None if it
    is a vessel.

    A pouch ends closed, no line leads into it, and it is less than `AS_LONG` times as long as it
    is wide: as long as its wall is away from the middle of its neck, at most, and as wide as its
    neck or as the widest sphere that its own wall surrounds in more than half of all directions.

    Parameters
    ----------
    surface : Surface
        Native, mm.
    beyond : Indices
        (k,) its triangles beyond the neck.
    middle : Floats
        (3,) middle of the neck, mm.
    neck : float
        Diameter of the neck, mm.
    outward : Floats
        (3,) direction across the neck, away from the vessel that opens.
    tree : Centerline, optional
        Leads into vessels, and into no pouch.
    """
    if not len(beyond):
        return None
    is_own = np.zeros(len(surface.points), dtype=bool)
    is_own[surface.triangles[beyond]] = True
    own = np.flatnonzero(is_own)
    length = float(norm(surface.points[own] - middle).max())
    least = max(neck, length / AS_LONG)
    width = _widest(surface, beyond, own, middle, outward, least) or neck
    if length >= AS_LONG * width or _is_open(surface, own):
        return None
    if tree is not None and _leads_to(tree, surface, own, middle, length):
        return None
    return width


def _is_open(surface: Surface, own: Indices) -> bool:
    """Whether points of a surface lie on its border."""
    return bool(np.isin(boundary_edges(surface.triangles), own).any())


def _leads_to(
    tree: Centerline, surface: Surface, own: Indices, middle: Floats, length: float
) -> bool:
    """Whether points of a line not far from a neck are nearest to the wall beyond it."""
    around = tree.points[norm(tree.points - middle) < 2 * length]
    return bool(np.isin(corner_tree(surface).query(around)[1], own).any())


def _widest(
    surface: Surface,
    beyond: Indices,
    own: Indices,
    middle: Floats,
    outward: Floats,
    least: float,
) -> float:
    """Diameter of the widest sphere within the wall beyond a neck; 0 where none is above a least.

    Spheres touch that wall, grow inward until they meet other wall, and have their center beyond
    the neck; the one that counts is surrounded by that wall in more than half of all directions.
    """
    wound = surface.wound_triangles[beyond]
    corners = surface.points[wound] - middle
    # What lies between the neck and the wall beyond is lumen, however the wall is wound.
    volume = np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    is_some = np.zeros(len(surface.points), dtype=bool)
    is_some[own[np.linspace(0, len(own) - 1, min(len(own), SOME)).astype(np.int64)]] = True
    ids, local = np.unique(wound[is_some[wound].any(axis=1)], return_inverse=True)
    touching = surface.points[ids] - middle
    inward = -np.sign(volume) * vertex_normals(touching, local.reshape(-1, 3))
    some = is_some[ids]
    centers, radii = _grown(surface.points - middle, touching[some], inward[some])
    fits = (centers @ outward > 0) & (2 * radii > least)
    for at in np.argsort(-radii):
        if fits[at] and abs(_solid_angle(corners - centers[at])) > 2 * np.pi:
            return 2 * float(radii[at])
    return 0.0


def _grown(wall: Points, touching: Points, inward: Floats) -> tuple[Points, Floats]:
    """Centers (k, 3) and radii (k,) of the spheres at points of a wall that hold none of it.

    By spheres that shrink onto the nearest point: Ma, Bae and Choi, The Visual Computer 2012,
    doi:10.1007/s00371-011-0594-7.
    """
    tree = search_tree(wall)
    radii = np.full(len(touching), norm(touching).max())
    # Ends, since every round meets a nearer point, and there are finitely many.
    while True:
        centers = touching + radii[:, None] * inward
        arms = wall[tree.query(centers)[1]] - touching
        height = dot(arms, inward)
        met = np.divide(dot(arms, arms), 2 * height, out=radii.copy(), where=height > 0)
        shrinks = (met < (1 - ROUNDING) * radii) & (met > 0)
        if not shrinks.any():
            return centers, radii
        radii = np.where(shrinks, met, radii)


def _solid_angle(corners: Floats) -> float:
    """The solid angle of triangles (t, 3, 3) seen from the origin, signed by their winding.

    Van Oosterom and Strackee, IEEE Trans Biomed Eng 1983, doi:10.1109/TBME.1983.325207.
    """
    a, b, c = corners.transpose(1, 0, 2)
    of_a, of_b, of_c = norm(a), norm(b), norm(c)
    below = of_a * of_b * of_c + dot(a, b) * of_c + dot(a, c) * of_b + dot(b, c) * of_a
    return float(2 * np.arctan2(dot(a, np.cross(b, c)), below).sum())
