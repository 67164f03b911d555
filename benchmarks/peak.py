"""The most memory that a process has held."""

from __future__ import annotations

import resource
import sys


def peak_mb() -> float:
    """Highest residence of this process.

    What `getrusage` tells is at least that of the process that started this one: Linux hands it
    on. So it is read where it starts anew with the program.
    """
    try:
        with open("/proc/self/status", encoding="utf-8") as status:
            for line in status:
                if line.startswith("VmHWM:"):
                    return int(line.split()[1]) * 1024 / 1e6
    except OSError:
        pass
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / 1e6 if sys.platform == "darwin" else peak * 1024 / 1e6
