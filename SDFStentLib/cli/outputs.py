"""Outputs that appear together at the end, or not at all."""

from __future__ import annotations

import os
import shutil
import stat
import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import NamedTuple

from ..files import cannot_write, check_writable
from ..validation import InputError

Writer = Callable[[Path], "Iterable[str] | None"]
"""Writes to a path; may return sentences about what could not be kept."""


_OLD = ".old"
"""Name of the old state in the staging folder, which is removed afterwards."""


class _Job(NamedTuple):
    path: str
    target: Path
    write: Writer
    may_be_missing: bool = False
    is_folder: bool = False


class Outputs:
    """Files and folders that a command writes, checked at once and written at the end.

    Everything is written beside its place first and moved there when all of it is done: a
    failure or an interruption leaves no output, or all of them.

    Parameters
    ----------
    inputs : sequence of paths
        Files that may not be overwritten.
    folder : path, optional
        A folder that is made for the outputs when it is missing; its parent must exist.
    """

    def __init__(
        self,
        inputs: Sequence[str | os.PathLike[str] | None] = (),
        folder: str | os.PathLike[str] | None = None,
    ) -> None:
        self._inputs = {os.path.realpath(path) for path in inputs if path is not None}
        self._folder = None if folder is None else _check_folder(folder)
        self._jobs: list[_Job] = []

    def add(
        self, path: str | os.PathLike[str], write: Writer, *, may_be_missing: bool = False
    ) -> None:
        """A file; `InputError` when it cannot be written, is an input, or is named twice.

        A writer that `may_be_missing` may leave it out; then an older one goes, too.
        """
        target = Path(os.path.realpath(path))
        if self._folder is None or target.parent != self._folder or self._folder.is_dir():
            target = check_writable(path)
        self._add(_Job(os.fspath(path), target, write, may_be_missing))

    def add_folder(
        self, path: str | os.PathLike[str], write: Writer, own: Callable[[str], bool]
    ) -> None:
        """A folder that is new, empty, or holds only files of its own kind, which it replaces."""
        target = _check_folder(path, may_come=self._folder)
        if os.path.ismount(target):
            raise InputError(
                f"{path}: expected a folder that can be replaced, got a mount point; name a folder "
                "in it."
            )
        others = [item for item in os.listdir(target) if not own(item)] if target.is_dir() else []
        if others:
            raise InputError(
                f"{path}: expected a new or empty folder, got one that holds {sorted(others)[0]}; "
                "name another one."
            )
        self._add(_Job(os.fspath(path), target, write, is_folder=True))

    def names(self) -> list[str]:
        """What is written, as the user named it."""
        return [job.path for job in self._jobs]

    def write(self) -> list[str]:
        """Write everything; returns the sentences of the writers.

        Raises
        ------
        InputError
            Something could not be written; then nothing was.
        """
        sentences: list[str] = []
        with self._made_folder(), ExitStack() as stack:
            moves = []
            for job in self._jobs:
                staged = stack.enter_context(_staging(job.target.parent)) / job.target.name
                try:
                    found = job.write(staged) or ()
                except OSError as error:
                    raise cannot_write(job.path, error) from error
                except InputError as error:
                    raise InputError(str(error).replace(str(staged), job.path)) from error
                sentences += [sentence.replace(str(staged), job.path) for sentence in found]
                moves.append((job, staged))
            _move_all(moves)
        return sentences

    def _add(self, job: _Job) -> None:
        if str(job.target) in self._inputs:
            raise InputError(
                f"{job.path}: expected another file than the input, which would be overwritten; "
                "choose another name."
            )
        if any(job.target == other.target for other in self._jobs):
            raise InputError(f"{job.path}: two outputs have this name; choose different ones.")
        self._jobs.append(job)
        for folder in self._jobs:
            if folder.is_folder:
                self._check_replaced(folder)

    def _check_replaced(self, folder: _Job) -> None:
        """A folder is replaced as a whole: nothing else may lie in it."""
        others = [*self._inputs, *(str(job.target) for job in self._jobs if job is not folder)]
        inside = [path for path in others if folder.target in Path(path).parents]
        if inside:
            raise InputError(
                f"{folder.path}: expected a folder for the steps alone, which are replaced "
                f"together, got one with {Path(inside[0]).name}; name another folder."
            )

    @contextmanager
    def _made_folder(self) -> Iterator[None]:
        """The folder of the outputs, removed again when writing fails."""
        folder = self._folder
        if folder is None or folder.is_dir():
            yield
            return
        try:
            folder.mkdir()
        except OSError as error:
            raise cannot_write(folder, error) from error
        try:
            yield
        except BaseException:
            with suppress(OSError):
                folder.rmdir()
            raise


def _check_folder(path: str | os.PathLike[str], may_come: Path | None = None) -> Path:
    """The folder, which exists and may be written, or can be made; one in `may_come` can."""
    target = Path(os.path.realpath(path))
    if target.exists() and not target.is_dir():
        raise InputError(f"{path}: expected a folder, got a file; name another one.")
    if may_come is not None and target.parent == may_come and not may_come.exists():
        return target
    holder = target if target.is_dir() else target.parent
    if not holder.is_dir():
        raise InputError(f"{path}: expected an existing folder, {holder} is none; create it first.")
    if not os.access(holder, os.W_OK | os.X_OK):
        raise InputError(f"{path}: no permission to write in {holder}; choose another folder.")
    return target


@contextmanager
def _staging(parent: Path) -> Iterator[Path]:
    try:
        folder = Path(tempfile.mkdtemp(prefix=".sdfstent-", dir=parent))
    except OSError as error:
        raise cannot_write(parent, error) from error
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _move_all(moves: Sequence[tuple[_Job, Path]]) -> None:
    """Put everything in its place; when one cannot be, all of them get their old state back."""
    begun: list[tuple[Path, Path, bool]] = []
    try:
        for job, staged in moves:
            begun.append((job.target, staged, staged.exists()))
            try:
                _move(*begun[-1])
            except OSError as error:
                raise cannot_write(job.path, error) from error
    except BaseException:
        for entry in reversed(begun):
            with suppress(OSError):
                _put_back(*entry)
        raise


def _move(target: Path, staged: Path, is_there: bool) -> None:
    """Move what was staged, if anything, to its place; the old state stays beside it."""
    old = staged.with_name(_OLD)
    if target.is_dir():
        os.replace(target, old)
    elif target.exists():
        if is_there:
            os.chmod(staged, stat.S_IMODE(target.stat().st_mode))
        try:
            os.link(target, old)
        except OSError:  # a file system without hard links
            shutil.copy2(target, old)
    if is_there:
        os.replace(staged, target)
    else:
        target.unlink(missing_ok=True)


def _put_back(target: Path, staged: Path, was_there: bool) -> None:
    """Undo a move, wherever it was interrupted."""
    old = staged.with_name(_OLD)
    is_moved = was_there and not staged.exists()
    if is_moved and target.is_dir():
        shutil.rmtree(target)
    elif is_moved:
        target.unlink(missing_ok=True)
    if old.exists() and not target.exists():
        os.replace(old, target)
