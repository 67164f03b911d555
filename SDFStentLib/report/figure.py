"""Diameters along the stent as a figure for a slide; drawn with matplotlib, which is an extra."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..validation import InputError
from .words import stent_titles

_SUFFIXES = (".png", ".svg", ".pdf")

_CURVES = (
    ("mis_before_mm", "before, inscribed sphere", "#b35806", "-", 2.0),
    ("equivalent_before_mm", "before, equivalent", "#b35806", ":", 1.4),
    ("mis_after_mm", "after, inscribed sphere", "#08519c", "-", 2.0),
    ("equivalent_after_mm", "after, equivalent", "#08519c", ":", 1.4),
    ("prescribed_mm", "prescribed", "#111111", "--", 1.2),
)


def write_figure(document: Mapping[str, Any], path: Path, suffix: str) -> None:
    """Draw one panel per stent of a report document to `path`, in the format of `suffix`.

    Raises
    ------
    InputError
        matplotlib is not installed, a suffix that is not .png, .svg or .pdf, or no stent.
    """
    if suffix.lower() not in _SUFFIXES:
        raise InputError(
            f"figure: expected a file that ends in {', '.join(_SUFFIXES)}, "
            f"got {suffix or 'no suffix'!r}."
        )
    stents = document["stents"]
    if not stents:
        raise InputError("figure: expected a report with at least one stent, got none.")
    try:
        # Imported here: an extra that nothing else needs. The figure class knows no windows.
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ImportError as error:
        raise InputError(
            "figure: matplotlib draws it and is not installed; "
            "install it with `pip install sdfstent[figures]`."
        ) from error
    figure = Figure(figsize=(8, 0.4 + 3.8 * len(stents)), layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(len(stents), 1, squeeze=False)[:, 0]
    for panel, stent, title in zip(panels, stents, stent_titles(stents), strict=True):
        _draw(panel, stent["diameters"], title)
    figure.supxlabel(document["notice"], fontsize=8, color="#555555")
    figure.savefig(path, dpi=150, format=suffix.lower()[1:])


def _draw(panel: Any, diameters: Mapping[str, Any], title: str) -> None:
    along = diameters["along"]
    for key, label, color, style, width in _CURVES:
        values = np.array(along[key], dtype=np.float64)
        panel.plot(along["arc_length_mm"], values, style, color=color, lw=width, label=label)
    narrow = diameters["minimum_lumen"]
    for when, color in (("before", "#b35806"), ("after", "#08519c")):
        if narrow[f"{when}_mm"] is not None:
            panel.plot(narrow[f"{when}_at_mm"], narrow[f"{when}_mm"], "o", color=color)
    panel.set_title(title, loc="left", fontsize=11)
    panel.set_xlabel("position along the stent, proximal to distal (mm)")
    panel.set_ylabel("lumen diameter (mm)")
    panel.set_ylim(bottom=0)
    panel.grid(alpha=0.3)
    panel.legend(fontsize=8, ncols=3, loc="lower center")
