"""The table and the plot of the diameters for the page, made from the nodes that the module leaves
in the scene."""

from __future__ import annotations

from typing import Any

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy

WIDTH, HEIGHT = 600.0, 240.0
LEFT, RIGHT, TOP, BOTTOM = 44.0, 12.0, 12.0, 34.0
STEPS = (0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)
MOST_TICKS = 8
TABLE_EVERY_MM = 1.0


def table_of(node: Any) -> dict[str, Any]:
    """Columns and rows of the table node, about one row per mm; empty without a node."""
    if node is None:
        return {"columns": [], "rows": [], "title": ""}
    columns = _columns(node)
    names, values = list(columns), np.column_stack(list(columns.values()))
    chosen = _every(values[:, 0], TABLE_EVERY_MM) if len(values) else []
    rows = [[_text(value) for value in values[index]] for index in chosen]
    return {"columns": names, "rows": rows, "title": node.GetDescription() or ""}


def plot_of(chart: Any) -> dict[str, Any]:
    """The drawing of a chart node for the page: lines in pixels, ticks, words; empty without a
    node."""
    size = {"width": WIDTH, "height": HEIGHT}
    if chart is None or chart.GetNumberOfPlotSeriesNodes() == 0:
        nothing = {"lines": [], "across": [], "up": [], "values": []}
        return {**size, **nothing, "title": "", "words": ["", ""]}
    series = [chart.GetNthPlotSeriesNode(i) for i in range(chart.GetNumberOfPlotSeriesNodes())]
    columns = _columns(series[0].GetTableNode())
    along = columns[series[0].GetXColumnName()]
    across = _PixelScale(float(along.min()), float(along.max()), LEFT, WIDTH - RIGHT)
    up = _PixelScale(0.0, chart.GetYAxisRange()[1], HEIGHT - BOTTOM, TOP)
    return {
        **size,
        "lines": [_line(one, along, columns, across, up) for one in series],
        "across": across.ticks(),
        "up": up.ticks(),
        "values": _values(series, along, columns, across),
        "title": chart.GetTitle() or "",
        "words": [chart.GetXAxisTitle() or "", chart.GetYAxisTitle() or ""],
    }


def opacity_of(chart: Any) -> float:
    """The opacity of the chart's lines: those of a former plan are faint."""
    series = chart.GetNthPlotSeriesNode(0)
    return 1.0 if series is None else series.GetOpacity()


def _line(
    node: Any, along: Any, columns: Any, across: _PixelScale, up: _PixelScale
) -> dict[str, Any]:
    """A series as a line, interrupted where its values are not known."""
    values = columns[node.GetYColumnName()]
    path, isOpen = [], False
    for x, y in zip(along, values, strict=True):
        isKnown = bool(np.isfinite(y))
        if isKnown:
            path.append(f"{'L' if isOpen else 'M'}{across(x):.1f},{up(y):.1f}")
        isOpen = isKnown
    color = "#" + "".join(f"{round(255 * part):02x}" for part in node.GetColor())
    isDashed = node.GetLineStyle() == node.LineStyleDash
    drawn = {"color": color, "dash": isDashed, "opacity": node.GetOpacity()}
    return {"name": node.GetYColumnName(), "path": " ".join(path), **drawn}


def _values(
    series: list[Any], along: Any, columns: Any, across: _PixelScale
) -> list[dict[str, Any]]:
    """The text to read at every station, and its place in the plot."""
    names = [node.GetYColumnName() for node in series]
    return [
        {
            "at": round(across(x), 1),
            "text": ", ".join(
                [f"{_text(x + 0.0)} mm", *(_named(one, columns[one][row]) for one in names)]
            ),
        }
        for row, x in enumerate(along)
    ]


def _named(column: str, value: float) -> str:
    return f"{column.partition(' (')[0].lower()} {_text(value) or 'not known'}"


class _PixelScale:
    """Linear map from values to pixels."""

    def __init__(self, low: float, high: float, first: float, last: float) -> None:
        self.low, self.high = low, max(high, low + 1e-9)
        self.first, self.last = first, last

    def __call__(self, value: float) -> float:
        share = (value - self.low) / (self.high - self.low)
        return self.first + share * (self.last - self.first)

    def ticks(self) -> list[dict[str, Any]]:
        """Round values between the ends, and their places."""
        span = self.high - self.low
        step = next((s for s in STEPS if span / s <= MOST_TICKS), STEPS[-1])
        first = np.ceil(self.low / step) * step
        values = np.arange(first, self.high + 1e-9, step)
        return [{"at": round(self(value), 1), "text": f"{value + 0.0:g}"} for value in values]


def _columns(node: Any) -> dict[str, Any]:
    table = node.GetTable()
    arrays = [table.GetColumn(index) for index in range(table.GetNumberOfColumns())]
    return {array.GetName(): vtk_to_numpy(array).astype(float) for array in arrays}


def _every(along: Any, distance: float) -> list[int]:
    """Indices of rows about this distance apart, the ends included."""
    places = np.arange(along[0], along[-1] + distance, distance)
    nearest = np.abs(along[None, :] - places[:, None]).argmin(axis=1)
    return sorted(set(nearest.tolist()))


def _text(value: float) -> str:
    """The value with two decimals, as in the table: rounded once more, 4.645 mm would be 4.7."""
    return f"{value:.2f}" if np.isfinite(value) else ""
