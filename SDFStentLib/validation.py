"""Checks of input: convert a value, check it, and name the fault in one sentence."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Mapping
from decimal import Decimal
from pathlib import Path
from string import Formatter
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

# Control characters of ASCII and Latin-1, separators of lines, characters that change the direction
# of writing, and halves of characters, as in the name of a file that is no valid text.
_CONTROL = re.compile(
    r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff\ufffe\uffff]"
)

Points = NDArray[np.float64]
"""(n, 3) array of coordinates, mm."""

Triangles = NDArray[np.int64]
"""(m, 3) array of indices into the points."""

Place = tuple[float, float, float]
"""A point as plain numbers, mm."""

Floats = NDArray[np.float64]
"""Array of numbers, whose shape depends on its use."""

Indices = NDArray[np.int64]
"""Array of indices."""

Flags = NDArray[np.bool_]
"""Array of truth values."""


LARGEST_COORDINATE = 1e6
"""Largest coordinate of any point, mm: a kilometer is far beyond every scanner."""


class InputError(ValueError):
    """Raised for input that cannot be used; the message has the expected and the given value, and
    a remedy.

    Parameters
    ----------
    message : str
        The sentence, or its part before the remedy.
    remedy : str
        Name of the remedy, such as an option of the command.
    otherwise : str
        The words in its place for a reader who has none for this remedy.
    end : str
        The rest of the sentence.
    place : (x, y, z), optional
        The place with which the message ends, mm; a reader who knows the file's unit adds it in
        that.
    """

    def __init__(
        self,
        message: str = "",
        remedy: str = "",
        *,
        otherwise: str = "",
        end: str = "",
        place: Place | None = None,
    ) -> None:
        super().__init__(message + otherwise + end)
        self._parts = (message, remedy, otherwise, end)
        self.place = place

    def sentence(self, remedies: Mapping[str, str], filed: str = "") -> str:
        """The message with the reader's words for the remedy, and for the place in the file."""
        message, remedy, otherwise, end = self._parts
        return message + filed + remedies.get(remedy, otherwise) + end

    def labeled(self, label: str) -> InputError:
        """The same error with a label in front: a file, a stent, a place in a document."""
        message, remedy, otherwise, end = self._parts
        return InputError(label + message, remedy, otherwise=otherwise, end=end, place=self.place)


class DeploymentError(RuntimeError):
    """Raised if a deployment cannot proceed although its input is well formed."""


def as_points(values: ArrayLike, name: str = "points", *, minimum: int = 0) -> Points:
    """Coordinates as a finite float64 array of shape (n, 3).

    Parameters
    ----------
    values : array_like, shape (n, 3)
        Coordinates, mm.
    name : str
        Name of the points in error messages.
    minimum : int
        Smallest number of points that is accepted.

    Raises
    ------
    InputError
        Wrong shape, not numeric, too few, or a coordinate that is NaN or infinite.
    """
    try:
        points = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(
            f"{name}: expected numbers of shape (n, 3), got {error}; give three for each point."
        ) from error
    if points.size == 0:
        points = points.reshape(0, 3)
    if points.ndim != 2 or points.shape[1] != 3:
        raise InputError(
            f"{name}: expected shape (n, 3), got {points.shape}; give three numbers for each point."
        )
    if len(points) < minimum:
        raise InputError(
            f"{name}: expected at least {minimum} points, got {len(points)}; add what is missing."
        )
    if not np.isfinite(points).all():
        bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
        raise InputError(
            f"{name}: expected finite coordinates, got NaN or infinity at {len(bad)} of "
            f"{len(points)} points, the first is point {bad[0]}; repair the file."
        )
    return points


def as_patient_points(values: ArrayLike, name: str = "points", *, minimum: int = 0) -> Points:
    """Points (n, 3) as from `as_points`, up to a kilometer; raises `InputError` otherwise."""
    points = as_points(values, name, minimum=minimum)
    largest = np.abs(points).max(initial=0.0)
    if largest > LARGEST_COORDINATE:
        raise InputError(
            f"{name}: expected coordinates up to {LARGEST_COORDINATE:g} mm, got {largest:g}; check "
            "its units, or repair the file."
        )
    return points


def as_point(values: ArrayLike, name: str = "point") -> NDArray[np.float64]:
    """A finite point as a float64 array of shape (3,); raises `InputError` otherwise."""
    return as_points(np.reshape(np.asarray(values, dtype=object), (1, -1)), name, minimum=1)[0]


def as_place(point: ArrayLike) -> Place:
    """A point (3,) as plain numbers."""
    x, y, z = np.asarray(point, dtype=np.float64).tolist()
    return x, y, z


def plain(value: float, spec: str) -> str:
    """A number by a format, without an exponent, and zero without a sign.

    Values below a millionth, such as the rounding errors of a zero, are written as 0.
    """
    text = format(value, spec)
    if "e" in text:
        text = f"{float(text):.6f}".rstrip("0").rstrip(".")
    return text.removeprefix("-") if not text.strip("-0.") else text


