"""A parameter of the method or of a stent: what it does and may be, said once for all who ask."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import MISSING, dataclass, field, fields
from typing import Any

from .validation import InputError, as_number


@dataclass(frozen=True)
class Parameter:
    """What a number, a name or a switch does and may be. Immutable.

    Settings check themselves by it; options, plans and their schema, reports and the panel read it.

    Attributes
    ----------
    does : str
        A sentence without its first capital and its end.
    unit : str
        Of a number; empty without one.
    least, most : float, optional
        Of a number; None for what is none.
    above : float, optional
        In place of the least, which does not belong to the range itself.
    may_be_zero : bool
        Zero belongs to the range, too, and stands for "not at all".
    is_optional : bool
        None stands for "by the rule".
    names : tuple of str
        The names that a choice knows.
    option : str
        Of the command line, without its dashes; empty where there is none. It turns a switch to
        what is not its default.
    called : str
        What a complaint calls it; its name where left out.
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
        """A value as a float of the range; `InputError`, with the name, for anything else."""
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
        """A value that is one of the names; `InputError` for anything else."""
        if value not in self.names:
            raise InputError(f"{name}: expected one of {', '.join(self.names)}, got {value!r}.")
        return str(value)

    @property
    def sentence(self) -> str:
        """What it does, for a document that describes it."""
        unit = f" ({self.unit})" if self.unit else ""
        return f"{self.does[0].upper()}{self.does[1:]}{unit}."

    def schema(self) -> dict[str, Any]:
        """The values that it takes in a JSON schema (draft 7), None left aside."""
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
    """A dataclass's field that is a parameter, optional with None for a default.

    Other arguments as of `Parameter`.
    """
    one = Parameter(does, is_optional=default is None, **more)
    return field(default=default, metadata={"parameter": one})


def parameters_of(kind: Any) -> dict[str, Parameter]:
    """The parameters among the fields of a dataclass, by name, in their order."""
    own = {one.name: one.metadata.get("parameter") for one in fields(kind)}
    return {name: found for name, found in own.items() if found is not None}


def check_parameters(values: Any, label: str = "") -> None:
    """Refuse numbers out of their range in a dataclass, those in tuples, too; `InputError`."""
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
