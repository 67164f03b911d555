"""A parameter of the method or of a stent: its effect and its range, defined once
for all readers."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import MISSING, dataclass, field, fields
from typing import Any

from .validation import InputError, as_number


@dataclass(frozen=True)
class Parameter:
    """The effect and the possible values of a number, a name or a switch. Immutable.

    Settings are checked by it; options, plans and their schema, reports and the panel read it.

    Attributes
    ----------
    does : str
        The effect as a sentence, without its first capital and its full stop.
    unit : str
        The unit of a number; empty if it has none.
    least, most : float, optional
        The range of a number; None if the parameter is not a number.
    above : float, optional
        A lower bound in place of `least`; the bound itself does not belong to the range.
    may_be_zero : bool
        Whether zero belongs to the range, too, and stands for "not at all".
    is_optional : bool
        Whether None is allowed, and stands for "by the rule".
    names : tuple of str
        The possible values of a choice.
    option : str
        The option of the command line, without its dashes; empty if there is none. It turns a
        switch away from its default.
    called : str
        The name in error messages; by default the name of the field.
    """

    does: str
    unit: str = ""
    least: float | None = None
    above: float | None = None
    most: float | None = None
    may_be_zero: bool = False
    is_optional: bool = False
    names: tuple[str, ...] = ()
    option: str = ""
    called: str = ""

    @property
    def is_number(self) -> bool:
        """Whether it is neither a choice nor a switch nor a text."""
        return self.most is not None

    @property
    def lowest(self) -> float:
        """The low end of the range of a number, zero included."""
        assert self.least is not None
        return 0.0 if self.may_be_zero else self.least

    def number(self, value: Any, name: str) -> float | None:
        """The value as a float within the range; raises `InputError`, with the name, for anything
        else."""
        if value is None and self.is_optional:
            return None
        if not self.may_be_zero:
            return as_number(
                value,
                name,
                unit=self.unit,
                above=self.above,
                minimum=self.least,
                maximum=self.most,
            )
        number = as_number(value, name, unit=self.unit, minimum=0, maximum=self.most)
        if number and self.least is not None and number < self.least:
            raise InputError(
                f"{name}: expected 0 or at least {self.least:g} ({self.unit}), got {value!r}; "
                "0 is none at all."
            )
        return number

    def choice(self, value: Any, name: str) -> str:
        """The value, if it is one of the names; raises `InputError` for anything else."""
        if value not in self.names:
            raise InputError(f"{name}: expected one of {', '.join(self.names)}, got {value!r}.")
        return str(value)

    @property
    def sentence(self) -> str:
        """The effect as a sentence, for a document that describes the parameter."""
        unit = f" ({self.unit})" if self.unit else ""
        return f"{self.does[0].upper()}{self.does[1:]}{unit}."

    def schema(self) -> dict[str, Any]:
        """The JSON schema (draft 7) of the possible values, except None."""
        if self.names:
            return {"enum": list(self.names)}
        if not self.is_number:
            return {"type": "boolean"}
        found: dict[str, Any] = {"type": "number", "maximum": self.most}
        if self.above is not None:
            return {**found, "exclusiveMinimum": self.above}
        if self.may_be_zero and self.least:
            return {**found, "anyOf": [{"const": 0}, {"minimum": self.least}]}
        return {**found, "minimum": self.lowest}


def parameter(does: str, default: Any = MISSING, **more: Any) -> Any:
    """Field of a dataclass with a parameter; it is optional if None is its default.

    Other arguments are those of `Parameter`.
    """
    one = Parameter(does, is_optional=default is None, **more)
    return field(default=default, metadata={"parameter": one})


def parameters_of(kind: Any) -> dict[str, Parameter]:
    """The parameters among the fields of a dataclass, by name, in their order."""
    own = {one.name: one.metadata.get("parameter") for one in fields(kind)}
    return {name: found for name, found in own.items() if found is not None}


def check_parameters(values: Any, label: str = "") -> None:
    """Refuse numbers of a dataclass, also in tuples, that are out of their range; raises
    `InputError`."""
    for name, one in parameters_of(values).items():
        if one.is_number:
            for value in _flat(getattr(values, name)):
                one.number(value, f"{label}{one.called or name}")


def _flat(value: Any) -> Iterator[Any]:
    if isinstance(value, tuple):
        for part in value:
            yield from _flat(part)
    else:
        yield value
