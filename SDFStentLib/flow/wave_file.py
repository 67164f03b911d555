"""A wave from a file: which rows are its cycle, whether they repeat the first, and how often."""

from __future__ import annotations

import codecs
import csv
import os
import re
from typing import NamedTuple

import numpy as np

from ..cautions import Caution
from ..validation import Floats, InputError, as_path
from .units import FLOW_UNITS, flow_column, time_column
from .wave import CLOSED, LEAST_ROWS, RATES, Wave, closes

EVEN = 0.05
"""The part of a step by which times that are written in ms may differ from even ones."""

SAME = 1e-5
"""The part of the range by which numbers of five digits or so that are the same may differ."""

ROUNDED = 1e-9
"""The rounding of a number that is calculated."""

MOST_BEATS = 64

_THOUSANDS = re.compile(r"[1-9]\d{0,2}(,\d{3})+")
"""A number whose commas may divide thousands."""

_SAMPLES = 64
"""Samples of a beat, at which it is held against the others."""


class ReadWave(NamedTuple):
    """A wave, and how its rows were taken."""

    wave: Wave
    cautions: tuple[Caution, ...]


class _Rows(NamedTuple):
    time: Floats
    """(n,) s, from 0."""
    flow: Floats
    """(n,) mL/s."""


def read_wave(
    path: str | os.PathLike[str], *, needs_unit: bool = True, cycle: float | None = None
) -> ReadWave:
    """A wave from CSV: a header with a unit of flow, then rows of time and flow; # for comments.

    Its last row repeats the first one, or is the last of as many even steps. Several beats that
    are alike are averaged.

    Parameters
    ----------
    path : path
    needs_unit : bool
        Without a unit its shape alone is known.
    cycle : float, optional
        Length of the cycle, s, where the rows leave that open; rows beyond it are further beats.

    Raises
    ------
    InputError
        A file that cannot be read, no unit or another one, or rows that are no cycle.
    """
    path = as_path(path)
    try:
        cells = _cells(_decoded(path.read_bytes()))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{path}: expected a CSV file, got {error}; correct the path.") from error
    try:
        return _wave(_values(cells, needs_unit), cycle)
    except InputError as error:
        raise error.labeled(f"{path}: ") from error


def _decoded(data: bytes) -> str:
    """Text as spreadsheets write it; only a header has more than digits."""
    if data[:2] in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE):
        return data.decode("utf-16")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("cp1252")


def _cells(text: str) -> list[list[str]]:
    """Rows without comments and empty cells at their ends, decimals with a point.

    Where semicolons or tabs divide columns, and no number has a point, commas are decimal ones.
    """
    lines = [line for line in text.splitlines() if line.strip() and line.lstrip()[0] != "#"]
    told = re.fullmatch("sep=(.)", lines[0].strip(), re.IGNORECASE) if lines else None
    lines = lines[told is not None :]
    divides = (
        told[1] if told else next((c for c in ";\t" if any(c in line for line in lines[1:])), ",")
    )
    rows = []
    for row in csv.reader(lines, delimiter=divides):
        cells = [cell.strip() for cell in row]
        # Ends: each round takes a cell.
        while cells and not cells[-1]:
            cells.pop()
        rows += [cells] if cells else []
    numbers = [cell for row in rows[1:] for cell in row]
    may_be_decimal = divides != "," and not any("." in cell for cell in numbers)
    if divides != ";" and all(_THOUSANDS.fullmatch(cell) for cell in numbers if "," in cell):
        may_be_decimal = False
    return [[cell.replace(",", ".") if may_be_decimal else cell for cell in row] for row in rows]


def _values(rows: list[list[str]], needs_unit: bool) -> _Rows:
    """Rows as numbers in s and mL/s."""
    header = rows[0] if rows and _numbers(rows[0]) is None else []
    values = [_numbers(row) for row in rows[bool(header) :]]
    if len(values) < LEAST_ROWS or None in values or len(header) not in (0, 2):
        raise InputError(
            "expected a header and rows of two numbers, time and flow, at least four of them, "
            "divided by commas (by semicolons or tabs where commas are decimal ones), got others; "
            "correct the file."
        )
    unit = flow_column(header[1]) if header else None
    if unit is None and needs_unit:
        raise InputError(
            "expected a header such as time_s,flow_mL/s that tells the unit of the flow, "
            f"{FLOW_UNITS}, got none; add it, or give the mean flow as well."
        )
    time, flow = np.array(values, dtype=float).T
    time = (time_column(header[0]) if header else 1.0) * time
    if (np.diff(time) <= 0).any():
        raise InputError("wave: expected times that go up, got others; sort the rows.")
    return _Rows(time - time[0], (unit or 1.0) * flow)


def _numbers(row: list[str]) -> tuple[float, float] | None:
    try:
        time, flow = (float(cell) for cell in row)
    except ValueError:
        return None
    return (time, flow) if np.isfinite([time, flow]).all() else None


def _wave(rows: _Rows, cycle: float | None) -> ReadWave:
    cautions = []
    if cycle is None:
        closed = _closed(rows)
        if len(closed.time) > len(rows.time):
            numbers: dict[str, float | str] = {
                "rows": len(rows.time),
                "cycle_s": float(closed.time[-1]),
            }
            cautions.append(Caution("wave-not-repeated", numbers))
        rows, beats = closed, _beats(closed)
    else:
        rows, beats = _filled(rows, cycle)
    if beats > 1:
        cautions.append(_of_beats(rows, beats))
    rows = _folded(rows, beats)
    return ReadWave(Wave(tuple(rows.time.tolist()), tuple(rows.flow.tolist())), tuple(cautions))


