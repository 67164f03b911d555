#!/usr/bin/env bash
# SimpleITK 2.5.7, nibabel 5.4.2, pynrrd 1.1.3: the unit in the header of an image is obeyed for
# NIfTI by one reader, left to the caller by the other, and for NRRD dropped without a trace.
#
# The same voxels of 0.5 x 0.5 x 2 mm, first point at (10, 20, 30) mm, are written in mm and in
# another unit that the header names: NIfTI's xyzt_units micron, NRRD's "space units" cm.
# SimpleITK turns NIfTI's microns into mm, the origin as well. Of NRRD it keeps the numbers as they
# are, and "space units" is not among its metadata keys, so that nobody behind it can tell.
# nibabel never scales: its affine of the micron file is a thousand times that of the mm file.
#
# Seen:  NIfTI mm:     SimpleITK spacing 0.5 0.5 2, nibabel 0.5 0.5 2
#        NIfTI micron: SimpleITK spacing 0.5 0.5 2, nibabel 500 500 2000
#        NRRD mm:      SimpleITK spacing 0.5 0.5 2, keys about units: none
#        NRRD cm:      SimpleITK spacing 0.05 0.05 0.2, keys about units: none
#
# Why it matters: a lumen that is segmented in a NRRD in cm is ten times too small, and one whose
# surface is made with nibabel's affine does not lie in the image that a viewer built on ITK shows.
# The unit of a surface has to be asked for; the image's own header does not settle it.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check \
  SimpleITK==2.5.7 nibabel==5.4.2 pynrrd==1.1.3
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import sys

import nibabel
import nrrd
import numpy as np
import SimpleITK

VOXELS = np.zeros((4, 5, 6), np.int16)
SPACING, ORIGIN = np.array([0.5, 0.5, 2.0]), np.array([10.0, 20.0, 30.0])
seen = []
for unit, per_mm in (("mm", 1), ("micron", 1000)):
    affine = np.diag([*(per_mm * SPACING), 1.0])
    affine[:3, 3] = per_mm * ORIGIN
    image = nibabel.Nifti1Image(VOXELS, affine)
    image.header.set_xyzt_units(unit)
    nibabel.save(image, f"{unit}.nii.gz")
    found = SimpleITK.ReadImage(f"{unit}.nii.gz")
    origin = np.abs(found.GetOrigin())  # ITK is LPS, NIfTI RAS
    steps = np.diag(nibabel.load(f"{unit}.nii.gz").affine)[:3]
    told = "SimpleITK spacing {:g} {:g} {:g}, nibabel {:g} {:g} {:g}"
    print(f"NIfTI {unit}:", told.format(*found.GetSpacing(), *steps))
    seen.append(np.allclose(found.GetSpacing(), SPACING) and np.allclose(origin, ORIGIN))
    seen.append(np.allclose(steps, per_mm * SPACING))
for unit, per_mm in (("mm", 1.0), ("cm", 0.1)):
    header = {
        "space": "left-posterior-superior",
        "space directions": np.diag(per_mm * SPACING),
        "space origin": per_mm * ORIGIN,
        "space units": [unit] * 3,
    }
    nrrd.write(f"{unit}.nrrd", VOXELS, header)
    assert list(nrrd.read_header(f"{unit}.nrrd")["space units"]) == [unit] * 3
    found = SimpleITK.ReadImage(f"{unit}.nrrd")
    keys = [key for key in found.GetMetaDataKeys() if "unit" in key.lower()]
    told = "SimpleITK spacing {:g} {:g} {:g}, keys about units:".format(*found.GetSpacing())
    print(f"NRRD {unit}:", told, ", ".join(keys) or "none")
    seen.append(np.allclose(found.GetSpacing(), per_mm * SPACING) and not keys)
sys.exit(0 if all(seen) else 1)
PYTHON
