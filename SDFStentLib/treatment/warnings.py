"""Sentences about stents in a vessel: too wide for it, without effect, or in each other."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike

from ..geometry import closest_points, length, resampled
from ..measure import DiameterProfile
from ..stent import StentAxis
from ..validation import InputError, Points, as_points
from .value import TreatedStent

WIDEST = 4.0
"""Largest diameter of a stent over that of the lumen; more is another unit or a slip."""

WIDE = 1.5
"""Diameter of a stent over that of the widest native lumen within its length that is warned of."""
# Our choice, far above practice: stents of great vessels were set to 0.66 and, dilated again, to
# 0.85 of the vessel beside them (Heart 2003;89:905); where the lesion is tight a balloon of about
# 1.1 times that vessel is advised (Palmaz stents in great vessels, Cardiology in the Young).

_SPACING, _ROUNDING = 0.1, 1e-6


def check_width(diameter: float, axis: StentAxis, points: Points) -> None:
    """Refuse a stent that is far wider than the vessel, before hours are spent on it.

    Parameters
    ----------
    diameter : float
        Of the stent, mm.
    axis : StentAxis
        Its inscribed radius is believed where it is known.
    points : (n, 3) array
        Of the surface, mm; the nearest one stands for the wall where the radius is unknown.

    Raises
    ------
    InputError
        More than `WIDEST` times as wide as the widest lumen along the axis.
    """
    radii = axis.inscribed_radius[np.isfinite(axis.inscribed_radius)]
    if not len(radii):
        # Late: scipy.spatial costs more to import than the rest of the library together.
        from scipy.spatial import KDTree

        radii = KDTree(points).query(axis.points)[0]
    lumen = 2 * float(radii.max())
    if diameter > WIDEST * lumen:
        raise InputError(
            f"stent diameter: expected at most {WIDEST:g} times the lumen of {lumen:.3g} mm where "
            f"it lies, got {diameter:g} mm; check the diameter, and the unit of the files."
        )


def overlap_length(
    first_axis: ArrayLike, first_radius: float, second_axis: ArrayLike, second_radius: float
) -> float:
    """Length of the second stent's axis along which the two stents overlap, mm.

    A place of the second axis counts when it lies beside the first one, between its ends, and
    nearer to it than the sum of the radii.

    Parameters
    ----------
    first_axis, second_axis : array_like, shapes (n, 3) and (m, 3)
        Axes, mm.
    first_radius, second_radius : float
        mm.
    """
    first = as_points(first_axis, "first axis", minimum=2)
    second = resampled(second_axis, _SPACING)
    # Each piece of the second axis counts by its middle.
    middles = (second[1:] + second[:-1]) / 2
    nearest = closest_points(first, middles)
    # What lies beyond an end is nearest to that end, up to rounding.
    inner = np.clip(nearest.arc_lengths, _ROUNDING, length(first) - _ROUNDING)
    beside = nearest.arc_lengths == inner
    near = nearest.distances < first_radius + second_radius
    pieces = np.linalg.norm(np.diff(second, axis=0), axis=1)
    return float(pieces[beside & near].sum())


def nothing_moved(treated: TreatedStent) -> str:
    """A sentence when a stent moved nothing; empty otherwise."""
    if treated.moved_points:
        return ""
    lumen, diameter = treated.before, treated.stent.diameter
    if not lumen.maximum > 0:
        return (
            f"Nothing moves: the stent of {diameter:g} mm touches no wall, and its axis lies "
            "outside the lumen; check that surface and axis are in the same unit and frame."
        )
    return (
        f"Nothing moves: the stent of {diameter:g} mm is not wider than the lumen where it lies "
        f"({lumen.minimum:.1f} to {lumen.maximum:.1f} mm)."
    )


def overdilated(treated: TreatedStent) -> str:
    """A sentence when a stent is more than `WIDE` times as wide as the vessel ever was there."""
    diameter, lumen = treated.stent.diameter, treated.before.maximum
    # Also false where no diameter could be measured, or the axis lies outside the lumen.
    if not 0 < WIDE * lumen < diameter:
        return ""
    return (
        f"The stent of {diameter:g} mm is {diameter / lumen:.2g} times as wide as the widest "
        f"native lumen within its length ({lumen:.1f} mm), far more than usual; check the "
        "diameter."
    )


def narrowed(own: DiameterProfile, final: DiameterProfile) -> str:
    """A sentence when a lumen is narrower after later stents than the stent itself left it."""
    if not final.minimum < 0.97 * own.minimum:
        return ""
    return (
        f"Later stents push tissue into it: its lumen is {final.minimum:.1f} mm at the narrowest, "
        f"{own.minimum:.1f} mm before them; deploy it after them, or once more."
    )


def overlap(first: TreatedStent, second: TreatedStent) -> Iterator[str]:
    """A sentence when two stents overlap."""
    common = overlap_length(
        first.axis.points,
        first.stent.radius,
        second.axis.points,
        second.stent.radius,
    )
    if common > 0:
        yield (
            f"Stents {first.number} and {second.number} overlap over {common:.1f} mm of the "
            "second one's length; there the wider one determines the lumen."
        )
