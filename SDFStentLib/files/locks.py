"""Locks of files that the system drops with their process, on every system."""

from __future__ import annotations

from importlib import import_module


def lock(descriptor: int, *, waits: bool) -> None:
    """Lock an open file for this process until it is closed, or the process ends.

    `flock` where there is `fcntl`, else the first byte by `msvcrt.locking`, which was tried with a
    stand-in of its documented behavior only, not on Windows. There a file that is open cannot be
    removed, so that a lock is closed before its file goes.

    Parameters
    ----------
    descriptor : int
        Of a file that is open for writing and was not read: the place in it is that of the byte.
    waits : bool
        For whoever holds the lock; Windows gives up after ten seconds.

    Raises
    ------
    OSError
        Another one holds the lock, or the file system has none.
    """
    try:
        fcntl = import_module("fcntl")
    except ImportError:
        msvcrt = import_module("msvcrt")
        msvcrt.locking(descriptor, msvcrt.LK_LOCK if waits else msvcrt.LK_NBLCK, 1)
    else:
        fcntl.flock(descriptor, fcntl.LOCK_EX | (0 if waits else fcntl.LOCK_NB))
