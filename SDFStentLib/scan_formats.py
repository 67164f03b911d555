"""Formats in which segmentations are read: the only list, for command line and page."""

from __future__ import annotations

SCAN_SUFFIXES = (".nrrd", ".nii.gz", ".nii", ".mha", ".mhd")
"""Suffixes of files of segmentations; Slicer's `.seg.nrrd` is among them."""

SCANS_IN_WORDS = f"{', '.join(SCAN_SUFFIXES[:-1])} or {SCAN_SUFFIXES[-1]}"
