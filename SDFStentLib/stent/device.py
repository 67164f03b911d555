"""A stent as its maker offers it: its known sizes, and their source.

What is not known stays unknown: no number stands in for it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import KW_ONLY, dataclass
from typing import Any

import numpy as np

from ..cautions import Caution
from ..parameter import check_parameters, parameter
from ..validation import InputError, as_number, in_short, printable

MAXIMUM_DIAMETER = 100.0
"""Largest plausible diameter of a stent, mm; more is another unit or a slip."""

MAXIMUM_LENGTH = 500.0
"""Largest plausible length of a stent, mm."""

LEAST_FORESHORTENING, MOST_FORESHORTENING = -0.2, 0.5
"""Parts of a nominal length that a stent can lose on expansion; below 0 it grows."""


def diameter_field(does: str, **more: Any) -> Any:
    """Field with a diameter, mm."""
    return parameter(does, unit="mm", above=0, most=MAXIMUM_DIAMETER, **more)


def length_field(does: str, **more: Any) -> Any:
    """Field with a length, mm."""
    return parameter(does, unit="mm", above=0, most=MAXIMUM_LENGTH, **more)


def part_field(does: str, least: float, most: float, **more: Any) -> Any:
    """Field with a fraction of something."""
    return parameter(does, least=least, most=most, **more)


SEEN = "with which its source saw it used, smallest and largest; no limits"
CELLS = ("closed", "open", "hybrid", "unknown")
"""Kinds of cells between the struts."""

Range = tuple[float, float]

_ROUNDING = 1e-12
"""The rounding by which a share may be beyond its bounds."""


@dataclass(frozen=True)
class Device:
    """A row of the device table. Lengths and diameters in mm; empty or None is not known.

    Raises
    ------
    InputError
        Numbers without a source, or that contradict each other.
    """

    name: str = parameter("what it is chosen by")
    _: KW_ONLY
    family: str = ""
    manufacturer: str = ""
    covered: bool | None = parameter("null where not known, or where there are both", default=None)
    cell: str = parameter("between the struts", default="unknown", names=CELLS)
    nominal_length: float | None = length_field(
        "as packed, of the one length that the row is about", default=None
    )
    sold_lengths: tuple[float, ...] = length_field(
        "in place of the nominal length, all lengths in which it is sold, as packed, rising",
        default=(),
    )
    lengths: tuple[Range, ...] = length_field(
        "pairs of a diameter and the length at it, by rising diameter; needs the nominal length",
        default=(),
    )
    foreshortening_fraction: float | None = part_field(
        "in place of lengths, the part of the nominal length that is lost: at the nominal "
        "diameters, and where the row is generic at any",
        LEAST_FORESHORTENING,
        MOST_FORESHORTENING,
        default=None,
    )
    nominal_diameters: Range | None = diameter_field(
        "for which it is made, smallest and largest", default=None
    )
    maximum_diameter: float | None = diameter_field(
        "to which it may be expanded at most", default=None
    )
    reported_diameters: Range | None = diameter_field(SEEN, default=None)
    reported_lengths: Range | None = length_field(SEEN, default=None)
    generic: bool = parameter(
        "no product: its numbers are assumptions and need no source", default=False
    )
    source: str = parameter(
        "where its numbers are from; needed with a number unless generic", default=""
    )
    source_date: str = ""
    verified: bool = parameter(
        "whether its numbers were compared with the maker's own document", default=False
    )
    note: str = ""

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name.strip():
            raise InputError(
                f"device name: expected a name, got {in_short(self.name)}; give the row one."
            )
        if self.cell not in CELLS:
            raise self._error("cell", f"one of {', '.join(CELLS)}", f"{self.cell!r}")
        self._check_numbers()
        self._check_sold()
        self._check_lengths()
        if self.has_numbers and not (self.generic or self.source.strip()):
            raise self._error(
                "source", "where its numbers are from", "nothing; name the source, or mark the row "
                "as generic"
            )  # fmt: skip

    @property
    def has_numbers(self) -> bool:
        """Whether any size of it is known."""
        return bool(self.lengths or self.sold_lengths) or any(
            getattr(self, name) is not None for name in _NUMBERS
        )

    @property
    def offered_lengths(self) -> tuple[float, ...]:
        """The lengths, as packed, that it is known to have, mm; empty where none is known."""
        return self.sold_lengths if self.nominal_length is None else (self.nominal_length,)

    def check_diameter(self, diameter: float, what: str = "stent diameter") -> None:
        """Refuse a diameter, mm, beyond the largest to which it may be expanded; `InputError`."""
        most = self.maximum_diameter
        if most is not None and diameter > most:
            raise InputError(
                f"{what}: expected at most {most:g} mm, the largest diameter of "
                f"{printable(self.name)}, got {diameter:g} mm; choose a wider device."
            )

    def foreshortening_at(self, diameter: float) -> float:
        """Foreshortening at a diameter, mm, as a part of the nominal length; lengths are
        interpolated.

        Raises
        ------
        InputError
            It is not known, or not known at that diameter: nothing is extrapolated.
        """
        if self.foreshortening_fraction is not None:
            return self.foreshortening_fraction
        known, lengths = self._columns()
        if not len(known):
            raise InputError(
                f"device {printable(self.name)}: its shortening is not known; say how much of its "
                "length it loses",
                "foreshortening",
                end="." if self.nominal_length else ", or place it between two points.",
            )
        if not known[0] <= diameter <= known[-1]:
            raise InputError(
                f"device {printable(self.name)}: its length is known from {known[0]:g} to "
                f"{known[-1]:g} mm of diameter, not at {diameter:g} mm; choose a diameter in "
                "between, or another device."
            )
        assert self.nominal_length is not None
        return 1.0 - float(np.interp(diameter, known, lengths)) / self.nominal_length

    def cautions(
        self, diameter: float, length: float | None, opened: float | None = None
    ) -> Iterator[Caution]:
        """Cautions for a diameter, or a nominal length, mm, beyond those known of it.

        `opened` is how far it is opened for that diameter, where that is farther.
        """
        made, seen = "for which it is made", "with which its source saw it used"
        widest = max(diameter, opened or 0.0)
        for ends, known_as in ((self.nominal_diameters, made), (self.reported_diameters, seen)):
            value = diameter if ends is None or diameter < ends[0] else widest
            yield from self._beyond("diameter", value, ends, known_as)
        yield from self._beyond("length", length, self.reported_lengths, seen)
        if self.foreshortening_fraction is not None and not self.generic:
            nominal = self.nominal_diameters
            if nominal is None or not nominal[0] <= diameter <= nominal[1]:
                is_it = "may be one of them or not" if nominal is None else "is none of them"
                told = {"device": self.name, "is_it": is_it}
                yield Caution("device-shortening", {**told, "diameter_mm": diameter})

    def _beyond(
        self, what: str, value: float | None, ends: Range | None, known_as: str
    ) -> Iterator[Caution]:
        if ends is None or value is None or ends[0] <= value <= ends[1]:
            return
        numbers = {"value_mm": value, "low_mm": ends[0], "high_mm": ends[1]}
        words = {"device": self.name, "what": what, "known_as": known_as}
        yield Caution("device-range", {**words, **numbers})

    def _columns(self) -> tuple[np.ndarray, np.ndarray]:
        table = np.array(self.lengths, dtype=np.float64).reshape(-1, 2)
        return table[:, 0], table[:, 1]

    def _check_numbers(self) -> None:
        check_parameters(self, f"device {printable(self.name)}, ")
        for name in ("nominal_diameters", "reported_diameters", "reported_lengths"):
            ends = getattr(self, name)
            if ends is not None and len(ends) != 2:
                raise self._error(name, "a smallest and a largest", f"{len(ends)} numbers")
            if ends is not None and ends[0] > ends[1]:
                raise self._error(name, "the smaller one first", f"{ends[0]:g} and {ends[1]:g} mm")
        most, wide = self.maximum_diameter, self.nominal_diameters
        if most is not None and wide is not None and wide[1] > most:
            raise self._error(
                "nominal_diameters", f"at most the largest diameter of {most:g} mm", f"{wide[1]:g}"
            )

    def _check_sold(self) -> None:
        if (np.diff(self.sold_lengths) <= 0).any():
            listed = ", ".join(f"{value:g}" for value in self.sold_lengths)
            raise self._error("sold_lengths", "rising lengths, each once", f"{listed} mm")
        if self.sold_lengths and self.nominal_length is not None:
            raise self._error("sold_lengths", "none beside a nominal_length", "both")

    def _check_lengths(self) -> None:
        low, high = LEAST_FORESHORTENING, MOST_FORESHORTENING
        if not self.lengths:
            return
        if self.foreshortening_fraction is not None:
            raise self._error("lengths", "none beside a foreshortening_fraction", "both")
        if self.nominal_length is None:
            raise self._error("lengths", "a nominal_length with them", "none")
        for pair in self.lengths:
            if len(pair) != 2:
                raise self._error("lengths", "a diameter and a length", f"{len(pair)} numbers")
            self._number(pair[0], "lengths", above=0, maximum=MAXIMUM_DIAMETER)
            lost = 1.0 - pair[1] / self.nominal_length
            if not low - _ROUNDING <= lost <= high + _ROUNDING:
                raise self._error(
                    "lengths",
                    f"between {1 - high:g} and {1 - low:g} times the nominal length of "
                    f"{self.nominal_length:g} mm",
                    f"{pair[1]:g} mm",
                )
        diameters, _ = self._columns()
        if (np.diff(diameters) <= 0).any():
            listed = ", ".join(f"{value:g}" for value in diameters)
            raise self._error("lengths", "rising diameters, each once", f"{listed} mm")
        most = self.maximum_diameter
        if most is not None and diameters[-1] > most:
            raise self._error(
                "lengths", f"at most the largest diameter of {most:g} mm", f"{diameters[-1]:g} mm"
            )

    def _number(self, value: Any, name: str, **bounds: Any) -> float:
        return as_number(value, f"device {printable(self.name)}, {name}", **bounds)

    def _error(self, name: str, wanted: str, got: str) -> InputError:
        return InputError(
            f"device {printable(self.name)}, {name}: expected {wanted}, got {got}; correct it."
        )  # fmt: skip


_NUMBERS = (
    "nominal_length",
    "foreshortening_fraction",
    "nominal_diameters",
    "maximum_diameter",
    "reported_diameters",
    "reported_lengths",
)
