"""Values in a document by their paths, such as "stents.0.diameter": got and set.

Whoever has a value of a plan by a name, as a widget of a panel or an axis of a sweep, has it by its
path.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

MISSING = object()


def value_at(document: Any, path: str, default: Any = None) -> Any:
    """Value at a path, or `default` where the path leads nowhere.

    Parameters
    ----------
    document : mapping or sequence
        As `json.loads` gives it.
    path : str
        Keys and, for lists, numbers from 0, with points between them.
    """
    for part in path.split("."):
        document = _inside(document, part)
        if document is MISSING:
            return default
    return document


def with_value(document: Any, path: str, value: Any) -> Any:
    """A document with another value at a path; this one stays, and shares all else with it.

    An object on the way that is not there, or null, is made. `IndexError` for an item that a list
    has not.
    """
    part, _, rest = path.partition(".")
    if rest:
        inner = _inside(document, part)
        value = with_value({} if inner is MISSING or inner is None else inner, rest, value)
    if not isinstance(document, list | tuple):
        return {**(document or {}), part: value}
    number = int(part)
    if not 0 <= number < len(document):
        raise IndexError(f"{path}: expected an item of {len(document)}, got {part}.")
    return [*document[:number], value, *document[number + 1 :]]


def _inside(document: Any, part: str) -> Any:
    if isinstance(document, Mapping):
        return document.get(part, MISSING)
    is_list = isinstance(document, Sequence) and not isinstance(document, str)
    if is_list and part.isdecimal() and int(part) < len(document):
        return document[int(part)]
    return MISSING
