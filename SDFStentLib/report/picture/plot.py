"""Values along a vessel, before and after: diameters in page, SVG and PNG, and flow in 3D."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from ..branches import again_words
from ..stents import stent_titles
from ..words import plain
from .drawing import GRAY, INK, Box, Disc, Drawing, Mark, Stroke, Words, shifted

_WIDTH, _HEIGHT, _FLAT = 820, 380, 300
_LEFT, _RIGHT, _TOP, _BOTTOM = 62, 14, 62, 48
_HEADING = 30
"""Height of the line above a plot with its stent's name, where it has one."""

_BEFORE, _AFTER, _PRESCRIBED = "#b35806", "#08519c", "#111111"
"""Colors that also readers who confuse red with green tell apart."""

_FREE, _STRIP = "#f0b400", 8
"""Color of the stretches without contact, and height of the stent on the floor of the plot."""

_CURVES = (
    ("mis_before_mm", "before, inscribed sphere", _BEFORE, None, 2.6),
    ("equivalent_before_mm", "before, equivalent", _BEFORE, (2, 4), 1.6),
    ("mis_after_mm", "after, inscribed sphere", _AFTER, None, 2.6),
    ("equivalent_after_mm", "after, equivalent", _AFTER, (2, 4), 1.6),
    ("prescribed_mm", "prescribed", _PRESCRIBED, (9, 5), 1.5),
)
"""Curves in the order of the legend, two in a column."""


AS_WIDE = 0.97
"""Part of the prescribed diameter from which on it counts as reached."""

SPHERE_HELD = (
    "Where the stent widens the sphere is held by the narrower wall beside it: smaller than "
    "prescribed, while the section is not."
)

FROM_STENT = "position from the proximal end of the stent, proximal to distal (mm)"
FROM_INLET = "along the centerline, from the inlet (mm)"

_SIDEWAYS = (0, -70, 70)
"""Offsets by which words may be moved off what lies under them, pixels."""


def stent_plot(document: Mapping[str, Any], stent: Mapping[str, Any]) -> Drawing | None:
    """The plot of one of the stents of a report document; None where nothing is known."""
    stretches = [one for one in document["apposition"] if one["stent"] == stent["number"]]
    return diameter_plot(stent["diameters"], stretches, stent.get("dilated_again_as"))


def diameter_plot(
    diameters: Mapping[str, Any],
    stretches: Sequence[Mapping[str, Any]] = (),
    again: int | None = None,
) -> Drawing | None:
    """The plot of the section `diameters` of a report document; None where nothing is known.

    A curve is interrupted where a diameter is not known. The narrowest places of the stent are
    marked. On the floor lies the stent, with the `stretches` where it touches no wall; one that is
    dilated `again`, as the stent of that number, lies there no more, and words say so.
    """
    along = diameters["along"]
    positions: list[float] = along["arc_length_mm"]
    known = [value for key, *_ in _CURVES for value in along[key] if value is not None]
    if not known or not positions:
        return None
    across = _Scale(positions[0], max(positions[-1], positions[0] + 1e-9), _LEFT, _WIDTH - _RIGHT)
    # From zero, so that heights compare as diameters do.
    up = _Scale(0.0, _round_up(max(known)), _HEIGHT - _BOTTOM, _TOP)
    first, last = (across(end) for end in diameters["stent_ends_mm"])
    marks = [*_beyond(first, last), *_grid(across, up, FROM_STENT, "lumen diameter (mm)")]
    marks += _strip(first, last, across, stretches) if again is None else _gone(first, last, again)
    curves = [
        Stroke([(across(position), up(value)) for position, value in piece], color, width, dashes)
        for key, _, color, dashes, width in (*_CURVES[1:4:2], *_CURVES[0:3:2], *_CURVES[4:])
        for piece in _pieces(positions, along[key])
    ]
    marks += curves
    marks += [*_minimum_marks(diameters["minimum_lumen"], across, up, marks), *_legend()]
    title = "Lumen diameter along the stent before and after"
    if not _sphere_is_held(along):
        return Drawing(_WIDTH, _HEIGHT, tuple(marks), title)
    marks.append(Words(SPHERE_HELD, _WIDTH / 2, _HEIGHT + 12, 12, GRAY))
    return Drawing(_WIDTH, _HEIGHT + 20, tuple(marks), title)


