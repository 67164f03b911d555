"""Dataclasses from their documents, by the types of their own fields."""

from __future__ import annotations

import types
from dataclasses import MISSING, fields, is_dataclass
from typing import Any, TypeVar, Union, get_args, get_origin, get_type_hints

from ..validation import InputError
from .json_document import number, section, sequence, text_value, truth

T = TypeVar("T")


def from_document(kind: type[T], value: Any, where: str, **made: Any) -> T:
    """A dataclass from an object whose keys are its fields.

    Parameters
    ----------
    kind : type
        Its fields are numbers, texts, switches, tuples of these, and such dataclasses; any of them
        may be None.
    value, where
        As `json.loads` gives it, fractions may be `Decimal`; its place in the document.
    made
        Fields that are made already, in place of what the document has.

    Raises
    ------
    InputError
        Unknown or missing keys, or values that do not belong there, with their place.
    """
    required, optional = _keys(kind)
    given = section(value, where, required, optional)
    found = {
        name: _typed(hint, given[name], f"{where}.{name}")
        for name, hint in _hints(kind).items()
        if name in given and name not in made
    }
    try:
        return kind(**found, **made)
    except InputError as error:
        raise error.labeled(f"{where}: ") from error


def _hints(kind: Any) -> dict[str, Any]:
    hints = get_type_hints(kind)
    return {field.name: hints[field.name] for field in fields(kind)}


def _keys(kind: Any) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Those that it needs, and the others."""
    needed = [field.name for field in fields(kind) if field.default is MISSING]
    return tuple(needed), tuple(name for name in _hints(kind) if name not in needed)


def _typed(hint: Any, value: Any, where: str) -> Any:
    if get_origin(hint) in (Union, types.UnionType):
        if value is None:
            return None
        (hint,) = (one for one in get_args(hint) if one is not type(None))
    if isinstance(hint, type) and is_dataclass(hint):
        return from_document(hint, value, where)
    if get_origin(hint) is tuple:
        items = [] if value is None else sequence(value, where)
        return tuple(
            _typed(get_args(hint)[0], item, f"{where}[{index}]") for index, item in enumerate(items)
        )
    if hint is float:
        return float(number(value, where))
    return truth(value, where) if hint is bool else text_value(value, where)
