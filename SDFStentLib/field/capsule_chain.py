"""The stent as a chain of capsules: one distance field for every radius.

The signed distance of the chain at radius r is `distance - r`, because the smooth minimum commutes
with adding a constant. So the field is evaluated once per point and position, never per radius.
Source: SDFStent, arXiv 2605.22009, section 2.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..geometry import Line, across, as_line, dot, norm
from ..validation import InputError, Points, as_number, as_points, in_short, read_only
from .chain_field import ChainField, Field
from .radius_shares import RadiusShares

FOLDS = ("both", "distal")
"""Ends from which the smooth minimum is folded over the capsules, one after the other."""

FOLLOWED = 1.0
"""Length of a capsule, mm, up to which the chain itself is the axis that the stent is meant to
follow (a centerline has kinks that no stent follows); with longer capsules a chain of this length
is what a result is judged by. Source: the capsules of the paper."""

STRAIGHT = 1e-6
"""Change of direction over two capsules, as a length of unit vectors, below which there is no
bend."""


@dataclass(frozen=True)
class CapsuleChain:
    """Capsules along an axis, joined by the quadratic smooth minimum. Immutable.

    Attributes
    ----------
    nodes : (m + 1, 3) array
        Ends of the m capsules, mm, from the proximal to the distal end.
    smoothing_width : float
        k of the smooth minimum, mm; 0 gives the hard minimum.
    fold : {"both", "distal"}
        The smooth minimum depends on the order of the capsules. "both" is the mean of both orders
        and stays the same for the reversed axis; the published method folds from the distal end.
    shares : RadiusShares, optional
        Shares of the radius along the axis where it varies; the field does not depend on them.
    axis : Line, optional
        The line that the stent is meant to follow where that is finer than the nodes: see
        `followed`.
    """

    nodes: Points
    smoothing_width: float = 0.4
    fold: str = "both"
    shares: RadiusShares | None = None
    axis: Line | None = None

    def __post_init__(self) -> None:
        nodes = as_points(self.nodes, "capsule chain nodes", minimum=2)
        if (np.linalg.norm(np.diff(nodes, axis=0), axis=1) == 0).any():
            raise InputError(
                "capsule chain nodes: expected distinct neighbors, got a repeated node; build the "
                "chain with CapsuleChain.along, which removes repeats."
            )
        object.__setattr__(self, "nodes", read_only(nodes))
        width = as_number(self.smoothing_width, "smoothing width", unit="mm", minimum=0)
        object.__setattr__(self, "smoothing_width", width)
        if self.fold not in FOLDS:
            raise InputError(f"fold: expected one of {', '.join(FOLDS)}, got {self.fold!r}.")

    @classmethod
    def along(
        cls,
        axis: Line | ArrayLike,
        *,
        capsule_length: float = 1.0,
        smoothing_width: float = 0.4,
        fold: str = "both",
        shares: RadiusShares | None = None,
    ) -> CapsuleChain:
        """A chain along a stent axis, resampled to capsules of equal length.

        Parameters
        ----------
        axis : Line or (n, 3) array_like
            Stent axis, mm, from the proximal to the distal end; repeats are removed.
        capsule_length : float
            Wanted capsule length, mm; the nearest length that divides the axis is used.

        Raises
        ------
        InputError
            An axis without length, or a capsule length that is not positive.
        """
        spacing = as_number(capsule_length, "capsule length", unit="mm", above=0)
        line = as_line(axis, "stent axis").without_repeats()
        if len(line) < 2:
            raise InputError("stent axis: expected a line with length, got a single place.")
        # Lengths are summed in one direction, so that the nodes do not depend on it by a last bit.
        is_forward = runs_forward(line.points)
        forward = line if is_forward else line.reversed()

        def even(spacing: float) -> Line:
            found = forward.resampled(spacing)
            return found if is_forward else found.reversed()

        if spacing <= FOLLOWED:
            return cls(even(spacing).points, smoothing_width, fold, shares)
        return cls(even(spacing).points, smoothing_width, fold, shares, even(FOLLOWED))

    @cached_property
    def line(self) -> Line:
        """The polyline through the nodes."""
        return Line(self.nodes)

    @property
    def followed(self) -> Line:
        """The line by which a result is judged; nothing is deployed along it."""
        return self.line if self.axis is None else self.axis

    @property
    def length(self) -> float:
        """Length of the axis, mm."""
        return self.line.length

    def field(self, points: ArrayLike) -> Field:
        """Smooth distance to the axis and its gradient.

        Works in blocks: memory stays bounded whatever the number of points.

        Parameters
        ----------
        points : (n, 3) array_like
            Places of evaluation, mm.
        """
        return self.folding.at(as_points(points))

    def axis_distance(self, points: ArrayLike) -> NDArray[np.float64]:
        """True distance (n,) of points (n, 3) to the axis, mm, without smoothing."""
        return self.folding.axis_distance(as_points(points))

    @cached_property
    def folding(self) -> ChainField:
        """The evaluator of the field, for points that are known to be sound."""
        if self.fold == "distal":
            return ChainField(self.nodes[::-1], self.smoothing_width, from_both_ends=False)
        return ChainField(self.undirected.nodes, self.smoothing_width, from_both_ends=True)

    @cached_property
    def undirected(self) -> CapsuleChain:
        """The same field with an order of its nodes that no input direction changes, where it may.

        Only rounding depends on that order.
        """
        if self.fold == "distal" or runs_forward(self.nodes):
            return self
        shares = None if self.shares is None else self.shares.reversed
        axis = None if self.axis is None else self.axis.reversed()
        return CapsuleChain(self.nodes[::-1], self.smoothing_width, self.fold, shares, axis)

    def shortfall(self, points: Points, radius: float) -> NDArray[np.float64] | float:
        """Shortfall (n,) of the stent's radius near points (n, 3) from its largest one, mm."""
        if self.shares is None:
            return 0.0
        return radius * (1 - self.shares.at(points, self.line))

    def least_radius(self, radius: float) -> float:
        """Radius of the stent where it is narrowest, mm."""
        return radius if self.shares is None else radius * float(self.shares.shares.min())

    def inscribed_radii(
        self, radius: float, stations: Points, *, in_caps: bool = False
    ) -> NDArray[np.float64]:
        """Radii (n,), mm, of spheres round stations on the axis that fit into the stent.

        `radius` is the stent's largest one. See `RadiusShares.inscribed`.
        """
        if self.shares is None:
            return np.full(len(stations), radius)
        return self.shares.inscribed(self.line, radius, stations, in_caps=in_caps)


