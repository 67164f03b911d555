"""A lock that the system drops with its process: who holds it is alive."""

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
        A file that is open for writing and was not read, so that its position is that of the byte.
    waits : bool
        Whether to wait for whoever holds the lock; Windows gives up after ten seconds.

    Raises
    ------
    OSError
        Another process holds the lock, or the file system has no locks.
    """
    try:
        fcntl = import_module("fcntl")
    except ImportError:
        msvcrt = import_module("msvcrt")
        msvcrt.locking(descriptor, msvcrt.LK_LOCK if waits else msvcrt.LK_NBLCK, 1)
    else:
        fcntl.flock(descriptor, fcntl.LOCK_EX | (0 if waits else fcntl.LOCK_NB))
