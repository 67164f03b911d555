"""The map of all angles: how much lies over a stretch, and where it is foreshortened."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...validation import Floats
from ...view import ViewMap
from ..picture.drawing import GRAY, INK, Box, Disc, Mark, Stroke, Words
from .facts import ToldViews

LEVELS = (0.1, 0.2, 0.4)
"""Shares foreshortened, and covered, that are drawn as lines: from what a computed view keeps below
to what views chosen by eye had at most (Green et al., Catheter Cardiovasc Interv 2005: 0 to
50 %)."""

LINE, COVER = "#08519c", (179, 88, 6)
"""Colors of the lines, and of covered parts."""


def map_marks(told: ToldViews, left: float, top: float, width: float) -> list[Mark]:
    """The map, RAO to LAO from left to right and CRA above CAU, below its heading."""
    grid = told.found.map
    step = width / len(grid.primary)
    marks: list[Mark] = [*_cells(grid, left, top, step)]
    marks += _lines(grid.covered, _color(1.0), left, top, step)
    marks += _lines(grid.foreshortening, LINE, left, top, step)
    marks += _axes(grid, left, top, step)
    place = _Placed(grid, left, top, step)
    views = [("1", told.found.best), ("2", told.found.second), ("x", told.found.worst)]
    for name, seen in views:
        if seen is not None:
            x, y = place(*seen.view)
            marks += [Disc(x, y, 9, "#ffffff"), Words(name, x, y + 5, 14, INK, is_bold=True)]
    bottom = top + step * len(grid.secondary)
    levels = ", ".join(f"{100 * level:.0f} %" for level in LEVELS)
    note = f"blue lines: foreshortened {levels}, the thicker the more"
    marks.append(Words(note, left, bottom + 62, 13, LINE, "start"))
    note = "brown, and lines for the same: under other vessels; gray: not reached"
    marks.append(Words(note, left, bottom + 82, 13, _color(1.0), "start"))
    note = "1, 2: best and second view, x: the worst"
    marks.append(Words(note, left, bottom + 102, 13, INK, "start"))
    return marks


def map_height(told: ToldViews, width: float) -> int:
    """The height of the map and the words below it."""
    grid = told.found.map
    return int(width * len(grid.secondary) / len(grid.primary)) + 112


class _Placed:
    """Places of angles on the map."""

    def __init__(self, grid: ViewMap, left: float, top: float, step: float) -> None:
        self._grid, self._corner, self._step = grid, (left, top), step

    def __call__(self, primary: float, secondary: float) -> tuple[float, float]:
        at = (
            np.interp(primary, self._grid.primary, np.arange(len(self._grid.primary))),
            np.interp(-secondary, self._grid.secondary, np.arange(len(self._grid.secondary))),
        )
        x, y = (
            float(first + (one + 0.5) * self._step)
            for first, one in zip(self._corner, at, strict=True)
        )
        return x, y


def _cells(grid: ViewMap, left: float, top: float, step: float) -> Iterator[Mark]:
    for row, column in np.ndindex(len(grid.secondary), len(grid.primary)):
        place = column, len(grid.secondary) - 1 - row
        color = _color(float(grid.covered[place])) if grid.is_reached[place] else "#d0d0d0"
        yield Box(left + column * step, top + row * step, step + 0.5, step + 0.5, color)


def _color(share: float) -> str:
    """The color of a share, from white to brown."""
    mixed = (255 + share * (np.array(COVER) - 255)).astype(int).tolist()
    return "#" + bytes(mixed).hex()


def _lines(shares: Floats, color: str, left: float, top: float, step: float) -> Iterator[Mark]:
    for level in LEVELS:
        for start, end in contour(shares[:, ::-1].T, level):
            corners = [
                (float(left + (x + 0.5) * step), float(top + (y + 0.5) * step))
                for y, x in (start, end)
            ]
            yield Stroke(corners, color, 1.0 + level * 4)


def contour(values: Floats, level: float) -> Floats:
    """The pieces (k, 2, 2) of a contour of values (r, c) on a grid, as rows and columns.

    Two triangles to a cell: each that has corners on both sides has one piece.
    """
    rows, columns = np.meshgrid(*(np.arange(n) for n in values.shape), indexing="ij")
    places = np.stack([rows, columns], axis=-1).astype(np.float64)
    corners = [
        (slice(None, -1), slice(None, -1)),
        (slice(None, -1), slice(1, None)),
        (slice(1, None), slice(None, -1)),
        (slice(1, None), slice(1, None)),
    ]
    pieces = []
    for three in ((0, 1, 2), (3, 2, 1)):
        at = np.stack([places[corners[k]].reshape(-1, 2) for k in three], axis=1)
        high = np.stack([values[corners[k]].ravel() for k in three], axis=1) - level
        for lone in range(3):
            first, second = (lone + 1) % 3, (lone + 2) % 3
            above = high >= 0
            own = (above[:, lone] != above[:, first]) & (above[:, lone] != above[:, second])
            ends = [
                at[own, lone]
                + (high[own, lone] / (high[own, lone] - high[own, to]))[:, None]
                * (at[own, to] - at[own, lone])
                for to in (first, second)
            ]
            pieces.append(np.stack(ends, axis=1))
    return np.concatenate(pieces)


def _axes(grid: ViewMap, left: float, top: float, step: float) -> Iterator[Mark]:
    place = _Placed(grid, left, top, step)
    bottom = top + step * len(grid.secondary)
    for angle in range(-90, 91, 30):
        if grid.primary[0] <= angle <= grid.primary[-1]:
            x, _ = place(angle, 0)
            name = f"{'RAO' if angle < 0 else 'LAO'} {abs(angle)}"
            yield Stroke([(x, bottom), (x, bottom + 5)])
            yield Words(name, x, bottom + 20, 12, GRAY)
    for angle in range(-40, 41, 20):
        if grid.secondary[0] <= angle <= grid.secondary[-1]:
            _, y = place(0, angle)
            name = f"{'CAU' if angle < 0 else 'CRA'} {abs(angle)}"
            yield Words(name, left - 6, y + 4, 12, GRAY, "end")
