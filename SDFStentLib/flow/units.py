"""Units of flow and of time: of a value such as 2.5L/min, and of a column such as q_ml_min."""

from __future__ import annotations

import re

from ..units import MOST_FLOW
from ..validation import InputError, as_number

VOLUMES = {"ml": 1.0, "dl": 100.0, "l": 1000.0, "cc": 1.0, "cm3": 1.0, "m3": 1e6}
"""Milliliters in the units of volume."""

TIMES = {"s": 1.0, "sec": 1.0, "ms": 1e-3, "msec": 1e-3, "min": 60.0}
"""Seconds in the units of time."""

FLOW_UNITS = "mL/s, mL/min, dL/min, L/min, cm3/s or m3/s"
TIME_UNITS = "s, ms or min"
"""Accepted units, in words."""

_BARE = ("", "t", "time")
"""Headers of a column of time without a unit: s, as documented."""

_VALUE = re.compile(r"([-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?)\s*(.*)", re.IGNORECASE)

_MOST_CYCLE = 600.0
"""s."""

_SIGNS = str.maketrans(
    {"³": "3", "⁻": "-", "\N{MINUS SIGN}": "-", "¹": "1", "^": "", "·": " ", "⋅": " ", "*": " "}
)
"""Letters for the signs in exponents and products."""

_PER = (
    (re.compile(r"[\s._]*(?<![a-z])(sec|s|min) ?-1(?!\d)"), r"/\1"),
    (re.compile(r"(?<=[a-z3])[\s_]+per[\s_]+(?=[a-z])"), "/"),
    (re.compile(r"(?<![a-z])(m?l)pm(?![a-z])"), r"\1/min"),
)
"""Other forms of a quotient: mL min-1, mL per min, lpm."""


def flow_value(text: str, name: str = "flow", *, may_be_zero: bool = False) -> float:
    """A flow with its unit, such as 41.7mL/s or 2.5L/min, in mL/s.

    Raises
    ------
    InputError
        No number, no unit, another unit, or a flow that is not positive.
    """
    number, unit = _parts(text)
    volume, time = (part.strip() for part in unit.partition("/")[::2])
    if not number or volume not in VOLUMES or time not in TIMES:
        raise InputError(
            f"{name}: expected a flow with its unit, such as 41.7mL/s or 2.5L/min, got "
            f"{text.strip()!r}; write {FLOW_UNITS} behind the number, without a space."
        )
    value = float(number) * (VOLUMES[volume] / TIMES[time])
    least = {"minimum": 0} if may_be_zero else {"above": 0}
    return as_number(value, name, unit="mL/s", maximum=MOST_FLOW, **least)


def time_value(text: str, name: str = "time") -> float:
    """A time with its unit, such as 0.8s or 800ms, in s; errors as of `flow_value`."""
    number, unit = _parts(text)
    if not number or unit not in TIMES:
        raise InputError(
            f"{name}: expected a time with its unit, such as 0.8s or 800ms, got {text.strip()!r}; "
            f"write {TIME_UNITS} behind the number, without a space."
        )
    value = float(number) * TIMES[unit]
    return as_number(value, name, unit="s", above=0, maximum=_MOST_CYCLE)


def flow_column(header: str) -> float | None:
    """Milliliters a second in the unit of a column of flow; None where it names no unit.

    Such as mL/s, flow_mL/s, q_ml_min or Flow [L/min].

    Raises
    ------
    InputError
        A unit that is none of flow.
    """
    words = _words(header)
    volume, time = words[-2:] if len(words) > 1 else ("", "")
    if volume in VOLUMES and time in TIMES:
        return VOLUMES[volume] / TIMES[time]
    if re.search(r"[/\[(]", header) or (words and words[-1] in TIMES):
        raise InputError(
            f"expected a flow in {FLOW_UNITS} in the second column, got {header.strip()!r}; "
            "convert it, or correct its header."
        )
    return None


def time_column(header: str) -> float:
    """Seconds in the unit of a column of time, such as s, t_ms or Time [ms]; bare `time` is in s.

    Raises
    ------
    InputError
        A header that is none of a time in a unit that is known.
    """
    words = _words(header)
    if words and words[-1] in TIMES and not VOLUMES.keys() & words[-2:-1]:
        return TIMES[words[-1]]
    if header.strip().lower() in _BARE:
        return 1.0
    raise InputError(
        f"expected a time in {TIME_UNITS} in the first column, such as time_s or Time [ms], got "
        f"{header.strip()!r}; convert it, or correct its header."
    )


def _parts(text: str) -> tuple[str, str]:
    """The number and the unit of a value; nothing where it begins with none."""
    found = _VALUE.fullmatch(_plain(text))
    return ("", "") if found is None else (found[1], found[2])


def _plain(text: str) -> str:
    """Text in lower case, with units as quotients."""
    plain = text.strip().lower().translate(_SIGNS)
    for written, quotient in _PER:
        plain = written.sub(quotient, plain)
    return plain


def _words(header: str) -> list[str]:
    """Words of a header: letters and digits between anything else."""
    return re.findall(r"[^\W_]+", _plain(header))
