"""X-ray views of a vessel: the position of the C-arm and the picture it takes there."""

from .angiogram import ATTENUATION as ATTENUATION
from .angiogram import Angiogram as Angiogram
from .angiogram import Gray as Gray
from .angiogram import angiogram as angiogram
from .angiogram import beam_on as beam_on
from .arm import ArmLimits as ArmLimits
from .arm import ArmView as ArmView
from .arm import arm_axes as arm_axes
from .arm import arm_limits as arm_limits
from .arm import arm_view as arm_view
from .best import APART as APART
from .best import GRID as GRID
from .best import SeenView as SeenView
from .best import Shown as Shown
from .best import ViewMap as ViewMap
from .best import WorkingViews as WorkingViews
from .best import working_views as working_views
from .rays import SOURCE as SOURCE
from .rays import Beam as Beam
from .rays import path_lengths as path_lengths
from .stenosis import LesionSections as LesionSections
from .stenosis import SeenStenosis as SeenStenosis
from .stenosis import seen_stenosis as seen_stenosis
from .stenosis import seen_widths as seen_widths
from .wishes import ViewWishes as ViewWishes
