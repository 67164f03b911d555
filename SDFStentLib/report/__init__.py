"""What is handed on: a document, a page, figures and pictures.

What is named here is imported when it is first asked for: much of it needs vtk.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..late import late_names

if TYPE_CHECKING:
    from .balloons import balloon_sentences, stent_balloon_sentences
    from .branches import stent_branch_sentences
    from .comparison import (
        comparison_document,
        comparison_json,
        comparison_page,
        comparison_pictures,
    )
    from .devices import (
        device_rows,
        device_sentence,
        planned_device_sentences,
        stent_device_sentences,
    )
    from .diameters import (
        MeasuredLine,
        diameter_section,
        diameter_table,
        filed_point,
        lumen_sentence,
    )
    from .lesions import (
        LEAST,
        LEFT,
        lesion_list,
        lesion_section,
        lesion_sentences,
        lesions_by_size,
        lesions_csv,
        residual_words,
        stent_lesion_sentences,
    )
    from .of_plan import plan_report
    from .painting import check_rendering
    from .picture import alternatives_picture, before_after_picture
    from .pressure import stent_pressure_sentences
    from .report import FIGURE_SUFFIXES, Report, write_report, write_report_figure
    from .segments import SEGMENT_FILES, segment_document, segment_sentences, write_segment
    from .sizing import (
        ratio_sentence,
        stent_ratio_sentences,
        suggestion_section,
        suggestion_sentences,
    )
    from .summary import deployment_sentences, deployment_summary
    from .zero_d import zero_d_cautions, zero_d_document

__all__ = [
    "FIGURE_SUFFIXES",
    "LEAST",
    "LEFT",
    "SEGMENT_FILES",
    "MeasuredLine",
    "Report",
    "alternatives_picture",
    "balloon_sentences",
    "before_after_picture",
    "check_rendering",
    "comparison_document",
    "comparison_json",
    "comparison_page",
    "comparison_pictures",
    "deployment_sentences",
    "deployment_summary",
    "device_rows",
    "device_sentence",
    "diameter_section",
    "diameter_table",
    "filed_point",
    "lesion_list",
    "lesion_section",
    "lesion_sentences",
    "lesions_by_size",
    "lesions_csv",
    "lumen_sentence",
    "plan_report",
    "planned_device_sentences",
    "ratio_sentence",
    "residual_words",
    "segment_document",
    "segment_sentences",
    "stent_balloon_sentences",
    "stent_branch_sentences",
    "stent_device_sentences",
    "stent_lesion_sentences",
    "stent_pressure_sentences",
    "stent_ratio_sentences",
    "suggestion_section",
    "suggestion_sentences",
    "write_report",
    "write_report_figure",
    "write_segment",
    "zero_d_cautions",
    "zero_d_document",
]

__getattr__, __dir__ = late_names(
    __name__,
    {
        "balloons": ["balloon_sentences", "stent_balloon_sentences"],
        "branches": ["stent_branch_sentences"],
        "comparison": [
            "comparison_document",
            "comparison_json",
            "comparison_page",
            "comparison_pictures",
        ],
        "devices": [
            "device_rows",
            "device_sentence",
            "planned_device_sentences",
            "stent_device_sentences",
        ],
        "diameters": [
            "MeasuredLine",
            "diameter_section",
            "diameter_table",
            "filed_point",
            "lumen_sentence",
        ],
        "lesions": [
            "LEAST",
            "lesion_list",
            "LEFT",
            "lesions_by_size",
            "residual_words",
            "lesion_section",
            "lesion_sentences",
            "lesions_csv",
            "stent_lesion_sentences",
        ],
        "of_plan": ["plan_report"],
        "painting": ["check_rendering"],
        "picture": ["alternatives_picture", "before_after_picture"],
        "pressure": ["stent_pressure_sentences"],
        "segments": [
            "SEGMENT_FILES",
            "segment_document",
            "segment_sentences",
            "write_segment",
        ],
        "sizing": [
            "ratio_sentence",
            "stent_ratio_sentences",
            "suggestion_section",
            "suggestion_sentences",
        ],
        "report": ["FIGURE_SUFFIXES", "Report", "write_report", "write_report_figure"],
        "summary": ["deployment_sentences", "deployment_summary"],
        "zero_d": ["zero_d_cautions", "zero_d_document"],
    },
)
