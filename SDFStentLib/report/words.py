"""Words for the values of a report; plain text, nothing escaped."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict, is_dataclass
from typing import Any

import numpy as np

from ..units import MILLIMETERS
from ..validation import InputError

UNKNOWN = "not known"
RESEARCH_USE = "Research use only, not a medical device."


def document_json(document: Mapping[str, Any]) -> str:
    """Values as JSON text; numbers that are not known are `null`, never NaN."""
    return json.dumps(plain(document), indent=2, allow_nan=False, ensure_ascii=False) + "\n"


def plain(value: Any, name: str = "document") -> Any:
    """Plain values for JSON, None for NaN and infinity; `InputError` for what has no place."""
    if hasattr(value, "as_dict"):
        return plain(value.as_dict(), name)
    if is_dataclass(value) and not isinstance(value, type):
        return plain(asdict(value), name)
    if isinstance(value, Mapping):
        return {str(key): plain(item, f"{name}.{key}") for key, item in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist(), name)
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, Sequence | set | frozenset):
        items = sorted(value) if isinstance(value, set | frozenset) else value
        return [plain(item, f"{name}[{number}]") for number, item in enumerate(items)]
    raise InputError(
        f"{name}: expected numbers, texts, lists and mappings, got {type(value).__name__}; "
        "give plain values to the report."
    )


def plain_label(key: str) -> str:
    """A field's name without unit and underscores."""
    for suffix in ("_mm2", "_mm", "_s"):
        key = key.removesuffix(suffix)
    words = key.replace("_", " ")
    return words[:1].upper() + words[1:]


def plain_text(key: str, value: Any) -> str:
    """A value with the unit that its key names."""
    unit = " mm" if key.endswith("_mm") else ""
    if value is None:
        return UNKNOWN
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return number_text(value, 2) + unit
    if isinstance(value, int):
        return f"{value:,}".replace(",", "\N{THIN SPACE}") + unit
    if isinstance(value, Sequence) and not isinstance(value, str):
        return ", ".join(plain_text("", item) for item in value) + unit
    return str(value)


def number_text(value: float | None, digits: int) -> str:
    """A number with a true minus sign, which zero has not, or that it is not known."""
    if value is None or not math.isfinite(value):
        return UNKNOWN
    return f"{_rounded(value, digits):.{digits}f}".replace("-", "\N{MINUS SIGN}")


def millimeters(value: float | None, digits: int = 2, *, signed: bool = False) -> str:
    """A length with its unit."""
    if value is None or not math.isfinite(value):
        return UNKNOWN
    sign = "+" if signed and _rounded(value, digits) > 0 else ""
    return f"{sign}{number_text(value, digits)} mm"


def size_words(value: float) -> str:
    """Set size: to a tenth of a millimeter, or to a hundredth where that adds something."""
    return millimeters(value, 1 if round(value, 1) == round(value, 2) else 2)


def degree_word(percent: float | None) -> str:
    """Percent stenosis; "none" where it is nothing, to the percent, or less."""
    if percent is None or not math.isfinite(percent):
        return UNKNOWN
    return f"{percent:.0f} %" if round(percent) > 0 else "none"


def degree_text(percent: float | None, sizes: str = "") -> str:
    """Percent stenosis; in brackets the rise above the reference, and the sizes behind it."""
    is_above = percent is not None and math.isfinite(percent) and round(percent) < 0
    above = f"{-percent:.0f} % above reference" if percent is not None and is_above else ""
    details = ", ".join(part for part in (above, sizes) if part)
    return f"{degree_word(percent)} ({details})" if details else degree_word(percent)


def degrees_text(diameter: float | None, area: float | None) -> str:
    """Percent stenosis by diameter and by area, in words."""
    return f"{degree_text(diameter)} by diameter, {degree_text(area)} by area"


def _rounded(value: float, digits: int) -> float:
    return round(value, digits) + 0.0  # no negative zero


def band_words(band: Mapping[str, float], scale: float = 1.0) -> str:
    """Value and its limits, where these are known."""
    value, low, high = (brief(scale * band[name]) for name in ("value", "low", "high"))
    return value if low == high else f"{value} ({low} to {high})"


def brief(value: float) -> str:
    """A number in short: two decimals below one, one below a hundred; no minus zero."""
    digits = 2 if abs(value) < 1 else 1
    return f"{round(value, digits) + 0.0:.{digits}f}"


def point_text(position: Sequence[float | None]) -> str:
    """Coordinates to a tenth."""
    return ", ".join(number_text(value, 1) for value in position)


def point_words(position_mm: Sequence[float | None], units: str) -> str:
    """Coordinates in mm and, if another one, in the unit of the file."""
    text = f"{point_text(position_mm)} mm"
    if units == "mm":
        return text
    factor = MILLIMETERS[units]
    digits = 1 + round(math.log10(factor))
    stored = (None if value is None else value / factor for value in position_mm)
    filed = ", ".join(number_text(value, digits) for value in stored)
    return f"{text}; in the file {filed} {units}"
