"""A piece of a vessel on its own: cut, closed, named."""

from .cut_planes import CutPlane as CutPlane
from .cut_planes import PlaneFinder as PlaneFinder
from .open_segment import Bounded as Bounded
from .open_segment import OpenSegment as OpenSegment
from .open_segment import bounded as bounded
from .open_segment import segment_between as segment_between
from .segment import Segment as Segment
from .segment import closed_segment as closed_segment
from .segment_faces import HOLE as HOLE
from .segment_faces import SegmentFace as SegmentFace
from .segment_faces import with_inlets as with_inlets
from .segment_planes import SegmentEnds as SegmentEnds
from .segment_planes import segment_ends as segment_ends
from .side_branches import OpenBranch as OpenBranch
from .side_branches import close_side_branches as close_side_branches
