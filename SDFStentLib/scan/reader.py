"""Segmentations in files: which labels they hold, and the voxels of one of them (by SimpleITK)."""

from __future__ import annotations

import gzip
import importlib.util
import re
import struct
from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..scan_formats import SCAN_SUFFIXES, SCANS_IN_WORDS
from ..validation import InputError, as_path, one_line
from .labelmap import Labelmap

INSTALL = 'pip install "SimpleITK>=2.3"'

MOSTLY = 0.5
"""Least share of equal neighbors in a segmentation: a part of it is wider than a voxel or two. In
an image of a scanner, which has noise, neighbors differ."""

_SAID = 12
"""Number of labels that a sentence names."""

_NIFTI_SPACING = 80
"""Byte of a NIfTI header at which the spacings of its three axes stand."""


class LabelEntry(NamedTuple):
    """A label of a segmentation."""

    value: int
    name: str
    """Empty where the file has none."""
    layer: int = 0

    @property
    def words(self) -> str:
        return f"{self.value} ({self.name})" if self.name else str(self.value)


class Segmentation(NamedTuple):
    """A segmentation that was read."""

    path: Path
    labelmap: Labelmap
    segment: LabelEntry


class ScanFile(NamedTuple):
    """A file of labels that was read: each of them may be a vessel."""

    path: Path
    image: Any
    layers: list[NDArray[Any]]
    known: list[LabelEntry]
    """Labels that the header names."""

    @property
    def labels(self) -> list[LabelEntry]:
        """Labels that have voxels, in order."""
        return [
            LabelEntry(int(value), _name_of(self.known, int(value), layer), layer)
            for layer, row in enumerate(voxels.ravel("K") for voxels in self.layers)
            for value in np.unique(row[row > 0])
        ]

    def named(self, label: str | int | None) -> LabelEntry:
        """The label of a name or a number, None for the only one; errors as `read_segmentation`."""
        return _chosen(self.labels, self.known, label, self.path)

    def segmentation(self, label: LabelEntry) -> Segmentation:
        """Segmentation of a label; `InputError` for voxels that are no boxes."""
        image = self.image
        directions = np.reshape(image.GetDirection(), (3, 3))
        mask = self.layers[label.layer] == label.value
        try:
            labelmap = Labelmap(mask, np.array(image.GetSpacing()), image.GetOrigin(), directions)
        except InputError as error:
            raise error.labeled(f"{self.path}: ") from None
        return Segmentation(self.path, labelmap, label)


def read_scan(path: str | PathLike[str]) -> ScanFile:
    """Read all labels of a segmentation; path and errors as `read_segmentation`."""
    target = as_path(path)
    if not target.name.lower().endswith(SCAN_SUFFIXES):
        raise InputError(f"{path}: expected a segmentation, {SCANS_IN_WORDS}; export it as one.")
    image, meta = _read(target)
    return ScanFile(target, image, _layers(image, target), _segments(meta))


def read_segmentation(path: str | PathLike[str], label: str | int | None = None) -> Segmentation:
    """Read one label of a segmentation.

    Parameters
    ----------
    path : path
        `.nrrd` and `.seg.nrrd`, `.nii` and `.nii.gz`, `.mha` and `.mhd`.
    label : str or int, optional
        Number of the label, or its name in a `.seg.nrrd`; not needed where there is only one.

    Raises
    ------
    InputError
        SimpleITK is not installed; no segmentation of three dimensions with a spacing; a label
        that is not there, or none where there are several.
    """
    read = read_scan(path)
    return read.segmentation(read.named(label))


def _read(path: Path) -> tuple[Any, dict[str, str]]:
    """The image and the texts of its header."""
    if importlib.util.find_spec("SimpleITK") is None:
        raise InputError(
            f"{path}: expected SimpleITK to read a segmentation, it is not installed; {INSTALL}, "
            "or export the segment as a model in 3D Slicer."
        )
    import SimpleITK

    if not path.is_file():
        raise InputError(f"{path}: expected a segmentation, there is no such file.")
    SimpleITK.ProcessObject.GlobalWarningDisplayOff()
    reader = SimpleITK.ImageFileReader()
    reader.SetFileName(str(path))
    try:
        reader.ReadImageInformation()
        _check_header(path, reader.GetDimension(), reader.GetSize(), reader.GetSpacing())
        image = reader.Execute()
    except RuntimeError as error:
        last = one_line(str(error).strip().splitlines()[-1])
        raise InputError(f"{path}: expected a segmentation, it cannot be read: {last}") from error
    return image, {key: reader.GetMetaData(key) for key in reader.GetMetaDataKeys()}


