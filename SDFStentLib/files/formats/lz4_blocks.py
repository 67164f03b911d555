"""LZ4 blocks of VTP files, expanded by VTK, which checks the ends of both buffers."""

from __future__ import annotations

from typing import Any

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOCore import vtkLZ4DataCompressor

from .vtk_quiet import vtk_messages

_LARGEST_EXPANSION = 255


def from_lz4(packed: bytes, size: int) -> bytes:
    """The `size` bytes of a block; `ValueError` when it holds others."""
    if not packed or size > _LARGEST_EXPANSION * len(packed):
        raise ValueError(f"{len(packed)} bytes cannot hold {size}")
    with vtk_messages():
        # Of the forms that VTK takes, an array is converted fastest.
        block: Any = np.frombuffer(packed, np.uint8)
        found = vtkLZ4DataCompressor().Uncompress(block, len(packed), size)
    if found is None or found.GetNumberOfTuples() != size:
        raise ValueError("it is no LZ4 block of this size")
    return vtk_to_numpy(found).tobytes()