def runs_forward(points: Points) -> bool:
    """Whether a line runs forward: its reverse does not; signs of coordinates count last.

    So both frames of a patient, between which two coordinates change sign, get the same answer.
    """
    for values in (np.abs(points), points):
        forward, backward = values.ravel(), values[::-1].ravel()
        differs = np.flatnonzero(forward != backward)
        if len(differs):
            return bool(forward[differs[0]] < backward[differs[0]])
    return True


def as_chain(value: Any) -> CapsuleChain:
    """The value itself if it is a `CapsuleChain`; `InputError` for all else, such as points of an
    axis."""
    if not isinstance(value, CapsuleChain):
        raise InputError(
            f"chain: expected a CapsuleChain, got {in_short(type(value).__name__)}; "
            "make one of an axis by CapsuleChain.along(axis)."
        )
    return value


def radius_correction(chain: CapsuleChain, radius: float) -> float:
    """Mean inflation of the chain by the smooth minimum at a radius, over the stent, mm.

    The paper subtracts k/4 everywhere. On a real axis the inflation depends on bends, capsule
    length and radius, so it is measured: the mean difference between the true and the smooth
    distance on circles of that radius round the middle of every capsule.
    """
    middle = (chain.nodes[:-1] + chain.nodes[1:]) / 2
    along = np.diff(chain.nodes, axis=0)
    along /= np.linalg.norm(along, axis=1)[:, None]
    first, second = _across_bend(along)
    angles = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    circle = np.cos(angles)[:, None, None] * first + np.sin(angles)[:, None, None] * second
    samples = (middle + radius * circle).reshape(-1, 3)
    true_distance = chain.axis_distance(samples)
    on_stent = true_distance > 0.999 * radius
    if not on_stent.any():
        return chain.smoothing_width / 4
    return float((true_distance - chain.field(samples).distance)[on_stent].mean())


def _across_bend(along: Points) -> tuple[Points, Points]:
    """Two perpendicular unit vectors (m, 3) across every capsule, the first toward its bend.

    Thus they turn with the axis. Where it is straight, the field is nearly the same all round.
    """
    # A first and a last capsule have one neighbor, an only one has none.
    padded = np.concatenate([along[:1], along, along[-1:]])
    turn = padded[2:] - padded[:-2]
    turn -= dot(turn, along)[:, None] * along
    bend = norm(turn)[:, None]
    first = np.where(bend > STRAIGHT, turn / np.maximum(bend, STRAIGHT), across(along)[:, 0])
    return first, np.cross(along, first)
