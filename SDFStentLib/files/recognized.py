"""Kind of a file, judged by its first bytes, whatever its name says."""

from __future__ import annotations

import os
import re
import zlib
from collections.abc import Iterator
from contextlib import suppress
from itertools import islice
from pathlib import Path
from typing import NamedTuple

HEAD = 4096
"""Number of first bytes that are looked at."""


class FileKind(NamedTuple):
    """The kind that a file seems to be of."""

    words: str
    """Words for the kind, with their article."""
    suffix: str = ""
    """Suffix under which it would be read; empty if it would not."""
    todo: str = "convert it"
    """Advice for a file that is not read."""

    @property
    def advice(self) -> str:
        """Advice for a file whose name says something else."""
        return f"name it {self.suffix}" if self.suffix else self.todo


_EXPORT = "export the segment as a model (.vtp)"
MODEL = (
    f"make a surface of the vessel's lumen from it, in 3D Slicer: Segment Editor, then {_EXPORT}"
)
"""Advice for an image."""
_SEGMENTED = f"use sdfstent prepare, or in 3D Slicer, Segmentations, {_EXPORT}"
_GZIP = b"\x1f\x8b"
_UNPACK = "unpack it"
_EXTRACT = "extract its surface and save that as .vtp"
_AS_STL = "save its surface as .stl"

_BEGINNINGS: tuple[tuple[bytes, FileKind], ...] = (
    (rb"# vtk DataFile", FileKind("a legacy VTK file", ".vtk")),
    (rb"ply\r?\n", FileKind("a PLY file", ".ply")),
    (rb"\s*(ST|C|N|4|n)*OFF\b", FileKind("an OFF file", ".off")),
    (rb"\s*solid\b", FileKind("an STL file", ".stl")),
    (rb"(\s|#.*\n)*(v|vt|vn|o|g|mtllib|usemtl)[ \t]+\S.*\n", FileKind("an OBJ file", ".obj")),
    (rb"\x89HDF\r\n\x1a\n(?s:.*)VTKHDF", FileKind("a VTKHDF file", ".vtkhdf")),
    (rb"\x89HDF\r\n\x1a\n", FileKind("an HDF5 file", todo=_EXTRACT)),
    (rb"\$MeshFormat", FileKind("a gmsh mesh", todo=_AS_STL)),
    (rb"\s*MeshVersionFormatted", FileKind("a Medit mesh", todo=_AS_STL)),
    (rb"glTF", FileKind("a glTF file", todo=_AS_STL)),
    (rb"PK", FileKind("a ZIP archive", todo=_UNPACK)),
    (rb"\x1f\x8b", FileKind("a compressed file", todo=_UNPACK)),
    (rb"\s*[\[{]", FileKind("a JSON file")),
    (rb"(<\?xml(?s:.*))?<Xdmf\b", FileKind("an XDMF file", todo=_EXTRACT)),
    (rb"<\?xml", FileKind("another XML file")),
)

_XML = {
    "PolyData": FileKind("a VTK XML file", ".vtp"),
    "UnstructuredGrid": FileKind("a VTK XML file", ".vtu"),
    "PPolyData": FileKind("a VTK XML file in several pieces", ".pvtp"),
    "PUnstructuredGrid": FileKind("a VTK XML file in several pieces", ".pvtu"),
    "Collection": FileKind("a list of files (.pvd)", todo="name one of them"),
    "vtkMultiBlockDataSet": FileKind("a list of blocks (.vtm)", todo="name one of its files"),
}
_TYPE = re.compile(rb"<VTKFile\b[^>]*?(?:\btype\s*=\s*[\"']([A-Za-z]+)[\"']|>)")

_LEGACY_IMAGE = re.compile(rb"# vtk DataFile[^\n]*\n[^\n]*\n\s*\w+\s+DATASET\s+STRUCTURED_POINTS")

_IMAGE_NAMES = {
    ".nii": "NIfTI", ".nii.gz": "NIfTI", ".nrrd": "NRRD", ".nhdr": "NRRD", ".mha": "MetaImage",
    ".mhd": "MetaImage", ".vti": "VTK", ".dcm": "DICOM", ".mgz": "MGZ", ".gipl": "GIPL",
    ".img": "Analyze", ".hdr": "Analyze", ".tif": "TIFF", ".tiff": "TIFF", ".png": "PNG",
    ".jpg": "JPEG",
}  # fmt: skip
_SEGMENTATION = ".seg.nrrd"
_NIFTI_MAGICS = {344: (b"n+1\0", b"ni1\0"), 4: (b"n+2\0", b"ni2\0")}
_MOST_OF_FOLDER = 20
"""Number of files of a folder that are looked at."""


def recognized(head: bytes) -> FileKind | None:
    """The kind of a file with this beginning; `None` if that does not show it."""
    found = _TYPE.search(head)
    if found:
        kind = (found[1] or b"PolyData").decode()
        return _XML.get(kind, FileKind(f"VTK's {kind}", todo=_EXTRACT))
    for pattern, known in _BEGINNINGS:
        if re.match(pattern, head):
            return known
    return None


def in_words(head: bytes) -> str:
    """The kind of a file with this beginning, and advice, for a message."""
    kind = recognized(head)
    if kind is None:
        return f"a file that begins with {head[:12]!r}"
    return f"{kind.words} ({kind.advice})"


def image_in(path: Path, head: bytes) -> str:
    """The kind of image that a file is by content or name, and advice; empty if it is none."""
    kind, name = _image_kind(head), path.name.lower()
    if not kind and recognized(head) in (None, recognized(_GZIP)):
        kind = next((words for end, words in _IMAGE_NAMES.items() if name.endswith(end)), "")
    if kind == "NRRD" and (name.endswith(_SEGMENTATION) or b"\nSegment0_" in head):
        return f"a segmentation ({kind}); {_SEGMENTED}"
    return f"an image ({kind}); {MODEL}" if kind else ""


def has_images(folder: Path) -> bool:
    """Whether a folder seems to hold a series of DICOM images."""
    return any(_image_kind(head) == "DICOM" for head in _heads(folder))


def _image_kind(head: bytes) -> str:
    if head.startswith(_GZIP):
        head = _unpacked(head)
    if head.startswith(b"NRRD0"):
        return "NRRD"
    if head[128:132] == b"DICM":
        return "DICOM"
    if any(head[at : at + 4] in magics for at, magics in _NIFTI_MAGICS.items()):
        return "NIfTI"
    if re.search(rb"^ObjectType\s*=\s*Image|^NDims\s*=", head, re.MULTILINE):
        return "MetaImage"
    is_legacy = re.match(
        rb"# vtk DataFile[^\n]*\n[^\n]*\n\s*\w+\s+DATASET\s+STRUCTURED_POINTS", head
    )
    found = _TYPE.search(head)
    is_xml = found is not None and found[1] in (b"ImageData", b"PImageData")
    return "VTK" if is_legacy or is_xml else ""


def _unpacked(head: bytes) -> bytes:
    try:
        return zlib.decompressobj(wbits=31).decompress(head, HEAD)
    except zlib.error:
        return b""


def _heads(folder: Path) -> Iterator[bytes]:
    found = (Path(place, name) for place, _, names in os.walk(folder) for name in sorted(names))
    for path in islice(filter(Path.is_file, found), _MOST_OF_FOLDER):  # a pipe would be waited for
        with suppress(OSError), path.open("rb") as file:  # some are not ours to read
            yield file.read(HEAD)
