"""Files of several folders that a run replaces, each of them whole.

Everything new is written first, in a staging folder `.sdfstent-*` beside its place, and only then
takes its place, one file after another. An error takes all of that back. Who is killed in between
leaves new files beside old ones: `unfinished` tells it of the staging folders that are left, and a
report, which comes last and has the hashes of all others, where these are gone.
"""

from __future__ import annotations

import os
import re
import shutil
import stat
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import suppress
from pathlib import Path

from .atomic import cannot_write, flush_to_disk

_PREFIX, _NEW, _OLD = ".sdfstent-", "new", "old"
_PART = re.compile(rf"{re.escape(_PREFIX)}[0-9a-f]{{12}}(\.\w+)*")
"""Name of a file that `atomic_path` has begun, unlike the `.sdfstent-lock` of a cohort."""

_LONGEST = 3600
"""No writing takes so long, s: what has not ended by then was left behind."""


class StagingFolder:
    """The new contents of some names in one folder, until they take their places.

    Parameters
    ----------
    parent : Path
        The folder of the outputs, which exists.
    """

    def __init__(self, parent: Path) -> None:
        self.path = Path(tempfile.mkdtemp(prefix=_PREFIX, dir=parent))
        for name in (_NEW, _OLD):
            (self.path / name).mkdir()

    def staged(self, name: str) -> Path:
        """The path at which the new file or folder of a name is written first."""
        return self.path / _NEW / name

    def remove(self) -> None:
        """Remove the staging folder with everything in it."""
        shutil.rmtree(self.path, ignore_errors=True)

    def put(self, name: str) -> None:
        """Let what was staged take its place, or nothing, and keep what was there until the end."""
        target, new, old = self.path.parent / name, self.staged(name), self.path / _OLD / name
        is_new = new.exists()
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

    def take_back(self, name: str) -> None:
        """Put what was there back in its place; also where `put` has stopped halfway."""
        target, new, old = self.path.parent / name, self.staged(name), self.path / _OLD / name
        with suppress(OSError):
            if old.exists():
                if target.is_dir():
                    os.replace(target, new)
                os.replace(old, target)
            elif target.exists() and not new.exists():
                os.replace(target, new)


def commit(outputs: Sequence[tuple[StagingFolder, str]]) -> None:
    """Let outputs take their places in this order; one of which nothing was staged is removed.

    Raises
    ------
    InputError
        Something could not be moved; then everything has its old state again.
    """
    for folder, name in outputs:
        for path in _files_of(folder.staged(name)):
            flush_to_disk(path)
    begun: list[tuple[StagingFolder, str]] = []
    try:
        for folder, name in outputs:
            begun.append((folder, name))
            folder.put(name)
    except BaseException:
        for folder, name in reversed(begun):
            folder.take_back(name)
        raise
    for parent in {folder.path.parent for folder, _ in outputs}:
        with suppress(OSError):  # such a call does not exist for folders everywhere
            flush_to_disk(parent)


def unfinished(folder: Path) -> list[str]:
    """Names of outputs that a run has not written into a folder yet: it goes on, or was cut off.

    Some of its outputs may be there and others not yet. What was written since is not told.
    """
    names = set()
    for path in _left_in(folder):
        with suppress(OSError):
            when = (path / _NEW).stat().st_mtime_ns  # of the last move, or before any
            new, old = (set(os.listdir(path / part)) for part in (_NEW, _OLD))
            for name in new | old:
                target = folder / name
                is_there = target.exists()
                # One that was only taken away stays away.
                if target.stat().st_mtime_ns <= when if is_there else name in new:
                    names.add(name)
    return sorted(names)


def sweep(folder: Path) -> None:
    """Remove what killed runs have left in a folder; a name that they took away comes back."""
    for path in _left_in(folder):
        with suppress(OSError):
            if _is_old(path):
                for old in (path / _OLD).glob("*"):
                    if not (folder / old.name).exists():
                        os.replace(old, folder / old.name)
                shutil.rmtree(path, ignore_errors=True)
    with suppress(OSError):  # such as of a name that is too long
        for path in folder.glob(f"{_PREFIX}*"):
            if path.is_file() and _PART.fullmatch(path.name) and _is_old(path):
                path.unlink(missing_ok=True)


def _left_in(folder: Path) -> Iterator[Path]:
    """The staging folders in a folder: nothing else is in them, and none leads elsewhere."""
    found: list[Path] = []
    with suppress(OSError):  # such as of a name that is too long
        found = sorted(folder.glob(f"{_PREFIX}*"))
    for path in found:
        with suppress(OSError):
            parts = [path, *path.iterdir()]
            is_own = {one.name for one in parts[1:]} <= {_NEW, _OLD}
            if is_own and all(one.is_dir() and not one.is_symlink() for one in parts):
                yield path


def _is_old(path: Path) -> bool:
    return time.time() - path.stat().st_mtime > _LONGEST


def _files_of(path: Path) -> list[Path]:
    return [one for one in (path.rglob("*") if path.is_dir() else [path]) if one.is_file()]


def _keep(target: Path, old: Path) -> None:
    """Keep a file under a second name, or as a copy where the file system has no second names."""
    try:
        os.link(target, old)
    except OSError:
        shutil.copy2(target, old)
