"""Formats of polygons and little else, one file each: bytes to arrays, and back."""

from .obj import decode_obj as decode_obj
from .obj import encode_obj as encode_obj
from .off import decode_off as decode_off
from .plain_mesh import Decoder as Decoder
from .ply import decode_ply as decode_ply
from .ply import encode_ply as encode_ply
from .ply import fits_ply as fits_ply
from .stl import decode_stl as decode_stl
from .stl import encode_solids as encode_solids
from .stl import encode_stl as encode_stl
