"""VTK's formats and those of markups and models, one file each: bytes to arrays, and back."""

from .markups import decode_markups as decode_markups
from .markups import encode_markups as encode_markups
from .markups import new_markups as new_markups
from .paths import decode_fcsv as decode_fcsv
from .paths import decode_pth as decode_pth
from .vtk_files import encode_legacy as encode_legacy
from .vtk_files import encode_vtp as encode_vtp
from .vtk_files import encode_vtu as encode_vtu
from .vtk_files import read_vtk_polydata as read_vtk_polydata
from .vtu import decode_vtu as decode_vtu
