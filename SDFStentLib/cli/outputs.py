"""Outputs that appear together at the end, or not at all."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from typing import NamedTuple

from ..cautions import Caution
from ..files import StagingFolder, cannot_write, check_folder, check_writable, commit, sweep
from ..validation import InputError
from .signals import check_interrupted, uninterrupted, uninterrupted_from_now

Writer = Callable[[Path], "Iterable[Caution] | None"]
"""A function that writes to a path; it may return cautions about what could not be kept."""


class _OutputJob(NamedTuple):
    path: str
    target: Path
    write: Writer
    may_be_missing: bool = False
    is_folder: bool = False
    is_last: bool = False


class Outputs:
    """Files and folders that a command writes, checked at once and written at the end.

    Everything is first written beside its place, and moved there when all of it is done: a failure
    or an interruption leaves either no output or all of them. A run that is killed amidst the moves
    leaves some new and some old, which `sdfstent check` tells.

    Parameters
    ----------
    inputs : sequence of paths
        Files that may not be overwritten.
    folder : path, optional
        A folder that is made for the outputs if it is missing; its parent must exist.
    """

    def __init__(
        self,
        inputs: Sequence[str | os.PathLike[str] | None] = (),
        folder: str | os.PathLike[str] | None = None,
    ) -> None:
        self._inputs = {os.path.realpath(path) for path in inputs if path is not None}
        self._folder = None if folder is None else _check_folder(folder)
        self._jobs: list[_OutputJob] = []
        self._written: dict[Path, str] = {}  # by what is hashed for those that come last

    def add(
        self,
        path: str | os.PathLike[str],
        write: Writer,
        *,
        may_be_missing: bool = False,
        is_last: bool = False,
    ) -> None:
        """Add a file; `InputError` if it cannot be written, is an input, or is named twice.

        If it `may_be_missing`, its writer may leave it out; an older file is then removed. What
        `is_last` is written and moved behind all others.
        """
        target = Path(os.path.realpath(path))
        sweep(target.parent)
        if self._folder is None or target.parent != self._folder or self._folder.is_dir():
            target = check_writable(path)
        self._add(_OutputJob(os.fspath(path), target, write, may_be_missing, is_last=is_last))

    def add_folder(
        self, path: str | os.PathLike[str], write: Writer, own: Callable[[str], bool]
    ) -> None:
        """Add a folder: new, empty, or with files of its own kind only, which it replaces."""
        sweep(Path(os.path.realpath(path)).parent)
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
        self._add(_OutputJob(os.fspath(path), target, write, is_folder=True))

    def names(self) -> list[str]:
        """The outputs, as the user named them."""
        return [job.path for job in self._jobs]

    def beside(self, path: str | os.PathLike[str]) -> dict[str, str]:
        """The files that were written so far, as seen from the folder of one, and their SHA-256."""
        folder = os.path.dirname(os.path.realpath(path))
        return {
            Path(os.path.relpath(target, folder)).as_posix(): found
            for target, found in self._written.items()
        }

    def write(self) -> list[Caution]:
        """Write everything; return cautions about what was not kept, under the final names.

        Raises
        ------
        InputError
            Something could not be written; then nothing was.
        """
        lost: list[Caution] = []
        with self._made_folder(), ExitStack() as stack:
            folders: dict[Path, StagingFolder] = {}
            moves: list[tuple[StagingFolder, str]] = []
            is_told = any(job.is_last for job in self._jobs)
            for job in sorted(self._jobs, key=lambda job: job.is_last):
                parent, name = job.target.parent, job.target.name
                if parent not in folders:
                    folders[parent] = stack.enter_context(_staging(parent))
                staged = folders[parent].staged(name)
                lost += _written(job, staged)
                if is_told and staged.is_file() and not job.is_last:
                    self._written[job.target] = sha256(staged.read_bytes()).hexdigest()
                moves.append((folders[parent], name))
            check_interrupted()
            with uninterrupted():
                try:
                    commit(moves)
                except OSError as error:
                    raise cannot_write(next(iter(folders)), error) from error
                uninterrupted_from_now()
        return lost

    def _add(self, job: _OutputJob) -> None:
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

    def _check_replaced(self, folder: _OutputJob) -> None:
        """Refuse other outputs or inputs inside a folder that is replaced as a whole."""
        others = [*self._inputs, *(str(job.target) for job in self._jobs if job is not folder)]
        inside = [path for path in others if folder.target in Path(path).parents]
        if inside:
            raise InputError(
                f"{folder.path}: expected a folder for the steps alone, which are replaced "
                f"together, got one with {Path(inside[0]).name}; name another folder."
            )

    @contextmanager
    def _made_folder(self) -> Iterator[None]:
        """Make the folder of the outputs; remove it again if writing fails."""
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
    """The folder, if it may be written or can be made; one in `may_come` always can."""
    target = Path(os.path.realpath(path))
    try:
        is_there = target.exists()
    except OSError as error:
        raise cannot_write(path, error) from error
    if is_there and not target.is_dir():
        raise InputError(f"{path}: expected a folder, got a file; name another one.")
    if may_come is not None and target.parent == may_come and not may_come.exists():
        return target
    check_folder(path, target if target.is_dir() else target.parent)
    return target


def _written(job: _OutputJob, staged: Path) -> list[Caution]:
    """Write one output where it is staged; return what it could not keep, under its final name."""
    try:
        found = job.write(staged) or ()
    except OSError as error:
        raise cannot_write(job.path, error) from error
    except InputError as error:
        raise InputError(str(error).replace(str(staged), job.path)) from error
    label = f"{job.path}: "
    return [replace(caution, label=label) if caution.label else caution for caution in found]


@contextmanager
def _staging(parent: Path) -> Iterator[StagingFolder]:
    try:
        folder = StagingFolder(parent)
    except OSError as error:
        raise cannot_write(parent, error) from error
    try:
        yield folder
    finally:
        with uninterrupted():
            folder.remove()
