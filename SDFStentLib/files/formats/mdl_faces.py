"""Names of faces from a SimVascular model file (.mdl), parsed within limits.

SimVascular writes an element `format` in front of the element `model`: two roots, which no XML
document has. An outer element is put round both.
"""

from __future__ import annotations

import re
from xml.parsers import expat

from ...validation import InputError

LARGEST = 2**22
"""Largest file, bytes; a model of a thousand faces takes a twentieth."""

_DEEPEST = 20
_DECLARATION = re.compile(rb"\A(?:\xef\xbb\xbf)?\s*(?:<\?xml[^>]{0,200}\?>)?")
_ID = re.compile("[0-9]{1,9}")


def mdl_face_names(data: bytes, name: str) -> dict[int, str]:
    """Names of the faces of a model by their ids.

    Parameters
    ----------
    data : bytes
        A whole file.
    name : str
        Name of the file in messages.

    Raises
    ------
    InputError
        No XML, too large or nested too deep, a document type, no element `model`, a face without
        id or name, or two faces with one id.
    """
    if len(data) > LARGEST:
        raise _refused(name, f"more than {LARGEST} bytes")
    reader = _FaceReader(name)
    parser = expat.ParserCreate("utf-8")
    parser.StartElementHandler, parser.EndElementHandler = reader.start, reader.end
    parser.StartDoctypeDeclHandler = reader.doctype
    try:
        parser.Parse(b"<file>" + _DECLARATION.sub(b"", data, count=1) + b"</file>", True)
    except (expat.ExpatError, UnicodeError) as error:
        raise _refused(name, f"an error ({error})") from error
    if not reader.has_model:
        raise _refused(name, "no element model")
    return reader.names


class _FaceReader:
    """Collects the attributes of every `face` in `faces`, wherever in a model these are."""

    def __init__(self, name: str) -> None:
        self.name, self.has_model = name, False
        self.names: dict[int, str] = {}
        self._open: list[str] = []

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        if len(self._open) >= _DEEPEST:
            raise _refused(self.name, f"more than {_DEEPEST} levels")
        self.has_model |= self._open == ["file"] and tag == "model"
        if tag == "face" and self.has_model and self._open[-1] == "faces":
            self._add(attributes.get("id", ""), attributes.get("name", ""))
        self._open.append(tag)

    def end(self, _tag: str) -> None:
        self._open.pop()

    def doctype(self, *_: object) -> None:
        raise _refused(self.name, "a document type")

    def _add(self, number: str, words: str) -> None:
        if not _ID.fullmatch(number) or not words.strip():
            raise _refused(self.name, f"a face with id {number[:40]!r} and name {words[:40]!r}")
        if self.names.setdefault(int(number), words) != words:
            raise _refused(self.name, f"two names of face {int(number)}")


def _refused(name: str, what: str) -> InputError:
    return InputError(
        f"{name}: expected a SimVascular model with a name for each face, got {what}; save the "
        "model again or take the file away."
    )
