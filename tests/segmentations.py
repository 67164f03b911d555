"""Round tubes cut into voxels, and written as segmentations."""

from __future__ import annotations

import numpy as np
import SimpleITK
from round_tubes import away

FORK = [
    ((0, 0, 0), (0, 0, 26), 4, 4),
    ((0, 0, 26), (11, 0, 48), 3, 3),
    ((0, 0, 26), (-11, 0, 48), 2.6, 2.6),
]
"""A trunk that parts in two, mm."""


def voxels(pieces, spacing, margin=5):
    """Whether the center of each voxel is in one of the pieces, and the place of the first."""
    spacing = np.broadcast_to(np.asarray(spacing, dtype=float), 3)
    ends = np.array([end for one, other, _, _ in pieces for end in (one, other)], dtype=float)
    widest = max(max(first, last) for _, _, first, last in pieces)
    low = ends.min(axis=0) - widest - margin * spacing
    size = np.ceil((ends.max(axis=0) + widest + margin * spacing - low) / spacing).astype(int)
    places = np.indices(tuple(size)).reshape(3, -1).T * spacing + low
    return (away(places, pieces) < 0).reshape(tuple(size)), low


def write(path, values, origin=(0, 0, 0), spacing=1.0, directions=None, texts=()):
    """Write values (i, j, k) or, of several layers, (i, j, k, l) as an image."""
    values = np.asarray(values)
    values = values.astype(np.uint8) if values.dtype == bool else values
    turned = np.swapaxes(values, 0, 2)
    image = SimpleITK.GetImageFromArray(turned, isVector=values.ndim == 4)
    image.SetSpacing(np.broadcast_to(np.asarray(spacing, dtype=float), 3).tolist())
    image.SetOrigin([float(one) for one in origin])
    if directions is not None:
        image.SetDirection(np.asarray(directions, dtype=float).ravel().tolist())
    for key, text in dict(texts).items():
        image.SetMetaData(key, str(text))
    SimpleITK.WriteImage(image, str(path), True)
    return path


def named(**segments):
    """The header of a `.seg.nrrd`: names, each with its value and its layer."""
    texts = {}
    for number, (name, (value, layer)) in enumerate(segments.items()):
        texts |= {
            f"Segment{number}_Name": name,
            f"Segment{number}_LabelValue": value,
            f"Segment{number}_Layer": layer,
            f"Segment{number}_ID": f"Segment_{number + 1}",
        }
    return texts
