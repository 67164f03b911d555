"""Surfaces and centerlines in files, read strictly and written whole or not at all.

What is named here is imported when it is first asked for: much of it needs vtk.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..late import late_names

if TYPE_CHECKING:
    from .atomic import (
        atomic_path,
        cannot_write,
        check_suffix,
        check_writable,
        flush_to_disk,
        write_bytes,
    )
    from .centerline_files import (
        VTK_LINE_SUFFIXES,
        LineFile,
        axis_of,
        in_frame_of,
        read_axis,
        read_centerline,
        read_lines,
    )
    from .centerline_output import check_line_output, write_centerline, write_extracted_lines
    from .content import read_content
    from .extraction import ExtractedLines, check_vmtk, extract_lines
    from .formats import encode_vtp
    from .locks import lock
    from .mesh_complete import MeshComplete, VolumeMesh
    from .model_faces import faces_of_polydata, set_face_names
    from .output_set import StagingFolder, commit, sweep
    from .polydata import (
        add_arrays,
        inscribed_radius_from_polydata,
        lines_from_polydata,
        polydata_from_arrays,
        polydata_from_lines,
        set_frame_of_polydata,
        surface_from_polydata,
    )
    from .same_space import check_same_space, size_warnings
    from .surface_files import SurfaceFile, read_surface
    from .surface_output import check_surface_output, write_surface
    from .triangulation import triangulated_polydata

__all__ = [
    "VTK_LINE_SUFFIXES",
    "ExtractedLines",
    "LineFile",
    "MeshComplete",
    "StagingFolder",
    "SurfaceFile",
    "VolumeMesh",
    "add_arrays",
    "atomic_path",
    "axis_of",
    "cannot_write",
    "check_line_output",
    "check_same_space",
    "check_suffix",
    "check_surface_output",
    "check_vmtk",
    "check_writable",
    "commit",
    "encode_vtp",
    "extract_lines",
    "faces_of_polydata",
    "flush_to_disk",
    "in_frame_of",
    "inscribed_radius_from_polydata",
    "lines_from_polydata",
    "lock",
    "polydata_from_arrays",
    "polydata_from_lines",
    "read_axis",
    "read_centerline",
    "read_content",
    "read_lines",
    "read_surface",
    "set_face_names",
    "set_frame_of_polydata",
    "size_warnings",
    "surface_from_polydata",
    "sweep",
    "triangulated_polydata",
    "write_bytes",
    "write_centerline",
    "write_extracted_lines",
    "write_surface",
]

__getattr__, __dir__ = late_names(
    __name__,
    {
        "atomic": [
            "atomic_path",
            "cannot_write",
            "check_suffix",
            "check_writable",
            "flush_to_disk",
            "write_bytes",
        ],
        "centerline_files": [
            "VTK_LINE_SUFFIXES",
            "LineFile",
            "axis_of",
            "in_frame_of",
            "read_axis",
            "read_centerline",
            "read_lines",
        ],
        "centerline_output": ["check_line_output", "write_centerline", "write_extracted_lines"],
        "content": ["read_content"],
        "extraction": ["ExtractedLines", "check_vmtk", "extract_lines"],
        "formats.vtk_files": ["encode_vtp"],
        "locks": ["lock"],
        "mesh_complete": ["MeshComplete", "VolumeMesh"],
        "model_faces": ["faces_of_polydata", "set_face_names"],
        "output_set": ["StagingFolder", "commit", "sweep"],
        "polydata": [
            "add_arrays",
            "surface_from_polydata",
            "inscribed_radius_from_polydata",
            "lines_from_polydata",
            "polydata_from_arrays",
            "polydata_from_lines",
            "set_frame_of_polydata",
        ],
        "same_space": ["check_same_space", "size_warnings"],
        "surface_files": ["SurfaceFile", "read_surface"],
        "surface_output": ["check_surface_output", "write_surface"],
        "triangulation": ["triangulated_polydata"],
    },
)
