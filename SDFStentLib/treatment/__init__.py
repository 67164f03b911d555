"""Several stents in order, each in the vessel that the earlier ones left, and measured."""

from ..late import list_contents
from .coverage import size_cautions as size_cautions
from .in_lumen import ON_WALL as ON_WALL
from .lesions import Residual as Residual
from .lesions import TreatedLesion as TreatedLesion
from .lesions import residual_of as residual_of
from .lesions import treated_lesions as treated_lesions
from .placing import placement_at as placement_at
from .preview import Preview as Preview
from .preview import PreviewedStent as PreviewedStent
from .preview import PreviewState as PreviewState
from .profile import prescribed_diameters as prescribed_diameters
from .ratios import SEEN_RATIOS as SEEN_RATIOS
from .ratios import Seen as Seen
from .ratios import SizeRatios as SizeRatios
from .ratios import size_ratios as size_ratios
from .ratios import stent_ratios as stent_ratios
from .ratios import treated_ratios as treated_ratios
from .segments import ExtractedSegment as ExtractedSegment
from .segments import extract_segment as extract_segment
from .sizing import LONGEST_MARGIN as LONGEST_MARGIN
from .sizing import RATIOS as RATIOS
from .sizing import SizingWishes as SizingWishes
from .sizing import Suggestion as Suggestion
from .sizing import suggested as suggested
from .straightening import AxisChange as AxisChange
from .straightening import axis_in_vessel as axis_in_vessel
from .treatment import Treatment as Treatment
from .value import TreatedStent as TreatedStent
from .value import TreatmentResult as TreatmentResult
from .value import TreatmentState as TreatmentState
from .value import label_of as label_of
from .vessel import Vessel as Vessel

list_contents(__name__)
