"""Shape of a stent that is no cylinder: one profile of diameters over its axis."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..parameter import check_parameters
from ..validation import Floats, InputError, as_number, read_only
from .device import MAXIMUM_DIAMETER, diameter_field, length_field, part_field

SAMPLES = 201
"""Places at which a waist or an end is sampled; profiles are linear in between."""

FLATTEST_CAP = 0.1
"""Least height of a cap over its radius."""


@dataclass(frozen=True)
class Waist:
    """A narrow place, as a lesion leaves it that does not give way: a raised cosine."""

    diameter: float = diameter_field("where it stays narrow", option="waist", called="waist")
    position: float | None = part_field(
        "part of the length from the proximal end; by default where the vessel is narrowest",
        0,
        1,
        default=None,
        option="waist-position",
        called="waist position",
    )
    length: float | None = length_field(
        "of the whole waist; by default that of the stent",
        default=None,
        option="waist-length",
        called="waist length",
    )

    def __post_init__(self) -> None:
        check_parameters(self)


@dataclass(frozen=True)
class StentEnd:
    """End that is wider (flare) or narrower (taper) than the stent."""

    diameter: float = diameter_field("at the very end", called="end of the stent")
    length: float = length_field("to where it has its own diameter", called="length of the end")

    def __post_init__(self) -> None:
        check_parameters(self)


class DiametersAlong(NamedTuple):
    """Diameters of a stent along its axis, linear in between."""

    fractions: Floats
    """(k,) of its length from the proximal end, rising from 0 to 1."""
    diameters: Floats
    """(k,) mm."""
    cap_height: float = 1.0
    """Cap height as of `Shape`."""

    @property
    def widest(self) -> float:
        """mm."""
        return float(self.diameters.max())

    def at(self, fractions: Floats) -> Floats:
        """Diameters (n,) at parts (n,) of the length, mm."""
        return np.interp(fractions, self.fractions, self.diameters)


@dataclass(frozen=True)
class Shape:
    """Shape of a stent that is no plain cylinder.

    Attributes
    ----------
    waist : Waist, optional
    start, end : StentEnd, optional
        Proximal and distal end.
    table : tuple of (fraction, diameter)
        Diameters in place of these, mm, at parts of the length from 0 to 1, linear in between.

    Raises
    ------
    InputError
        A table beside other parts, one that does not rise from 0 to 1, or numbers out of range.
    """

    waist: Waist | None = None
    start: StentEnd | None = None
    end: StentEnd | None = None
    table: tuple[tuple[float, float], ...] = ()
    cap_height: float = part_field(
        "how far it pushes beyond its ends, over the radius there: 1 is half a sphere",
        FLATTEST_CAP,
        1,
        default=1.0,
        option="cap-height",
        called="cap height",
    )

    def __post_init__(self) -> None:
        check_parameters(self)
        if not self.table:
            return
        others = [name for name in ("waist", "start", "end") if getattr(self, name) is not None]
        if others:
            raise InputError(
                f"profile: expected a table alone, got one with {' and '.join(others)}; leave one "
                "of them out."
            )
        for row in self.table:
            if len(row) != 2:
                raise InputError(
                    f"profile: expected rows of a fraction and a diameter, got {len(row)} numbers; "
                    "give both."
                )
            as_number(row[0], "profile fraction", minimum=0, maximum=1)
            as_number(row[1], "profile diameter", unit="mm", above=0, maximum=MAXIMUM_DIAMETER)
        fractions = [row[0] for row in self.table]
        if fractions[0] != 0 or fractions[-1] != 1 or (np.diff(fractions) <= 0).any():
            raise InputError(
                "profile: expected fractions that rise from 0 to 1, each once, got "
                f"{_listed(fractions)}; begin with 0, end with 1, and sort the rows."
            )

    def check(self, diameter: float) -> None:
        """Refuse parts that do not fit a stent of that diameter, mm; `InputError`."""
        if self.waist is not None and self.waist.diameter > diameter:
            raise InputError(
                f"waist: expected at most the {diameter:g} mm of the stent, got "
                f"{self.waist.diameter:g} mm; make it narrower."
            )
        if self.table:
            widest = max(row[1] for row in self.table)
            if abs(widest - diameter) > 1e-9 * diameter:
                raise InputError(
                    f"stent diameter: expected {widest:g} mm, the largest of its profile, got "
                    f"{diameter:g} mm; leave it out."
                )

    def widest(self, diameter: float) -> float:
        """Largest diameter of a stent with this shape and a nominal diameter, mm."""
        ends = [end.diameter for end in (self.start, self.end) if end is not None]
        return max([diameter, *ends])

    def along(self, diameter: float, length: float, narrowest: float = 0.5) -> DiametersAlong:
        """The profile of a stent.

        Parameters
        ----------
        diameter, length : float
            Sizes of the deployed stent, mm.
        narrowest : float
            Part of its length at which the vessel is narrowest.

        Raises
        ------
        InputError
            Ends that are together longer than the stent.
        """
        if self.table:
            fractions, diameters = np.array(self.table).T
            return DiametersAlong(read_only(fractions), read_only(diameters), self.cap_height)
        ends = sum(end.length for end in (self.start, self.end) if end is not None)
        if ends > length:
            raise InputError(
                f"ends of the stent: expected at most its length of {length:.1f} mm, got {ends:g} "
                "mm together; make them shorter."
            )
        position = narrowest
        if self.waist is not None and self.waist.position is not None:
            position = self.waist.position
        fractions = np.union1d(np.linspace(0, 1, SAMPLES), [position])
        at, diameters = fractions * length, np.full(len(fractions), float(diameter))
        for end, distance in ((self.start, at), (self.end, length - at)):
            if end is not None:
                diameters += (end.diameter - diameter) * _smooth_step(1 - distance / end.length)
        if self.waist is not None:
            half = (length if self.waist.length is None else self.waist.length) / 2
            away = np.clip(np.abs(at - position * length) / half, 0, 1)
            depth = (diameter - self.waist.diameter) * (1 + np.cos(np.pi * away)) / 2
            diameters = np.maximum(diameters - depth, min(self.waist.diameter, diameters.min()))
        return DiametersAlong(read_only(fractions), read_only(diameters), self.cap_height)


def _smooth_step(values: Floats) -> Floats:
    """A step from 0 to 1, level at both."""
    values = np.clip(values, 0, 1)
    return values**2 * (3 - 2 * values)


def _listed(values: list[float]) -> str:
    return ", ".join(f"{value:g}" for value in values[:8]) + (" ..." if len(values) > 8 else "")
