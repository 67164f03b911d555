"""Files of several folders that change together: one commit point, finished or undone by the next.

Everything new is written in a staging folder `.sdfstent-*` beside its place. A file `committed` in
the first of these folders is the commit point: as long as it is missing, the old state holds, and
from the moment it is there, the new one. Whoever is killed in between leaves staging folders; the
next run on one of the folders finishes the moves of a committed set, and takes back those of
another. A lock that the system drops with its process tells the dead ones from the living.

Nobody is obeyed but a run that was here: its lock holds the numbers by which the file system knows
the folder and the lock, and a folder that was copied or unpacked has others. What moves is a name
in the folder that holds the staging folder, never a path.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import stat
import tempfile
import time
from collections.abc import Iterable, Mapping
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import Any

from ..validation import InputError
from .atomic import cannot_write, flush_to_disk


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


_PREFIX = ".sdfstent-"
_LOCK, _MOVES, _COMMITTED = "lock", "moves.json", "committed"
_NEW, _OLD = "new", "old"
_PART = re.compile(rf"{re.escape(_PREFIX)}[0-9a-f]{{12}}(\.\w+)*")
"""Name of a file that `atomic_path` has begun, unlike the `.sdfstent-lock` of a cohort."""


class StagingFolder:
    """The new contents of some names in one folder, staged in it until they are moved to their
    places.

    Parameters
    ----------
    parent : Path
        The folder of the outputs, which exists.
    """

    def __init__(self, parent: Path) -> None:
        # A run that sweeps just now may take the folder, not yet locked, for that of a dead run.
        self._lock: int | None = None
        # Ends: at the latest when no other run begins; each sweeps once.
        while self._lock is None:
            self.path = Path(tempfile.mkdtemp(prefix=_PREFIX, dir=parent))
            self._lock = _locked(self.path / _LOCK)
        os.write(self._lock, json.dumps(_numbers(self.path)).encode())
        for name in (_NEW, _OLD):
            (self.path / name).mkdir()

    def staged(self, name: str) -> Path:
        """The path at which the new file or folder of a name is written first."""
        return self.path / _NEW / name

    def remove(self) -> None:
        """Remove the staging folder with everything in it."""
        if self._lock is not None:
            os.close(self._lock)
            self._lock = None
        _remove(self.path)


def commit(folders: Mapping[StagingFolder, Iterable[str]]) -> None:
    """Move everything that was staged to its place, all of it or nothing.

    Parameters
    ----------
    folders : mapping of StagingFolder to names
        The names that are replaced; a name that was not staged is removed.

    Raises
    ------
    InputError
        Something could not be moved; then everything has its old state again.
    """
    if not folders:
        return
    first = next(iter(folders)).path
    for folder, names in folders.items():
        moves = {name: folder.staged(name).exists() for name in names}
        _write(folder.path / _MOVES, {"first": os.fspath(first), "moves": moves})
        for name, is_there in moves.items():
            if is_there:
                _flush(folder.staged(name))
    paths = [folder.path for folder in folders]
    _write(first / _COMMITTED, [os.fspath(path) for path in paths])
    try:
        for path in paths:
            _move(path)
    except BaseException:
        (first / _COMMITTED).unlink(missing_ok=True)
        for path in paths:
            _take_back(path)
        raise


def sweep(parent: Path) -> None:
    """Finish or undo what killed runs have left in a folder."""
    found: list[Path] = []
    with suppress(OSError):  # such as of a name that is too long
        found = sorted(parent.glob(f"{_PREFIX}*"))
    for path in found:
        with suppress(OSError):
            if path.is_dir() and not path.is_symlink():
                _settle(path)
            elif path.is_file() and _PART.fullmatch(path.name) and _is_old(path):
                path.unlink(missing_ok=True)


def _settle(path: Path) -> None:
    """Finish or undo a set that has a staging folder here, unless its run is alive."""
    if not _is_own(path):
        _remove_empty(path)
        return
    first = Path(_record(path / _MOVES).get("first", path))
    if not _is_own(first):
        first = path  # its run was killed before anything was moved, or has settled all else
    descriptor = _lock_of_the_dead(first / _LOCK)
    if descriptor is None:
        return
    settled: list[Path] = []
    try:
        with suppress(OSError, InputError):
            committed = first / _COMMITTED
            if committed.exists():
                names = json.loads(committed.read_text(encoding="utf-8"))
                paths = [other for other in map(Path, names) if other == first or _is_own(other)]
                for other in paths:
                    _move(other)
                # The commit point goes last: without it the moves would be taken back.
                settled = [*paths[1:], first]
            else:
                _take_back(path)
                settled = [path]
            for other in settled:
                _remove(other)
    finally:
        os.close(descriptor)
    for other in settled:
        _remove(other)  # where no open file can be removed, the lock is still there


def _is_own(path: Path) -> bool:
    """Whether a run made this staging folder here, with nothing in it that leads elsewhere."""
    try:
        return (
            path.name.startswith(_PREFIX)
            and json.loads((path / _LOCK).read_text(encoding="utf-8")) == _numbers(path)
            and not any(part.is_symlink() for part in (path, path / _NEW, path / _OLD))
        )
    except (OSError, ValueError):
        return False


def _numbers(path: Path) -> list[int]:
    """Numbers of a staging folder and of its lock in the file system."""
    return [os.lstat(part).st_ino for part in (path, path / _LOCK)]


def _remove_empty(path: Path) -> None:
    """Remove a folder whose run was killed before it wrote into its lock; leave any other alone."""
    if os.listdir(path) == [_LOCK] and (path / _LOCK).stat().st_size == 0:
        descriptor = _lock_of_the_dead(path / _LOCK)
        if descriptor is None:
            return
        # Where no open file can be removed, both stay: nobody minds them.
        with suppress(OSError):
            (path / _LOCK).unlink()
        os.close(descriptor)
    path.rmdir()


def _record(path: Path) -> dict[str, Any]:
    """The record that a run wrote of its moves; empty if it did not get that far."""
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


def _moves(path: Path) -> dict[str, bool]:
    found = _record(path / _MOVES).get("moves")
    if not isinstance(found, dict):
        return {}
    are_names = all(name == Path(name).name and name not in ("", os.pardir) for name in found)
    return found if are_names else {}


def _move(path: Path) -> None:
    """Move new things to their places and old ones aside; it may be repeated if it was cut off."""
    for name, is_new in _moves(path).items():
        target, new, old = path.parent / name, path / _NEW / name, path / _OLD / name
        if is_new and not new.exists():
            continue  # it is in its place
        try:
            if target.is_dir() or (target.exists() and not is_new):
                os.replace(target, old)
            elif target.exists():
                os.chmod(new, stat.S_IMODE(target.stat().st_mode))
                _keep(target, old)
            if is_new:
                os.replace(new, target)
        except OSError as error:
            raise cannot_write(target, error) from error
    with suppress(OSError):  # such a call does not exist for folders everywhere
        flush_to_disk(path.parent)


def _take_back(path: Path) -> None:
    """Put old things back in their places; it may be repeated if it was cut off."""
    for name, is_new in _moves(path).items():
        target, new, old = path.parent / name, path / _NEW / name, path / _OLD / name
        with suppress(OSError):
            if is_new and not new.exists() and target.exists():
                os.replace(target, new)
            if old.exists() and not target.exists():
                os.replace(old, target)


def _keep(target: Path, old: Path) -> None:
    """Keep a file under a second name, or as a copy where the file system has no second names."""
    if old.exists():
        return
    try:
        os.link(target, old)
    except OSError:
        part = old.with_name(f"{old.name}.part")
        shutil.copy2(target, part)
        os.replace(part, old)


def _write(path: Path, value: object) -> None:
    """Write a small file that is whole as soon as it has its name, even after a power cut."""
    part = path.with_name(f"{path.name}.part")
    part.write_text(json.dumps(value), encoding="utf-8")
    flush_to_disk(part)
    os.replace(part, path)
    with suppress(OSError):
        flush_to_disk(path.parent)


def _flush(path: Path) -> None:
    for part in path.rglob("*") if path.is_dir() else [path]:
        if part.is_file():
            flush_to_disk(part)


def _remove(path: Path) -> None:
    """Remove a staging folder; its lock goes last, as without it the folder is not swept."""
    for name in (_NEW, _OLD, _MOVES, _COMMITTED, _LOCK):
        part = path / name
        if part.is_dir():
            shutil.rmtree(part, ignore_errors=True)
        else:
            with suppress(OSError):
                part.unlink(missing_ok=True)
    shutil.rmtree(path, ignore_errors=True)


def _is_old(path: Path) -> bool:
    """Whether a file that is written in one go was left behind: no writing takes that long."""
    return time.time() - path.stat().st_mtime > 3600


def _locked(path: Path) -> int | None:
    """The lock of a new folder; `None` if the folder was swept away before it was locked."""
    try:
        descriptor = os.open(path, os.O_CREAT | os.O_RDWR, 0o600)
    except FileNotFoundError:
        return None
    # Some network folders have no such locks: there nothing is swept.
    with suppress(OSError):
        lock(descriptor, waits=True)
    if path.exists():
        return descriptor
    os.close(descriptor)
    return None


def _lock_of_the_dead(path: Path) -> int | None:
    """The lock of a run that is over; `None` while it is alive."""
    descriptor = os.open(path, os.O_CREAT | os.O_RDWR, 0o600)
    try:
        lock(descriptor, waits=False)
    except OSError:
        os.close(descriptor)
        return None
    return descriptor
