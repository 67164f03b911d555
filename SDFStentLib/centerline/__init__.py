"""Tree of a vessel's centerlines from any lines that a file may hold, and the way that each vessel
takes on."""

from .branch_lumen import BranchLumen as BranchLumen
from .branch_lumen import station_spacing as station_spacing
from .centerline import Centerline as Centerline
from .inner_balls import InnerBalls as InnerBalls
from .inner_balls import inner_balls as inner_balls
from .jagged import JAGGED as JAGGED
from .jagged import zigzag as zigzag
from .lumen_tree import SAME_CALIBER as SAME_CALIBER
from .lumen_tree import USUAL as USUAL
from .lumen_tree import LumenTree as LumenTree
from .path import CenterlinePath as CenterlinePath
from .path import JunctionChoice as JunctionChoice
from .path import Location as Location
from .point_tree import distal_ends as distal_ends
from .point_tree import points_between as points_between
from .root import WIDER as WIDER
from .root import Widths as Widths
from .stretches import LumenStretch as LumenStretch
from .stretches import joined_lumens as joined_lumens
from .tips import round_ends as round_ends
from .touching import touching_vessels as touching_vessels
from .widest_ways import ExtractedLines as ExtractedLines
from .widest_ways import WidestWays as WidestWays
from .widest_ways import with_places as with_places