class PlainNumbers(Formatter):
    """Fills templates with `plain` numbers."""

    def format_field(self, value: Any, spec: str) -> str:
        """The text of a field of a template."""
        return plain(value, spec) if isinstance(value, float) else format(value, spec)


def coordinates(point: ArrayLike, spec: str = ".4g") -> str:
    """A point (3,) as text for sentences, without a unit."""
    return "(" + ", ".join(plain(value, spec) for value in as_place(point)) + ")"


def place_words(point: ArrayLike) -> str:
    """A point (3,) in mm as text for sentences."""
    return f"{coordinates(point)} mm"


def as_triangles(values: ArrayLike, point_count: int, name: str = "triangles") -> Triangles:
    """Triangles as an int64 array of shape (m, 3) whose indices exist.

    Raises
    ------
    InputError
        Wrong shape, no triangle, or an index outside `0 .. point_count - 1`.
    """
    triangles = np.asarray(values)
    if triangles.ndim != 2 or triangles.shape[1] != 3 or triangles.dtype.kind not in "iu":
        raise InputError(
            f"{name}: expected integers of shape (m, 3), got {triangles.dtype} {triangles.shape}; "
            "give three point indices for each triangle."
        )
    if len(triangles) == 0:
        raise InputError(f"{name}: expected at least one triangle, got none; add one.")
    if triangles.min() < 0 or triangles.max() >= point_count:
        raise InputError(
            f"{name}: expected point indices from 0 to {point_count - 1}, got "
            f"{triangles.min()} to {triangles.max()}; repair the file."
        )
    return triangles.astype(np.int64, copy=False)


def as_number(
    value: Any,
    name: str,
    *,
    unit: str = "",
    above: float | None = None,
    minimum: float | None = None,
    maximum: float | None = None,
) -> float:
    """A finite float inside its range; the bounds `minimum`, `maximum` belong to the range.

    Raises
    ------
    InputError
        Not a number, not finite, or out of range.
    """
    wanted = _range_in_words(above, minimum, maximum, unit)
    try:
        number = math.nan if isinstance(value, str | bytes) else float(value)
    except (TypeError, ValueError, OverflowError):
        raise InputError(
            f"{name}: expected {wanted}, got {in_short(value)}; choose such a number."
        ) from None
    outside = (
        not np.isfinite(number)
        or (above is not None and number <= above)
        or (minimum is not None and number < minimum)
        or (maximum is not None and number > maximum)
    )
    if isinstance(value, bool) or outside:
        raise InputError(f"{name}: expected {wanted}, got {in_short(value)}; choose such a number.")
    return number


def as_path(value: Any) -> Path:
    """A path from a text or a path; raises `InputError` for anything else."""
    if not isinstance(value, str | os.PathLike) or not isinstance(os.fspath(value), str):
        raise InputError(f"path: expected the path of a file, got {in_short(value)}; name one.")
    return Path(value)


def check_is_a(value: Any, kind: type, name: str) -> None:
    """Raise `InputError` unless a value is of the kind that a function takes."""
    if not isinstance(value, kind):
        raise InputError(f"{name}: expected a {kind.__name__}, got {in_short(value)}; pass one.")


def as_length(value: Any, name: str, shortest: float, longest: float) -> float:
    """Length in mm, above 0 and plausible; raises `InputError` otherwise."""
    length = as_number(value, name, unit="mm", above=0)
    return as_number(length, name, unit="mm", minimum=shortest, maximum=longest)


def in_short(value: Any) -> str:
    """A value as Python writes it, for a message; only the beginning of a long one."""
    try:
        text = str(value) if isinstance(value, Decimal) else repr(value)
    except ValueError:  # Python does not write integers of more than some thousand digits
        return "a number of thousands of digits"
    return text if len(text) <= 60 else f"{text[:40]}... ({len(text)} characters)"


def printable(text: str) -> str:
    """A text with control characters written as escapes, except line ends and tabs.

    Names come from files: in a terminal or on a page, control characters in them could move the
    cursor, clear the screen or reverse the direction of writing.
    """
    return _CONTROL.sub(lambda found: ascii(found[0])[1:-1], text)


def one_line(text: str) -> str:
    """A text as `printable`, with line ends and tabs as escapes, too."""
    return printable(text).replace("\n", r"\n").replace("\t", r"\t")


def read_only(array: NDArray[Any]) -> NDArray[Any]:
    """A write-protected copy, for the fields of immutable values."""
    copy = np.array(array)
    copy.setflags(write=False)
    return copy


def _range_in_words(
    above: float | None, minimum: float | None, maximum: float | None, unit: str
) -> str:
    parts = ["a number"]
    if above is not None:
        parts.append(f"greater than {above:g}")
    if minimum is not None:
        parts.append(f"at least {minimum:g}")
    if maximum is not None:
        parts.append(f"at most {maximum:g}")
    words = parts[0] + (" " + " and ".join(parts[1:]) if len(parts) > 1 else "")
    return f"{words} ({unit})" if unit else words
