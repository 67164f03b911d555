"""A stent whose radius changes along its axis, and how far it pushes beyond its ends."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..geometry import arc_lengths, closest_points, norm, product
from ..validation import Floats, InputError, Points, as_number, read_only


@dataclass(frozen=True, eq=False)
class RadiusShares:
    """The radius of a stent along its axis, as parts of the largest one.

    While the stent expands the shares stay as they are: it grows in proportion.

    Attributes
    ----------
    fractions : (k,) array
        Of the length from the proximal end, rising from 0 to 1.
    shares : (k,) array
        Of the largest radius, above 0 and up to 1, linear in between.
    cap_height : float
        How far the stent goes beyond its ends, over its radius there: 1 is half a sphere.
    """

    fractions: Floats
    shares: Floats
    cap_height: float = 1.0

    def __post_init__(self) -> None:
        fractions, shares = np.asarray(self.fractions), np.asarray(self.shares)
        if fractions.shape != shares.shape or fractions.ndim != 1 or len(fractions) < 2:
            raise InputError(
                "radius shares: expected as many fractions as shares, two at least, got "
                f"{fractions.shape} and {shares.shape}."
            )
        if fractions[0] != 0 or fractions[-1] != 1 or not (np.diff(fractions) > 0).all():
            raise InputError("radius shares: expected fractions that rise from 0 to 1.")
        if not ((shares > 0) & (shares <= 1)).all():
            raise InputError("radius shares: expected shares above 0 and up to 1.")
        as_number(self.cap_height, "cap height", above=0, maximum=1)
        object.__setattr__(self, "fractions", read_only(fractions))
        object.__setattr__(self, "shares", read_only(shares))

    @property
    def reversed(self) -> RadiusShares:
        """Those of the same stent with its nodes the other way round."""
        return RadiusShares(1 - self.fractions[::-1], self.shares[::-1], self.cap_height)

    def at(self, points: Points, nodes: Points) -> Floats:
        """Share (n,) of the radius that the stent has where it is nearest to points (n, 3)."""
        foot = closest_points(nodes, points)
        along = arc_lengths(nodes)[-1]
        share = np.interp(foot.arc_lengths / along, self.fractions, self.shares)
        if self.cap_height == 1:
            return share
        return share * self._cap_share(points, nodes)

    def along(self, fractions: Floats) -> Floats:
        """Shares at some parts of the length."""
        return np.interp(fractions, self.fractions, self.shares)

    def inscribed(self, nodes: Points, radius: float, stations: Points, *, in_caps: bool) -> Floats:
        """Radii (n,), mm, of the spheres round stations of the axis that fit into the stent.

        They touch it where it is narrower beside them. Reckoned along a straight axis. Where flat
        caps count, spheres near the ends fit into these as well; else it is open there.
        """
        length = arc_lengths(nodes)[-1]
        fine = np.union1d(np.linspace(0, 1, max(200, int(length / 0.1))), self.fractions)
        at, wall = fine * length, radius * self.along(fine)
        if in_caps and self.cap_height < 1:
            angles = np.linspace(0, np.pi / 2, 30)
            for end, way, place in ((wall[0], -1, 0.0), (wall[-1], 1, length)):
                at = np.append(at, place + way * self.cap_height * end * np.sin(angles))
                wall = np.append(wall, end * np.cos(angles))
        own = closest_points(nodes, stations).arc_lengths
        return np.hypot(at[None] - own[:, None], wall[None]).min(axis=1)

    def _cap_share(self, points: Points, nodes: Points) -> Floats:
        """Of the radius in the direction of points beyond an end: an ellipsoid's; 1 beside it."""
        share = np.ones(len(points))
        for end, inner in (nodes[:2], nodes[:-3:-1]):
            along = (end - inner) / np.linalg.norm(end - inner)
            offset = points - end
            distance = norm(offset)
            height = product(offset, along)
            beyond = (height > 0) & (distance > 0)
            beyond &= closest_points(nodes, points).distances >= distance * (1 - 1e-9)
            cosine = height[beyond] / distance[beyond]
            share[beyond] = 1 / np.sqrt(1 - cosine**2 + (cosine / self.cap_height) ** 2)
        return share
