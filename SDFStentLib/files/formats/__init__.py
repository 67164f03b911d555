"""One file per format: bytes to arrays and polydata, and back."""

from .markups import decode_markups as decode_markups
from .markups import encode_markups as encode_markups
from .markups import new_markups as new_markups
from .plain_mesh import Decoder as Decoder
from .plain_mesh import decode_obj as decode_obj
from .plain_mesh import decode_stl as decode_stl
from .plain_mesh import encode_obj as encode_obj
from .plain_mesh import encode_stl as encode_stl
from .ply import decode_ply as decode_ply
from .ply import encode_ply as encode_ply
from .ply import fits_ply as fits_ply
from .vtk_files import encode_legacy as encode_legacy
from .vtk_files import encode_vtp as encode_vtp
from .vtk_files import encode_vtu as encode_vtu
from .vtk_files import read_vtk_polydata as read_vtk_polydata
from .vtu import decode_vtu as decode_vtu
