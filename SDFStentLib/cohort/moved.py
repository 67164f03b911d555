"""Moved points as a small file, and the surface restored from it bit by bit.

A surface of single precision is kept as the numbers that its file holds, in the unit of that file:
written again, they have the same bits. A surface of double precision is kept in mm, as it was
computed, with 8 bytes a number: writing it divides by the unit again. Both are exact.
"""

from __future__ import annotations

import io
import os
import zlib
from typing import NamedTuple
from zipfile import BadZipFile

import numpy as np

from ..files import SurfaceFile, write_surface
from ..units import MILLIMETERS
from ..validation import Indices, InputError, Points


class MovedPoints(NamedTuple):
    """Points of a surface and their new places."""

    indices: Indices
    """(k,) indices, rising."""
    coordinates: Points
    """(k, 3) coordinates, mm."""


def encoded(surface: SurfaceFile, indices: Indices, coordinates: Points) -> bytes:
    """Moved points (k, 3), mm, as the bytes of an `.npz`: `index`, `coordinates`, `millimeters`.

    `coordinates` times `millimeters` are mm.
    """
    scale, values = 1.0, coordinates
    if surface.coordinate_type == np.float32:
        scale = float(MILLIMETERS[surface.units])
        values = (coordinates / scale).astype(np.float32)
    file = io.BytesIO()
    np.savez_compressed(
        file, index=indices.astype(np.uint32), coordinates=values, millimeters=np.float64(scale)
    )
    return file.getvalue()


def decoded(data: bytes) -> MovedPoints:
    """The points that `encoded` stored; `InputError` for damaged data."""
    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as found:
            coordinates = found["coordinates"].astype(np.float64) * float(found["millimeters"])
            return MovedPoints(found["index"].astype(np.int64), coordinates)
    except (OSError, ValueError, KeyError, EOFError, BadZipFile, zlib.error) as error:
        raise InputError(f"moved points: expected an .npz of a cohort, got {error}.") from error


def points_of(surface: SurfaceFile, moved: MovedPoints) -> Points:
    """The points (n, 3) of the surface after treatment, mm."""
    points = surface.points.copy()
    points[moved.indices] = moved.coordinates
    return points


def write_restored(path: str | os.PathLike[str], surface: SurfaceFile, moved: MovedPoints) -> None:
    """Write the whole surface, with the same bytes as if it had been written in the first place."""
    write_surface(path, surface, points_of(surface, moved))
