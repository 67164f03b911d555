"""A flat drawing as a list of marks: written as SVG here, painted into a PNG by `painting`."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Sequence
from html import escape
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...validation import printable
from .gray_png import gray_png

INK = "#212933"
GRAY = "#6b7580"


class Stroke(NamedTuple):
    """A polyline; `dashes` are the lengths of dash and gap."""

    points: Sequence[tuple[float, float]]
    color: str = INK
    width: float = 1.0
    dashes: tuple[float, float] | None = None


class Words(NamedTuple):
    """A line of text; `y` is its baseline, `is_upright` turns it to read upward."""

    text: str
    x: float
    y: float
    size: float = 13
    color: str = INK
    anchor: Literal["start", "middle", "end"] = "middle"
    is_bold: bool = False
    is_upright: bool = False


class Box(NamedTuple):
    """A filled rectangle; `x` and `y` are its left upper corner."""

    x: float
    y: float
    width: float
    height: float
    color: str


class Disc(NamedTuple):
    """A filled circle."""

    x: float
    y: float
    radius: float
    color: str


class Photo(NamedTuple):
    """A picture in gray; `x` and `y` are its left upper corner."""

    gray: NDArray[np.uint8]
    """(rows, columns), 0 is black."""
    x: float
    y: float
    width: float
    height: float


Mark = Stroke | Words | Box | Disc | Photo


class Drawing(NamedTuple):
    """Marks on white paper, in pixels from the left upper corner; later ones lie on top."""

    width: int
    height: int
    marks: tuple[Mark, ...]
    title: str = ""


def shifted(marks: Sequence[Mark], down: float) -> list[Mark]:
    """The marks further down the page."""
    moved: list[Mark] = []
    for mark in marks:
        if isinstance(mark, Stroke):
            moved.append(mark._replace(points=[(x, y + down) for x, y in mark.points]))
        else:
            moved.append(mark._replace(y=mark.y + down))
    return moved


def svg(drawing: Drawing) -> str:
    """The drawing as an `<svg>` that stands alone or in a page."""
    lines = "\n".join(
        [
            f"<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {drawing.width} "
            f"{drawing.height}' role='img' font-family='system-ui,sans-serif'>"
            f"<title>{escape(drawing.title)}</title>",
            *map(_element, drawing.marks),
            "</svg>",
        ]
    )
    return printable(lines)


def _element(mark: Mark) -> str:
    if isinstance(mark, Stroke):
        corners = " ".join(f"{x:.2f},{y:.2f}" for x, y in mark.points)
        dashes = "stroke-dasharray='{:g} {:g}' ".format(*mark.dashes) if mark.dashes else ""
        return (
            f"<polyline points='{corners}' fill='none' stroke='{mark.color}' "
            f"stroke-width='{mark.width:g}' {dashes}stroke-linejoin='round'/>"
        )
    if isinstance(mark, Box):
        return (
            f"<rect x='{mark.x:.2f}' y='{mark.y:.2f}' width='{mark.width:.2f}' "
            f"height='{mark.height:.2f}' fill='{mark.color}'/>"
        )
    if isinstance(mark, Disc):
        return (
            f"<circle cx='{mark.x:.2f}' cy='{mark.y:.2f}' r='{mark.radius:g}' fill='{mark.color}'/>"
        )
    place = f"x='{mark.x:.2f}' y='{mark.y:.2f}'"
    if isinstance(mark, Photo):
        data = b64encode(gray_png(mark.gray)).decode()
        return (
            f"<image {place} width='{mark.width:.2f}' height='{mark.height:.2f}' "
            f"href='data:image/png;base64,{data}'/>"
        )
    if mark.is_upright:
        place = f"transform='translate({mark.x:.2f} {mark.y:.2f}) rotate(-90)'"
    weight = "font-weight='600' " if mark.is_bold else ""
    start = f"<text {place} font-size='{mark.size:g}' {weight}text-anchor='{mark.anchor}' "
    text = f"{escape(mark.text)}</text>"
    # White around the letters keeps them readable on a curve; an element of its own, because
    # not every program that shows SVG knows `paint-order`.
    halo = f"{start}stroke='#fff' stroke-width='4' fill='#fff'>{text}" if mark.is_bold else ""
    return f"{halo}{start}fill='{mark.color}'>{text}"
