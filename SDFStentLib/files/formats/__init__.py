"""One file per format: bytes to arrays and polydata, and back."""

from __future__ import annotations

from .markups import decode_markups, encode_markups, new_markups
from .obj import decode_obj, encode_obj
from .plain_mesh import Decoder, PlainMesh
from .ply import decode_ply, encode_ply, fits_ply
from .stl import decode_stl, encode_stl
from .vtk_files import encode_legacy, encode_vtp, encode_vtu, read_vtk_polydata

__all__ = [
    "Decoder",
    "PlainMesh",
    "decode_markups",
    "decode_obj",
    "decode_ply",
    "decode_stl",
    "encode_legacy",
    "encode_markups",
    "encode_obj",
    "encode_ply",
    "encode_stl",
    "encode_vtp",
    "encode_vtu",
    "fits_ply",
    "new_markups",
    "read_vtk_polydata",
]


def __dir__() -> list[str]:
    return __all__
