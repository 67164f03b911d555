"""Diameters along the stent as inline SVG."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

_WIDTH, _HEIGHT = 820, 380
_LEFT, _RIGHT, _TOP, _BOTTOM = 62, 14, 62, 48

_BEFORE, _AFTER, _PRESCRIBED = "#b35806", "#08519c", "#111111"
"""Told apart also by readers who do not tell red from green."""

_CURVES = (
    ("equivalent_before_mm", "before, equivalent", _BEFORE, "2 4", 1.6),
    ("equivalent_after_mm", "after, equivalent", _AFTER, "2 4", 1.6),
    ("mis_before_mm", "before, inscribed sphere", _BEFORE, "", 2.6),
    ("mis_after_mm", "after, inscribed sphere", _AFTER, "", 2.6),
    ("prescribed_mm", "prescribed", _PRESCRIBED, "9 5", 1.5),
)

Values = Sequence["float | None"]


def diameter_plot(diameters: Mapping[str, Any]) -> str:
    """An `<svg>` of the diameters in the section `diameters` of a report document.

    A curve is interrupted where a diameter is not known. The narrowest places are marked.
    """
    along = diameters["along"]
    positions: list[float] = along["arc_length_mm"]
    known = [value for key, *_ in _CURVES for value in along[key] if value is not None]
    if not known or not positions:
        return "<p>No diameter could be measured.</p>"
    across = _Scale(positions[0], max(positions[-1], positions[0] + 1e-9), _LEFT, _WIDTH - _RIGHT)
    # From zero, so that heights compare as diameters do.
    up = _Scale(0.0, _round_up(max(known)), _HEIGHT - _BOTTOM, _TOP)
    parts = [
        f"<svg viewBox='0 0 {_WIDTH} {_HEIGHT}' role='img' font-family='system-ui,sans-serif' "
        "font-size='13'><title>Lumen diameter along the stent before and after</title>",
        *_grid(across, up),
    ]
    for key, _, color, dash, width in _CURVES:
        parts += _curve(positions, along[key], across, up, color, dash, width)
    parts += _minimum_marks(diameters["minimum_lumen"], across, up)
    return "\n".join([*parts, *_legend(), "</svg>"])


class _Scale:
    """Linear map from values to the picture."""

    def __init__(self, low: float, high: float, start: float, end: float) -> None:
        self.low, self.high, self.start, self.end = low, high, start, end

    def __call__(self, value: float) -> float:
        fraction = (value - self.low) / (self.high - self.low)
        return round(self.start + fraction * (self.end - self.start), 2)

    def ticks(self) -> list[float]:
        step = _tick_step(self.high - self.low)
        first = math.ceil(self.low / step - 1e-9)
        count = math.floor((self.high - first * step) / step + 1e-9)
        return [step * (first + number) for number in range(count + 1)]


def _tick_step(extent: float) -> float:
    rough = extent / 6
    power = 10.0 ** math.floor(math.log10(rough))
    return power * next(factor for factor in (1, 2, 5, 10) if factor * power >= rough * 0.999)


def _round_up(value: float) -> float:
    step = _tick_step(max(value, 1e-6) * 1.08)
    return step * math.ceil(value * 1.08 / step)


def _grid(across: _Scale, up: _Scale) -> list[str]:
    parts = []
    for tick in up.ticks():
        y = up(tick)
        parts.append(f"<path d='M{_LEFT} {y}H{_WIDTH - _RIGHT}' stroke='#ddd'/>")
        parts.append(f"<text x='{_LEFT - 8}' y='{y + 4}' text-anchor='end'>{tick:g}</text>")
    floor = _HEIGHT - _BOTTOM
    for tick in across.ticks():
        x = across(tick)
        parts.append(f"<path d='M{x} {floor}v5' stroke='#444'/>")
        parts.append(f"<text x='{x}' y='{floor + 19}' text-anchor='middle'>{tick:g}</text>")
    middle = (_LEFT + _WIDTH - _RIGHT) / 2
    parts += [
        f"<path d='M{_LEFT} {_TOP}V{floor}H{_WIDTH - _RIGHT}' fill='none' stroke='#444'/>",
        f"<text x='{middle}' y='{_HEIGHT - 8}' text-anchor='middle'>"
        "position along the stent, proximal to distal (mm)</text>",
        f"<text transform='translate(16 {(_TOP + floor) / 2}) rotate(-90)' "
        "text-anchor='middle'>lumen diameter (mm)</text>",
    ]
    return parts


def _curve(
    positions: Sequence[float],
    values: Values,
    across: _Scale,
    up: _Scale,
    color: str,
    dash: str,
    width: float,
) -> list[str]:
    pieces: list[list[str]] = [[]]
    for position, value in zip(positions, values, strict=True):
        if value is None:
            pieces.append([])
        else:
            pieces[-1].append(f"{across(position)},{up(value)}")
    dashes = f" stroke-dasharray='{dash}'" if dash else ""
    return [
        f"<polyline points='{' '.join(piece)}' fill='none' stroke='{color}' "
        f"stroke-width='{width}' stroke-linejoin='round'{dashes}/>"
        for piece in pieces
        if len(piece) > 1
    ]


def _minimum_marks(narrow: Mapping[str, Any], across: _Scale, up: _Scale) -> list[str]:
    parts = []
    for when, color in (("before", _BEFORE), ("after", _AFTER)):
        value, position = narrow[f"{when}_mm"], narrow[f"{when}_at_mm"]
        if value is None or position is None:
            continue
        x, y = across(position), up(value)
        anchor = "end" if x > _WIDTH * 0.85 else "start" if x < _WIDTH * 0.15 else "middle"
        parts.append(f"<circle cx='{x}' cy='{y}' r='4.5' fill='{color}'/>")
        parts.append(
            f"<text x='{x}' y='{y + 20}' text-anchor='{anchor}' fill='{color}' "
            "font-weight='600' stroke='#fff' stroke-width='4' paint-order='stroke'>"
            f"min {value:.2f} mm</text>"
        )
    return parts


def _legend() -> list[str]:
    parts = []
    for number, (_, label, color, dash, width) in enumerate(sorted(_CURVES, key=_legend_order)):
        x, y = _LEFT + 4 + 235 * (number // 2), 14 + 22 * (number % 2)
        dashes = f" stroke-dasharray='{dash}'" if dash else ""
        parts.append(
            f"<path d='M{x} {y}h34' stroke='{color}' stroke-width='{width}'{dashes}/>"
            f"<text x='{x + 42}' y='{y + 4}'>{label}</text>"
        )
    return parts


def _legend_order(curve: tuple[str, str, str, str, float]) -> int:
    order = ("before, inscribed", "before, eq", "after, inscribed", "after, eq", "prescribed")
    return next(place for place, start in enumerate(order) if curve[1].startswith(start))
