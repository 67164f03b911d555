"""Files that a plan names: are they still the ones it was made with, and what is in them."""

from __future__ import annotations

from ..files import axis_of, in_frame_of, read_lines
from ..stent import AlongAxis, InputFile
from ..units import Frame
from ..validation import InputError


def read_axis_file(
    file: InputFile, units: str, frame: Frame | None, *, accept_changed: bool = False
) -> AlongAxis:
    """The curve of an axis file in the frame of a plan, with the hash of what was read.

    Raises
    ------
    InputError
        A file that cannot be read, that has not one line, or that is not the one of the plan.
    """
    line_file = in_frame_of(read_lines(file.path, units), frame)
    if is_changed(file, line_file.sha256) and not accept_changed:
        raise changed_input(file, line_file.sha256)
    return AlongAxis(axis_of(line_file), InputFile(file.path, line_file.sha256))


def is_changed(file: InputFile, sha256: str) -> bool:
    """Whether a file is not the one that a plan was made with; any will do where none is named."""
    return file.sha256 not in (None, sha256)


def changed_input(file: InputFile, sha256: str) -> InputError:
    """What to raise for a file that is not the one that a plan was made with."""
    return InputError(
        f"{file.path}: expected the file that the plan was made with (sha256 {file.sha256}), got "
        f"another one (sha256 {sha256}); give the original, or accept the changed one ",
        "accept_changed_inputs",
        otherwise="(accept_changed_inputs)",
        end=".",
    )
