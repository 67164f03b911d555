"""Files that appear whole or not at all."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from ..validation import InputError, as_path


def check_suffix(path: str | os.PathLike[str], what: str, suffixes: Sequence[str]) -> None:
    """Raise `InputError` for a file whose suffix is not one of its kind."""
    suffix = Path(path).suffix
    if suffix.lower() not in suffixes:
        raise InputError(
            f"{path}: expected {what} that ends in {', '.join(suffixes)}, got "
            f"{suffix or 'no suffix'!r}; rename it."
        )


@contextmanager
def atomic_path(path: str | os.PathLike[str]) -> Iterator[Path]:
    """A temporary file beside `path` that takes its place when the block ends well.

    The temporary file has the suffix of `path` and lies in the same folder, so that the change
    of name is atomic: whoever looks, also after a crash, finds the old file or the whole new
    one. When the block raises, the temporary file is removed and the old one is untouched. A
    symbolic link stays one, its target is replaced. Permissions of an old file are kept.

    Parameters
    ----------
    path : path
        The file to write.

    Yields
    ------
    Path
        The temporary file, empty, to be written by the block.

    Raises
    ------
    InputError
        No such folder, no permission, `path` is no ordinary file, or the disk is full.
    """
    target = check_writable(path)
    temporary = target.with_name(f".sdfstent-{os.urandom(6).hex()}{target.suffix}")
    try:
        os.close(os.open(temporary, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
        if target.exists():
            os.chmod(temporary, stat.S_IMODE(target.stat().st_mode))
        yield temporary
        flush_to_disk(temporary)
        os.replace(temporary, target)
    except OSError as error:
        raise cannot_write(target, error) from error
    finally:
        with suppress(OSError):
            temporary.unlink(missing_ok=True)
    # The new name itself survives a power cut only once the folder is on the disk; where a
    # folder cannot be opened (Windows) there is no such call.
    with suppress(OSError):
        flush_to_disk(target.parent)


def write_bytes(path: str | os.PathLike[str], data: bytes) -> None:
    """Write `data` to `path` through `atomic_path`; `InputError` if that fails."""
    with atomic_path(path) as temporary, temporary.open("wb") as file:
        file.write(data)


def check_writable(path: str | os.PathLike[str]) -> Path:
    """The file that writing to `path` would replace, links followed; to be asked before any
    computing.

    Raises
    ------
    InputError
        The folder does not exist or may not be written, or `path` is a folder, a device or a
        pipe.
    """
    try:
        target = Path(os.path.realpath(as_path(path)))
        if target.is_dir():
            raise InputError(f"{path}: expected a file to write, got a folder; add a file name.")
        if target.exists() and not target.is_file():
            raise InputError(f"{path}: expected a file to write, got a device or a pipe.")
        check_folder(path, target.parent)
    except InputError:
        raise
    except (OSError, ValueError) as error:  # ValueError: a null character in the name
        raise cannot_write(path, error) from error
    return target


def check_folder(path: str | os.PathLike[str], folder: Path) -> None:
    """Raise `InputError` for a folder that does not exist or may not be written."""
    if not folder.is_dir():
        raise InputError(f"{path}: expected an existing folder, {folder} is none; create it first.")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise InputError(f"{path}: no permission to write in {folder}; choose another folder.")


def flush_to_disk(path: Path) -> None:
    """Wait until a file, or the names in a folder, would survive a power cut."""
    descriptor = os.open(path, os.O_RDONLY if path.is_dir() else os.O_RDWR)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def cannot_write(path: str | os.PathLike[str], error: Exception) -> InputError:
    """The error for a file or folder that the system does not let us write."""
    reason = getattr(error, "strerror", None) or str(error)
    return InputError(
        f"{path}: cannot be written ({reason}); free space, or choose another folder or name."
    )
