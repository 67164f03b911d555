"""New folders for what is written as several files: whole or not at all, and over nothing."""

import shutil
from pathlib import Path

from SDFStentLib.files import cannot_write


def newFolder(parent, name):
    """A folder in another one that was not there before; nothing is overwritten."""
    folder = Path(parent) / name
    try:
        folder = freePath(folder)
        folder.mkdir()
    except OSError as error:
        raise cannot_write(folder, error) from error
    return folder


def freePath(path):
    """The path, with a number behind its name while there is something already."""
    free, number = path, 1
    # Ends: there are finitely many files.
    while free.exists():
        number += 1
        free = path.with_stem(f"{path.stem} {number}")
    return free


def inNewFolder(parent, name, stepsInto):
    """The iterator that `stepsInto` makes for a new folder, which goes again when that fails or is stopped."""
    folder = newFolder(parent, name)
    try:
        return (yield from stepsInto(folder))
    except BaseException as error:
        shutil.rmtree(folder, ignore_errors=True)
        if isinstance(error, OSError):
            raise cannot_write(folder, error) from error
        raise
