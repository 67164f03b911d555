"""What a file is by its first bytes, whatever its name says."""

from __future__ import annotations

import re
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

HEAD = 4096
"""Bytes that are looked at."""


class Kind(NamedTuple):
    """What a file seems to be."""

    words: str
    """With its article."""
    suffix: str = ""
    """Under which it would be read; empty where it would not."""
    todo: str = "convert it"
    """What to do with one that is not read."""

    @property
    def advice(self) -> str:
        """What to do where its name says something else."""
        return f"name it {self.suffix}" if self.suffix else self.todo


MODEL = (
    "make a surface of the vessel's lumen from it, in 3D Slicer: Segment Editor, then export the "
    "segment as a model (.vtp)"
)
_UNPACK = "unpack it"
_EXTRACT = "extract its surface and save that as .vtp"
_AS_STL = "save its surface as .stl"

_BEGINNINGS: tuple[tuple[bytes, Kind], ...] = (
    (rb"# vtk DataFile", Kind("a legacy VTK file", ".vtk")),
    (rb"ply\r?\n", Kind("a PLY file", ".ply")),
    (rb"\s*(ST|C|N|4|n)*OFF\b", Kind("an OFF file", ".off")),
    (rb"\s*solid\b", Kind("an STL file", ".stl")),
    (rb"(\s|#.*\n)*(v|vt|vn|o|g|mtllib|usemtl)[ \t]+\S.*\n", Kind("an OBJ file", ".obj")),
    (rb"\x89HDF\r\n\x1a\n(?s:.*)VTKHDF", Kind("a VTKHDF file", ".vtkhdf")),
    (rb"\x89HDF\r\n\x1a\n", Kind("an HDF5 file", todo=_EXTRACT)),
    (rb"\$MeshFormat", Kind("a gmsh mesh", todo=_AS_STL)),
    (rb"\s*MeshVersionFormatted", Kind("a Medit mesh", todo=_AS_STL)),
    (rb"glTF", Kind("a glTF file", todo=_AS_STL)),
    (rb"PK", Kind("a ZIP archive", todo=_UNPACK)),
    (rb"\x1f\x8b", Kind("a compressed file", todo=_UNPACK)),
    (rb"\s*[\[{]", Kind("a JSON file")),
    (rb"(<\?xml(?s:.*))?<Xdmf\b", Kind("an XDMF file", todo=_EXTRACT)),
    (rb"<\?xml", Kind("another XML file")),
)

_XML = {
    "PolyData": Kind("a VTK XML file", ".vtp"),
    "UnstructuredGrid": Kind("a VTK XML file", ".vtu"),
    "PPolyData": Kind("a VTK XML file in several pieces", ".pvtp"),
    "PUnstructuredGrid": Kind("a VTK XML file in several pieces", ".pvtu"),
    "Collection": Kind("a list of files (.pvd)", todo="name one of them"),
    "vtkMultiBlockDataSet": Kind("a list of blocks (.vtm)", todo="name one of its files"),
}
_TYPE = re.compile(rb"<VTKFile\b[^>]*?(?:\btype\s*=\s*[\"']([A-Za-z]+)[\"']|>)")

_LEGACY_IMAGE = re.compile(rb"# vtk DataFile[^\n]*\n[^\n]*\n\s*\w+\s+DATASET\s+STRUCTURED_POINTS")

_IMAGE_NAMES = {
    ".seg.nrrd": "a segmentation (NRRD)", ".nii": "an image (NIfTI)", ".nii.gz": "an image (NIfTI)",
    ".nrrd": "an image (NRRD)", ".nhdr": "an image (NRRD)", ".mha": "an image (MetaImage)",
    ".mhd": "an image (MetaImage)", ".vti": "an image (VTK)", ".dcm": "an image (DICOM)",
    ".mgz": "an image (MGZ)",
}  # fmt: skip
_NIFTI_MAGICS = {344: (b"n+1\0", b"ni1\0"), 4: (b"n+2\0", b"ni2\0")}
_MOST_OF_FOLDER = 20
"""Files of a folder that are looked at."""


def recognized(head: bytes) -> Kind | None:
    """What a file is that begins so; `None` where that tells nothing."""
    found = _TYPE.search(head)
    if found:
        kind = (found[1] or b"PolyData").decode()
        return _XML.get(kind, Kind(f"VTK's {kind}", todo=_EXTRACT))
    for pattern, known in _BEGINNINGS:
        if re.match(pattern, head):
            return known
    return None


def in_words(head: bytes) -> str:
    """The same for a message."""
    kind = recognized(head)
    if kind is None:
        return f"a file that begins with {head[:12]!r}"
    return f"{kind.words} ({kind.advice})"


def image_in(path: Path, head: bytes) -> str:
    """What kind of image a file is, in words, by content or name; empty where it is none."""
    by_content = _image_kind(head)
    if by_content or recognized(head) not in (None, recognized(b"\x1f\x8b")):
        return by_content
    name = path.name.lower()
    return next((words for end, words in _IMAGE_NAMES.items() if name.endswith(end)), "")


def has_images(folder: Path) -> bool:
    """Whether a folder seems to hold a series of DICOM images."""
    return any(_image_kind(head).endswith("(DICOM)") for head in _heads(folder))


def _image_kind(head: bytes) -> str:
    if head.startswith(b"\x1f\x8b"):
        head = _unpacked(head)
    if head.startswith(b"NRRD0"):
        return "a segmentation (NRRD)" if b"\nSegment0_" in head else "an image (NRRD)"
    if head[128:132] == b"DICM":
        return "an image (DICOM)"
    if any(head[at : at + 4] in magics for at, magics in _NIFTI_MAGICS.items()):
        return "an image (NIfTI)"
    if re.search(rb"^ObjectType\s*=\s*Image|^NDims\s*=", head, re.MULTILINE):
        return "an image (MetaImage)"
    is_legacy = re.match(
        rb"# vtk DataFile[^\n]*\n[^\n]*\n\s*\w+\s+DATASET\s+STRUCTURED_POINTS", head
    )
    found = _TYPE.search(head)
    is_xml = found is not None and found[1] in (b"ImageData", b"PImageData")
    return "an image (VTK)" if is_legacy or is_xml else ""


def _unpacked(head: bytes) -> bytes:
    try:
        return zlib.decompressobj(wbits=31).decompress(head, HEAD)
    except zlib.error:
        return b""


def _heads(folder: Path) -> Iterator[bytes]:
    try:
        files = [path for path in sorted(folder.iterdir())[:_MOST_OF_FOLDER] if path.is_file()]
        for path in files:
            with path.open("rb") as file:
                yield file.read(HEAD)
    except OSError:
        return  # not ours to read