def along_plot(
    positions: Sequence[float], values: Mapping[str, Sequence[float | None]], words: str
) -> Drawing:
    """Values before and after along the centerline, mm; interrupted where they are not known."""
    known = [one for name in values for one in plain(values[name]) if one is not None]
    low, high = min([0.0, *known]), max([0.0, *known])
    across = _Scale(0.0, max(float(positions[-1]), 1e-9), _LEFT, _WIDTH - _RIGHT)
    up = _Scale(low, high if high > low else low + 1.0, _FLAT - _BOTTOM, 34)
    marks = [*_grid(across, up, FROM_INLET, words)]
    for start, name, color in ((72, "before", _BEFORE), (192, "after", _AFTER)):
        for piece in _pieces(plain(positions), plain(values[name])):
            marks.append(Stroke([(across(at), up(one)) for at, one in piece], color, 2.6))
        marks.append(Stroke([(start, 16), (start + 30, 16)], color, 2.6))
        marks.append(Words(name, start + 38, 20, anchor="start"))
    return Drawing(_WIDTH, _FLAT, tuple(marks), f"{words} along the centerline")


def _sphere_is_held(along: Mapping[str, Any]) -> bool:
    """Whether a section is as wide as a shape prescribes and no sphere fits in, as in a flare."""
    places = [
        place
        for place in zip(
            along["prescribed_mm"],
            along["mis_after_mm"],
            along["equivalent_after_mm"],
            strict=True,
        )
        if None not in place
    ]
    wanted = [place[0] for place in places]
    is_shaped = bool(wanted) and max(wanted) > min(wanted) / AS_WIDE
    return is_shaped and any(
        sphere < AS_WIDE * prescribed <= section for prescribed, sphere, section in places
    )


def figure(document: Mapping[str, Any]) -> Drawing:
    """The plots of all stents of a report document, one below the other."""
    stents, height = document["stents"], 0
    marks: list[Mark] = []
    for title, stent in zip(stent_titles(stents), stents, strict=True):
        plot = stent_plot(document, stent)
        words = title if plot else f"{title}: no diameter could be measured"
        marks.append(Words(words, _LEFT, height + 20, 16, anchor="start", is_bold=True))
        height += _HEADING
        if plot:
            marks += shifted(plot.marks, height)
            height += plot.height
    marks.append(Words(document["notice"], _WIDTH / 2, height + 16, 11, GRAY))
    return Drawing(_WIDTH, height + 28, tuple(marks), "Lumen diameters before and after")


class _Scale:
    """Linear map from values to the picture."""

    def __init__(self, low: float, high: float, start: float, end: float) -> None:
        self.low, self.high, self.start, self.end = low, high, start, end

    def __call__(self, value: float) -> float:
        fraction = (value - self.low) / (self.high - self.low)
        return self.start + fraction * (self.end - self.start)

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


def _grid(across: _Scale, up: _Scale, along: str, upright: str) -> Iterator[Mark]:
    right, floor = across.end, up.start
    for tick in up.ticks():
        y = up(tick)
        yield Stroke([(_LEFT, y), (right, y)], "#dddddd")
        yield Words(f"{tick:g}", _LEFT - 8, y + 4, anchor="end")
    for tick in across.ticks():
        x = across(tick)
        yield Stroke([(x, floor), (x, floor + 5)])
        yield Words(f"{tick:g}", x, floor + 19)
    yield Stroke([(_LEFT, up.end), (_LEFT, floor), (right, floor)])
    yield Words(along, (_LEFT + right) / 2, floor + _BOTTOM - 8)
    yield Words(upright, 18, (up.end + floor) / 2, is_upright=True)


def _beyond(first: float, last: float) -> Iterator[Mark]:
    """The vessel proximal and distal of the stent lies on gray."""
    floor, right = _HEIGHT - _BOTTOM, _WIDTH - _RIGHT
    for left, end, words in ((_LEFT, first, "proximal"), (last, right, "distal")):
        if end > left:
            yield Box(left, _TOP, end - left, floor - _TOP, "#f1f2f4")
        if end > left + 60:
            yield Words(words, (left + end) / 2, _TOP + 16, 12, GRAY)


