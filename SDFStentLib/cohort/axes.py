"""The axes of a sweep: each is the name of a parameter with the values that it takes."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..parameter import parameters_of
from ..plan import (
    device_named,
    from_document,
    in_words,
    number,
    section,
    sequence,
    text_value,
    to_document,
)
from ..stent import Device, Shape, Stent, StentEnd, Waist
from ..validation import InputError, as_number

DIAMETERS = ("diameter", "diameter_over_lumen", "diameter_over_reference")
"""Ways to give a width: in mm, over the lumen at the place, over the reference of the lesion."""

PLACES = ("branch", "distance", "fraction", "lesion", "offset")
"""Names of places, as in the placement of a plan's stent; a lesion without an offset has 0."""

SHAPE_PARTS = (
    *(f"shape.waist.{name}" for name in parameters_of(Waist)),
    *(f"shape.{end}.{name}" for end in ("start", "end") for name in parameters_of(StentEnd)),
    *(f"shape.{name}" for name in parameters_of(Shape)),
)
SIZES = tuple(
    name for name, one in parameters_of(Stent).items() if one.is_number and name not in DIAMETERS
)
"""Other numbers of a stent."""

NAMES = (*DIAMETERS, *SIZES, *PLACES, "device", "shape", *SHAPE_PARTS)
"""Names of everything that can be an axis: but for widths and places, paths in the plan's stent."""

_LISTED = ("branch", "lesion", "device", "shape")
"""Axes whose values are things rather than sizes, so that they must be listed."""

MOST = 1e6
"""Largest number on an axis: as a length in mm or a ratio it is beyond any use."""

MOST_STEPS = 100_000
"""Largest number of steps of a range."""

DECIMALS = 6
"""Decimals to which drawn numbers are rounded: a millionth of a millimeter."""

Value = float | int | str | None | Mapping[str, Any]
"""A value of a parameter."""


@dataclass(frozen=True)
class SweepAxis:
    """A parameter and its values.

    Attributes
    ----------
    name : str
        Name, one of `NAMES`.
    values : tuple
        Values that are taken in turn; empty for a range.
    low, high : float
        Ends of a uniform range, or of the part that is kept of a normal distribution; -inf and inf
        for all of it.
    mean, sd : float, optional
        Mean and standard deviation of a normal distribution.
    """

    name: str
    values: tuple[Value, ...] = ()
    low: float = 0.0
    high: float = 0.0
    mean: float | None = None
    sd: float = 0.0

    @property
    def is_listed(self) -> bool:
        """Whether its values are listed, so that it can be an axis of a grid."""
        return bool(self.values)

    @property
    def is_number(self) -> bool:
        """Whether its values are numbers, as a table has to know."""
        return not self.values or all(isinstance(value, int | float) for value in self.values)

    def at(self, share: NDArray[np.float64]) -> list[Value]:
        """The values at shares (n,) of the distribution, in [0, 1)."""
        if self.values:
            places = np.minimum(share * len(self.values), len(self.values) - 1).astype(int)
            return [self.values[place] for place in places]
        if self.mean is None:
            found = self.low + share * (self.high - self.low)
        else:
            found = self._normal(share)
        return [round(value, DECIMALS) for value in found.tolist()]

    def _normal(self, share: NDArray[np.float64]) -> NDArray[np.float64]:
        from scipy.special import ndtr, ndtri  # late: few sweeps need it

        assert self.mean is not None
        below, above = (ndtr((end - self.mean) / self.sd) for end in (self.low, self.high))
        # The margin keeps away from the infinite ends.
        inside = np.clip(below + share * (above - below), 1e-12, 1 - 1e-12)
        found: NDArray[np.float64] = self.mean + self.sd * ndtri(inside)
        return np.clip(found, self.low, self.high)


def axis_from_document(name: str, value: Any, where: str) -> SweepAxis:
    """An axis from its value in a sweep document.

    Raises
    ------
    InputError
        An unknown name, or values that do not belong there; their place is named.
    """
    if name not in NAMES:
        raise InputError(f"{where}: unknown axis; expected one of {', '.join(NAMES)}.")
    is_shape_or_device = name in ("shape", "device")
    if isinstance(value, Mapping) and not (is_shape_or_device and "values" not in value):
        return _spread(name, value, where)
    listed = value if isinstance(value, Sequence) and not isinstance(value, str) else [value]
    return _listed(name, listed, where)


def label(value: Value) -> float | int | str:
    """A value as a cell of a table."""
    if isinstance(value, Mapping):
        named = value.get("name")
        return named if named else json.dumps(plain(value), sort_keys=True)
    return "" if value is None else value


