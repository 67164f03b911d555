"""What is handed on: a document, a page, figures and pictures.

What is named here is imported when it is first asked for: much of it needs vtk.
"""

from typing import TYPE_CHECKING

from ..late import list_contents

if TYPE_CHECKING:
    from .balloons import balloon_sentences as balloon_sentences
    from .balloons import stent_balloon_sentences as stent_balloon_sentences
    from .branches import stent_branch_sentences as stent_branch_sentences
    from .comparison import comparison_document as comparison_document
    from .comparison import comparison_json as comparison_json
    from .comparison import comparison_page as comparison_page
    from .comparison import comparison_pictures as comparison_pictures
    from .devices import device_rows as device_rows
    from .devices import device_sentence as device_sentence
    from .devices import planned_device_sentences as planned_device_sentences
    from .devices import stent_device_sentences as stent_device_sentences
    from .diameters import MeasuredLine as MeasuredLine
    from .diameters import diameter_section as diameter_section
    from .diameters import diameter_table as diameter_table
    from .diameters import filed_point as filed_point
    from .diameters import lumen_sentence as lumen_sentence
    from .lesions import LEAST as LEAST
    from .lesions import LEFT as LEFT
    from .lesions import lesion_list as lesion_list
    from .lesions import lesion_section as lesion_section
    from .lesions import lesion_sentences as lesion_sentences
    from .lesions import lesions_by_size as lesions_by_size
    from .lesions import lesions_csv as lesions_csv
    from .lesions import residual_words as residual_words
    from .lesions import stent_lesion_sentences as stent_lesion_sentences
    from .of_plan import plan_report as plan_report
    from .painting import check_rendering as check_rendering
    from .picture import alternatives_picture as alternatives_picture
    from .picture import before_after_picture as before_after_picture
    from .pressure import stent_pressure_sentences as stent_pressure_sentences
    from .report import FIGURE_SUFFIXES as FIGURE_SUFFIXES
    from .report import Report as Report
    from .report import write_report as write_report
    from .report import write_report_figure as write_report_figure
    from .segments import SEGMENT_FILES as SEGMENT_FILES
    from .segments import segment_document as segment_document
    from .segments import segment_sentences as segment_sentences
    from .segments import write_segment as write_segment
    from .sizing import ratio_sentence as ratio_sentence
    from .sizing import stent_ratio_sentences as stent_ratio_sentences
    from .sizing import suggestion_section as suggestion_section
    from .sizing import suggestion_sentences as suggestion_sentences
    from .summary import deployment_sentences as deployment_sentences
    from .summary import deployment_summary as deployment_summary
    from .zero_d import zero_d_cautions as zero_d_cautions
    from .zero_d import zero_d_document as zero_d_document

list_contents(__name__)
