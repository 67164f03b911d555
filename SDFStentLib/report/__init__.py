"""What is handed on: a document, a page, figures and pictures.

What is named here is imported when it is first asked for: much of it needs vtk.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..late import late_names

if TYPE_CHECKING:
    from .of_plan import plan_report
    from .picture import before_after_picture, check_rendering
    from .report import FIGURE_SUFFIXES, Report, write_report, write_report_figure

__all__ = [
    "FIGURE_SUFFIXES",
    "Report",
    "before_after_picture",
    "check_rendering",
    "plan_report",
    "write_report",
    "write_report_figure",
]

__getattr__, __dir__ = late_names(
    __name__,
    {
        "of_plan": ["plan_report"],
        "picture": ["before_after_picture", "check_rendering"],
        "report": ["FIGURE_SUFFIXES", "Report", "write_report", "write_report_figure"],
    },
)