def _strip(
    first: float, last: float, across: _Scale, stretches: Sequence[Mapping[str, Any]]
) -> Iterator[Mark]:
    """Marks of the stent, and of its parts that touch no wall."""
    floor = _HEIGHT - _BOTTOM
    yield Box(first, floor - _STRIP, last - first, _STRIP, "#8a939c")
    for one in stretches:
        start, end = across(one["start_mm"]), across(one["end_mm"])
        yield Box(start, floor - _STRIP, end - start, _STRIP, _FREE)
    free = sum(one["end_mm"] - one["start_mm"] for one in stretches)
    words = f"the stent; yellow: not in contact all round, {free:.1f} mm" if free else "the stent"
    yield Words(words, (first + last) / 2, floor - _STRIP - 5, 12, GRAY)


def _gone(first: float, last: float, again: int) -> Iterator[Mark]:
    """The words in place of a stent that does not lie so in the end."""
    y = _HEIGHT - _BOTTOM - _STRIP - 5
    yield Words(f"the stent, {again_words(again)}", (first + last) / 2, y, 12, GRAY)


def _pieces(
    positions: Sequence[float], values: Sequence[float | None]
) -> Iterator[list[tuple[float, float]]]:
    """Runs of at least two known values."""
    piece: list[tuple[float, float]] = []
    for position, value in [*zip(positions, values, strict=True), (0.0, None)]:
        if value is not None:
            piece.append((position, value))
            continue
        if len(piece) > 1:
            yield piece
        piece = []


def _minimum_marks(
    narrow: Mapping[str, Any], across: _Scale, up: _Scale, drawn: Sequence[Mark]
) -> Iterator[Mark]:
    """The narrowest places, with their numbers below or above them, where least is drawn."""
    taken = list(drawn)
    for when, color in (("before", _BEFORE), ("after", _AFTER)):
        value, position = narrow[f"{when}_mm"], narrow[f"{when}_at_mm"]
        if value is None or position is None:
            continue
        x, y = across(position), up(value)
        words = Words(f"min {value:.2f} mm", x, y + 20, color=color, is_bold=True)
        places = [
            words._replace(x=x + aside, y=y + below) for aside in _SIDEWAYS for below in (20, -12)
        ]
        inside = [one for one in places if _span(one)[0] >= _LEFT and _span(one)[1] <= _WIDTH]
        best = min(inside or places, key=lambda one: _crossed(one, taken))
        taken.append(best)
        yield Disc(x, y, 4.5, color)
        yield best


def _crossed(words: Words, drawn: Sequence[Mark]) -> int:
    """Number of curve corners under the words; words and the stent there count far more."""
    left, right = _span(words)
    top, low = words.y - words.size, words.y + 4
    count = 0
    for mark in drawn:
        if isinstance(mark, Stroke):
            count += sum(left < x < right and top < y < low for x, y in mark.points)
        elif isinstance(mark, Words):
            start, end = _span(mark)
            is_over = start < right and left < end and mark.y - mark.size < low and top < mark.y
            count += 1000 * is_over
        elif isinstance(mark, Box) and mark.height == _STRIP:
            count += 1000 * (mark.x < right and left < mark.x + mark.width and low > mark.y)
    return count


def _span(words: Words) -> tuple[float, float]:
    """Left and right end of words; a letter counts 8 pixels at most."""
    width = 8 * len(words.text) * words.size / 13
    left = words.x - width * ("start", "middle", "end").index(words.anchor) / 2
    return left, left + width


def _legend() -> Iterator[Mark]:
    for number, (_, label, color, dashes, width) in enumerate(_CURVES):
        x, y = _LEFT + 4 + 235 * (number // 2), 14 + 22 * (number % 2)
        yield Stroke([(x, y), (x + 34, y)], color, width, dashes)
        yield Words(label, x + 42, y + 4, color=INK, anchor="start")
