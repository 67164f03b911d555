"""One document that holds all that determines a result: written, read and carried out.

What is named here is imported when it is first asked for: much of it needs vtk.
"""

from typing import TYPE_CHECKING

from ..late import list_contents

if TYPE_CHECKING:
    from .axis import read_axis_file as read_axis_file
    from .comparison import Alternative as Alternative
    from .comparison import PlanComparison as PlanComparison
    from .comparison import compare as compare
    from .comparison import comparison_inputs as comparison_inputs
    from .details import StentDetails as StentDetails
    from .details import detailed_stent as detailed_stent
    from .details import details_words as details_words
    from .details import read_details as read_details
    from .details import stent_details as stent_details
    from .device_file import device_vtp as device_vtp
    from .device_file import write_device as write_device
    from .devices import device_document as device_document
    from .devices import device_named as device_named
    from .devices import device_table as device_table
    from .document import POINT_PLACEMENTS as POINT_PLACEMENTS
    from .document import plan_text as plan_text
    from .document import save_plan as save_plan
    from .json_document import in_words as in_words
    from .json_document import number as number
    from .json_document import parsed as parsed
    from .json_document import scaled as scaled
    from .json_document import section as section
    from .json_document import sequence as sequence
    from .json_document import text_value as text_value
    from .plan import Plan as Plan
    from .plan import method_parameters as method_parameters
    from .plan import plan_of_method as plan_of_method
    from .plan import turned as turned
    from .reader import load_plan as load_plan
    from .reader import plan_from_document as plan_from_document
    from .run import InputFiles as InputFiles
    from .run import PlanResult as PlanResult
    from .run import as_read as as_read
    from .run import input_file as input_file
    from .run import read_input_files as read_input_files
    from .run import read_plan_inputs as read_plan_inputs
    from .run import run_plan as run_plan
    from .run import treatment_of as treatment_of
    from .shapes import read_profile as read_profile
    from .shapes import shape_document as shape_document
    from .steps import StepFiles as StepFiles
    from .today import Today as Today
    from .typed import from_document as from_document

list_contents(__name__)
