"""How wide a lumen is, what a stent covers, and how far tissue was stretched."""

from __future__ import annotations

from .apposition import Apposition, FreeStretch, apposition
from .branch_names import branch_names, named_branches, size_words
from .caps import bulged_caps, caps_across, looks_across, off_caps
from .closed_ends import OpenWall, open_at_ends
from .closed_surface import Holes, closed_surface, holes_of
from .cross_section import equivalent_diameters, winding_numbers
from .cut_planes import CutPlane
from .extended_axis import REACH, ExtendedAxis, extended_axis
from .inscribed import InscribedSpheres, Until, inscribed_spheres
from .known_lumen import measured_after, measured_once
from .local_surface import LocalSurface
from .metrics import DiameterProfile, diameter_profile
from .moved_wall import MovedWall, moved_wall
from .neighbor_lumen import NeighborLumen, NeighborStations, VesselStates
from .neighbor_ways import BranchWays, NeighborWay, end_ways
from .open_segment import OpenSegment, segment_between
from .ostia import LISTED, NEARLY, Ostium, find_ostia
from .point_lumen import rough_radii
from .pressure import (
    ADULT,
    TOO_LOW,
    TURBULENCE,
    Blood,
    PressureBand,
    VesselBlock,
    pressure_band,
    vessel_block,
)
from .profile_around import AxisStations, axis_stations, profile_around
from .segment import Segment, closed_segment
from .segment_faces import HOLE, SegmentFace
from .segment_planes import SegmentEnds, segment_ends
from .side_branches import OpenBranch, close_side_branches
from .stations import Stations, measured_at
from .stretch import FaceStretch, displacements, face_stretches
from .triangle_sizes import TriangleSizes, triangle_sizes
from .vessel_ends import LineSeeds, VesselEnd, line_seeds, vessel_ends
from .vessel_parts import VesselParts, vessel_parts

__all__ = [
    "ADULT",
    "HOLE",
    "LISTED",
    "NEARLY",
    "REACH",
    "TOO_LOW",
    "TURBULENCE",
    "Apposition",
    "AxisStations",
    "Blood",
    "BranchWays",
    "CutPlane",
    "DiameterProfile",
    "ExtendedAxis",
    "FaceStretch",
    "FreeStretch",
    "Holes",
    "InscribedSpheres",
    "LineSeeds",
    "LocalSurface",
    "MovedWall",
    "NeighborLumen",
    "NeighborStations",
    "NeighborWay",
    "OpenBranch",
    "OpenSegment",
    "OpenWall",
    "Ostium",
    "PressureBand",
    "Segment",
    "SegmentEnds",
    "SegmentFace",
    "Stations",
    "TriangleSizes",
    "Until",
    "VesselBlock",
    "VesselEnd",
    "VesselParts",
    "VesselStates",
    "apposition",
    "axis_stations",
    "branch_names",
    "bulged_caps",
    "caps_across",
    "close_side_branches",
    "closed_segment",
    "closed_surface",
    "diameter_profile",
    "displacements",
    "end_ways",
    "equivalent_diameters",
    "extended_axis",
    "face_stretches",
    "find_ostia",
    "holes_of",
    "inscribed_spheres",
    "line_seeds",
    "looks_across",
    "measured_after",
    "measured_at",
    "measured_once",
    "moved_wall",
    "named_branches",
    "off_caps",
    "open_at_ends",
    "pressure_band",
    "profile_around",
    "rough_radii",
    "segment_between",
    "segment_ends",
    "size_words",
    "triangle_sizes",
    "vessel_block",
    "vessel_ends",
    "vessel_parts",
    "winding_numbers",
]


def __dir__() -> list[str]:
    return __all__
