"""Dataclasses from their documents, back, and what describes these, by their own fields."""

from __future__ import annotations

import sys
import types
from collections.abc import Mapping, Sequence
from dataclasses import MISSING, fields, is_dataclass
from functools import cache
from typing import Any, TypeVar, Union, get_args, get_origin, get_type_hints

from ..parameter import Parameter, parameters_of
from ..validation import InputError
from .json_document import number, section, sequence, text_value, truth

T = TypeVar("T")


def from_document(kind: type[T], value: Any, where: str, **made: Any) -> T:
    """A dataclass from an object whose keys are its fields.

    Parameters
    ----------
    kind : type
        Dataclass of numbers, texts, switches, tuples of these, and such dataclasses; any of them
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
    found = typed_values(kind, value, where, **made)
    try:
        return kind(**found)
    except InputError as error:
        raise error.labeled(f"{where}: ") from error


def typed_values(kind: type, value: Any, where: str, **made: Any) -> dict[str, Any]:
    """The fields of which `from_document` makes a dataclass; parameters and errors as there."""
    required, optional = _keys(kind)
    given = section(value, where, required, optional)
    found = {
        name: _typed(hint, given[name], f"{where}.{name}")
        for name, hint in _hints(kind).items()
        if name in given and name not in made
    }
    return {**found, **made}


def without_unset(kind: type, value: Mapping[str, Any]) -> dict[str, Any]:
    """The document of a dataclass, null in place of objects that are not filled in.

    These are the ones in which a required key is null, or in which some key is null and all others
    are as by default: what a form has of a part that its user has left out.
    """
    found = {}
    for name, part in value.items():
        inner = _object_in(_hints(kind).get(name))
        if inner is not None and isinstance(part, Mapping):
            part = without_unset(inner, part)
            required, _ = _keys(inner)
            usual = {one.name: to_document(one.default) for one in fields(inner)}
            is_unset = any(part.get(key, "") is None for key in required)
            is_usual = all(item in (None, usual.get(key)) for key, item in part.items())
            if is_unset or (is_usual and None in part.values()):
                part = None
        found[name] = part
    return found


def parameter_in(kind: Any, path: str) -> Parameter:
    """The parameter at a path in the document of a dataclass, such as "balloon.diameter"."""
    name, _, inside = path.partition(".")
    if inside:
        return parameter_in(_object_in(_hints(kind)[name]), inside)
    return parameters_of(kind)[name]


def _object_in(hint: Any) -> Any:
    """The dataclass that a field may have, or None."""
    return next((one for one in (hint, *get_args(hint)) if is_dataclass(one)), None)


def to_document(value: Any) -> Any:
    """Document of a dataclass: values of JSON, without those as by default."""
    if isinstance(value, tuple):
        return [to_document(item) for item in value]
    if not is_dataclass(value):
        return value
    own = {one.name: (getattr(value, one.name), one.default) for one in fields(value)}
    return {name: to_document(part) for name, (part, default) in own.items() if part != default}


def schema_of(kind: Any, **made: Any) -> dict[str, Any]:
    """JSON schema (draft 7) of what `from_document` takes for a dataclass.

    What its fields do and may be is said by their parameters; `made` has fields that are read by
    others.
    """
    required, _ = _keys(kind)
    known, properties = parameters_of(kind), {}
    for name, hint in _hints(kind).items():
        one = known.get(name)
        told = {} if one is None else {"description": one.sentence}
        properties[name] = {**told, **(made.get(name) or _schema(hint, one))}
    return object_schema(properties, required)


def object_schema(properties: dict[str, Any], required: Sequence[str] = ()) -> dict[str, Any]:
    """An object with these keys and no other ones."""
    found = {"type": "object", "additionalProperties": False, "properties": properties}
    return {**found, "required": list(required)} if required else found


def or_null(schema: dict[str, Any]) -> dict[str, Any]:
    """Schema that takes null, too."""
    return {"anyOf": [schema, {"type": "null"}]}


def list_of(schema: dict[str, Any], count: int | None = None) -> dict[str, Any]:
    """Schema of a list, of `count` items where that is given."""
    found = {"type": "array", "items": schema}
    return found if count is None else {**found, "minItems": count, "maxItems": count}


def _schema(hint: Any, one: Parameter | None) -> dict[str, Any]:
    """JSON schema of what `_typed` takes."""
    if get_origin(hint) in (Union, types.UnionType):
        (inner,) = (each for each in get_args(hint) if each is not type(None))
        return or_null(_schema(inner, one))
    if is_dataclass(hint):
        return schema_of(hint)
    if get_origin(hint) is tuple:
        first, *others = get_args(hint)
        count = None if others == [...] else 1 + len(others)
        return list_of(_schema(first, one), count)
    if one is not None and (one.names or one.is_number):
        return one.schema()
    return {"type": {float: "number", bool: "boolean"}.get(hint, "string")}


@cache
def _hints(kind: Any) -> dict[str, Any]:
    # Of the fields only: Python 3.10 refuses the mark KW_ONLY as a type.
    own = {field.name: field.type for field in fields(kind)}
    names = vars(sys.modules[kind.__module__])
    return get_type_hints(types.SimpleNamespace(__annotations__=own), names)


def _keys(kind: Any) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """The keys that are needed, and the others."""
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