def _closed(rows: _Rows) -> _Rows:
    """Rows with the first one repeated at their end.

    It is there where it closes the wave, unless the first and the last row are alike because the
    flow stands still there, or nearly alike only: then the rounder cycle is meant.
    """
    time, flow = rows
    # How well times are known, shows in how even they are.
    known = max(2 * _uneven(time), ROUNDED * time[-1])
    repeated, longer = (_roundness(one, known) for one in (time[-1], time[-1] + _step(time)))
    # Across the seam, and on both sides of it.
    is_same, *stands = np.abs([flow[-1] - flow[0], flow[-1] - flow[-2], flow[1] - flow[0]]) <= (
        SAME * np.ptp(flow)
    )
    if (is_same and not any(stands)) or not _may_go_on(rows):
        is_repeated = True
    elif repeated == longer:
        is_repeated = bool(is_same)
    else:
        is_repeated = repeated < longer
    if not is_repeated:
        time = np.append(time, time[-1] + _step(time))
        return _Rows(time, np.append(flow, flow[0]))
    if not closes(flow):
        raise InputError(
            f"wave: expected one that closes, got {flow[0]:g} mL/s at its begin and {flow[-1]:g} "
            f"mL/s at its end, {time[-1]:g} s later; end it with the flow with which it begins, or "
            "tell how long its cycle is",
            "cycle",
            end=".",
        )
    return rows


def _step(time: Floats) -> float:
    return float(time[-1] / (len(time) - 1))


def _uneven(time: Floats) -> float:
    """The distance of times from even ones, s."""
    return float(np.abs(time - np.linspace(0, time[-1], len(time))).max())


def _may_go_on(rows: _Rows) -> bool:
    """Whether a further step may lead from the last row to the first: their times are even, and
    from row to row it changes as much elsewhere."""
    time, flow = rows
    most = np.abs(np.diff(flow)).max()
    return bool(_uneven(time) <= EVEN * _step(time) and abs(flow[0] - flow[-1]) <= most)


def _roundness(cycle: float, known: float) -> int:
    """Digits that its length, or its rate, needs: people and scanners have round ones, in ms or
    beats. More than three of them are none."""
    return min(_digits(cycle, known / cycle), _digits(60 / cycle, known / cycle))


def _digits(value: float, known: float) -> int:
    """Number of digits, at most four, of a value known to a share of itself."""
    few = (n for n in (1, 2, 3) if abs(float(f"{value:.{n}g}") - value) <= known * value)
    return next(few, 4)


def _beats(rows: _Rows) -> int:
    """The number of beats that are alike into which a closed wave falls."""
    period = rows.time[-1]
    most = min(int(period * RATES[1] / 60), len(rows.time) // LEAST_ROWS, MOST_BEATS)
    for count in range(most, 1, -1):
        apart, size = _apart(rows, count)
        if apart < CLOSED * size:
            return count
    return 1


def _apart(rows: _Rows, count: int) -> tuple[float, float]:
    """Root-mean-square distance of beats from their average, and that one's range."""
    at = np.arange(count * _SAMPLES) * rows.time[-1] / (count * _SAMPLES)
    each = np.interp(at, rows.time, rows.flow).reshape(count, _SAMPLES)
    beat = each.mean(axis=0)
    return float(np.sqrt(np.mean((each - beat) ** 2))), float(np.ptp(beat))


def _of_beats(rows: _Rows, count: int) -> Caution:
    """Caution that beats are averaged; with their distance from it where they are not alike."""
    apart, size = _apart(rows, count)
    told: dict[str, float | str] = {"beats": count, "cycle_s": float(rows.time[-1]) / count}
    if apart < CLOSED * size:
        return Caution("wave-beats", told)
    most = float(rows.flow.max()), float(_folded(rows, count).flow.max())
    return Caution("wave-unlike-beats", told | dict(zip(("most", "peak"), most, strict=True)))


def _filled(rows: _Rows, cycle: float) -> tuple[_Rows, int]:
    """The rows of whole cycles of a known length, and how many these are."""
    time, flow = rows
    span = float(time[-1])
    beats = int((span + 1.5 * _step(time)) / cycle)
    if beats * cycle <= (1 + EVEN / 10) * span:
        beats = int(span / cycle + EVEN / 10)
    if beats == 0 and span < cycle / 2:
        raise InputError(
            f"wave: expected rows of a cycle of {cycle:g} s, got some of {span:g} s; correct "
            "the length of the cycle, or the rows."
        )
    end = max(beats, 1) * cycle
    inner = time < (1 - EVEN / 10 / max(beats, 1)) * end
    last = np.interp(end, time, flow) if span >= (1 - EVEN / 10) * end else flow[0]
    rows = _Rows(np.append(time[inner], end), np.append(flow[inner], last))
    return rows, max(beats, 1)


def _folded(rows: _Rows, beats: int) -> _Rows:
    """Average of the beats, at the times of all their rows."""
    if beats == 1:
        return rows
    cycle = rows.time[-1] / beats
    phase = np.round(np.mod(rows.time, cycle) / cycle, 6)
    at = np.append(np.unique(phase[phase < 1]), 1.0) * cycle
    each = [np.interp(at + number * cycle, rows.time, rows.flow) for number in range(beats)]
    return _Rows(at, np.mean(each, axis=0))
