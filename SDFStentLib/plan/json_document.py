"""JSON documents that are read strictly: every complaint names the place in the document.

Numbers are read and written as decimals, so that a change of unit (mm to cm) moves the decimal
point and nothing is rounded.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from decimal import Decimal, InvalidOperation
from typing import Any

from ..validation import InputError, in_short

Number = int | float | Decimal


def parsed(text: str, name: str) -> Any:
    """The value of a JSON text, fractions as `Decimal`.

    Raises
    ------
    InputError
        No JSON, nested without end, a key that stands twice, NaN, infinity, or a number beyond
        all bounds.
    """
    try:
        return json.loads(
            text,
            parse_float=_fraction,
            parse_int=_integer,
            parse_constant=_refuse,
            object_pairs_hook=_without_repeats,
        )
    except (ValueError, RecursionError) as error:
        reason = "it is nested too deeply" if isinstance(error, RecursionError) else error
        raise InputError(
            f"{name}: expected a JSON document, got an error: {reason}; correct it."
        ) from error


def section(
    value: Any, where: str, required: Sequence[str] = (), optional: Sequence[str] = ()
) -> Mapping[str, Any]:
    """The value if it is an object with all required keys and no unknown one.

    Raises
    ------
    InputError
        Naming the place, the key, and what was expected.
    """
    known = ", ".join((*required, *optional))
    if not isinstance(value, Mapping):
        raise InputError(
            f"{where}: expected an object with {known}; got {in_words(value)}; correct it."
        )
    for key in value:
        if key not in required and key not in optional:
            raise InputError(
                f"{where}: unknown key {key!r}; expected {known}; rename it, or take it out."
            )
    for key in required:
        if key not in value:
            raise InputError(f"{where}: expected the key {key!r}, got none; add it.")
    return value


def check_schema(document: Any, schema: str, version: int, otherwise: str) -> None:
    """Refuse a document of another schema or version; `otherwise` says what to do or think."""
    found = document.get("schema") if isinstance(document, Mapping) else document
    if found != schema:
        raise InputError(f"schema: expected {schema!r}, got {in_words(found)}; {otherwise}.")
    found = document.get("version")
    if found != version or not isinstance(found, int) or isinstance(found, bool):
        raise InputError(
            f"version: expected {version}, got {in_words(found)}; use the version of sdfstent "
            "that wrote it."
        )


def sequence(value: Any, where: str) -> Sequence[Any]:
    """The value if it is a list."""
    if not isinstance(value, Sequence) or isinstance(value, str):
        raise InputError(f"{where}: expected a list, got {in_words(value)}; correct it.")
    return value


def text_value(value: Any, where: str) -> str:
    """The value if it is a text of whole characters, which files and screens can hold."""
    if not isinstance(value, str):
        raise InputError(f"{where}: expected a text, got {in_words(value)}; correct it.")
    if not _is_unicode(value):
        raise InputError(
            f"{where}: expected a text, got half of a character in {in_words(value)}; correct it."
        )
    return value


def truth(value: Any, where: str) -> bool:
    """The value if it is true or false."""
    if not isinstance(value, bool):
        raise InputError(f"{where}: expected true or false, got {in_words(value)}; correct it.")
    return value


def number(value: Any, where: str) -> Number:
    """The value if it is a number, and no larger than a float can be."""
    if not isinstance(value, Number) or isinstance(value, bool):
        raise InputError(f"{where}: expected a number, got {in_words(value)}; correct it.")
    if not (isinstance(value, float) or _fits_float(value)):
        raise InputError(
            f"{where}: expected a number up to 1.8e308, got {in_words(value)}; correct it."
        )
    return value


def scaled(value: Number, factor: float) -> float:
    """The value times 1, 10 or 1000, exactly rounded once."""
    return float(Decimal(repr(value) if isinstance(value, float) else value) * Decimal(factor))


def unscaled(value: float, factor: float) -> Decimal:
    """The value divided by 1, 10 or 1000: its decimals, moved."""
    return Decimal(repr(float(value))) / Decimal(factor)


def json_text(value: Any, indent: str = "") -> str:
    """Indented JSON with every point on one line; `Decimal` allowed."""
    inner = indent + "  "
    if isinstance(value, Decimal):
        return str(value)
    if isinstance(value, Mapping) and value:
        lines = [f"{inner}{json.dumps(key)}: {json_text(value[key], inner)}" for key in value]
        return "{\n" + ",\n".join(lines) + f"\n{indent}}}"
    if isinstance(value, list | tuple) and value:
        parts = [json_text(item, inner) for item in value]
        if not any(isinstance(item, Mapping | list | tuple) for item in value):
            return "[" + ", ".join(parts) + "]"
        return "[\n" + ",\n".join(inner + part for part in parts) + f"\n{indent}]"
    # The name of a file need not be valid text; escaped, it comes back.
    is_plain = not isinstance(value, str) or _is_unicode(value)
    return json.dumps(value, ensure_ascii=not is_plain, allow_nan=False)


def in_words(value: Any) -> str:
    """Words for a value of JSON in a message."""
    if isinstance(value, Mapping):
        return "an object"
    if isinstance(value, Sequence) and not isinstance(value, str):
        return f"a list of {len(value)}"
    if value is None or isinstance(value, bool):
        return {None: "null", True: "true", False: "false"}[value]
    return in_short(value)


def _fits_float(value: int | Decimal) -> bool:
    try:
        return math.isfinite(float(value))
    except (OverflowError, ValueError):
        return False


def _is_unicode(text: str) -> bool:
    return not any("\ud800" <= character <= "\udfff" for character in text)


def _integer(digits: str) -> int:
    try:
        return int(digits)
    except ValueError:
        raise ValueError(f"a number of {len(digits)} digits is too long") from None


def _fraction(text: str) -> Decimal:
    try:
        return Decimal(text)
    except InvalidOperation:
        raise ValueError(f"the number {in_short(text)} is beyond all bounds") from None


def _refuse(constant: str) -> Any:
    raise ValueError(f"{constant} is no number")


def _without_repeats(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for key, value in pairs:
        if key in found:
            raise ValueError(f"the key {key!r} stands twice in one object")
        found[key] = value
    return found
