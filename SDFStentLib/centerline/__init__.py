"""One tree of a vessel from any lines that a file may hold."""

from .centerline import Centerline as Centerline
from .junctions import JunctionChoice as JunctionChoice
from .path import CenterlinePath as CenterlinePath
from .path import Location as Location
from .point_tree import points_between as points_between