def plain(value: Any) -> Any:
    """A value of a strict document as plain JSON, with decimals as floats."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, str | bool | int) or value is None:
        return value
    if isinstance(value, Sequence):
        return [plain(item) for item in value]
    return float(value)


def _spread(name: str, value: Mapping[str, Any], where: str) -> SweepAxis:
    given = section(
        value, where, (), ("values", "from", "to", "steps", "uniform", "normal", "within")
    )
    kinds = [key for key in ("values", "from", "uniform", "normal") if key in given]
    if len(kinds) != 1 or ("within" in given and kinds != ["normal"]):
        raise InputError(
            f"{where}: expected one of values, from with to and steps, uniform, or normal (which "
            f"may have within), got {', '.join(given) or 'nothing'}."
        )
    if kinds == ["values"]:
        return _listed(name, sequence(given["values"], f"{where}.values"), where)
    if name in _LISTED:
        raise InputError(f"{where}: expected a list of values, got {kinds[0]}.")
    if kinds == ["from"]:
        return _stepped(name, given, where)
    low, high = -np.inf, np.inf
    if kinds == ["uniform"]:
        return SweepAxis(name, (), *rising(given["uniform"], f"{where}.uniform"))
    mean, sd = _two(given["normal"], f"{where}.normal")
    if sd <= 0:
        raise InputError(f"{where}.normal: expected a mean and an SD above 0, got SD {sd:g}.")
    if "within" in given:
        low, high = rising(given["within"], f"{where}.within")
    return SweepAxis(name, (), low, high, mean, sd)


def _stepped(name: str, given: Mapping[str, Any], where: str) -> SweepAxis:
    section(given, where, ("from", "to", "steps"))
    steps = number(given["steps"], f"{where}.steps")
    if not isinstance(steps, int) or not 1 < steps <= MOST_STEPS:
        raise InputError(f"{where}.steps: expected 2 to {MOST_STEPS}, got {in_words(steps)}.")
    low, high = (_number(given[key], f"{where}.{key}") for key in ("from", "to"))
    return SweepAxis(
        name, tuple(round(v, DECIMALS) for v in np.linspace(low, high, steps).tolist())
    )


def _listed(name: str, values: Sequence[Any], where: str) -> SweepAxis:
    if not values:
        raise InputError(f"{where}: expected at least one value, got none.")
    checks = {"branch": _branch, "lesion": _whole, "device": _device, "shape": _shape}
    check = checks.get(name, _number)
    found = tuple(check(value, f"{where}[{at}]") for at, value in enumerate(values))
    if len({json.dumps(plain(value), sort_keys=True) for value in found}) < len(found):
        raise InputError(f"{where}: expected every value once, got one twice.")
    return SweepAxis(name, found)


def _number(value: Any, where: str) -> float:
    return as_number(number(value, where), where, minimum=-MOST, maximum=MOST)


def _whole(value: Any, where: str) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or value < 1:
        raise InputError(f"{where}: expected a number of the list, from 1, got {in_words(value)}.")
    return value


def _branch(value: Any, where: str) -> int | str:
    return text_value(value, where) if isinstance(value, str) else _whole(value, where)


def _device(value: Any, where: str) -> Mapping[str, Any]:
    """The row of the device table, as its name may mean something else where the worker is."""
    if isinstance(value, Mapping):
        return _document(Device, value, where)
    try:
        found: Mapping[str, Any] = to_document(device_named(text_value(value, where)))
    except InputError as error:
        raise error.labeled(f"{where}: ") from error
    return found


def _shape(value: Any, where: str) -> Mapping[str, Any] | None:
    return None if value is None else _document(Shape, value, where)


def _document(kind: type, value: Any, where: str) -> Mapping[str, Any]:
    """The document of a value after all checks, with every field."""
    found: Mapping[str, Any] = to_document(from_document(kind, plain(value), where))
    return found


def _two(value: Any, where: str) -> tuple[float, float]:
    ends = sequence(value, where)
    if len(ends) != 2:
        raise InputError(f"{where}: expected two numbers, got {in_words(value)}.")
    return _number(ends[0], f"{where}[0]"), _number(ends[1], f"{where}[1]")


def rising(value: Any, where: str) -> tuple[float, float]:
    """Two rising numbers of a document; `InputError` for anything else."""
    low, high = _two(value, where)
    if low >= high:
        raise InputError(f"{where}: expected two rising numbers, got {low:g} and {high:g}.")
    return low, high
