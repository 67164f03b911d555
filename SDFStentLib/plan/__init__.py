"""One document that holds all that determines a result: written, read and carried out.

What is named here is imported when it is first asked for: much of it needs vtk.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..late import late_names

if TYPE_CHECKING:
    from .axis import read_axis_file
    from .comparison import Alternative, Comparison, compare, comparison_inputs
    from .details import (
        StentDetails,
        detailed_stent,
        details_words,
        read_details,
        stent_details,
    )
    from .device_file import device_vtp, write_device
    from .devices import (
        device_document,
        device_from_document,
        device_named,
        device_table,
    )
    from .document import POINT_PLACEMENTS, plan_text, save_plan
    from .json_document import in_words, number, parsed, scaled, section, sequence, text_value
    from .plan import Plan, method_parameters, plan_of_method, turned
    from .reader import load_plan, plan_from_document
    from .run import (
        InputFiles,
        PlanResult,
        as_read,
        input_file,
        read_input_files,
        read_plan_inputs,
        run_plan,
        treatment_of,
    )
    from .shapes import read_profile, shape_document, shape_from_document
    from .steps import StepFiles
    from .today import Today

__all__ = [
    "POINT_PLACEMENTS",
    "Alternative",
    "Comparison",
    "InputFiles",
    "Plan",
    "PlanResult",
    "StentDetails",
    "StepFiles",
    "Today",
    "as_read",
    "compare",
    "comparison_inputs",
    "detailed_stent",
    "details_words",
    "device_document",
    "device_from_document",
    "device_named",
    "device_table",
    "device_vtp",
    "in_words",
    "input_file",
    "load_plan",
    "method_parameters",
    "number",
    "parsed",
    "plan_from_document",
    "plan_of_method",
    "plan_text",
    "read_axis_file",
    "read_details",
    "read_input_files",
    "read_plan_inputs",
    "read_profile",
    "run_plan",
    "save_plan",
    "scaled",
    "section",
    "sequence",
    "shape_document",
    "shape_from_document",
    "stent_details",
    "text_value",
    "treatment_of",
    "turned",
    "write_device",
]

__getattr__, __dir__ = late_names(
    __name__,
    {
        "axis": ["read_axis_file"],
        "comparison": ["Alternative", "Comparison", "compare", "comparison_inputs"],
        "details": [
            "StentDetails",
            "detailed_stent",
            "details_words",
            "read_details",
            "stent_details",
        ],
        "device_file": ["device_vtp", "write_device"],
        "devices": ["device_document", "device_from_document", "device_named", "device_table"],
        "document": ["POINT_PLACEMENTS", "plan_text", "save_plan"],
        "json_document": [
            "in_words",
            "number",
            "parsed",
            "scaled",
            "section",
            "sequence",
            "text_value",
        ],
        "plan": ["Plan", "method_parameters", "plan_of_method", "turned"],
        "reader": ["load_plan", "plan_from_document"],
        "run": [
            "InputFiles",
            "PlanResult",
            "as_read",
            "input_file",
            "read_input_files",
            "read_plan_inputs",
            "run_plan",
            "treatment_of",
        ],
        "shapes": ["read_profile", "shape_document", "shape_from_document"],
        "steps": ["StepFiles"],
        "today": ["Today"],
    },
)
