"""Files that a plan names: are they still the ones it was made with, and what is in them."""

from __future__ import annotations

from ..files import axis_of, in_frame_of, read_lines
from ..stent import InputFile
from ..units import Frame
from ..validation import InputError, Points


def read_axis_file(
    file: InputFile, units: str, frame: Frame | None, *, accept_changed: bool = False
) -> Points:
    """The curve (n, 3) of an axis file in the frame of a plan, mm.

    Raises
    ------
    InputError
        A file that cannot be read, that has not one line, or that is not the one of the plan.
    """
    line_file = in_frame_of(read_lines(file.path, units), frame)
    changed = changed_input(file, line_file.sha256)
    if changed and not accept_changed:
        raise InputError(changed)
    return axis_of(line_file)


def changed_input(file: InputFile, sha256: str) -> str:
    """A sentence when a file is not the one that a plan was made with; empty when it is."""
    if file.sha256 in (None, sha256):
        return ""
    return (
        f"{file.path}: expected the file that the plan was made with (sha256 {file.sha256}), got "
        f"another one (sha256 {sha256}); give the original, or accept the changed one "
        "(accept_changed_inputs)."
    )
