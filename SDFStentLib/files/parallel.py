"""Files that are a list of others, PVTP and PVTU, with the pieces that they name."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from ..validation import InputError, in_short
from .content import FileContent, read_content
from .formats.vtp_markup import parsed_markup

LISTS = {".pvtp": "PPolyData", ".pvtu": "PUnstructuredGrid"}
"""Suffixes of such files, with their names for the kind of data."""


def read_with_pieces(path: str | os.PathLike[str]) -> FileContent:
    """The bytes of a file and, if it is a list, of its pieces; the hash covers all of them.

    Raises
    ------
    InputError
        As for `read_content`, also for a piece; a list that is damaged, empty, or names a file
        that lies neither beside it nor in a folder there.
    """
    content = read_content(path)
    if content.suffix not in LISTS:
        return content
    pieces = tuple(read_content(piece) for piece in _sources(content))
    sums = "".join(part.sha256 for part in (content, *pieces))
    return replace(content, pieces=pieces, sha256=hashlib.sha256(sums.encode()).hexdigest())


def _sources(content: FileContent) -> Iterator[Path]:
    name, kind = str(content.path), LISTS[content.suffix]
    markup = parsed_markup(content.data, name, content.suffix[1:].upper())
    if markup.kind != kind:
        raise InputError(f"{name}: expected {kind}, got {markup.kind}; extract its surface.")
    found = [piece for body in markup.root.all_of(kind) for piece in body.all_of("Piece")]
    if not found:
        raise InputError(f"{name}: expected a list of pieces, got none; write it again.")
    folder = content.path.resolve().parent
    for piece in found:
        source = piece.attributes.get("Source", "").replace("\\", "/")
        path = folder / source
        if not source or not path.resolve().is_relative_to(folder):
            raise InputError(
                f"{name}: expected pieces beside it or in a folder there, got "
                f"{in_short(source)}; write it again."
            )
        yield content.path.parent / source
