"""VTK's part in the readers: its errors, collected instead of shown, and its LZ4 blocks."""

from __future__ import annotations

import re
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from vtkmodules.util.misc import calldata_type
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import (
    VTK_STRING,
    vtkCommand,
    vtkLogger,
    vtkOutputWindow,
    vtkStringOutputWindow,
)
from vtkmodules.vtkIOCore import vtkLZ4DataCompressor

# VTK's window for messages is one for the whole process, so that only one thread may swap it.
_MESSAGES_LOCK = threading.RLock()


@contextmanager
def vtk_messages() -> Iterator[list[str]]:
    """Collect the errors of VTK in a list instead of showing them; warnings are dropped.

    The previous window and log level are restored when the block ends. Only one block runs at a
    time: other threads wait.
    """
    messages: list[str] = []

    @calldata_type(VTK_STRING)
    def remember(_sender: Any, _event: str, text: str) -> None:
        messages.append(re.sub(r"ERROR: In [^\n]*\n|\(0x[0-9a-f]+\)", "", text or "").strip())

    window = vtkStringOutputWindow()
    window.AddObserver(vtkCommand.ErrorEvent, remember)
    with _MESSAGES_LOCK:
        before = vtkOutputWindow.GetInstance()
        verbosity = vtkLogger.GetCurrentVerbosityCutoff()
        vtkOutputWindow.SetInstance(window)
        vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
        try:
            yield messages
        finally:
            vtkLogger.SetStderrVerbosity(verbosity)
            vtkOutputWindow.SetInstance(before)


_LARGEST_EXPANSION = 255


def from_lz4(packed: bytes, size: int) -> bytes:
    """The `size` bytes of an LZ4 block; `ValueError` if it holds another number."""
    if not packed or size > _LARGEST_EXPANSION * len(packed):
        raise ValueError(f"{len(packed)} bytes cannot hold {size}")
    with vtk_messages():
        # Of the forms that VTK takes, an array is converted fastest.
        block: Any = np.frombuffer(packed, np.uint8)
        found = vtkLZ4DataCompressor().Uncompress(block, len(packed), size)
    if found is None or found.GetNumberOfTuples() != size:
        raise ValueError("it is no LZ4 block of this size")
    return vtk_to_numpy(found).tobytes()
