"""What is handed on: a document, a page, figures and pictures.

What is named here is imported when it is first asked for: much of it needs vtk.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..late import late_names

if TYPE_CHECKING:
    from .of_plan import plan_report
    from .picture import render_before_after
    from .report import Report, write_report, write_report_figure

__all__ = [
    "Report",
    "plan_report",
    "render_before_after",
    "write_report",
    "write_report_figure",
]

__getattr__, __dir__ = late_names(
    __name__,
    {
        "of_plan": ["plan_report"],
        "picture.picture": ["render_before_after"],
        "report": ["Report", "write_report", "write_report_figure"],
    },
)
