"""Surfaces and centerlines in files, read strictly and written whole or not at all.

What is named here is imported when it is first asked for: much of it needs vtk.
"""

from typing import TYPE_CHECKING

from ..late import list_contents

if TYPE_CHECKING:
    from .atomic import atomic_path as atomic_path
    from .atomic import cannot_write as cannot_write
    from .atomic import check_suffix as check_suffix
    from .atomic import check_writable as check_writable
    from .atomic import flush_to_disk as flush_to_disk
    from .atomic import write_bytes as write_bytes
    from .centerline_files import VTK_LINE_SUFFIXES as VTK_LINE_SUFFIXES
    from .centerline_files import LineFile as LineFile
    from .centerline_files import axis_of as axis_of
    from .centerline_files import in_frame_of as in_frame_of
    from .centerline_files import read_axis as read_axis
    from .centerline_files import read_centerline as read_centerline
    from .centerline_files import read_lines as read_lines
    from .centerline_output import check_line_output as check_line_output
    from .centerline_output import write_centerline as write_centerline
    from .centerline_output import write_extracted_lines as write_extracted_lines
    from .content import read_content as read_content
    from .extraction import ExtractedLines as ExtractedLines
    from .extraction import check_vmtk as check_vmtk
    from .extraction import extract_lines as extract_lines
    from .formats.vtk_files import encode_vtp as encode_vtp
    from .locks import lock as lock
    from .mesh_complete import MeshComplete as MeshComplete
    from .mesh_complete import VolumeMesh as VolumeMesh
    from .model_faces import faces_of_polydata as faces_of_polydata
    from .model_faces import set_face_names as set_face_names
    from .output_set import StagingFolder as StagingFolder
    from .output_set import commit as commit
    from .output_set import sweep as sweep
    from .polydata import add_arrays as add_arrays
    from .polydata import inscribed_radius_from_polydata as inscribed_radius_from_polydata
    from .polydata import lines_from_polydata as lines_from_polydata
    from .polydata import polydata_from_arrays as polydata_from_arrays
    from .polydata import polydata_from_lines as polydata_from_lines
    from .polydata import set_frame_of_polydata as set_frame_of_polydata
    from .polydata import surface_from_polydata as surface_from_polydata
    from .same_space import check_same_space as check_same_space
    from .same_space import size_warnings as size_warnings
    from .surface_files import SurfaceFile as SurfaceFile
    from .surface_files import read_surface as read_surface
    from .surface_output import check_surface_output as check_surface_output
    from .surface_output import write_surface as write_surface
    from .triangulation import triangulated_polydata as triangulated_polydata

list_contents(__name__)
