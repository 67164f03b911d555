"""The XML of VTP and VTU, parsed within limits; its numbers are left to `vtp_arrays`."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import NamedTuple
from xml.parsers import expat

from ...validation import InputError, in_short
from ..recognized import in_words

_SECTIONS = ("PointData", "CellData", "Points", "Verts", "Lines", "Strips", "Polys", "Cells")
_ARRAYS = ("DataArray", "Array")
_BODIES = ("PolyData", "UnstructuredGrid", "PPolyData", "PUnstructuredGrid")
_PARENTS = {
    "VTKFile": ("",),
    **dict.fromkeys(_BODIES, ("VTKFile",)),
    "FieldData": _BODIES,
    "Piece": _BODIES,
    **dict.fromkeys(_SECTIONS, ("Piece",)),
    **dict.fromkeys(_ARRAYS, ("FieldData", *_SECTIONS)),
}
"""Elements that are read, with the elements that may hold them; all others are skipped."""

_CHUNK = 2**20
_LONGEST_TAG = 2 * _CHUNK  # bytes that the parser may keep without making anything of them
_DEEPEST = 100
_MOST_ELEMENTS = 200_000

_APPENDED = b"<AppendedData"
_OPENING = re.compile(_APPENDED + rb"\s+encoding\s*=\s*[\"'](raw|base64)[\"']\s*>\s*_")
_CLOSING = re.compile(rb"</AppendedData\s*>\s*</VTKFile\s*>\Z")


@dataclass
class Element:
    """Element of the markup: its attributes, its children, and its own text."""

    tag: str
    attributes: dict[str, str]
    children: list[Element] = field(default_factory=list)
    texts: list[str] = field(default_factory=list)

    def all_of(self, *tags: str) -> Iterator[Element]:
        """The children with some tags."""
        return (child for child in self.children if child.tag in tags)


class Markup(NamedTuple):
    """A parsed file: its root, and the place of its appended bytes (`start` is 0 without any)."""

    root: Element
    start: int
    end: int
    is_raw: bool

    @property
    def kind(self) -> str:
        """Kind of data, as the file calls it."""
        return in_short(self.root.attributes.get("type", "none"))[1:-1]


def parsed_markup(data: bytes, name: str, suffix: str) -> Markup:
    """The elements of a VTP or VTU file and the place of its appended bytes.

    Parameters
    ----------
    data : bytes
        A whole file.
    name : str
        Name of the file in messages.
    suffix : str
        The expected format, VTP or VTU.

    Raises
    ------
    InputError
        Not VTK's XML, cut short, nested or long without end, a document type, or appended data
        that are not the last element.
    """
    if b"<VTKFile" not in data[:4096]:
        raise InputError(f"{name}: expected a {suffix} file (VTK XML), got {in_words(data)}.")
    if not re.search(rb"</VTKFile\s*>\Z", data[-1000:].rstrip(b" \t\r\n\0")):
        raise InputError(f"{name}: its end is missing; it is cut short, write it again.")
    whole = data.rstrip(b" \t\r\n\0")
    split = whole.find(_APPENDED)
    parser = _Parser(name)
    if split < 0:
        return Markup(parser.root_of(whole, is_all=True), 0, 0, False)
    opening, closing = (
        _OPENING.match(whole, split),
        _CLOSING.search(whole, max(split, len(whole) - 200)),
    )
    if not opening or not closing or whole.find(_APPENDED, opening.end()) >= 0:
        raise InputError(
            f"{name}: expected one AppendedData, raw or base64, as its last element, got another "
            "end; it is cut short or damaged, write it again."
        )
    root = parser.root_of(whole[:split], is_all=False)
    return Markup(root, opening.end(), closing.start(), opening[1] == b"raw")


class _Parser:
    """Collects the elements that are read in a tree, and counts all elements."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._open: list[Element | None] = []
        self._root: Element | None = None
        self._count = 0
        parser = expat.ParserCreate()
        parser.buffer_text = True
        parser.buffer_size = _CHUNK
        parser.StartElementHandler = self._start
        parser.EndElementHandler = self._end
        parser.CharacterDataHandler = self._text
        parser.StartDoctypeDeclHandler = self._doctype
        self._parser = parser

    def root_of(self, data: bytes, *, is_all: bool) -> Element:
        """The root element; data that are not the whole file must end inside of the root."""
        try:
            for start in range(0, len(data), _CHUNK):
                chunk = data[start : start + _CHUNK]
                self._parser.Parse(chunk, False)
                if start + len(chunk) - self._parser.CurrentByteIndex > _LONGEST_TAG:
                    raise self._refused(f"a tag of more than {_LONGEST_TAG} bytes")
            if is_all:
                self._parser.Parse(b"", True)
        except (expat.ExpatError, UnicodeError) as error:
            raise InputError(
                f"{self._name}: expected well-formed XML, got an error ({error}); it is cut short "
                "or damaged, write it again."
            ) from error
        if self._root is None or (not is_all and self._open != [self._root]):
            raise self._refused("no element VTKFile around its data")
        return self._root

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        self._count += 1
        if len(self._open) >= _DEEPEST or self._count > _MOST_ELEMENTS:
            raise self._refused(f"more than {_DEEPEST} levels or {_MOST_ELEMENTS} elements")
        parent = self._open[-1] if self._open else None
        place = "" if not self._open else parent.tag if parent else None
        element = Element(tag, attributes) if place in _PARENTS.get(tag, ()) else None
        if element and parent:
            parent.children.append(element)
        elif element:
            self._root = element
        self._open.append(element)

    def _end(self, _tag: str) -> None:
        self._open.pop()

    def _text(self, text: str) -> None:
        element = self._open[-1] if self._open else None
        if element and element.tag in _ARRAYS:
            element.texts.append(text)

    def _doctype(self, *_: object) -> None:
        raise self._refused("a document type")

    def _refused(self, what: str) -> InputError:
        return InputError(
            f"{self._name}: expected the XML of a VTP file, got {what}; it is damaged, write it "
            "again."
        )
