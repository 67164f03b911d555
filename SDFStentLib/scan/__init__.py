"""Vessel from a segmentation: surface with flat ends, centerline, exactness of its numbers."""

from .contour import contoured as contoured
from .labelmap import Labelmap as Labelmap
from .labelmap import LabelPiece as LabelPiece
from .labelmap import largest_piece as largest_piece
from .labelmap import thin_bridges as thin_bridges
from .prepared import VOXEL_ERROR as VOXEL_ERROR
from .prepared import PreparedEnd as PreparedEnd
from .prepared import PreparedVessel as PreparedVessel
from .prepared import prepared_vessel as prepared_vessel
from .reader import ScanFile as ScanFile
from .reader import Segmentation as Segmentation
from .reader import read_scan as read_scan
from .reader import read_segmentation as read_segmentation
from .voxel_range import MovedCase as MovedCase
from .voxel_range import Ranged as Ranged
from .voxel_range import Span as Span
from .voxel_range import VoxelRange as VoxelRange
from .voxel_range import moved_cases as moved_cases
from .voxel_range import range_of_walls as range_of_walls
from .voxel_range import treated_voxel_range as treated_voxel_range
from .voxel_range import voxel_range as voxel_range
from .wall_distance import wall_distance as wall_distance