def _check_header(
    path: Path, dimension: int, size: Sequence[int], spacing: Sequence[float]
) -> None:
    if dimension != 3 or min(size) < 2:
        raise InputError(
            f"{path}: expected a segmentation of three dimensions, got an image of "
            f"{' x '.join(map(str, size))}; save one moment of it, or all of its slices."
        )
    sides = np.array(spacing)
    if path.name.lower().endswith((".nii", ".nii.gz")):
        sides = _nifti_spacing(path)  # the reader takes 1 in place of 0
    if not np.isfinite(sides).all() or (sides == 0).any():
        words = " x ".join(f"{side:.4g}" for side in sides)
        raise InputError(
            f"{path}: expected voxels that are some mm apart, got a spacing of {words}; correct "
            "it in the file's header."
        )


def _nifti_spacing(path: Path) -> NDArray[np.float64]:
    with gzip.open(path) if path.suffix == ".gz" else path.open("rb") as file:
        head = file.read(_NIFTI_SPACING + 12)
    order = "<" if head[:4] == struct.pack("<i", 348) else ">"
    return np.array(struct.unpack(f"{order}3f", head[_NIFTI_SPACING:]))


def _layers(image: Any, path: Path) -> list[NDArray[Any]]:
    """The layers of a segmentation, axes in the order of its coordinates."""
    import SimpleITK

    values = SimpleITK.GetArrayViewFromImage(image)
    stack = values if image.GetNumberOfComponentsPerPixel() > 1 else values[..., None]
    layers = [np.asarray(stack[..., n]).transpose(2, 1, 0) for n in range(stack.shape[-1])]
    for layer in layers:
        fault = _fault(layer)
        if fault:
            raise InputError(
                f"{path}: expected a segmentation, whose voxels are numbers of labels, got {fault} "
                "as of an image; segment the vessel first, in Slicer by Segment Editor."
            )
    if not any(layer.any() for layer in layers):
        raise InputError(
            f"{path}: expected voxels of a vessel, all of them are empty; export the segment."
        )
    return layers


def _fault(voxels: NDArray[Any]) -> str:
    """Fault of voxels that are no labels, in words; empty where they may be labels."""
    if voxels.min() < 0:
        return "negative numbers"
    if voxels.dtype.kind == "f" and (voxels != np.rint(voxels)).any():
        return "fractions"
    marked = voxels[:-1] > 0
    alike = np.count_nonzero((voxels[:-1] == voxels[1:]) & marked)
    return "" if alike >= MOSTLY * np.count_nonzero(marked) else "neighbors that differ"


def _segments(meta: dict[str, str]) -> list[LabelEntry]:
    """The segments that the header of a `.seg.nrrd` names."""
    found = []
    for key, name in meta.items():
        match = re.fullmatch(r"Segment(\d+)_Name", key)
        if match:
            value = meta.get(f"Segment{match[1]}_LabelValue", "1")
            layer = meta.get(f"Segment{match[1]}_Layer", "0")
            found.append(LabelEntry(int(value), one_line(name), int(layer)))
    return found


def _name_of(known: Sequence[LabelEntry], value: int, layer: int) -> str:
    names = [one.name for one in known if (one.value, one.layer) == (value, layer)]
    return names[0] if names else ""


def _chosen(
    present: Sequence[LabelEntry], known: Sequence[LabelEntry], label: str | int | None, path: Path
) -> LabelEntry:
    """Label by the user's words; `InputError` for none, or more than one."""
    some = ", ".join(one.words for one in present[:_SAID])
    some += f" and {len(present) - _SAID} more" if len(present) > _SAID else ""
    if label is None:
        if len(present) == 1:
            return present[0]
        raise InputError(
            f"{path}: expected one label, got {len(present)}: {some}; say which by its number or "
            "name."
        )
    word = str(label).strip()
    of_name = [one for one in present if one.name == word]
    of_number = [one for one in present if str(one.value) == word]
    found = of_name or of_number
    if len(found) == 1:
        return found[0]
    if found:
        raise InputError(
            f"{path}: expected one label {word}, got {len(found)}, in several layers; say its name."
        )
    if any(word in (one.name, str(one.value)) for one in known):
        raise InputError(
            f"{path}: expected voxels of {word}, this segment is empty; choose one of {some}."
        )
    raise InputError(f"{path}: expected a label that is there, got {word}; choose one of {some}.")
