"""A stent: its size, where it goes, and the axis that follows from both."""

from ..late import list_contents
from .balloon import MOST_RECOIL as MOST_RECOIL
from .balloon import RAISED_RECOIL as RAISED_RECOIL
from .balloon import USUAL_RECOIL as USUAL_RECOIL
from .balloon import WIDE_BALLOON as WIDE_BALLOON
from .balloon import Balloon as Balloon
from .balloon import balloon_by_rule as balloon_by_rule
from .beside import beside as beside
from .beside import placement_points as placement_points
from .device import CELLS as CELLS
from .device import MAXIMUM_DIAMETER as MAXIMUM_DIAMETER
from .device import MAXIMUM_LENGTH as MAXIMUM_LENGTH
from .device import Device as Device
from .lattice import Lattice as Lattice
from .lattice import LatticeDesign as LatticeDesign
from .lattice import design_of as design_of
from .lattice import laid_along as laid_along
from .lattice import stent_lattice as stent_lattice
from .lattice import straight_lattice as straight_lattice
from .placement import AlongAxis as AlongAxis
from .placement import AtCenter as AtCenter
from .placement import AtDistalEnd as AtDistalEnd
from .placement import AtProximalEnd as AtProximalEnd
from .placement import BetweenPoints as BetweenPoints
from .placement import ByValue as ByValue
from .placement import InputFile as InputFile
from .placement import OfStent as OfStent
from .placement import Placement as Placement
from .redilation import dilated_again as dilated_again
from .redilation import redilated as redilated
from .shape import DiametersAlong as DiametersAlong
from .shape import Shape as Shape
from .shape import StentEnd as StentEnd
from .shape import Waist as Waist
from .stent import DEFAULT_FORESHORTENING as DEFAULT_FORESHORTENING
from .stent import KEPT as KEPT
from .stent import Stent as Stent
from .stent_axis import StentAxis as StentAxis
from .stent_axis import moved_axis as moved_axis
from .stent_axis import stent_axis as stent_axis
from .straightened import TurnedWay as TurnedWay
from .straightened import straight_way as straight_way
from .straightened import straightened as straightened
from .straightened import turned_way as turned_way

list_contents(__name__)
