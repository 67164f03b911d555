"""One parameter of the method: what it does and what it may be, said once for everyone who asks."""

from __future__ import annotations

from dataclasses import dataclass
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
    may_be_zero : bool
        Zero belongs to the range, too, and stands for "not at all".
    is_optional : bool
        None stands for "by the rule".
    names : tuple of str
        The names that a choice knows.
    option : str
        Of the command line, without its dashes; empty where there is none. It turns a switch off.
    """

    does: str
    unit: str = ""
    least: float | None = None
    most: float | None = None
    may_be_zero: bool = False
    is_optional: bool = False
    names: tuple[str, ...] = ()
    option: str = ""

    @property
    def lowest(self) -> float:
        """The low end of the range of a number, zero included."""
        assert self.least is not None
        return 0.0 if self.may_be_zero else self.least

    def number(self, value: Any, name: str) -> float | None:
        """A value as a float of the range; `InputError`, with the name, for anything else."""
        if value is None and self.is_optional:
            return None
        if self.lowest == 0:
            number = as_number(value, name, unit=self.unit, minimum=0)
            if number == 0:
                return number
        else:
            number = as_number(value, name, unit=self.unit, above=0)
        if self.may_be_zero and self.least is not None and number < self.least:
            raise InputError(
                f"{name}: expected 0 or at least {self.least:g} ({self.unit}), got {value!r}; "
                "0 is none at all."
            )
        minimum = self.least or None
        return as_number(number, name, unit=self.unit, minimum=minimum, maximum=self.most)

    def choice(self, value: Any, name: str) -> str:
        """A value that is one of the names; `InputError` for anything else."""
        if value not in self.names:
            raise InputError(f"{name}: expected one of {', '.join(self.names)}, got {value!r}.")
        return str(value)

    def schema(self) -> dict[str, Any]:
        """The parameter in a JSON schema (draft 7)."""
        unit = f" ({self.unit})" if self.unit else ""
        sentence = f"{self.does[0].upper()}{self.does[1:]}{unit}."
        found: dict[str, Any] = {"description": sentence}
        if self.names:
            return {**found, "enum": list(self.names)}
        if self.least is None:
            return {**found, "type": "boolean"}
        found["type"] = ["number", "null"] if self.is_optional else "number"
        if self.may_be_zero and self.least > 0:
            return {**found, "anyOf": [{"const": 0}, {"minimum": self.least}], "maximum": self.most}
        return {**found, "minimum": self.lowest, "maximum": self.most}
