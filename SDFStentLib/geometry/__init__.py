"""Polylines and triangle surfaces: what can be said of them without knowing a vessel."""

from __future__ import annotations

from .bends import frames, minimum_bend_radius, tangents, tightest_bend
from .carrying import carried
from .connected_parts import component_labels, connected
from .distance import NearPairs, SurfaceIndex
from .faces import (
    NO_HEIGHT,
    compacted,
    face_areas,
    face_normals,
    faces_at,
    may_meet_box,
    median_edge,
    oriented_triangles,
    signed_volume,
    vertex_normals,
)
from .flat_fill import FlatFill, flat_fill
from .named_faces import NamedFaces, checked_faces
from .near_balls import Balls, nearest_distances
from .plane_cut import CutSurface, SectionAround, cut_along, section_around
from .polyline import (
    arc_lengths,
    closest_points,
    cut,
    kept_points,
    length,
    locate,
    point_at,
    resampled,
    resampled_to,
    segment_count,
    without_repeats,
)
from .precision import Precision
from .ragged import blocks_of, ranges
from .rows import across, dot, norm, product
from .section import ClosedSurface, is_inside, plane_section
from .segments import closest_on_segments, distances_to_segments
from .smooth_line import smoothed_line
from .smoothing import smooth_minimum
from .surface import Surface, as_surface, state_of
from .topology import (
    Topology,
    VertexNeighbors,
    boundary_edges,
    consistently_wound,
    edges,
    is_manifold,
    paired_sides,
    surface_topology,
    vertex_neighbors,
)

__all__ = [
    "NO_HEIGHT",
    "Balls",
    "ClosedSurface",
    "CutSurface",
    "FlatFill",
    "NamedFaces",
    "NearPairs",
    "Precision",
    "SectionAround",
    "Surface",
    "SurfaceIndex",
    "Topology",
    "VertexNeighbors",
    "across",
    "arc_lengths",
    "as_surface",
    "blocks_of",
    "boundary_edges",
    "carried",
    "checked_faces",
    "closest_on_segments",
    "closest_points",
    "compacted",
    "component_labels",
    "connected",
    "consistently_wound",
    "cut",
    "cut_along",
    "distances_to_segments",
    "dot",
    "edges",
    "face_areas",
    "face_normals",
    "faces_at",
    "flat_fill",
    "frames",
    "is_inside",
    "is_manifold",
    "kept_points",
    "length",
    "locate",
    "may_meet_box",
    "median_edge",
    "minimum_bend_radius",
    "nearest_distances",
    "norm",
    "oriented_triangles",
    "paired_sides",
    "plane_section",
    "point_at",
    "product",
    "ranges",
    "resampled",
    "resampled_to",
    "section_around",
    "segment_count",
    "signed_volume",
    "smooth_minimum",
    "smoothed_line",
    "state_of",
    "surface_topology",
    "tangents",
    "tightest_bend",
    "vertex_neighbors",
    "vertex_normals",
    "without_repeats",
]


def __dir__() -> list[str]:
    return __all__
