"""Several stents in order, each in the vessel that the earlier ones left, and measured."""

from __future__ import annotations

from .coverage import size_cautions
from .in_lumen import ON_WALL
from .lesions import Residual, TreatedLesion, residual_of, treated_lesions
from .placing import placement_at
from .preview import Preview, PreviewedStent, PreviewState
from .profile import prescribed_diameters
from .ratios import SEEN_RATIOS, Seen, SizeRatios, size_ratios, stent_ratios, treated_ratios
from .segments import ExtractedSegment, extract_segment
from .sizing import (
    LONGEST_MARGIN,
    RATIOS,
    SizingWishes,
    Suggestion,
    suggested,
)
from .straightening import AxisChange, axis_in_vessel
from .treatment import Treatment
from .value import TreatedStent, TreatmentResult, TreatmentState, label_of
from .vessel import Vessel

__all__ = [
    "LONGEST_MARGIN",
    "ON_WALL",
    "RATIOS",
    "SEEN_RATIOS",
    "AxisChange",
    "ExtractedSegment",
    "Preview",
    "PreviewState",
    "PreviewedStent",
    "Residual",
    "Seen",
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
    "residual_of",
    "size_cautions",
    "size_ratios",
    "stent_ratios",
    "suggested",
    "treated_lesions",
    "treated_ratios",
]


def __dir__() -> list[str]:
    return __all__
