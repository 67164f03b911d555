"""VTK's errors, collected instead of shown on the screen."""

from __future__ import annotations

import re
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from vtkmodules.util.misc import calldata_type
from vtkmodules.vtkCommonCore import (
    VTK_STRING,
    vtkCommand,
    vtkLogger,
    vtkOutputWindow,
    vtkStringOutputWindow,
)

# VTK's window for messages is one for the whole process, so that only one thread may swap it.
_MESSAGES_LOCK = threading.RLock()


@contextmanager
def vtk_messages() -> Iterator[list[str]]:
    """Collect the errors of VTK in a list instead of on the screen, warnings are swallowed.

    The window and the log level are those of before when the block ends. One block at a time:
    other threads wait.
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
