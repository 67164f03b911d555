"""Several stents in order, each in the vessel that the earlier ones left, and measured."""

from __future__ import annotations

from .lesions import TreatedLesion, placement_at, treated_lesions
from .preview import Preview, PreviewedStent, PreviewState
from .profile import prescribed_diameters
from .segments import ExtractedSegment, extract_segment
from .sizing import (
    LONGEST_MARGIN,
    RATIOS,
    SEEN_RATIO,
    SizeRatios,
    SizingWishes,
    Suggestion,
    ratio_cautions,
    size_ratios,
    stent_ratios,
    suggested,
)
from .straightening import AxisChange, axis_in_vessel
from .treatment import Treatment
from .value import TreatedStent, TreatmentResult, TreatmentState, label_of
from .vessel import Vessel

__all__ = [
    "LONGEST_MARGIN",
    "RATIOS",
    "SEEN_RATIO",
    "AxisChange",
    "ExtractedSegment",
    "Preview",
    "PreviewState",
    "PreviewedStent",
    "SizeRatios",
    "SizingWishes",
    "Suggestion",
    "TreatedLesion",
    "TreatedStent",
    "Treatment",
    "TreatmentResult",
    "TreatmentState",
    "Vessel",
    "axis_in_vessel",
    "extract_segment",
    "label_of",
    "placement_at",
    "prescribed_diameters",
    "ratio_cautions",
    "size_ratios",
    "stent_ratios",
    "suggested",
    "treated_lesions",
]


def __dir__() -> list[str]:
    return __all__
