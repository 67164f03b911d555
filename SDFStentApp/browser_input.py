"""Messages of a browser about its view and the mouse over it, passed on only if a real screen and
hand can produce them.

VTK believes every message: a side of 1e9 pixels takes all memory, a camera moved by NaN draws
nothing again, and a list in the place of a number ends the process.
"""

from __future__ import annotations

from typing import Any

from trame_rca.view_adapter import RcaViewAdapter

MOST = 16_384
"""Largest size of a view and distance from its corner, pixels: no screen has more. Turns of the
wheel and angles are below it, too."""

RATIOS = (0.1, 10.0)
"""Smallest and largest ratio of a screen's pixels to those of the page."""

FACTORS = (0.01, 100.0)
"""Smallest and largest factor by which the distance of two fingers changes; fingers that began at
one place had none."""

UNHEARD = {"LongTap"}
"""Kinds of events that VTK does not know and complains about."""

LONGEST_WORD = 64
MOST_FINGERS = 20

NUMBERS = {"w", "h", "x", "y", "z", "spinX", "spinY", "pixelX", "pixelY", "rotation", "keyCode"}
FLAGS = {"shiftKey", "altKey", "ctrlKey", "controlKey", "metaKey"}
WORDS = {"type", "key"}


class BrowserInput(RcaViewAdapter):
    """The view's adapter, which leaves out impossible messages."""

    def update_size(self, origin: str, size: Any) -> None:
        sides = size if isinstance(size, dict) else {}
        is_size = all(is_number(sides.get(side), 0, MOST) for side in ("w", "h"))
        if is_size and is_number(sides.get("p", 1), *RATIOS):
            super().update_size(origin, sides)

    def on_interaction(self, origin: str, event: Any) -> None:
        known = known_event(event)
        if known is not None:
            super().on_interaction(origin, known)


def known_event(event: Any) -> dict[str, Any] | None:
    """The known parts of an event of mouse, keys or fingers; None if one of them is impossible."""
    if not isinstance(event, dict) or "type" not in event:
        return None
    known = {name: event[name] for name in event if name in CHECKS}
    is_known = all(CHECKS[name](value) for name, value in known.items())
    return known if is_known and known["type"] not in UNHEARD else None


def is_number(value: Any, least: float = -MOST, most: float = MOST) -> bool:
    """Whether a value is a number between two others."""
    is_one = isinstance(value, int | float) and not isinstance(value, bool)
    return is_one and least <= value <= most


def _is_flag(value: Any) -> bool:
    return value in (0, 1)


def _is_word(value: Any) -> bool:
    return isinstance(value, str) and len(value) <= LONGEST_WORD


def _is_factor(value: Any) -> bool:
    return is_number(value, *FACTORS)


def _are_two(value: Any) -> bool:
    return isinstance(value, list | tuple) and len(value) == 2 and all(map(is_number, value))


def _are_fingers(value: Any) -> bool:
    return (
        isinstance(value, dict)
        and len(value) <= MOST_FINGERS
        and all(isinstance(place, dict) and set(place) >= {"x", "y"} for place in value.values())
        and all(is_number(number) for place in value.values() for number in place.values())
    )


CHECKS = {
    **dict.fromkeys(NUMBERS, is_number),
    **dict.fromkeys(FLAGS, _is_flag),
    **dict.fromkeys(WORDS, _is_word),
    **dict.fromkeys(("factor", "scale"), _is_factor),
    "translation": _are_two,
    "positions": _are_fingers,
}
