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

from .atomic import check_writable
from .validation import InputError

Writer = Callable[[Path], "Iterable[str] | None"]
"""Writes to a path; may return sentences about what could not be kept."""


class _Job(NamedTuple):
    path: str
    target: Path
    write: Writer
    may_be_missing: bool = False


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
        target = _check_folder(path)
        others = [item for item in os.listdir(target) if not own(item)] if target.is_dir() else []
        if others:
            raise InputError(
                f"{path}: expected a new or empty folder, got one that holds {sorted(others)[0]}; "
                "name another one."
            )
        self._add(_Job(os.fspath(path), target, write))

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
                    raise _failure(job.path, error) from error
                except InputError as error:
                    raise InputError(str(error).replace(str(staged), job.path)) from error
                sentences += [sentence.replace(str(staged), job.path) for sentence in found]
                moves.append((job, staged))
            for job, staged in moves:
                _move(job, staged)
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
            raise _failure(os.fspath(folder), error) from error
        try:
            yield
        except BaseException:
            with suppress(OSError):
                folder.rmdir()
            raise


def _check_folder(path: str | os.PathLike[str]) -> Path:
    """The folder, which exists and may be written, or can be made."""
    target = Path(os.path.realpath(path))
    if target.exists() and not target.is_dir():
        raise InputError(f"{path}: expected a folder, got a file; name another one.")
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
        raise _failure(os.fspath(parent), error) from error
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _move(job: _Job, staged: Path) -> None:
    try:
        if job.may_be_missing and not staged.exists():
            job.target.unlink(missing_ok=True)
            return
        if job.target.is_dir():
            # Out of the way into the staging folder, which is removed afterwards.
            os.replace(job.target, staged.with_name(".old"))
        elif job.target.exists():
            os.chmod(staged, stat.S_IMODE(job.target.stat().st_mode))
        os.replace(staged, job.target)
    except OSError as error:
        raise _failure(job.path, error) from error


def _failure(path: str, error: OSError) -> InputError:
    reason = error.strerror or str(error)
    return InputError(
        f"{path}: cannot be written ({reason}); free space, or choose another folder or name."
    )
