"""The C-arm: its two angles, where they look, and how far it turns.

The angles are those of DICOM's X-ray angiography (PS3.3 C.8.7.5, Positioner Primary and Secondary
Angle), of a patient who lies on the back: the primary one in the transaxial plane, 0 in front of
the chest and +90 degrees at the left side (LAO), the secondary one toward the head, +90 degrees
there (CRA). They name where the detector is; the tube is opposite to it.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..units import Frame
from ..validation import Flags, Floats, InputError, as_number

LAO_RAO, CRA_CAU = 110.0, 50.0
"""Degrees to either side to which an arm turns unless something else is said. Arms differ, and
tables and patients are in their way: Philips has 120 and 45 for an Xper FD10C at the head."""


class ArmView(NamedTuple):
    """A position of the C-arm, degrees."""

    primary: float
    """LAO; RAO is negative."""
    secondary: float
    """CRA; CAU is negative."""

    @property
    def words(self) -> str:
        """The angles in the words of the laboratory, to a degree."""
        sides = (("LAO", "RAO"), self.primary), (("CRA", "CAU"), self.secondary)
        return ", ".join(f"{names[round(at) < 0]} {abs(round(at))}" for names, at in sides)

    def axes(self, frame: Frame) -> Floats:
        """`arm_axes` of this one, (3, 3)."""
        return arm_axes(np.array([self.primary]), np.array([self.secondary]), frame)[0]


class ArmLimits(NamedTuple):
    """Limits of an arm's angles, degrees to either side, and of those with the patient's table."""

    lao_rao: float = LAO_RAO
    cra_cau: float = CRA_CAU
    table: tuple[tuple[float, float, float], ...] = ()
    """Rows of primary angle, largest CRA and largest CAU there, by growing angle: what table and
    patient leave. Between rows it follows a straight line, beyond them nothing is reached."""

    def reach(self, primary: Floats, secondary: Floats) -> Flags:
        """Whether positions (k,) are within the limits."""
        within = (np.abs(primary) <= self.lao_rao) & (np.abs(secondary) <= self.cra_cau)
        if not self.table:
            return np.asarray(within)
        at, cranial, caudal = np.array(self.table).T
        within &= (primary >= at[0]) & (primary <= at[-1])
        within &= secondary <= np.interp(primary, at, cranial)
        return np.asarray(within & (-secondary <= np.interp(primary, at, caudal)))


def arm_limits(
    lao_rao: float = LAO_RAO,
    cra_cau: float = CRA_CAU,
    table: Sequence[tuple[float, float, float]] = (),
) -> ArmLimits:
    """Checked limits.

    Raises
    ------
    InputError
        Angles beyond 180 and 90 degrees or below 0, rows that do not grow.
    """
    lao_rao = as_number(lao_rao, "LAO/RAO", unit="degrees", minimum=0, maximum=180)
    cra_cau = as_number(cra_cau, "CRA/CAU", unit="degrees", minimum=0, maximum=90)
    for row in table:
        if len(row) != 3:
            raise InputError(
                f"table of limits: expected rows of LAO, CRA and CAU, got {len(row)} numbers; "
                "correct it."
            )
        as_number(row[0], "LAO of a row", unit="degrees", minimum=-180, maximum=180)
        for value, name in zip(row[1:], ("CRA of a row", "CAU of a row"), strict=True):
            as_number(value, name, unit="degrees", minimum=0, maximum=90)
    first = [row[0] for row in table]
    if any(after <= before for before, after in pairwise(first)):
        raise InputError(
            "table of limits: expected rows by growing LAO, RAO as a negative number, got others; "
            "sort them, each angle once."
        )
    return ArmLimits(lao_rao, cra_cau, tuple(table))


def arm_axes(primary: Floats, secondary: Floats, frame: Frame) -> Floats:
    """Right, up, and the direction toward the detector in the pictures of positions (k,).

    Parameters
    ----------
    primary, secondary : (k,) arrays
        Degrees.
    frame : "RAS" or "LPS"
        Patient frame of the vectors.

    Returns
    -------
    (k, 3, 3) array
        Three unit vectors each, as rows. The picture is what an observer at the detector sees: the
        patient's left is on the right in a view from the front, and the head is up.
    """
    alpha, beta = np.deg2rad(primary), np.deg2rad(secondary)
    sides, tops = (np.sin(alpha), np.cos(alpha)), (np.sin(beta), np.cos(beta))
    zero = np.zeros_like(alpha)
    right = np.stack([sides[1], sides[0], zero], axis=-1)
    up = np.stack([-sides[0] * tops[0], sides[1] * tops[0], tops[1]], axis=-1)
    toward = np.stack([sides[0] * tops[1], -sides[1] * tops[1], tops[0]], axis=-1)
    axes = np.stack([right, up, toward], axis=1)
    return axes if frame == "LPS" else axes * (-1.0, -1.0, 1.0)


def arm_view(toward: Floats, frame: Frame) -> ArmView:
    """The position whose detector is in a direction (3,) of any length but zero."""
    x, y, z = np.asarray(toward) * ((1.0, 1.0, 1.0) if frame == "LPS" else (-1.0, -1.0, 1.0))
    flat = np.hypot(x, y)
    primary = np.arctan2(x, -y) if flat > 0 else 0.0
    return ArmView(float(np.rad2deg(primary)), float(np.rad2deg(np.arctan2(z, flat))))
